//! In what the elements of two scenarios differ: motions, bodies, borders, links, cycles, goals.

use std::collections::{BTreeMap, BTreeSet};

use super::{FieldDifference, Found, SAME, apart, same_shape};
use crate::scenario::{
    Ego, Goal, Lanelet, Motion, Obstacle, ObstacleRole, PlanningProblem, Position, Prediction,
    Scenario, Sign, State, Steps, Track, TrafficLight,
};

/// The lines of the summary, the id, where it is, and the other attributes of the root.
pub(super) fn about(a: &Scenario, b: &Scenario) -> Found {
    let mut found = Found::default();
    let id = |of: &Scenario| Some(of.header.benchmark_id.clone());
    found.words("benchmark id", id(a), id(b));
    let (of_a, of_b) = (a.summary(), b.summary());
    let said = |lines: &[(&'static str, String)], word: &str| {
        let mut lines = lines.iter();
        lines
            .find(|(known, _)| *known == word)
            .map(|(_, said)| said.clone())
    };
    let mut seen = BTreeSet::new();
    for (word, _) in of_a.iter().chain(&of_b) {
        if seen.insert(*word) {
            found.words(word, said(&of_a, word), said(&of_b, word));
        }
    }
    found.other("location", a.location == b.location);
    found
}

pub(super) fn egos(a: &Ego, b: &Ego, found: &mut Found) {
    found.body(Some(&a.footprint), Some(&b.footprint));
    found.words("steps", steps(&a.track), steps(&b.track));
    let motions = a.track.iter();
    motion(
        motions.filter_map(|(step, m)| Some((step, m, b.track.at(step)?))),
        found,
    );
}

/// The steps of a track, and how many within them it lacks.
fn steps(track: &Track) -> Option<String> {
    let steps = track.steps();
    let mut gaps = steps.clone().filter(|step| track.at(*step).is_none());
    let lacking = gaps.next().map(|first| (first, gaps.count() + 1));
    let gaps = lacking.map_or_else(String::new, |(first, count)| {
        format!(" without {count}, {first} first")
    });
    (!steps.is_empty()).then(|| format!("{} to {}{gaps}", steps.start, steps.end - 1))
}

/// The largest differences of two motions, and when they are.
fn motion<'m>(pairs: impl Iterator<Item = (i64, &'m Motion, &'m Motion)>, found: &mut Found) {
    let mut largest: [(&str, f64, &str, i64); 4] = [
        ("position", 0.0, "m", 0),
        ("heading", 0.0, "rad", 0),
        ("velocity", 0.0, "m/s", 0),
        ("acceleration", 0.0, "m/s²", 0),
    ];
    for (step, a, b) in pairs {
        let accelerated = (a.acceleration - b.acceleration).abs();
        let differences = a.differences(b).map(|(_, by)| by);
        let all = differences.into_iter().chain([accelerated]);
        for ((_, most, _, at), by) in largest.iter_mut().zip(all) {
            if by > *most {
                (*most, *at) = (by, step);
            }
        }
    }
    for (field, by, unit, step) in largest {
        found.number(field, by, unit, Some(step));
    }
}

pub(super) fn obstacles(a: &Obstacle, b: &Obstacle, found: &mut Found) {
    let role = |of: &Obstacle| Some(of.role.to_string());
    found.words("role", role(a), role(b));
    let kind = |of: &Obstacle| Some(of.kind.to_string());
    found.words("type", kind(a), kind(b));
    found.body(a.footprint.as_ref(), b.footprint.as_ref());
    if a.role == ObstacleRole::Static && b.role == ObstacleRole::Static {
        // It stands there at all times, whatever step its state has.
        let first = |of: &Obstacle| of.track().steps().start;
        let pair = a.motion_at(first(a)).zip(b.motion_at(first(b)));
        let step = first(a);
        motion(pair.map(|(a, b)| (step, a, b)).into_iter(), found);
        return;
    }
    found.words("steps", steps(a.track()), steps(b.track()));
    let shared = a.track().iter();
    motion(
        shared.filter_map(|(step, m)| Some((step, m, b.track().at(step)?))),
        found,
    );
    states(a, b, found);
    occupancies(&a.prediction, &b.prediction, found);
    let signalled = a.track().iter().map(|(step, _)| step);
    let mut shared = signalled.filter(|step| b.track().at(*step).is_some());
    if let Some(step) = shared.find(|step| {
        let said = |of: &Obstacle| of.signals_at(*step).map(|s| s.signals.clone());
        said(a) != said(b)
    }) {
        found.0.push(FieldDifference {
            field: "signals",
            step: Some(step),
            ..FieldDifference::default()
        });
    }
}

/// What states say beyond motion.
fn states(a: &Obstacle, b: &Obstacle, found: &mut Found) {
    let later: BTreeMap<i64, &State> = b.states().map(|s| (s.time.from, s)).collect();
    let mut largest: BTreeMap<&'static str, (f64, i64)> = BTreeMap::new();
    let mut uncertain = None;
    for state in a.states() {
        let step = state.time.from;
        let Some(other) = later.get(&step) else {
            continue;
        };
        let fields = state
            .more
            .iter()
            .chain(&other.more)
            .map(|(field, _)| *field);
        for field in fields {
            let by = match (state.quantity(field), other.quantity(field)) {
                (Some(a), Some(b)) => apart(a, b),
                _ => f64::INFINITY,
            };
            let most = largest.entry(field.name()).or_insert((0.0, step));
            if by > most.0 {
                *most = (by, step);
            }
        }
        let region = |of: &State| match &of.position {
            Some(Position::Region(shape)) => Some(shape.clone()),
            _ => None,
        };
        let same = match (region(state), region(other)) {
            (Some(a), Some(b)) => same_shape(&a, &b),
            (a, b) => a.is_none() && b.is_none(),
        };
        if !same {
            uncertain.get_or_insert(step);
        }
    }
    for (field, (by, step)) in largest {
        if by.is_finite() {
            found.number(field, by, "", Some(step));
        } else {
            // One of them does not say it.
            found.0.push(FieldDifference {
                field,
                step: Some(step),
                ..FieldDifference::default()
            });
        }
    }
    found.0.extend(uncertain.map(|step| FieldDifference {
        field: "region",
        step: Some(step),
        ..FieldDifference::default()
    }));
}

fn occupancies(a: &Prediction, b: &Prediction, found: &mut Found) {
    let words = |of: &Prediction| match of {
        Prediction::None => "none".to_string(),
        Prediction::Trajectory(_) => "trajectory".to_string(),
        Prediction::Occupancies(all) => format!("{} occupancies", all.len()),
    };
    found.words("prediction", Some(words(a)), Some(words(b)));
    if let (Prediction::Occupancies(a), Prediction::Occupancies(b)) = (a, b)
        && a.len() == b.len()
    {
        let mut pairs = a.iter().zip(b);
        let same = pairs.all(|(a, b)| a.time == b.time && same_shape(&a.region, &b.region));
        found.other("occupancies", same);
    }
}

pub(super) fn lanelets(a: &Lanelet, b: &Lanelet, found: &mut Found) {
    found.line("left bound", &a.left.points, &b.left.points);
    found.line("right bound", &a.right.points, &b.right.points);
    let painted = |of: &Lanelet| [of.left.marking, of.right.marking];
    found.list("markings", &painted(a), &painted(b));
    let high = |of: &Lanelet| [of.left.heights.clone(), of.right.heights.clone()];
    found.other("heights", high(a) == high(b));
    found.list("predecessors", &a.predecessors, &b.predecessors);
    found.list("successors", &a.successors, &b.successors);
    found.other("left neighbour", a.adjacent_left == b.adjacent_left);
    found.other("right neighbour", a.adjacent_right == b.adjacent_right);
    found.other("stop line", a.stop_line == b.stop_line);
    found.list("types", &a.types, &b.types);
    found.list("users", &a.users_one_way, &b.users_one_way);
    found.list(
        "users both ways",
        &a.users_bidirectional,
        &b.users_bidirectional,
    );
    found.list("signs", &a.signs, &b.signs);
    found.list("lights", &a.lights, &b.lights);
}

pub(super) fn signs(a: &Sign, b: &Sign, found: &mut Found) {
    found.place(a.position.as_ref(), b.position.as_ref());
    found.other("elements", a.elements == b.elements);
    found.other("virtual", a.is_virtual == b.is_virtual);
}

pub(super) fn lights(a: &TrafficLight, b: &TrafficLight, found: &mut Found) {
    found.place(a.position.as_ref(), b.position.as_ref());
    let phases = |of: &TrafficLight| -> Vec<String> {
        let phases = of.cycle.iter();
        phases
            .map(|p| format!("{} {}", p.color, p.duration))
            .collect()
    };
    found.list("cycle", &phases(a), &phases(b));
    found.list("offset", &[a.offset], &[b.offset]);
    found.other("active", a.active == b.active);
    found.other("direction", a.direction == b.direction);
}

pub(super) fn problems(a: &PlanningProblem, b: &PlanningProblem, found: &mut Found) {
    let (start, other) = (&a.initial, &b.initial);
    found.list("start step", &[start.time.from], &[other.time.from]);
    found.place(start.middle().as_ref(), other.middle().as_ref());
    found.quantity("heading", "rad", [start.orientation, other.orientation]);
    found.quantity("velocity", "m/s", [start.velocity, other.velocity]);
    let span = |of: &PlanningProblem| -> Vec<String> {
        let times = of.goals.iter().map(|goal| goal.time);
        times
            .map(|Steps { from, to }| format!("{from} to {to}"))
            .collect()
    };
    found.list("goal steps", &span(a), &span(b));
    if a.goals.len() == b.goals.len() {
        let same = |(a, b): (&Goal, &Goal)| {
            let mut of_goal = Found::default();
            of_goal.quantity("heading", "rad", [a.orientation, b.orientation]);
            of_goal.quantity("velocity", "m/s", [a.velocity, b.velocity]);
            let mut places = a.positions.iter().zip(&b.positions);
            let alike = |(a, b): (&Position, &Position)| match (a, b) {
                (Position::Region(a), Position::Region(b)) => same_shape(a, b),
                (Position::Point(a), Position::Point(b)) => (a - b).norm() <= SAME,
                (a, b) => a == b,
            };
            of_goal.0.is_empty() && a.positions.len() == b.positions.len() && places.all(alike)
        };
        found.other("goal", { a.goals.iter().zip(&b.goals) }.all(same));
    }
}
