"""Keeps its lane behind the vehicle ahead: Intelligent Driver Model (Treiber et al. 2000) on the lane's centre line."""
import json, math, sys

def centre(lanelet):
    return [((a + c) / 2, (b + d) / 2) for (a, b), (c, d) in zip(lanelet["left"], lanelet["right"])]

def place(path, x, y):  # distance, arc length, offset to the left and heading of the nearest point
    best, s = (math.inf, 0, 0, 0), 0
    for (ax, ay), (bx, by) in zip(path, path[1:]):
        dx, dy, length = bx - ax, by - ay, math.dist((ax, ay), (bx, by)) or 1e-9
        t = min(1, max(0, ((x - ax) * dx + (y - ay) * dy) / length ** 2))
        off, left = math.dist((x, y), (ax + t * dx, ay + t * dy)), (dx * (y - ay) - dy * (x - ax)) / length
        best = min(best, (off, s + t * length, left, math.atan2(dy, dx)))
        s += length
    return best

def at(path, s):  # the pose at an arc length; beyond the end straight on
    for (ax, ay), (bx, by) in zip(path, path[1:]):
        length = math.dist((ax, ay), (bx, by)) or 1e-9
        if s <= length or (bx, by) == path[-1]:
            return ax + (bx - ax) * s / length, ay + (by - ay) * s / length, math.atan2(by - ay, bx - ax)
        s -= length

def route(lanelets, start):  # the lane of the start and what follows it
    near = lambda one: (lambda p: p[0] + 9 * (math.cos(p[3] - start["heading"]) < 0))(place(centre(one), start["x"], start["y"]))
    lane, path, seen = min(lanelets.values(), key=near), [], set()
    while lane and lane["id"] not in seen:
        seen.add(lane["id"])
        path += centre(lane)[bool(path):]
        lane = lanelets.get((lane["successors"] or [None])[0])
    return path

def plan(hello, path, wanted, step, ego, obstacles):
    dt, length, v = hello["dt"], hello["vehicle"]["length"], ego["velocity"]
    front = hello["vehicle"]["rear_to_centre"] + length / 2
    _, s, d, heading = place(path, ego["x"], ego["y"])
    turned = (ego["heading"] - heading + math.atan(d / 8) + math.pi) % math.tau - math.pi
    seen = [(place(path, o["x"], o["y"]), o) for o in obstacles]
    gaps = [(p[1] - o["length"] / 2 - s - front, o["velocity"]) for p, o in seen if p[0] < 1.8 and p[1] > s]
    gap, lead = min(gaps, default=(math.inf, 0))
    states = [ego]
    for _ in range(round(hello["horizon"] / dt)):
        space = 2 + max(0, v * 1.2 + v * (v - lead) / (2 * math.sqrt(1.5 * 2)))
        a = max(-8, 1.5 * (1 - (v / wanted) ** 4 - (space / max(gap, 0.1)) ** 2))
        way = max(0, v * dt + a * dt * dt / 2)
        v, s, gap, left = max(0, v + a * dt), s + way, gap + lead * dt - way, math.exp(-way / 8)
        d, turned = d * left, turned * left
        x, y, heading = at(path, s)
        states.append({"x": x - d * math.sin(heading), "y": y + d * math.cos(heading), "velocity": v,
                       "heading": heading - math.atan(d / 8) + turned, "acceleration": a})
    states[0] = {key: ego[key] for key in ("x", "y", "heading", "velocity", "acceleration")}
    return {"type": "trajectory", "step": step, "states": states}

for line in sys.stdin:
    message = json.loads(line)
    if message["type"] == "hello":
        hello, start = message, message["problem"]["start"]
        path = route({one["id"]: one for one in hello["road"]["lanelets"]}, start)
        answer = {"type": "ready", "protocol": 1, "name": "minimal", "version": "1", "reusable": True, "stateless": True}
    elif message["type"] == "plan":
        others = message["obstacles"] + hello["static_obstacles"]
        answer = plan(hello, path, max(8, start["velocity"]), message["step"], message["ego"], others)
    else:
        break
    print(json.dumps(answer), flush=True)
