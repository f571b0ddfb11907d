"""Batches of Arrow in and out, for Ray, Spark and Daft: what comes in as pyarrow goes out as pyarrow."""

from ._nearmiss import index_batch, measure_batch


def index_batches(batches, **options):
    """Windows of all pairs of road users, batch by batch, with the schema of `nearmiss corpus index`.

    batches: an iterator of Arrow batches or tables with a column `path` (a row a file), or of tracks, one recording a batch
    (columns time, id, x, y). options: length, stride, radius and measures as of Scenario.windows; columns, rate and map as of
    nearmiss.open. Files that cannot be read are warnings; a batch without one that can is an error.
    """
    for batch in batches:
        yield from _like(batch, index_batch(batch, **options))


def measure_batches(batches, **options):
    """Safety measures, batch by batch, with the schema of `nearmiss metrics`.

    batches: as of index_batches. options: names and radius as of Scenario.measures; columns, rate and map as of nearmiss.open.
    """
    for batch in batches:
        yield from _like(batch, measure_batch(batch, **options))


def _like(batch, made):
    """The table that was made, as the kind of object that its batch is."""
    if not type(batch).__module__.startswith("pyarrow"):
        yield made
        return
    import pyarrow  # type: ignore[import-untyped]

    table = pyarrow.table(made)
    if isinstance(batch, pyarrow.Table):
        yield table
    else:
        yield from table.combine_chunks().to_batches() or [pyarrow.RecordBatch.from_pylist([], schema=table.schema)]
