//! Checks planning problems: starts and goals that no vehicle can have.

use std::f64::consts::TAU;

use super::{ElementRef, Findings, beyond, gap, obstacles};
use crate::scenario::{
    Goal, LONGEST_TRACK, LaneletNetwork, Obstacle, ObstacleRole, PlanningProblem, Position,
    Quantity, Scenario, StateField, Steps,
};
use nearmiss_base::geometry::{Bounds, Point, angle_between};

/// No planning problem starts farther from the road, metres.
const OFF_ROAD: f64 = 1.0;

/// A goal farther from the road than this, metres, is on another map.
const GOAL_OFF_ROAD: f64 = 50.0;

/// Against the lane it starts on, a vehicle looks by more than this: 120°.
const MAX_HEADING_ERROR: f64 = TAU / 3.0;

/// No road user accelerates more, m/s².
const STRONGEST: f64 = 12.0;

pub(super) fn check(scenario: &Scenario, found: &mut Findings) {
    for (place, problem) in scenario.planning_problems.iter().enumerate() {
        let id = problem.id;
        let about = ElementRef::Start(place);
        let mut say = |message: String| {
            found.warn(about, format!("planning problem {id}: {message}"));
        };
        start(scenario, problem, &mut say);
        for (i, goal) in problem.goals.iter().enumerate() {
            let about = ElementRef::Goal {
                problem: place,
                goal: i,
            };
            let mut say = |message: String| {
                found.warn(about, format!("planning problem {id}: {message}"));
            };
            self::goal(scenario, problem, goal, &mut say);
        }
    }
}

fn start(scenario: &Scenario, problem: &PlanningProblem, say: &mut impl FnMut(String)) {
    let initial = &problem.initial;
    for (_, message) in obstacles::quantities(&[initial]) {
        say(message);
    }
    if initial.time.from < 0 || initial.time.from > LONGEST_TRACK {
        say(format!("starts at time step {}", initial.time.from));
    }
    let Some(at) = initial.point() else {
        match &initial.position {
            None => say("initial state has no position".into()),
            Some(Position::Region(_)) => {
                say("starts in a region; its centre is used".into());
            }
            Some(_) => say("starts on lanelets, without a known point".into()),
        }
        return;
    };
    let heading = initial.orientation.map(|o| o.middle());
    place(&scenario.network, &at, heading, say);
    let covers = |o: &&Obstacle| {
        matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic)
            && !o.is_occupancy_at(initial.time.from)
            && o.placed_at(initial.time.from)
                .is_some_and(|body| body.holds(&at))
    };
    if let Some(other) = scenario.obstacles.iter().find(covers) {
        say(format!("starts inside obstacle {}", other.id));
    }
}

/// Where on the road it begins, and which way it looks.
fn place(network: &LaneletNetwork, at: &Point, heading: Option<f64>, say: &mut impl FnMut(String)) {
    let Some(around) = network.bounds() else {
        return;
    };
    // Not by the index, which is built only when more is asked.
    let boxes = (0..network.lanelets.len()).map(|i| (i, beyond(&network.bounds_of(i), at)));
    let mut near: Vec<_> = boxes.filter(|(_, metres)| *metres <= OFF_ROAD).collect();
    near.retain(|(i, _)| network.lanelets[*i].distance(at) <= OFF_ROAD);
    if near.is_empty() {
        let off = beyond(&around, at);
        say(if off > OFF_ROAD {
            format!("starts {off:.0} m from the road; is a coordinate wrong?")
        } else {
            "starts off the road".into()
        });
        return;
    }
    let Some(heading) = heading else { return };
    let mut least = f64::MAX;
    for (i, _) in near {
        let lanelet = &network.lanelets[i];
        if !lanelet.users_bidirectional.is_empty() || lanelet.borders_disagree() {
            return;
        }
        let legs = lanelet.left.points.windows(2);
        let nearest = legs.min_by(|a, b| {
            let off = |pair: &[Point]| (nalgebra::center(&pair[0], &pair[1]) - at).norm();
            off(a).total_cmp(&off(b))
        });
        if let Some(leg) = nearest {
            let way = leg[1] - leg[0];
            least = least.min(angle_between(way.y.atan2(way.x), heading).abs());
        }
    }
    if least > MAX_HEADING_ERROR {
        say(format!(
            "starts against its lane, at {:.0}° to it",
            least.to_degrees()
        ));
    }
}

fn goal(scenario: &Scenario, problem: &PlanningProblem, goal: &Goal, say: &mut impl FnMut(String)) {
    let begins = problem.initial.time.from;
    let Steps { from, to } = goal.time;
    if to <= begins {
        say(format!(
            "a goal ends at time step {to}, but the problem starts at {begins}; it cannot be reached"
        ));
    }
    // An open end was said where it was read.
    if to < super::LATEST_STEP && to.saturating_sub(begins) > LONGEST_TRACK {
        say(format!(
            "a goal from time step {from} to {to}, {:.0} s after the start",
            to.saturating_sub(begins) as f64 * scenario.dt()
        ));
    }
    if let Some(velocity) = goal.velocity {
        let (low, high) = ends(velocity);
        if high < -super::FASTEST_BACKWARDS || low > super::FASTEST {
            say(format!(
                "a goal speed of {low} to {high} m/s is unreachable for road users"
            ));
        }
    }
    if let Some(orientation) = goal.orientation {
        let (low, high) = ends(orientation);
        if high - low > TAU {
            say(format!(
                "a goal with headings from {low} to {high}, more than a full turn"
            ));
        } else if let Some(message) = super::doubtful(StateField::Orientation, orientation) {
            say(format!("a goal: {message}"));
        }
    }
    let around = scenario.network.bounds();
    for position in &goal.positions {
        let Some(bounds) = self::position_bounds(&scenario.network, position) else {
            continue;
        };
        if let Position::Region(region) = position
            && let Some((a, b)) = obstacles::crossing(region)
        {
            say(format!(
                "outline of a goal crosses itself after corners {} and {}",
                a + 1,
                b + 1
            ));
        }
        let off = around.map_or(0.0, |road| gap(&road, &bounds));
        if off > GOAL_OFF_ROAD {
            say(format!(
                "a goal {off:.0} m from the road; is a coordinate wrong?"
            ));
        }
        too_far(scenario.dt(), problem, to, &bounds, say);
    }
}

/// A goal that lies farther away than any vehicle gets until then.
fn too_far(
    dt: f64,
    problem: &PlanningProblem,
    until: i64,
    goal: &Bounds,
    say: &mut impl FnMut(String),
) {
    let Some(at) = problem.initial.point() else {
        return;
    };
    let time = until.saturating_sub(problem.initial.time.from) as f64 * dt;
    let metres = beyond(goal, &at);
    let speed = problem.initial.velocity.map_or(0.0, |v| v.middle().abs());
    let reach = (speed * time + STRONGEST * time * time / 2.0).min(super::FASTEST * time);
    if time > 0.0 && metres > reach {
        say(format!(
            "a goal {metres:.0} m away in {time:.1} s, too far for any vehicle"
        ));
    }
}

fn ends(quantity: Quantity) -> (f64, f64) {
    match quantity {
        Quantity::Exact(value) => (value, value),
        Quantity::Interval(from, to) => (from, to),
    }
}

/// The box around a place; `None` for missing lanelets.
fn position_bounds(network: &LaneletNetwork, position: &Position) -> Option<Bounds> {
    match position {
        Position::Point(p) => Some(Bounds { min: *p, max: *p }),
        Position::Region(shape) => Bounds::from_points(shape.outlines().iter().flatten()),
        Position::Lanelets(ids) => {
            let places = ids.iter().filter_map(|id| network.place(*id));
            let boxes = places.map(|place| network.bounds_of(place));
            boxes.reduce(|a, b| a.union(&b))
        }
    }
}
