"""Opens recordings with the loaders that the data sets come with and with nearmiss, one core each, and prints ratios.

    python benches/official_loaders.py target/release/nearmiss --waymo FILE.tfrecord --argoverse FOLDER --commonroad FILE.xml

Official loaders read what a scenario is made of: states of all tracks as numbers, and the map. What is not installed is
said and skipped: waymo_open_dataset's protos (WAYMO_PROTOS=folder of its wheel; protobuf before 4), av2, commonroad-io.
nearmiss is timed as a process, without its start, while it opens every scenario in a folder of copies (`inspect`). Times
are those of the processor, so that other work on the machine does not count.
"""

import argparse
import contextlib
import io
import os
import resource
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

COPIES = 40


def children():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def clock(call, now, times=5):
    call()
    spent = []
    for _ in range(times):
        begun = now()
        call()
        spent.append(now() - begun)
    return statistics.median(spent)


def waymo(path):
    sys.path.insert(0, os.environ.get("WAYMO_PROTOS", ""))
    from google.protobuf.internal import api_implementation
    from waymo_open_dataset.protos import scenario_pb2

    print(f"waymo: protobuf as {api_implementation.Type()}: `python` takes many times as long as `cpp` and `upb`")

    def states(scenario):
        fields = ("center_x", "center_y", "length", "width", "heading", "velocity_x", "velocity_y", "valid")
        tracks = [[[getattr(s, f) for f in fields] for s in t.states] for t in scenario.tracks]
        lanes = [[(p.x, p.y) for p in f.lane.polyline] for f in scenario.map_features if f.HasField("lane")]
        return len(tracks) + len(lanes)

    def load():
        bytes_ = Path(path).read_bytes()
        at = 0
        while at < len(bytes_):
            (length,) = struct.unpack_from("<Q", bytes_, at)
            scenario = scenario_pb2.Scenario()
            scenario.ParseFromString(bytes_[at + 12 : at + 12 + length])
            states(scenario)
            at += length + 16

    return load


def argoverse(folder):
    from av2.datasets.motion_forecasting import scenario_serialization
    from av2.map.map_api import ArgoverseStaticMap

    table = next(Path(folder).glob("scenario_*.parquet"))
    archive = next(Path(folder).glob("log_map_archive_*.json"))

    def load():
        scenario_serialization.load_argoverse_scenario_parquet(table)
        ArgoverseStaticMap.from_json(archive)

    return load


def argoverse_arrow(folder):
    """What can be had without av2: the table as Python values, and the map as JSON."""
    import json

    import pyarrow.parquet

    table = next(Path(folder).glob("scenario_*.parquet"))
    archive = next(Path(folder).glob("log_map_archive_*.json"))

    def load():
        pyarrow.parquet.read_table(table, use_threads=False).to_pylist()
        json.loads(archive.read_text())

    return load


def commonroad(path):
    from commonroad.common.file_reader import CommonRoadFileReader

    def load():
        # It says what is deprecated.
        with contextlib.redirect_stderr(io.StringIO()), contextlib.redirect_stdout(io.StringIO()):
            CommonRoadFileReader(path).open()

    return load


def ours(program, path):
    """Seconds that one more copy takes."""
    with tempfile.TemporaryDirectory() as root:
        spent = []
        for copies in (1, COPIES + 1):
            folder = Path(root) / str(copies)
            for i in range(copies):
                into = folder / str(i)
                if Path(path).is_dir():
                    shutil.copytree(path, into)
                else:
                    into.mkdir(parents=True)
                    shutil.copy(path, into)
            command = [program, "inspect", str(folder)]
            if shutil.which("taskset"):
                command = ["taskset", "-c", "0", *command]
            run = lambda: subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            spent.append(clock(run, children))
        return (spent[1] - spent[0]) / COPIES


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("nearmiss")
    for name in ("waymo", "argoverse", "commonroad"):
        arguments.add_argument(f"--{name}")
    chosen = arguments.parse_args()
    rows = [
        ("waymo", waymo, chosen.waymo),
        ("argoverse (av2)", argoverse, chosen.argoverse),
        ("argoverse (pyarrow)", argoverse_arrow, chosen.argoverse),
        ("commonroad-io", commonroad, chosen.commonroad),
    ]
    for name, loader, path in rows:
        if not path:
            continue
        try:
            official = clock(loader(path), time.process_time)
        except ImportError as error:
            print(f"skipped: {name}: {error}")
            continue
        own = ours(chosen.nearmiss, path)
        print(f"{name:20} official {official * 1e3:9.1f} ms   nearmiss {own * 1e3:7.2f} ms   {official / own:6.1f} times")


main()
