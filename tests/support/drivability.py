"""Asks commonroad-drivability-checker whether trajectories can be driven.

Reads a JSON list of {name, dt, states} and writes one of {name, model, fails_at}; fails_at is the time step from which
the next state cannot be reached, or null.
"""

import json
import math
import sys

import numpy as np
from commonroad.common.solution import VehicleType
from commonroad.scenario.state import KSState, PMState
from commonroad.scenario.trajectory import Trajectory
from commonroad_dc.feasibility.feasibility_checker import trajectory_feasibility
from commonroad_dc.feasibility.vehicle_dynamics import VehicleDynamics


def kinematic(s):
    return KSState(
        time_step=s["step"],
        position=np.array([s["x"], s["y"]]),
        steering_angle=s["steering"],
        velocity=s["velocity"],
        orientation=s["heading"],
    )


def point_mass(s):
    """The centre moves sideways as the body turns about its rear axle."""
    sideways = s["yaw_rate"] * s["rear_to_centre"]
    cos, sin = math.cos(s["heading"]), math.sin(s["heading"])
    return PMState(
        time_step=s["step"],
        position=np.array([s["x"], s["y"]]),
        velocity=s["velocity"] * cos - sideways * sin,
        velocity_y=s["velocity"] * sin + sideways * cos,
    )


def main():
    vehicle = VehicleType.BMW_320i
    models = [("KS", kinematic, VehicleDynamics.KS(vehicle)), ("PM", point_mass, VehicleDynamics.PM(vehicle))]
    said = []
    for given in json.load(sys.stdin):
        for name, state, dynamics in models:
            states = [state(s) for s in given["states"]]
            trajectory = Trajectory(states[0].time_step, states)
            feasible, inputs = trajectory_feasibility(trajectory, dynamics, given["dt"])
            fails_at = None if feasible else inputs.state_list[-1].time_step
            said.append({"name": given["name"], "model": name, "fails_at": fails_at})
    json.dump(said, sys.stdout)


main()
