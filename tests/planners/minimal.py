"""Keeps its lane behind the vehicle ahead with the Intelligent Driver Model (Treiber et al. 2000)."""
import json, math, sys
STEP = 0.5  # metres between the points of a path
def points_of(lanelet):  # points of the centre line, each with its heading
    centre = [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in zip(lanelet["left"], lanelet["right"])]
    for (ax, ay), (bx, by) in zip(centre, centre[1:]):
        count, heading = round(math.dist((ax, ay), (bx, by)) / STEP) or 1, math.atan2(by - ay, bx - ax)
        yield from ((ax + (bx - ax) * i / count, ay + (by - ay) * i / count, heading) for i in range(count))
def path_from(hello):  # along the lane of the start and what follows it
    start, path = hello["problem"]["start"], []
    lanes = {one["id"]: (list(points_of(one)), one["successors"]) for one in hello["road"]["lanelets"]}
    fit = lambda p: math.dist(p[:2], (start["x"], start["y"])) - 9 * math.cos(p[2] - start["heading"])
    lane = min(lanes, key=lambda id: min(map(fit, lanes[id][0])))
    while lane in lanes and len(path) < 4000:
        path, lane = path + lanes[lane][0], next(iter(lanes[lane][1]), None)
    return path
def project(path, x, y):  # arc length, offset to the left, heading of the path there
    i = min(range(len(path)), key=lambda i: math.dist(path[i][:2], (x, y)))
    dx, dy, cos, sin = x - path[i][0], y - path[i][1], math.cos(path[i][2]), math.sin(path[i][2])
    return i * STEP + dx * cos + dy * sin, dy * cos - dx * sin, path[i][2]
def plan(hello, path, now):
    ego, dt, car, wanted = now["ego"], hello["dt"], hello["vehicle"], max(8, hello["problem"]["start"]["velocity"])
    (s, d, heading), v, states = project(path, ego["x"], ego["y"]), ego["velocity"], [ego]
    seen = [(project(path, o["x"], o["y"]), o) for o in now["obstacles"] + hello["static_obstacles"]]
    ahead = [(p[0] - o["length"] / 2, o["velocity"]) for p, o in seen if abs(p[1]) < 1.8 and p[0] > s]
    gap, lead = min(ahead, default=(1e9, 0))
    gap, turned = gap - s - car["rear_to_centre"] - car["length"] / 2, ego["heading"] - heading + d / 8
    for _ in range(round(hello["horizon"] / dt)):
        space = 2 + max(0, 1.2 * v + v * (v - lead) / 3.5)  # the gap that it wants
        a = max(-8, 1.5 * (1 - (v / wanted) ** 4 - (space / max(gap, 0.1)) ** 2))
        v, way = max(0, v + a * dt), max(0, v + a * dt / 2) * dt
        s, gap, d, turned = s + way, gap + lead * dt - way, d * math.exp(-way / 8), turned * math.exp(-way / 8)
        (x, y, heading), r = path[min(int(s / STEP), len(path) - 1)], s - min(int(s / STEP), len(path) - 1) * STEP
        states.append({"x": x + r * math.cos(heading) - d * math.sin(heading), "velocity": v, "acceleration": a,
                       "y": y + r * math.sin(heading) + d * math.cos(heading), "heading": heading - d / 8 + turned})
    return {"type": "trajectory", "step": now["step"], "states": states}
while (message := json.loads(sys.stdin.readline() or '{"type": "bye"}'))["type"] != "bye":
    if message["type"] == "hello": hello, path = message, path_from(message)
    ready = {"type": "ready", "protocol": 1, "name": "minimal", "version": "1", "reusable": True}
    print(json.dumps(plan(hello, path, message) if message["type"] == "plan" else ready), flush=True)
