"""Tables in polars, pandas, pyarrow and DuckDB, and back; rows of corpora equal those of the commands."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import duckdb
import pandas
import polars
import pyarrow
import pyarrow.parquet

import nearmiss

PROGRAM = os.environ["NEARMISS"]
NAMES = nearmiss.scenarios()


def stream(*arguments):
    """The Arrow stream that a command prints."""
    printed = subprocess.run([PROGRAM, *arguments], check=True, capture_output=True).stdout
    return pyarrow.ipc.open_stream(printed).read_all()


class Libraries(unittest.TestCase):
    def test_each_takes_a_table_as_it_is(self):
        table = nearmiss.measures(NAMES, ["ttc", "distance"])
        taken = pyarrow.table(table)
        self.assertEqual(taken.schema.field("distance").metadata[b"unit"], b"m")
        self.assertEqual(taken.schema.field("time").type, pyarrow.duration("us"))
        self.assertEqual(taken.to_pylist(), table.rows())
        self.assertEqual(polars.DataFrame(table).rows(named=True), table.rows())
        measured = table
        self.assertEqual(duckdb.sql("select count(*), min(distance) from measured").fetchall()[0][0], len(measured))
        frame = pandas.DataFrame.from_arrow(table)
        self.assertEqual(list(frame["distance"]), [row["distance"] for row in table.rows()])
        self.assertTrue(frame.equals(table.to_pandas()))
        self.assertTrue(polars.DataFrame(table).equals(table.to_polars()))
        # Again: the table is not used up.
        self.assertEqual(pyarrow.table(table).num_rows, len(table))

    def test_tracks_come_from_each(self):
        scenario = nearmiss.open(NAMES[1])
        tracks, worst = scenario.tracks(), scenario.worst()
        frame = polars.DataFrame(tracks)
        seconds = polars.col("time").dt.total_seconds(fractional=True)
        kinds = {
            "itself": tracks,
            "polars": frame,
            "seconds": frame.with_columns(seconds),
            "categories": frame.with_columns(polars.col("class").cast(polars.Categorical)),
            "float32": frame.with_columns(polars.col("width").cast(polars.Float32)),
            "pandas": pandas.DataFrame.from_arrow(tracks),
            "table": pyarrow.table(tracks),
            "batch": pyarrow.table(tracks).combine_chunks().to_batches()[0],
            "DuckDB": duckdb.sql("from tracks"),
        }
        for kind, made in kinds.items():
            again = nearmiss.from_tracks(made, ego=scenario.ego)
            self.assertEqual(again.steps, scenario.steps, kind)
            for key in ("step", "severity", "obstacle", "what"):
                self.assertEqual(again.worst()[key], worst[key], f"{key} of {kind}")

    def test_a_stream_that_lies_is_an_error(self):
        schema = pyarrow.table(nearmiss.open(NAMES[0]).tracks()).schema
        lies = pyarrow.RecordBatchReader.from_batches(schema, iter([pyarrow.record_batch({"q": [1]})]))

        class Other:
            def __arrow_c_stream__(self, requested_schema=None):
                return schema.__arrow_c_schema__()

        for stream, kind in [(lies, Exception), (Other(), TypeError)]:
            with self.assertRaises(kind):
                nearmiss.from_tracks(stream)

    def test_columns_are_named(self):
        frame = pandas.DataFrame({"t": [0, 0, 100, 100], "who": [1, 2, 1, 2], "x": [0.0, 9, 1, 9], "y": [0.0] * 4})
        scenario = nearmiss.from_tracks(frame, columns="time=t[ms],id=who", name="mine")
        self.assertEqual((scenario.name, scenario.time_step), ("mine", 0.1))
        # An index is no data, and what is missing is named.
        again = nearmiss.from_tracks(pandas.concat([frame, frame.assign(who=frame["who"] + 2)]), columns="time=t[ms],id=who")
        self.assertFalse([words for words in again.diagnostics if "index" in words])
        with self.assertRaises(nearmiss.Error) as raised:
            nearmiss.from_tracks(frame.drop(columns="y"), columns="time=t[ms],id=who")
        self.assertIn("y", str(raised.exception))
        self.assertNotIn("/tmp", str(raised.exception))
        with self.assertRaises(nearmiss.Error) as raised:
            nearmiss.from_tracks(frame.rename(columns={"t": "when", "y": "north"}).drop(columns="x"))
        self.assertIn("columns for time, id, x and y", str(raised.exception))
        named = frame.assign(who=frame["who"].map({1: "lead", 2: "mine"}))
        self.assertEqual(nearmiss.from_tracks(named, columns="time=t[ms],id=who", ego="mine").ego, 2)


class Commands(unittest.TestCase):
    def same(self, table, other):
        one = pyarrow.table(table).combine_chunks()
        self.assertEqual(one.schema.names, other.schema.names)
        self.assertEqual(one.schema, other.schema)
        for name in one.schema.names:
            self.assertEqual(one.column(name).to_pylist(), other.column(name).to_pylist(), name)

    def test_what_streams_is_the_same(self):
        self.same(nearmiss.measures(NAMES), stream("metrics", *NAMES, "--format", "arrow", "-o", "-"))
        self.same(nearmiss.windows(NAMES), stream("corpus", "index", *NAMES, "-o", "-"))
        self.same(nearmiss.encounters(NAMES), stream("drivers", *NAMES, "--format", "arrow", "-o", "-"))
        self.same(nearmiss.inspect(NAMES), stream("inspect", *NAMES, "--format", "arrow", "-o", "-"))

    def test_an_index_of_files_has_the_same_rows(self):
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([PROGRAM, "corpus", "index", *NAMES, "-o", folder], check=True, capture_output=True)
            parts = sorted(pathlib.Path(folder).glob("**/*.parquet"))
            other = pyarrow.concat_tables(pyarrow.parquet.read_table(part, partitioning=None) for part in parts)
        one = pyarrow.table(nearmiss.windows(NAMES))
        self.assertEqual(one.schema.names, other.schema.names)
        for name in one.schema.names:
            values = one.column(name).to_pylist()
            if name in ("start", "end"):
                values = [value.total_seconds() for value in values]
            self.assertEqual(values, other.column(name).to_pylist(), name)
        self.assertEqual(other.schema.field("distance").metadata[b"unit"], b"m")

    def test_batches_go_in_and_out(self):
        paths = pyarrow.table({"path": NAMES})
        whole = pyarrow.table(nearmiss.windows(NAMES))
        made = list(nearmiss.index_batches([paths]))
        self.assertIsInstance(made[0], pyarrow.Table)
        self.assertEqual(made[0].to_pylist(), whole.to_pylist())
        batches = list(nearmiss.index_batches(paths.to_batches(max_chunksize=3)))
        self.assertIsInstance(batches[0], pyarrow.RecordBatch)
        self.assertEqual(pyarrow.Table.from_batches(batches).to_pylist(), whole.to_pylist())
        tracks = nearmiss.open(NAMES[0]).tracks()
        made = polars.concat(polars.DataFrame(one) for one in nearmiss.measure_batches([polars.DataFrame(tracks)], names=["ttc"]))
        self.assertGreater(len(made), 100)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
