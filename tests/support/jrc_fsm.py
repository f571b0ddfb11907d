"""Runs the safety models of JRC-FSM, an own checkout of it, on cases from standard input.

JRC_FSM=FOLDER python3 jrc_fsm.py < cases.csv
A case is `driver,family,speed,a,b,c` (m/s, m, m/s²); the answer repeats it and adds the ego's speed less the other's at
the first contact, or nothing, and the gap at the start.
"""

import os
import sys
import types

# Only speed comes from numba.
sys.modules["numba"] = types.SimpleNamespace(njit=lambda function: function)
sys.path.insert(0, os.environ["JRC_FSM"])

import numpy as np
from utility import global_parameters as given
from utility import models, movement

NAMES = {"cc": "CC", "r157": "Reg157", "rss": "RSS", "fsm": "FSM"}
STEPS, RATE, LENGTH, WIDTH = given.iterations, given.freq, given.length, given.width


def sized(vehicle):
    vehicle.length, vehicle.width = LENGTH, WIDTH
    vehicle.cfs = vehicle.pfs = 0
    vehicle.large_TTC = False
    return vehicle


def before(vehicle, lateral):
    """The vehicle with the steps that it needs to get its lateral speed, at 1.5 m/s² (after the source's grids)."""
    speeds = np.arange(0, lateral, -1.5 / RATE)
    along = vehicle.speed_profile_long[0]
    starts = vehicle.start
    across = speeds if vehicle.turns else np.zeros(len(speeds))
    last = lateral if vehicle.turns else 0
    for name, values, end, at in (
        ("long", np.full(len(speeds), along), along, starts[0]),
        ("lat", across, last, starts[1]),
    ):
        places = np.append(np.cumsum(-values[::-1] / RATE)[::-1] + at, at)
        for kind, more in (("speed", np.append(values, [end])), ("pos", places)):
            field = f"{kind}_profile_{name}"
            setattr(vehicle, field, np.append(more, getattr(vehicle, field)))
    return len(speeds)


def contact(ego, other, step):
    return float(ego.speed_profile_long[step] - other.speed_profile_long[step])


def cut_in(model, speed, other, gap, lateral):
    check = getattr(models, {"CC": "CC_check_safety_cut_in", "Reg157": "Reg157_check_safety_cut_in"}.get(model, f"{model}_check_safety"))
    start = (gap + LENGTH, 1.6 + WIDTH)
    enters = sized(movement.create_profile_cutting_in(np.array(start), other, -lateral, STEPS, RATE))
    ego = sized(movement.create_profile_cutting_in(np.array([0, 0]), speed, 0, STEPS, RATE))
    enters.start, enters.turns, ego.start, ego.turns = start, True, (0, 0), False
    more = before(enters, -lateral)
    before(ego, -lateral)
    for step in range(STEPS + more):
        movement.control(ego, enters, RATE, check, getattr(models, f"{model}_react"), step)
        if ego.crash:
            return contact(ego, enters, step), gap
        if ego.large_TTC:
            break
    return None, gap


def follow(model, speed):
    imagined = movement.create_profile_decel(np.array([42 + LENGTH, 0]), 0, 10, 10, 10)
    return getattr(models, f"{model}_distance")(imagined, speed)


def cut_out(model, speed, front, lateral):
    check, react = getattr(models, f"{model}_check_safety"), getattr(models, f"{model}_react")
    gap = follow(model, speed)
    leaves = sized(movement.create_profile_cutting_in(np.array([gap + LENGTH, 4]), speed, -lateral, STEPS, RATE))
    leaves.pos_profile_lat = leaves.pos_profile_lat - 4
    stands = sized(movement.create_profile_decel(np.array([gap + LENGTH + front + LENGTH, 0]), 0, 0, STEPS, RATE))
    ego = sized(movement.create_profile_decel(np.array([0, 0]), 0, speed, STEPS, RATE))
    for step in range(STEPS - 1):
        aside = abs(stands.pos_profile_lat[step] - leaves.pos_profile_lat[step]) - WIDTH / 2 - WIDTH / 2
        along = abs(stands.pos_profile_long[step] - leaves.pos_profile_long[step]) - LENGTH / 2 - LENGTH / 2
        if aside < 0 and along < 0:
            leaves.crash = True
            for name in ("long", "lat"):
                getattr(leaves, f"speed_profile_{name}")[step:] = 0
                places = getattr(leaves, f"pos_profile_{name}")
                places[step:] = places[step]
        ahead = leaves if leaves.crash else stands
        if leaves.crash or leaves.pos_profile_lat[step] < given.wandering_zone:
            movement.control(ego, ahead, RATE, check, react, step)
        if ego.crash:
            return contact(ego, ahead, step), gap
        if ego.speed_profile_long[step] == 0:
            break
    return None, gap


def braking(model, speed, deceleration):
    check, react = getattr(models, f"{model}_check_safety"), getattr(models, f"{model}_react")
    gap = follow(model, speed)
    ahead = sized(movement.create_profile_decel(np.array([gap + LENGTH, 0]), deceleration, speed, STEPS, RATE))
    ego = sized(movement.create_profile_decel(np.array([0, 0]), 0, speed, STEPS, RATE))
    for step in range(STEPS - 1):
        movement.control(ego, ahead, RATE, check, react, step)
        if ego.crash:
            return contact(ego, ahead, step), gap
        if ego.speed_profile_long[step] == 0:
            break
    return None, gap


np.seterr(all="ignore")
FAMILIES = {"cut_in": (cut_in, 4), "cut_out": (cut_out, 3), "braking": (braking, 2)}
for line in sys.stdin:
    driver, family, *numbers = line.strip().split(",")
    run, count = FAMILIES[family]
    closing, gap = run(NAMES[driver], *map(float, numbers[:count]))
    print(f"{line.strip()},{'' if closing is None else repr(closing)},{float(gap)!r}")
