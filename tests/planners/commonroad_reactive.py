"""commonroad-reactive-planner for nearmiss: `--planner 'python3 commonroad_reactive.py'`.

Needs: pip install commonroad-reactive-planner commonroad-route-planner (2025.1). Obstacles move as the likeliest
prediction says. `replan` is nearmiss's; the horizon is the planner's own, 60 steps or what fits.
"""
import os
import sys

sys.path.append(os.path.dirname(os.path.abspath(__file__)))
from commonroad_scene import scene, serve  # noqa: E402
import numpy as np  # noqa: E402
from commonroad.geometry.shape import Rectangle  # noqa: E402
from commonroad.prediction.prediction import TrajectoryPrediction  # noqa: E402
from commonroad.scenario.obstacle import DynamicObstacle, ObstacleType  # noqa: E402
from commonroad.scenario.state import CustomState, InitialState  # noqa: E402
from commonroad.scenario.trajectory import Trajectory  # noqa: E402
from commonroad_clcs.config import CLCSParams  # noqa: E402
from commonroad_dc import pycrcc  # noqa: E402
from commonroad_dc.boundary.boundary import create_road_boundary_obstacle  # noqa: E402
from commonroad_dc.collision.collision_detection.pycrcc_collision_dispatch import create_collision_object  # noqa: E402
from commonroad_route_planner.fast_api import fast_api  # noqa: E402
from commonroad_rp.reactive_planner import ReactivePlanner  # noqa: E402
from commonroad_rp.state import ReactivePlannerState  # noqa: E402
from commonroad_rp.utility.config import ReactivePlannerConfiguration  # noqa: E402
from commonroad_rp.utility.utils_coordinate_system import CoordinateSystem  # noqa: E402


def moving(said, step):
    """An obstacle with its likeliest prediction."""
    shape = Rectangle(said["length"], said["width"])
    states = said["predictions"][0]["states"] if said.get("predictions") else []
    state = lambda k, s: CustomState(time_step=step + k, position=np.array(s[:2]), orientation=s[2], velocity=s[3])
    initial = InitialState(time_step=step, position=np.array([said["x"], said["y"]]), orientation=said["heading"],
                           velocity=said["velocity"], acceleration=0.0, yaw_rate=0.0, slip_angle=0.0)
    later = [state(k, s) for k, s in enumerate(states) if k > 0]
    prediction = TrajectoryPrediction(Trajectory(step + 1, later), shape) if later else None
    return DynamicObstacle(said["id"], ObstacleType(said["type"]), shape, initial, prediction)


def start(hello):
    scenario, problem = scene(hello)
    config = ReactivePlannerConfiguration()
    config.planning.dt = hello["dt"]
    config.planning.time_steps_computation = min(60, round(hello["horizon"] / hello["dt"]))
    config.planning.__post_init__()
    config.debug.multiproc = False
    config.debug.logging_level = "WARNING"
    config.vehicle.id_type_vehicle = hello["vehicle"]["number"]
    config.update(scenario=scenario, planning_problem=problem)
    route = fast_api.generate_reference_path_from_scenario_and_planning_problem(scenario, problem)
    planner = ReactivePlanner(config)
    planner.set_reference_path(coordinate_system=CoordinateSystem(route.reference_path, clcs_params=CLCSParams()))
    _, boundary = create_road_boundary_obstacle(scenario)
    standing = [create_collision_object(one) for one in scenario.static_obstacles]

    def plan(now):
        checker = pycrcc.CollisionChecker()
        for one in [boundary, *standing]:
            checker.add_collision_object(one)
        for one in now["obstacles"]:
            checker.add_collision_object(create_collision_object(moving(one, now["step"])))
        ego = now["ego"]
        state = ReactivePlannerState(
            time_step=now["step"], position=np.array([ego["x"], ego["y"]]), orientation=ego["heading"],
            velocity=ego["velocity"], acceleration=ego["acceleration"], yaw_rate=ego["yaw_rate"],
            steering_angle=ego["steering"])
        planner.set_desired_velocity(current_speed=ego["velocity"])
        planner._low_vel_mode = ego["velocity"] < config.planning.low_vel_mode_threshold
        planner.reset(initial_state_cart=state, collision_checker=checker, coordinate_system=planner.coordinate_system)
        found = planner.plan()
        return found[0].state_list if found else None

    return plan


serve("commonroad-reactive-planner", "2025.1", start, predictions=True)
