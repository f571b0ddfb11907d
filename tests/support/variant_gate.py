"""Holds a changed scenario against its original, with nothing but Python's standard library.

Usage: variant_gate.py ORIGINAL.xml VARIANT.xml [--ego EGO.csv] [--contact STEP] [--attackers N]

Says as JSON who moves in another way, from which step, and which steps of the new motion no road user of its kind can
drive, or drives through another obstacle. It knows nothing of the program that it checks: the formulas are its own.
Steps at which both ends are those of the original are not judged. Several may move in another way, at most N of
them (3); each is judged among the others as they move in the variant.
"""

import argparse
import csv
import json
import math
import xml.etree.ElementTree as ET

GRIP = 11.5  # m/s²
JERK = 30.0  # m/s³
PLACE = 0.02  # m
TURN = 0.03  # rad

# Wheelbase (m), rear axle to middle (m), steering (rad), top speed and speed of full power (m/s); with shares of the
# length where a number is given as a string.
CAR = (2.5789, 1.4227, 1.066, 50.8, 7.319)
LORRY = ("0.5", "0.25", 0.550, 22.22, 7.824)
KINDS = {
    "car": (CAR, GRIP),
    "taxi": (CAR, GRIP),
    "priorityVehicle": (CAR, GRIP),
    "parkedVehicle": (CAR, GRIP),
    "truck": (LORRY, GRIP),
    "bus": (LORRY, GRIP),
    "motorcycle": (("0.6", "0.3", 0.6, 50.0, 50.0), 9.0),
    "bicycle": (("0.6", "0.3", 0.8, 15.0, 15.0), 5.0),
    "pedestrian": (("0.6", "0.3", 1.3, 5.0, 5.0), 4.0),
}


def number(element, path):
    found = element.find(path)
    if found is None:
        return None
    exact = found.find("exact")
    found = found if exact is None else exact
    return float(found.text) if found.text and found.text.strip() else None


def states(element):
    trajectory = element.find("trajectory")
    every = [element.find("initialState")] + ([] if trajectory is None else trajectory.findall("state"))
    out = {}
    for state in every:
        if state is None:
            continue
        x, y = number(state, "position/point/x"), number(state, "position/point/y")
        heading = number(state, "orientation")
        if x is None or y is None or heading is None:
            continue
        out[int(number(state, "time"))] = (x, y, heading, number(state, "velocity") or 0.0, number(state, "acceleration"))
    return out


def body(element):
    """Corners of a body about its middle; a circle as a polygon around it."""
    shape = element.find("shape")
    if shape is None or len(shape) != 1:
        return None, None
    if shape[0].tag == "rectangle":
        length, width = number(shape, "rectangle/length"), number(shape, "rectangle/width")
        l, w = length / 2, width / 2
        return [(l, w), (-l, w), (-l, -w), (l, -w)], length
    if shape[0].tag == "circle":
        r = number(shape, "circle/radius")
        around = r / math.cos(math.pi / 16)
        angles = [2 * math.pi * k / 16 for k in range(16)]
        return [(around * math.cos(a), around * math.sin(a)) for a in angles], 2 * r
    return None, None


def read(path):
    root = ET.parse(path).getroot()
    obstacles = {}
    for element in root:
        if element.tag not in ("staticObstacle", "dynamicObstacle", "obstacle"):
            continue
        corners, length = body(element)
        obstacles[element.get("id")] = {
            "static": element.tag == "staticObstacle" or element.findtext("role") == "static",
            "kind": element.findtext("type"),
            "corners": corners,
            "length": length,
            "states": states(element),
        }
    lanes = {}
    for lane in root.findall("lanelet"):
        points = [(float(p.findtext("x")), float(p.findtext("y"))) for p in lane.iter("point")]
        types = [(e.tag, e.text) for e in lane if e.text and e.text.strip()]
        lanes[lane.get("id")] = (points, types)
    return float(root.get("timeStepSize")), obstacles, lanes


def wrap(angle):
    return math.atan2(math.sin(angle), math.cos(angle))


def placed(corners, state):
    c, s = math.cos(state[2]), math.sin(state[2])
    return [(state[0] + c * x - s * y, state[1] + s * x + c * y) for x, y in corners]


def overlap(a, b):
    """Whether two convex polygons share a point: no axis separates them."""
    for ring in (a, b):
        for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1]):
            nx, ny = y1 - y0, x0 - x1
            of_a = [nx * x + ny * y for x, y in a]
            of_b = [nx * x + ny * y for x, y in b]
            if max(of_a) < min(of_b) or max(of_b) < min(of_a):
                return False
    return True


def same(a, b):
    return a is not None and b is not None and all(abs(p - q) < 1e-9 for p, q in zip(a[:4], b[:4]))


def at(obstacle, step):
    if obstacle["static"]:
        return next(iter(obstacle["states"].values()), None)
    return obstacle["states"].get(step)


class Report:
    def __init__(self):
        self.found = []

    def most(self, reason, step, value, limit):
        if not value <= limit:
            self.found.append({"reason": reason, "step": step, "value": value, "limit": limit})

    def say(self, reason, step=None, value=None, limit=None):
        self.found.append({"reason": reason, "step": step, "value": value, "limit": limit})


def kinematics(report, old, new, start, dt):
    """Every step of the new motion that is not that of the old one."""
    (base, rear, steering, top, power), grip = KINDS[new["kind"]]
    base, rear = [float(n) * new["length"] if isinstance(n, str) else n for n in (base, rear)]
    bend = math.tan(steering) / base
    now, was = new["states"], old["states"]
    recorded = lambda step: same(was.get(step), now.get(step))
    steps = sorted(s for s in now if s >= start)
    for a, b in zip(steps, steps[1:]):
        if b != a + 1:
            report.say("gap", a, b - a, 1)
            continue
        p, q = now[a], now[b]
        if not all(math.isfinite(n) for n in p[:4] + q[:4]):
            report.say("not a number", a)
            continue
        left_alone = recorded(a) and recorded(b)
        before = a - 1
        force = (q[3] - p[3]) / dt
        if a > start and before in now and not (left_alone and recorded(before)):
            report.most("jerk", a, abs(force - (p[3] - now[before][3]) / dt) / dt, JERK * 1.001)
        elif a == start and not left_alone and a in was:
            # The recording says how it was speeding up: before, after, and in words.
            said = [] if was[a][4] is None else [was[a][4]]
            said += [(was[t][3] - was[s][3]) / dt for s, t in ((a - 1, a), (a, b)) if s in was and t in was]
            if said:
                report.most("jerk", a, max(min(said) - force, force - max(said), 0.0) / dt, JERK * 1.001)
        if left_alone:
            continue
        if not recorded(b):
            report.most("speed", b, q[3], top * 1.001)
            report.most("backwards", b, -q[3], 1e-3)
        fast = max(p[3], q[3])
        pull = grip * (min(1.0, power / fast) if force > 0 and fast > 0 else 1.0)
        report.most("acceleration", a, abs(force), pull * 1.001)
        turn = wrap(q[2] - p[2])
        mean = (p[3] + q[3]) / 2
        yaw = turn / dt
        report.most("friction circle", a, math.hypot(force, mean * yaw), grip * 1.02)
        report.most("yaw rate", a, abs(yaw), max(fast, 0.0) * bend + 2e-3)
        # Where the rear axle goes; or, as recordings have it, the middle.
        mid = p[2] + turn / 2
        off = []
        for back in (rear, 0.0):
            dx = q[0] - back * math.cos(q[2]) - p[0] + back * math.cos(p[2])
            dy = q[1] - back * math.sin(q[2]) - p[1] + back * math.sin(p[2])
            along = dx * math.cos(mid) + dy * math.sin(mid)
            across = dy * math.cos(mid) - dx * math.sin(mid)
            off.append((abs(across), abs(along - mean * dt), math.hypot(dx, dy)))
        across, along, length = min(off, key=lambda o: o[0])
        report.most("displacement is speed times time", a, along, PLACE)
        if length > 0.01:
            report.most("heading along motion", a, math.atan2(across, length), TURN + math.atan2(PLACE / 2, length))
        whole_way = math.hypot(q[0] - p[0], q[1] - p[1])
        report.most("jump", a, whole_way, max(fast, 0.0) * dt + 0.5 * GRIP * dt * dt + rear * abs(turn) + 2 * PLACE)


def meetings(report, obstacles, mover, name, old, start, contact, ego):
    for step, state in sorted(mover["states"].items()):
        if step < start or same(old["states"].get(step), state) or (contact is not None and step > contact):
            continue
        here = placed(mover["corners"], state)
        for other_name, other in obstacles.items():
            there = None if other_name == name or other["corners"] is None else at(other, step)
            if there is not None and overlap(here, placed(other["corners"], there)):
                report.say("overlap with " + other_name, step, 0.0, 0.0)
    for step, there in ego.items():
        state = mover["states"].get(step)
        if state is not None and step <= start:
            if overlap(placed(mover["corners"], state), placed([(2.254, 0.805), (-2.254, 0.805), (-2.254, -0.805), (2.254, -0.805)], there)):
                report.say("overlap with the ego before the change", step, 0.0, 0.0)


def judge(name, old, new, others, dt, contact, ego):
    steps = sorted(set(old["states"]) | set(new["states"]))
    differ = [s for s in steps if not same(old["states"].get(s), new["states"].get(s))]
    first = min(old["states"])
    start = max(first, differ[0] - 1)
    report = Report()
    if old["static"] or new["kind"] not in KINDS or new["corners"] is None:
        report.say("does not move by itself", differ[0])
        return {"obstacle": int(name), "from": differ[0], "violations": report.found}
    p, q = old["states"].get(start), new["states"].get(start)
    if p is None or q is None:
        report.say("start", start)
    elif not same(p, q):
        report.most("start position", start, math.dist(p[:2], q[:2]), 1e-9)
        report.most("start heading", start, abs(wrap(q[2] - p[2])), 1e-9)
        report.most("start velocity", start, abs(q[3] - p[3]), 1e-9)
    kinematics(report, old, new, start, dt)
    meetings(report, others, new, name, old, start, contact, ego)
    report.found.sort(key=lambda v: -1 if v["step"] is None else v["step"])
    return {"obstacle": int(name), "from": differ[0], "changed_states": len(differ), "violations": report.found}


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("original")
    arguments.add_argument("variant")
    arguments.add_argument("--ego")
    arguments.add_argument("--contact", type=int)
    arguments.add_argument("--attackers", type=int, default=3)
    given = arguments.parse_args()
    dt, before, road = read(given.original)
    other_dt, after, other_road = read(given.variant)
    ego = {}
    if given.ego:
        with open(given.ego, newline="") as file:
            for row in csv.DictReader(file):
                values = [float(row[k]) for k in ("x_position", "y_position", "orientation")]
                ego[int(float(row["timestep"]))] = values
    whole = []
    if dt != other_dt:
        whole.append("time step")
    for part, what in enumerate(("shape of the road", "types of the road")):
        if {k: v[part] for k, v in road.items()} != {k: v[part] for k, v in other_road.items()}:
            whole.append(what)
    whole += ["missing " + n for n in before if n not in after] + ["added " + n for n in after if n not in before]
    both = [n for n in before if n in after]
    for n in both:
        if any(before[n][k] != after[n][k] for k in ("static", "kind", "corners")):
            whole.append("reshaped " + n)
    differ = lambda n: any(
        not same(before[n]["states"].get(s), after[n]["states"].get(s))
        for s in set(before[n]["states"]) | set(after[n]["states"])
    )
    changed = [n for n in both if differ(n)]
    if not 1 <= len(changed) <= given.attackers:
        whole.append(f"{len(changed)} changed obstacles")
    judged = [judge(n, before[n], after[n], after, dt, given.contact, ego) for n in changed]
    passed = not whole and not any(j["violations"] for j in judged)
    print(json.dumps({"passed": passed, "scenario": whole, "changed": judged}, indent=1))


if __name__ == "__main__":
    main()
