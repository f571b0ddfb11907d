"""Frenetix for nearmiss: `--planner 'python3 frenetix.py CHECKOUT' --set replan=3`.

CHECKOUT is a checkout of TUM-AVS/Frenetix-Motion-Planner (2024.4). Needs Python 3.9 to 3.11 and: pip install
"frenetix>=0.4.0" "commonroad-drivability-checker~=2024.1" "commonroad-route-planner~=2024.2.1" "commonroad-io~=2024.2"
"commonroad-vehicle-models~=3.0" "numpy<2" "scipy<1.14" "matplotlib~=3.8" "pandas~=2.0" "pygeos~=0.14" methodtools
omegaconf imageio shapely triangle psutil rich. Predictions are those of nearmiss, within the planner's sensor radius
and outside of its cone behind the ego; its learned prediction and its plots are not used.
"""
import math
import os
import sys
import tempfile

CHECKOUT = os.path.abspath(sys.argv[1])
# This file has the name of the package.
here = os.path.dirname(os.path.abspath(__file__))
sys.path = [CHECKOUT] + [path for path in sys.path if os.path.abspath(path or ".") != here] + [here]
sys.argv = sys.argv[:1]  # Its configuration reads the command line, too.
from commonroad_scene import obstacle, scene, serve  # noqa: E402
import numpy as np  # noqa: E402
from cr_scenario_handler.planner_interfaces.frenet_interface import FrenetPlannerInterface  # noqa: E402
from cr_scenario_handler.utils.configuration_builder import ConfigurationBuilder  # noqa: E402
from cr_scenario_handler.utils.sensor_model import get_obstacles_in_radius  # noqa: E402
from frenetix_motion_planner.state import ReactivePlannerState  # noqa: E402

logs = tempfile.TemporaryDirectory()


def configured(hello):
    simulation = ConfigurationBuilder.build_sim_configuration(hello["scenario"], logs.name, CHECKOUT)
    planner = ConfigurationBuilder.build_frenetplanner_configuration(hello["scenario"], CHECKOUT)
    simulation.simulation.log_path = logs.name
    simulation.visualization.save_plots = False
    planner.planning.dt = hello["dt"]
    planner.planning.replanning_frequency = hello["replan"]
    planner.debug.use_cpp = True
    planner.debug.multiproc = False
    planner.debug.activate_logging = False
    planner.debug.msg_log_mode = "ERROR"
    return simulation, planner


def predicted(said, horizon):
    """The likeliest prediction, as the planner reads it, with the covariance of its own ground truth."""
    states = np.array(said["predictions"][0]["states"][:horizon])
    return {"pos_list": states[:, :2], "orientation_list": states[:, 2], "v_list": states[:, 3],
            "cov_list": np.tile(np.eye(2) * 0.1, (len(states), 1, 1)),
            "shape": {"length": said["length"], "width": said["width"]}}


def start(hello):
    scenario, problem = scene(hello)
    config, planning = configured(hello)
    own_id = problem.planning_problem_id
    interface = FrenetPlannerInterface(own_id, planning, config, scenario, problem, logs.name, CHECKOUT)
    horizon = int(planning.planning.planning_horizon / hello["dt"])
    there, own = set(), [hello["first_step"]]

    def state_of(ego, step):
        return ReactivePlannerState(
            time_step=step, position=np.array([ego["x"], ego["y"]]), orientation=ego["heading"],
            velocity=ego["velocity"], acceleration=ego["acceleration"], yaw_rate=ego["yaw_rate"],
            steering_angle=ego["steering"])

    def apart(state, ego):
        return math.hypot(state.position[0] - ego["x"], state.position[1] - ego["y"])

    def corrected(ego, step):
        """The planner goes on from its own state; where the ego is elsewhere, from that."""
        x_0 = interface.x_0
        if apart(x_0, ego) < 1e-3 and abs(x_0.velocity - ego["velocity"]) < 1e-3:
            return
        interface.x_0 = state_of(ego, step)
        interface.x_cl = interface.planner._compute_initial_states(interface.x_0)

    def plan(now):
        step = now["step"]
        planned = interface.replanning_traj is not None
        while planned and own[0] < step and interface.replanning_counter < hello["replan"]:
            interface.step_interface(own[0])
            own[0] += 1
        interface.replanning_counter = 0
        own[0] = step + 1
        if there:
            scenario.remove_obstacle([scenario.obstacle_by_id(id) for id in there])
        there.clear()
        for said in now["obstacles"]:
            scenario.add_objects(obstacle(said, step))
            there.add(said["id"])
        seen = get_obstacles_in_radius(
            scenario, own_id, interface.vehicle_history[-1], step, config.prediction.sensor_radius,
            vehicles_in_cone_angle=config.prediction.cone_angle > 0, config=config)
        predictions = {said["id"]: predicted(said, horizon) for said in now["obstacles"]
                       if said["id"] in seen and said.get("predictions")}
        corrected(now["ego"], step)
        interface.planner.predictionsForCpp.clear()
        interface.update_planner(scenario, predictions)
        found, _ = interface.step_interface(step)
        if not found:
            return None
        first, *later = found.state_list
        # In sharp bends its coordinates along the path jump: that step counts as one that no vehicle can drive.
        return [first if apart(first, now["ego"]) < 0.05 else state_of(now["ego"], step), *later]

    return plan


serve("frenetix", "2024.4", start, predictions=True)
