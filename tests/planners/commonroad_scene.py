"""What the adapters share: messages of nearmiss as objects of commonroad-io, and the loop over standard input.

Signs and lights are left out: neither planner obeys them.
"""
import json
import math
import os
import sys
import time

import numpy as np
from commonroad.common.util import AngleInterval, Interval
from commonroad.geometry.shape import Polygon, Rectangle, ShapeGroup
from commonroad.planning.goal import GoalRegion
from commonroad.planning.planning_problem import PlanningProblem
from commonroad.scenario.lanelet import Lanelet, LaneletNetwork, LaneletType, RoadUser
from commonroad.scenario.obstacle import DynamicObstacle, ObstacleType, StaticObstacle
from commonroad.scenario.scenario import Scenario, ScenarioID
from commonroad.scenario.state import CustomState, InitialState


def lanelet(said):
    left, right = np.array(said["left"]), np.array(said["right"])
    beside = lambda side, key: (said[side] or {}).get(key)
    return Lanelet(left, (left + right) / 2, right, said["id"], said["predecessors"], said["successors"],
                   beside("left_neighbour", "id"), beside("left_neighbour", "same_direction"),
                   beside("right_neighbour", "id"), beside("right_neighbour", "same_direction"),
                   lanelet_type={LaneletType(name) for name in said["types"]},
                   user_one_way={RoadUser(name) for name in said["users_one_way"]},
                   user_bidirectional={RoadUser(name) for name in said["users_bidirectional"]})


def obstacle(said, step, kind=DynamicObstacle):
    state = InitialState(time_step=step, position=np.array([said["x"], said["y"]]), orientation=said["heading"],
                         velocity=said["velocity"], acceleration=said["acceleration"], yaw_rate=0.0, slip_angle=0.0)
    return kind(said["id"], ObstacleType(said["type"]), Rectangle(said["length"], said["width"]), state)


def problem(said, step, network):
    states, lanelets = [], {}
    for place, goal in enumerate(said["goals"]):
        state = {"time_step": Interval(goal["first_step"], goal["last_step"])}
        shapes = [Polygon(np.array(area)) for area in goal["areas"]]
        if goal["lanelets"]:
            lanelets[place] = goal["lanelets"]
            shapes += [network.find_lanelet_by_id(id).polygon for id in goal["lanelets"]]
        if shapes:
            state["position"] = ShapeGroup(shapes) if goal["lanelets"] or len(shapes) > 1 else shapes[0]
        if goal["velocity"]:
            state["velocity"] = Interval(*goal["velocity"])
        if goal["heading"]:
            state["orientation"] = AngleInterval(*goal["heading"])
        states.append(CustomState(**state))
    start = said["start"]
    initial = InitialState(time_step=step, position=np.array([start["x"], start["y"]]), orientation=start["heading"],
                           velocity=start["velocity"], acceleration=start["acceleration"],
                           yaw_rate=start["yaw_rate"], slip_angle=0.0)
    return PlanningProblem(said["id"], initial, GoalRegion(states, lanelets or None))


def scene(hello):
    """The road with what stands on it, and the planning problem."""
    scenario = Scenario(hello["dt"], ScenarioID.from_benchmark_id(hello["scenario"], "2020a"))
    network = LaneletNetwork.create_from_lanelet_list([lanelet(one) for one in hello["road"]["lanelets"]])
    scenario.add_objects(network)
    scenario.add_objects([obstacle(one, hello["first_step"], StaticObstacle) for one in hello["static_obstacles"]])
    return scenario, problem(hello["problem"], hello["first_step"], scenario.lanelet_network)


def state(said):
    """A planned state of the rear axle as nearmiss reads it."""
    return {"x": float(said.position[0]), "y": float(said.position[1]),
            "heading": math.remainder(said.orientation, math.tau), "velocity": float(said.velocity), "acceleration": float(said.acceleration),
            "steering": float(said.steering_angle)}


def serve(name, version, start, **wants):
    """Answers nearmiss: `start(hello)` gives a function from `plan` messages to states, or to None without a plan."""
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # What packages print is no message.
    say = lambda message: print(json.dumps(message), file=out, flush=True)
    for message in map(json.loads, sys.stdin):
        if message["type"] == "bye":
            break
        try:
            if message["type"] == "hello":
                plan = start(message)
                say({"type": "ready", "protocol": 1, "name": name, "version": version, "reusable": True, **wants})
                continue
            began = time.perf_counter()
            states = plan(message)
        except Exception as error:  # noqa: BLE001
            say({"type": "error", "message": f"{type(error).__name__}: {error}"})
            raise
        if not states:
            say({"type": "error", "message": "no feasible trajectory", "infeasible": True})
            continue
        ms = (time.perf_counter() - began) * 1e3
        say({"type": "trajectory", "step": message["step"], "states": [state(one) for one in states], "ms": ms})
