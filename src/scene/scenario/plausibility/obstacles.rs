//! Checks obstacles: their types, positions, times and motions.

use super::{ElementRef, Finding, Findings, Row, and_more, beyond, bodies, limits, motion, times};
use crate::scenario::obstacle::sample;
use crate::scenario::{
    Obstacle, ObstacleRole, ObstacleType, Occupancy, Prediction, Scenario, Severity, State,
    StateField,
};

/// Obstacles farther than this from every lanelet belong to another map, metres.
const OFF_MAP: f64 = 500.0;

/// A static obstacle is slower than this, m/s, and moves less than this, metres.
const STANDING: (f64, f64) = (0.1, 0.5);

pub(super) fn check(scenario: &Scenario, found: &mut Findings) {
    let around = scenario.network.bounds();
    for (place, obstacle) in scenario.obstacles.iter().enumerate() {
        let id = obstacle.id;
        let mut say = |state: Option<usize>, message: String| {
            let about = match state {
                Some(state) => ElementRef::State {
                    obstacle: place,
                    state,
                },
                None => ElementRef::Obstacle(place),
            };
            found.0.push(Finding {
                severity: Severity::Warning,
                about,
                message: format!("obstacle {id}: {message}"),
            });
        };
        bodies::check(obstacle, &mut |message| say(None, message));
        role(obstacle, &mut say);
        match &obstacle.prediction {
            Prediction::Occupancies(regions) => {
                occupancies(regions, &mut |message| say(None, message));
            }
            _ => states(obstacle, scenario.dt(), &mut say),
        }
        if let Some(around) = &around {
            let places = obstacle.states().enumerate();
            let mut off = places.filter_map(|(i, s)| Some((i, beyond(around, &s.middle()?))));
            if let Some((state, metres)) = off.find(|(_, metres)| *metres > OFF_MAP) {
                say(
                    Some(state),
                    format!("{metres:.0} m from every lanelet; is a coordinate wrong?"),
                );
            }
        }
    }
}

/// Contradictions between the role of an obstacle and its other properties.
fn role(obstacle: &Obstacle, say: &mut impl FnMut(Option<usize>, String)) {
    let kind = obstacle.kind;
    let fixed = matches!(
        kind,
        ObstacleType::ParkedVehicle
            | ObstacleType::ConstructionZone
            | ObstacleType::RoadBoundary
            | ObstacleType::Building
            | ObstacleType::Pillar
            | ObstacleType::MedianStrip
    );
    let (slow, near) = STANDING;
    let speeds = || {
        obstacle
            .states()
            .map(|s| s.velocity.map_or(0.0, |v| v.middle().abs()))
    };
    let places: Vec<_> = obstacle.states().filter_map(State::middle).collect();
    let moves = places
        .first()
        .is_some_and(|first| places.iter().any(|p| (p - first).norm() > near));
    match obstacle.role {
        ObstacleRole::Static => {
            if obstacle.prediction != Prediction::None {
                let what = if moves { "moves" } else { "has a prediction" };
                say(
                    None,
                    format!("static but {what}; assumed to stay at its first position"),
                );
            } else if let Some(speed) = speeds().find(|v| *v > slow) {
                say(
                    Some(0),
                    format!("static but drives at {speed} m/s; assumed to stand"),
                );
            }
        }
        ObstacleRole::Dynamic => {
            if fixed && moves {
                say(None, format!("a {kind} that moves"));
            }
            match &obstacle.prediction {
                Prediction::Trajectory(states) if states.is_empty() => {
                    say(None, "trajectory has no states".into());
                }
                Prediction::None if speeds().any(|v| v > slow) => say(
                    Some(0),
                    "drives, but has only an initial state; absent afterwards".into(),
                ),
                Prediction::None if obstacle.initial.is_some() => say(
                    Some(0),
                    "has only an initial state; absent afterwards".into(),
                ),
                _ => {}
            }
        }
        ObstacleRole::Phantom | ObstacleRole::Environment => {}
    }
}

/// The times of regions that may be covered.
fn occupancies(regions: &[Occupancy], say: &mut impl FnMut(String)) {
    if let Some((a, b)) = regions.iter().find_map(|o| bodies::crossing(&o.region)) {
        say(format!(
            "outline of an occupancy crosses itself after corners {} and {}",
            a + 1,
            b + 1
        ));
    }
    let mut spans: Vec<_> = regions.iter().map(|o| (o.time.from, o.time.to)).collect();
    spans.sort_unstable();
    let mut covered = spans.first().map_or(0, |(from, _)| *from);
    for (from, to) in spans {
        if from > covered.saturating_add(1) {
            say(format!(
                "no occupancy from time step {} to {}; assumed absent",
                covered + 1,
                from - 1
            ));
            return;
        }
        covered = covered.max(to);
    }
}

/// The states of an obstacle, one by one and one after the other.
fn states(obstacle: &Obstacle, dt: f64, say: &mut impl FnMut(Option<usize>, String)) {
    let all: Vec<&State> = obstacle.states().collect();
    if obstacle.role == ObstacleRole::Dynamic {
        let steps: Vec<i64> = all.iter().map(|s| s.time.from).collect();
        for (place, message) in times::check(&steps) {
            say(Some(place), message);
        }
        let placeless = || all.iter().enumerate().filter(|(_, s)| s.middle().is_none());
        if let Some((place, state)) = placeless().next() {
            let message = format!(
                "no position at time step {}; this state is left out",
                state.time.from
            );
            say(Some(place), and_more(message, placeless().count() - 1));
        }
    }
    for (place, message) in quantities(&all) {
        say(Some(place), message);
    }
    let rows = all.iter().enumerate();
    let mut rows: Vec<Row> = rows
        .filter_map(|(place, state)| {
            let sample = sample(state)?;
            Some(Row { place, sample })
        })
        .collect();
    rows.sort_by_key(|row| row.sample.step);
    rows.dedup_by_key(|row| row.sample.step);
    if let Some(jump) = obstacle.track().jump(dt) {
        let after = rows.iter().find(|row| row.sample.step == jump.to);
        say(after.map(|row| row.place), jump.to_string());
    }
    let walks = matches!(
        obstacle.kind,
        ObstacleType::Pedestrian | ObstacleType::Unknown
    );
    for (place, message) in motion::doubts(&rows, dt, walks) {
        say(Some(place), message);
    }
}

/// The first value out of proportion of every kind, and how many more there are.
pub(super) fn quantities(states: &[&State]) -> Vec<(usize, String)> {
    let mut found: Vec<(StateField, usize, String, usize)> = Vec::new();
    for (place, state) in states.iter().enumerate() {
        let said = [
            (StateField::Orientation, state.orientation),
            (StateField::Velocity, state.velocity),
            (StateField::Acceleration, state.acceleration),
        ]
        .into_iter()
        .filter_map(|(f, q)| Some((f, q?)));
        for (field, quantity) in said.chain(state.more.iter().copied()) {
            let Some(message) = limits::doubtful(field, quantity) else {
                continue;
            };
            match found.iter_mut().find(|(known, ..)| *known == field) {
                Some((.., more)) => *more += 1,
                None => found.push((field, place, message, 0)),
            }
        }
    }
    let words = |(_, place, first, more)| (place, and_more(first, more));
    found.into_iter().map(words).collect()
}
