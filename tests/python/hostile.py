"""Damaged files through the module: an exception, never the end of the process; and memory that stays flat.

hostile.py mutated CASES SEED FILE... | hostile.py memory OPENS FILE...
"""

import gc
import pathlib
import random
import sys
import tempfile
import warnings

import nearmiss


def resident():
    """Bytes of memory in use."""
    pages = int(pathlib.Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096


def damaged(data, chance):
    """The bytes with a cut, a flip, a doubled stretch or a changed number."""
    data = bytearray(data)
    for _ in range(chance.randint(1, 2)):
        if not data:
            break
        place = chance.randrange(len(data))
        end = min(len(data), place + chance.randint(1, 200))
        kind = chance.randrange(5)
        if kind == 0:
            del data[place:end]
        elif kind == 1:
            data[place] = chance.randrange(256)
        elif kind == 2:
            data[place:place] = data[place:end]
        elif kind == 3:
            del data[place:]
        else:
            data[place:end] = bytes(chance.choice(b"0123456789eE.-<>\"'nainf ,") for _ in range(end - place))
    return bytes(data)


def mutated(cases, seed, sources):
    chance = random.Random(seed)
    kinds = {"opened": 0, "refused": 0}
    with tempfile.TemporaryDirectory() as folder:
        for case in range(cases):
            source = pathlib.Path(sources[case % len(sources)])
            file = pathlib.Path(folder) / f"{case}{source.suffix}"
            file.write_bytes(damaged(source.read_bytes(), chance))
            try:
                scenario = nearmiss.open(file)
                for made in (scenario.tracks, scenario.lanes, scenario.measures, scenario.windows, scenario.figure):
                    try:
                        made()
                    except nearmiss.Error:
                        pass
                try:
                    nearmiss.judge(scenario.window("safety"))
                except nearmiss.Error:
                    pass
                kinds["opened"] += 1
            except nearmiss.Error:
                kinds["refused"] += 1
            file.unlink()
    assert all(kinds.values()), kinds
    print(f"{cases} damaged files: {kinds}")


def memory(opens, sources):
    def some(count):
        for place in range(count):
            scenario = nearmiss.open(sources[place % len(sources)])
            len(scenario.tracks())
        gc.collect()
        return resident()

    warm = some(max(200, opens // 10))
    after = some(opens)
    grown = (after - warm) / 1e6
    assert grown < 20, f"{grown:.1f} MB more after {opens} opens"
    print(f"{opens} opens: {grown:+.1f} MB")


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    kind, count, *rest = sys.argv[1:]
    if kind == "mutated":
        mutated(int(count), int(rest[0]), rest[1:])
    else:
        memory(int(count), rest)
