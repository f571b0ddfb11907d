"""Compares what nearmiss converted with what the files of the data sets hold, read here independently of it.

    recordings.py waymo FILE.tfrecord CONVERTED.xml
    recordings.py argoverse FOLDER CONVERTED.xml

Waymo's messages are read byte by byte, by the numbers of their fields; Argoverse's tables with pyarrow. Prints what it
compared and, for each difference, a line; status 1 if there is any, 3 if pyarrow is missing.
"""

import json
import math
import statistics
import struct
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

differences = []


def same(what, ours, theirs, within=1e-5):
    if isinstance(theirs, float) or isinstance(ours, float):
        if ours is None or theirs is None or not abs(ours - theirs) <= within:
            differences.append(f"{what}: {ours} is not {theirs}")
    elif ours != theirs:
        differences.append(f"{what}: {ours} is not {theirs}")


def turned(what, ours, theirs):
    same(what, math.remainder(ours - theirs, math.tau), 0.0)


class Converted:
    def __init__(self, path):
        self.root = ET.parse(path).getroot()
        self.obstacles = {int(o.get("id")): o for o in self.root.findall("dynamicObstacle")}
        self.lanelets = {int(l.get("id")): l for l in self.root.findall("lanelet")}
        self.lights = {int(l.get("id")): l for l in self.root.findall("trafficLight")}

    def number(self, element, path):
        found = element.find(path)
        return None if found is None else float(found.text)

    def state(self, element):
        at = lambda path: self.number(element, path)
        place = at("position/point/x"), at("position/point/y")
        return place + (at("orientation/exact"), at("velocity/exact"))

    def track(self, obstacle):
        states = [obstacle.find("initialState"), *obstacle.findall("trajectory/state")]
        return {int(float(s.find("time/exact").text)): self.state(s) for s in states}

    def size(self, obstacle):
        return tuple(self.number(obstacle, f"shape/rectangle/{side}") for side in ("length", "width"))

    def bound(self, lanelet, side):
        return [(float(p.find("x").text), float(p.find("y").text)) for p in lanelet.findall(f"{side}Bound/point")]

    def links(self, lanelet, name):
        return sorted(int(link.get("ref")) for link in lanelet.findall(name))


def compare_track(name, ours, theirs):
    same(f"{name}: steps", sorted(ours), sorted(theirs))
    for step in ours.keys() & theirs.keys():
        (x, y, heading, velocity), (tx, ty, their_heading, vx, vy) = ours[step], theirs[step]
        at = f"{name}, step {step}"
        same(f"{at}: x", x, tx)
        same(f"{at}: y", y, ty)
        turned(f"{at}: heading", heading, their_heading)
        same(f"{at}: speed", abs(velocity), math.hypot(vx, vy))


def compare_all(converted, tracks, ego):
    """Tracks by id: states by step."""
    same("tracks", sorted(converted.obstacles), sorted(id for id in tracks if id != ego))
    for id, obstacle in converted.obstacles.items():
        if id in tracks:
            compare_track(f"track {id}", converted.track(obstacle), tracks[id])
    problem = converted.root.find("planningProblem")
    same("ego", int(problem.get("id")), ego)
    first = min(tracks[ego])
    compare_track("ego", {first: converted.state(problem.find("initialState"))}, {first: tracks[ego][first]})


# Waymo: the wire of protobuf.


def varint(data, at):
    value = shift = 0
    while True:
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at, shift = at + 1, shift + 7
        if byte < 0x80:
            return value, at


def fields(data):
    """The fields of a message: by number, the values in order."""
    found, at = {}, 0
    while at < len(data):
        key, at = varint(data, at)
        kind = key & 7
        if kind == 0:
            value, at = varint(data, at)
            value = value - (1 << 64) if value >= 1 << 63 else value
        elif kind == 1:
            value, at = struct.unpack_from("<d", data, at)[0], at + 8
        elif kind == 5:
            value, at = struct.unpack_from("<f", data, at)[0], at + 4
        else:
            length, at = varint(data, at)
            value, at = data[at : at + length], at + length
        found.setdefault(key >> 3, []).append(value)
    return found


def one(message, number, default=0):
    return message.get(number, [default])[0]


def numbers(values, format_, size):
    """Repeated numbers, packed or not."""
    if values and isinstance(values[0], bytes):
        return [v for packed in values for (v,) in struct.iter_unpack(format_, packed)]
    return values


def ids(message, number):
    values = message.get(number, [])
    if not values or not isinstance(values[0], bytes):
        return values
    found = []
    for packed in values:
        at = 0
        while at < len(packed):
            value, at = varint(packed, at)
            found.append(value)
    return found


def waymo(path, converted):
    data = Path(path).read_bytes()
    (length,) = struct.unpack_from("<Q", data)
    scenario = fields(data[12 : 12 + length])
    steps = len(numbers(scenario[1], "<d", 8))
    tracks, sizes = {}, {}
    order = []
    for raw in scenario[2]:
        track = fields(raw)
        states = {}
        lengths, widths = [], []
        for step, raw_state in enumerate(track.get(3, [])[:steps]):
            state = fields(raw_state)
            if not one(state, 11):
                continue
            states[step] = (one(state, 2), one(state, 3), one(state, 8), one(state, 9), one(state, 10))
            lengths.append(one(state, 5))
            widths.append(one(state, 6))
        order.append(one(track, 1))
        if states:
            tracks[one(track, 1)] = states
            sizes[one(track, 1)] = (statistics.median(lengths), statistics.median(widths))
    compare_all(converted, tracks, order[one(scenario, 6)])
    for id, obstacle in converted.obstacles.items():
        for ours, theirs in zip(converted.size(obstacle), sizes[id]):
            same(f"track {id}: size", ours, float(theirs))
    lanes = {}
    for raw in scenario[8]:
        feature = fields(raw)
        if 3 in feature:
            lanes[one(feature, 1)] = fields(feature[3][0])
    points = {id: [fields(p) for p in lane.get(8, [])] for id, lane in lanes.items()}
    kept = {id for id, line in points.items() if len({(one(p, 1), one(p, 2)) for p in line}) > 1}
    same("lanes left out", sorted(kept - set(converted.lanelets)), [])
    for id in kept & set(converted.lanelets):
        lanelet = converted.lanelets[id]
        left, right = converted.bound(lanelet, "left"), converted.bound(lanelet, "right")
        middle = [(one(p, 1, 0.0), one(p, 2, 0.0)) for p in points[id]]
        middle = [p for i, p in enumerate(middle) if i == 0 or math.dist(p, middle[i - 1]) > 1e-6]
        same(f"lane {id}: points", len(left), len(middle))
        for i, (a, b, m) in enumerate(zip(left, right, middle)):
            # The middle lies between the borders: on the inside of tight bends these are moved.
            detour = math.dist(a, m) + math.dist(m, b) - math.dist(a, b)
            if detour > 0.1 and math.dist(a, m) < 5 and 0 < i < len(middle) - 1:
                differences.append(f"lane {id}: point {i} of its middle is {detour:.2f} m beside its borders")
        for number, name in ((9, "predecessor"), (10, "successor")):
            theirs = sorted(set(ids(lanes[id], number)) & kept)
            same(f"lane {id}: {name}s", converted.links(lanelet, name), theirs)
    # What each light shows, by lane and step.
    words = {1: "red", 4: "red", 7: "red", 2: "yellow", 5: "yellow", 8: "yellow", 3: "green", 6: "green"}
    shown = {}
    for step, raw in enumerate(scenario.get(7, [])[:steps]):
        for raw_state in fields(raw).get(1, []):
            state = fields(raw_state)
            shown.setdefault(one(state, 1), {})[step] = words.get(one(state, 2), "inactive")
    compared = 0
    for lane, colors in shown.items():
        if lane not in converted.lanelets:
            continue
        refs = [int(r.get("ref")) for r in converted.lanelets[lane].findall("trafficLightRef")]
        same(f"lane {lane}: lights", len(refs), 1)
        cycle = []
        for ref in refs[:1]:
            for element in converted.lights[ref].findall("cycle/cycleElement"):
                cycle += [element.find("color").text] * int(float(element.find("duration").text))
        for step in range(steps):
            same(f"light of lane {lane}, step {step}", cycle[step : step + 1], [colors.get(step, "inactive")])
            compared += 1
    return f"{len(tracks)} tracks, {len(kept)} lanes, {compared} states of lights"


def argoverse(folder, converted):
    try:
        import pyarrow.parquet
    except ImportError:
        print("pyarrow is not installed")
        sys.exit(3)
    table = pyarrow.parquet.read_table(next(Path(folder).glob("*.parquet"))).to_pylist()
    by_name = {}
    for row in table:
        values = [row[k] for k in ("position_x", "position_y", "heading", "velocity_x", "velocity_y")]
        by_name.setdefault(row["track_id"], {})[row["timestep"]] = tuple(values)
    ego = int(converted.root.find("planningProblem").get("id"))
    tracks = {ego if name == "AV" else int(name): states for name, states in by_name.items()}
    compare_all(converted, tracks, ego)
    archive = json.loads(next(Path(folder).glob("log_map_archive_*.json")).read_text())
    lanes = archive["lane_segments"].values()
    known = {lane["id"] for lane in lanes}
    for lane in lanes:
        lanelet = converted.lanelets.get(lane["id"])
        if lanelet is None:
            differences.append(f"lane {lane['id']} is missing")
            continue
        for side in ("left", "right"):
            # Points may be added, so that both borders have as many; none is moved or lost.
            ours = converted.bound(lanelet, side)
            for p in lane[f"{side}_lane_boundary"]:
                off = min(math.dist((p["x"], p["y"]), q) for q in ours)
                same(f"lane {lane['id']}: {side}", off, 0.0, 1e-3)
        for key, name in (("predecessors", "predecessor"), ("successors", "successor")):
            theirs = sorted(set(lane[key]) & known)
            same(f"lane {lane['id']}: {name}s", converted.links(lanelet, name), theirs)
    return f"{len(tracks)} tracks, {len(known)} lanes"


kind, source, path = sys.argv[1:]
said = {"waymo": waymo, "argoverse": argoverse}[kind](source, Converted(path))
print(f"compared {said}: {len(differences)} differences")
print("\n".join(differences[:20]))
sys.exit(bool(differences))
