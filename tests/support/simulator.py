"""Plays an exported scenario with esmini and compares it with the CommonRoad file that it was made of.

    python3 simulator.py ESMINI_FOLDER SCENARIO.xml EGO.csv EXPORT.xosc

Standard library only. Prints one JSON object:
position (m) and heading (rad): largest differences of the entities' bodies at any step; missing, extra: entities that are
not there at a step, or there without a record; contact: the first step at which the ego touches another body, in the
player and in the file; log: errors and warnings; border (m): the largest distance of lane borders sampled by odrplot from
the lanelets'; uncovered (m): the largest distance of the lanelets' borders from those.
"""

import csv
import json
import math
import os
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET


def number(element, path):
    found = element.find(path)
    if found is None:
        return None
    exact = found.find("exact")
    if exact is not None:
        return float(exact.text)
    return (float(found.find("intervalStart").text) + float(found.find("intervalEnd").text)) / 2


def shape_box(shape):
    """Corners of the box around a shape, in the object's frame, as (xmin, xmax, ymin, ymax)."""
    points = []
    for part in shape:
        center = part.find("center")
        cx = float(center.find("x").text) if center is not None else 0.0
        cy = float(center.find("y").text) if center is not None else 0.0
        if part.tag == "rectangle":
            a = float(part.findtext("orientation") or 0)
            shift = float(part.findtext("originXShift") or 0)
            length, width = float(part.find("length").text), float(part.find("width").text)
            for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
                x, y = x * length / 2 - shift, y * width / 2
                points.append((cx + x * math.cos(a) - y * math.sin(a), cy + x * math.sin(a) + y * math.cos(a)))
        elif part.tag == "circle":
            r = float(part.find("radius").text)
            points += [(cx + r, cy + r), (cx - r, cy - r)]
        elif part.tag == "polygon":
            points += [(float(p.find("x").text), float(p.find("y").text)) for p in part.findall("point")]
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    return min(xs), max(xs), min(ys), max(ys)


class Body:
    def __init__(self, box, stands):
        self.box, self.stands, self.states = box, stands, {}

    def at(self, step):
        if self.stands:
            return next(iter(self.states.values()), None)
        return self.states.get(step)

    def center(self, state):
        x, y, h = state
        cx, cy = (self.box[0] + self.box[1]) / 2, (self.box[2] + self.box[3]) / 2
        return x + cx * math.cos(h) - cy * math.sin(h), y + cx * math.sin(h) + cy * math.cos(h)

    def corners(self, state):
        cx, cy = self.center(state)
        h = state[2]
        l, w = (self.box[1] - self.box[0]) / 2, (self.box[3] - self.box[2]) / 2
        return [
            (cx + a * l * math.cos(h) - b * w * math.sin(h), cy + a * l * math.sin(h) + b * w * math.cos(h))
            for a, b in ((1, 1), (1, -1), (-1, -1), (-1, 1))
        ]


def overlap(a, b):
    """Whether two convex quadrilaterals share an area."""
    for one in (a, b):
        for i in range(4):
            (x0, y0), (x1, y1) = one[i], one[(i + 1) % 4]
            nx, ny = y0 - y1, x1 - x0
            pa = [nx * x + ny * y for x, y in a]
            pb = [nx * x + ny * y for x, y in b]
            if max(pa) < min(pb) or max(pb) < min(pa):
                return False
    return True


def state_of(element):
    point = element.find("position/point")
    heading = number(element, "orientation")
    if point is None or heading is None:
        return None
    return float(point.find("x").text), float(point.find("y").text), heading


def bodies(root):
    found = {}
    for tag in ("staticObstacle", "dynamicObstacle", "obstacle"):
        for obstacle in root.iter(tag):
            shape, initial = obstacle.find("shape"), obstacle.find("initialState")
            if shape is None or initial is None:
                continue
            stands = tag == "staticObstacle" or obstacle.findtext("role") == "static"
            body = Body(shape_box(shape), stands)
            states = [initial] + ([] if stands else obstacle.findall("trajectory/state"))
            for state in states:
                place, step = state_of(state), number(state, "time")
                if place is not None and step is not None:
                    body.states[int(step)] = place
            if body.states:
                found[obstacle.get("id")] = body
    return found


def recorded(path, box, resting):
    """An ego of a table with the columns step or time, x, y and heading."""
    body = Body(box, False)
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            row = {k.strip(): v for k, v in row.items() if k}
            step = row.get("step", row.get("time_step", row.get("timestep")))
            heading = row.get("orientation", row.get("heading"))
            body.states[int(float(step))] = (float(row.get("x_position", row.get("x"))), float(row.get("y_position", row.get("y"))), float(heading))
    # Recorders write the direction of the last displacement, which says nothing at a standstill: it is held there.
    steps = sorted(body.states)
    known = {s: body.states[s][2] for s in steps}
    for a, b in zip(steps, steps[1:]):
        if math.dist(body.states[a][:2], body.states[b][:2]) < 0.005:
            known[b] = None
            if a == steps[0]:
                known[a] = None
    held = resting if resting is not None else next((h for h in known.values() if h is not None), 0.0)
    for s in steps:
        held = held if known[s] is None else known[s]
        body.states[s] = (*body.states[s][:2], held)
    return body


def ego_of(xosc, dt):
    """The ego as the export gives it: for scenarios whose table is not read here."""
    root = ET.parse(xosc).getroot()
    for entity in root.iter("ScenarioObject"):
        if entity.get("name") == "ego":
            c, d = entity.find(".//Center"), entity.find(".//Dimensions")
            x, y = float(c.get("x")), float(c.get("y"))
            l, w = float(d.get("length")) / 2, float(d.get("width")) / 2
            return x - l, x + l, y - w, y + w
    return None


def rows(path):
    """Time and entities of each row: name → (x, y, heading, bb_x, bb_y)."""
    with open(path) as file:
        lines = file.read().split("\n")
    start = next(i for i, line in enumerate(lines) if "TimeStamp" in line)
    names = [cell.strip() for cell in lines[start].split(",")]
    width = sum(1 for name in names if name.startswith("#1 "))
    first = names.index(next(name for name in names if name.startswith("#1 ")))
    at = lambda name: names.index("#1 " + name) - first
    columns = [at(name) for name in ("World_Position_X [m]", "World_Position_Y [m]", "World_Heading_Angle [rad]", "bb_x [m]", "bb_y [m]")]
    for line in lines[start + 1 :]:
        cells = [cell.strip() for cell in line.split(",")]
        if len(cells) < first + 2:
            continue
        found = {}
        # Entities follow each other; each begins with its name and its number.
        place = first
        while place + max(columns) < len(cells):
            found[cells[place]] = [float(cells[place + c]) for c in columns]
            place += width
            while place < len(cells) and not cells[place]:
                place += 1
        yield float(cells[1]), found


def to_segment(p, a, b):
    (px, py), (ax, ay), (bx, by) = p, a, b
    dx, dy = bx - ax, by - ay
    n = dx * dx + dy * dy
    t = 0 if n == 0 else max(0, min(1, ((px - ax) * dx + (py - ay) * dy) / n))
    return math.hypot(px - ax - t * dx, py - ay - t * dy)


class Lines:
    """Segments in cells, to find the nearest one quickly."""

    def __init__(self, lines, cell=4.0):
        self.cell, self.cells = cell, {}
        for line in lines:
            for a, b in zip(line, line[1:]):
                x0, x1 = sorted((a[0], b[0]))
                y0, y1 = sorted((a[1], b[1]))
                for i in range(int(x0 // cell), int(x1 // cell) + 1):
                    for j in range(int(y0 // cell), int(y1 // cell) + 1):
                        self.cells.setdefault((i, j), []).append((a, b))

    def distance(self, p):
        i, j = int(p[0] // self.cell), int(p[1] // self.cell)
        best = float("inf")
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                for a, b in self.cells.get((i + di, j + dj), ()):
                    best = min(best, to_segment(p, a, b))
        return best


def borders(root, odr, plotter, folder):
    out = os.path.join(folder, "lanes.csv")
    ended = subprocess.run([plotter, odr, out, "0.25"], cwd=folder, capture_output=True, text=True)
    sampled, current = [], None
    if ended.returncode == 0 and os.path.exists(out):
        for line in open(out):
            if line.startswith("lane"):
                current = []
                sampled.append(current)
            else:
                x, y = line.split(",")[:2]
                current.append((float(x), float(y)))
    lanelets = []
    for lanelet in root.iter("lanelet"):
        for side in ("leftBound", "rightBound"):
            bound = lanelet.find(side)
            if bound is not None:
                lanelets.append([(float(p.find("x").text), float(p.find("y").text)) for p in bound.findall("point")])
    if not lanelets:
        return 0.0, 0.0
    own, other = Lines(lanelets), Lines(sampled)
    off = max((own.distance(p) for line in sampled for p in line), default=float("inf"))
    missed = max(other.distance(p) for line in lanelets for p in line)
    return off, missed


def main():
    folder_of_esmini, source, ego_file, xosc = sys.argv[1:5]
    root = ET.parse(source).getroot()
    dt = float(root.get("timeStepSize"))
    all_bodies = bodies(root)
    box = ego_of(xosc, dt)
    if ego_file != "-" and box is not None:
        problem = root.find("planningProblem/initialState")
        all_bodies["ego"] = recorded(ego_file, box, None if problem is None else number(problem, "orientation"))
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.csv")
        command = [os.path.join(folder_of_esmini, "esmini"), "--osc", os.path.abspath(xosc), "--headless"]
        command += ["--fixed_timestep", repr(dt), "--collision", "--csv_logger", out, "--disable_stdout"]
        ended = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=600)
        log = []
        if os.path.exists(os.path.join(folder, "log.txt")):
            log = open(os.path.join(folder, "log.txt")).read().split("\n")
        # Pictures of entities are not part of the player.
        bad = [line for line in log if ("[warn]" in line or "[error]" in line) and "3D model" not in line and "Collision between" not in line]
        position = heading = 0.0
        missing, extra, touched = [], [], None
        first = min([0] + [s for b in all_bodies.values() if not b.stands for s in b.states])
        for time, found in rows(out):
            step = round(time / dt) + first
            present = {n: b.at(step) for n, b in all_bodies.items() if b.at(step) is not None}
            missing += [f"{n}@{step}" for n in present if n not in found]
            extra += [f"{n}@{step}" for n in found if n not in present]
            for name, state in present.items():
                if name not in found:
                    continue
                x, y, h, bx, by = found[name]
                cx, cy = all_bodies[name].center(state)
                position = max(position, math.hypot(x + bx * math.cos(h) - by * math.sin(h) - cx, y + bx * math.sin(h) + by * math.cos(h) - cy))
                heading = max(heading, abs((h - state[2] + math.pi) % (2 * math.pi) - math.pi))
            ego = present.get("ego")
            if touched is None and ego is not None:
                corners = all_bodies["ego"].corners(ego)
                for name, state in present.items():
                    if name != "ego" and overlap(corners, all_bodies[name].corners(state)):
                        touched = step
                        break
        played = None
        for line in log:
            if "Collision between" in line and "ego" in line.split() and "dissolved" not in line:
                played = round(float(line[line.index("[") + 1 : line.index("]")]) / dt) + first
                break
        off, missed = borders(root, os.path.splitext(os.path.abspath(xosc))[0] + ".xodr", os.path.join(folder_of_esmini, "odrplot"), folder)
        print(json.dumps({
            "status": ended.returncode, "position": position, "heading": heading, "missing": missing[:8], "extra": extra[:8],
            "contact": [played, touched], "log": bad[:8], "border": off, "uncovered": missed,
        }))


main()
