"""Measure, judge and endanger driving scenarios.

>>> import nearmiss
>>> scenario = nearmiss.open("ZAM_CutIn-1_1_T-1")           # a file, or a bundled scenario
>>> scenario.worst()["what"]                                 # the moment that matters
>>> scenario.measures(["ttc", "distance"])                   # a row an obstacle and time step
>>> scenario.figure()                                        # a notebook shows it
>>> window = scenario.window("safety", at="worst")
>>> nearmiss.judge(window)["dangerous"]                      # from exact geometry
>>> nearmiss.plan(scenario).record["outcome"]                # the built-in planner, or a function of yours
>>> [variant] = nearmiss.attack(scenario, seed=0)            # what endangers it, with certificates
>>> nearmiss.inspect("recordings")                           # a folder, the worst first

Tables are Arrow: table.to_pandas(), table.to_polars(), pyarrow.table(table) and DuckDB take them without copying;
table.rows() needs none of these. Lengths are in metres, angles in radians, times in seconds, moments of a recording are
durations; table.columns says so of each column.

What is wrong with a file or a wish is a nearmiss.Error, with file and line where they are known; an argument of a wrong type
is a TypeError. Ctrl-C stops.
"""

from ._batches import index_batches, measure_batches
from ._commonroad import from_commonroad, to_commonroad
from ._nearmiss import (
    Drive,
    Error,
    Figure,
    Scenario,
    Table,
    Variant,
    Window,
    __version__,
    ask,
    attack,
    check,
    drivers,
    encounters,
    from_tracks,
    inspect,
    judge,
    measures,
    open,
    plan,
    prompt,
    read_verdict,
    scenarios,
    windows,
)

__all__ = [
    "Drive",
    "Error",
    "Figure",
    "Scenario",
    "Table",
    "Variant",
    "Window",
    "ask",
    "attack",
    "check",
    "drivers",
    "encounters",
    "from_commonroad",
    "from_tracks",
    "index_batches",
    "inspect",
    "judge",
    "measure_batches",
    "measures",
    "open",
    "plan",
    "prompt",
    "read_verdict",
    "scenarios",
    "to_commonroad",
    "windows",
]
