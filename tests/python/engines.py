"""Ray, Spark and Daft, each with two workers on loopback: the rows are those of the command, also where a worker is killed.

engines.py ray|spark|daft [killed]
"""

import os
import pathlib
import secrets
import shutil
import signal
import subprocess
import sys
import tempfile

os.environ["DAFT_ANALYTICS_ENABLED"] = "0"
os.environ["DAFT_PROGRESS_BAR"] = "0"

import pyarrow

import nearmiss

PROGRAM = os.environ["NEARMISS"]
SCENARIOS = 60
OPTIONS = {"measures": ["distance", "ttc"]}


def files(folder):
    """So many scenarios in files."""
    subprocess.run([PROGRAM, "convert", *nearmiss.scenarios(), "-o", folder], check=True, capture_output=True)
    found = sorted(pathlib.Path(folder).glob("*.xml"))
    for place in range(SCENARIOS - len(found)):
        source = found[place % len(found)]
        copy = source.with_stem(f"{source.stem.removesuffix('-1')}-{place + 2}")
        shutil.copy(source, copy)
        ego = source.with_suffix(".ego_trajectory.csv")
        shutil.copy(ego, copy.with_suffix(".ego_trajectory.csv"))
    return sorted(str(file) for file in pathlib.Path(folder).glob("*.xml"))


def killing_once(batches):
    """The same batches; each worker signs, and the first kills itself if that is wanted."""
    mark = os.environ.get("KILL_ONCE")
    for batch in batches:
        (pathlib.Path(os.environ["WORKERS"]) / str(os.getpid())).touch()
        if mark:
            try:
                os.close(os.open(mark, os.O_CREAT | os.O_EXCL))
            except FileExistsError:
                pass
            else:
                os.kill(os.getpid(), signal.SIGKILL)
        yield batch


def work(batches):
    yield from nearmiss.index_batches(killing_once(batches), **OPTIONS)


def with_ray(paths):
    os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
    os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"  # the node is 127.0.0.1
    os.environ["HTTP_PROXY"] = os.environ["HTTPS_PROXY"] = "http://127.0.0.1:9"  # nobody is asked which cloud this is
    os.environ["NO_PROXY"] = "127.0.0.1,localhost"
    os.environ["RAY_AUTH_MODE"], os.environ["RAY_AUTH_TOKEN"] = "token", secrets.token_hex(32)
    os.environ["RAY_DATA_DISABLE_PROGRESS_BARS"] = "1"
    import ray

    ray.init(num_cpus=2, include_dashboard=False, object_store_memory=200 << 20, log_to_driver=False)
    dataset = ray.data.from_items([{"path": path} for path in paths], override_num_blocks=6)
    made = dataset.map_batches(lambda table: work([table]), batch_format="pyarrow", batch_size=10)
    rows = pyarrow.concat_tables(ray.get(made.to_arrow_refs())).to_pylist()
    ray.shutdown()
    return rows


def with_spark(paths):
    os.environ["SPARK_LOCAL_IP"] = "127.0.0.1"
    os.environ["PYSPARK_PYTHON"] = os.environ["PYSPARK_DRIVER_PYTHON"] = sys.executable
    from pyspark.sql import SparkSession
    from pyspark.sql.pandas.types import from_arrow_schema

    options = {
        "spark.ui.enabled": "false",
        "spark.ui.showConsoleProgress": "false",
        "spark.driver.bindAddress": "127.0.0.1",
        "spark.driver.host": "127.0.0.1",
        "spark.sql.execution.arrow.maxRecordsPerBatch": "10",
    }
    builder = SparkSession.builder.master("local[2,4]")
    for key, value in options.items():
        builder = builder.config(key, value)
    spark = builder.getOrCreate()
    spark.sparkContext.setLogLevel("OFF")
    schema = from_arrow_schema(pyarrow.table(nearmiss.windows([], **OPTIONS)).schema)
    frame = spark.createDataFrame([(path,) for path in paths], "path string").repartition(6)
    rows = [row.asDict() for row in frame.mapInArrow(work, schema).collect()]
    spark.stop()
    return rows


def with_daft(paths):
    import daft

    schema = pyarrow.table(nearmiss.windows([], **OPTIONS)).schema
    listed = daft.DataType.list(daft.DataType.from_arrow_type(pyarrow.struct(schema)))

    @daft.cls(max_concurrency=2, use_process=True)
    class Index:
        @daft.method.batch(return_dtype=listed, batch_size=10)
        def rows(self, path):
            tables = [pyarrow.table({"path": [one]}) for one in path.to_pylist()]
            return [table.to_pylist() for table in work(tables)]

    frame = daft.from_pydict({"path": paths}).into_batches(10)
    frame = frame.select(Index().rows(frame["path"]).alias("row")).explode("row")
    return [one["row"] for one in frame.to_pylist()]


def main():
    engine, *how = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as workers:
        os.environ["WORKERS"] = workers
        paths = files(folder)
        assert len(paths) == SCENARIOS
        arguments = ["corpus", "index", *paths, "--measure", ",".join(OPTIONS["measures"]), "-o", "-"]
        printed = subprocess.run([PROGRAM, *arguments], check=True, capture_output=True).stdout
        wanted = pyarrow.ipc.open_stream(printed).read_all().to_pylist()
        if how == ["killed"]:
            os.environ["KILL_ONCE"] = str(pathlib.Path(folder) / "killed")
        rows = {"ray": with_ray, "spark": with_spark, "daft": with_daft}[engine](paths)
        if how == ["killed"]:
            assert os.path.exists(os.environ["KILL_ONCE"]), "no worker was killed"
        count = len(os.listdir(workers))
        assert count >= 2, f"{count} worker"
    order = lambda row: (row["file"], row["ego_source"], row["ego_id"], row["obstacle_id"], row["first_step"])
    rows.sort(key=order)
    wanted.sort(key=order)
    assert len(rows) == len(wanted), (len(rows), len(wanted))
    for row, other in zip(rows, wanted):
        assert row == other, (row, other)
    print(f"{engine}: {count} workers, {len(rows)} rows of {SCENARIOS} scenarios are those of the command", flush=True)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # Daft 0.7 aborts now and then while Python shuts down, after all work is done
