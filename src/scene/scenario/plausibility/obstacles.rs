//! Checks obstacles: their types, positions, bodies, times and motions, and whether they overlap at the first step.

use nearmiss_base::geometry::{Bounds, Point, Shape, convex_hull, convex_overlap};

use super::lanelets::self_crossing;
use super::{ElementRef, Finding, Findings, Row, and_more, beyond, motion};
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
        check_body(obstacle, &mut |message| say(None, message));
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
    if let Some((a, b)) = regions.iter().find_map(|o| crossing(&o.region)) {
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
        for (place, message) in motion::check(&steps) {
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
            let Some(message) = super::doubtful(field, quantity) else {
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

/// Bounds for an unknown type, metres: from negligible to larger than any building.
const ANYTHING: Sizes = Sizes::new(0.01, 10_000.0, 0.01, 10_000.0);

/// A body farther from its obstacle's position, metres, and farther than it is large, is elsewhere.
const ELSEWHERE: f64 = 10.0;

/// The least and the most length and width, metres.
#[derive(Debug, Clone, Copy)]
struct Sizes {
    length: (f64, f64),
    width: (f64, f64),
}

impl Sizes {
    const fn new(shortest: f64, longest: f64, narrowest: f64, widest: f64) -> Self {
        Self {
            length: (shortest, longest),
            width: (narrowest, widest),
        }
    }

    /// Wide enough for all that recordings of traffic hold: special vehicles, loads, boxes around groups.
    fn for_kind(kind: ObstacleType) -> Self {
        match kind {
            ObstacleType::Car | ObstacleType::Taxi => Self::new(1.0, 15.0, 0.5, 4.0),
            ObstacleType::Truck => Self::new(1.5, 40.0, 0.8, 8.0),
            ObstacleType::Bus => Self::new(2.0, 40.0, 0.8, 6.0),
            ObstacleType::PriorityVehicle => Self::new(1.0, 40.0, 0.4, 8.0),
            ObstacleType::ParkedVehicle => Self::new(0.5, 40.0, 0.2, 10.0),
            ObstacleType::Motorcycle | ObstacleType::Bicycle => Self::new(0.4, 6.0, 0.1, 3.0),
            ObstacleType::Pedestrian => Self::new(0.1, 5.0, 0.1, 5.0),
            ObstacleType::Train => Self::new(1.0, 1_000.0, 0.5, 8.0),
            ObstacleType::Unknown => Self::new(0.05, 100.0, 0.05, 100.0),
            _ => ANYTHING,
        }
    }
}

/// Implausible properties of an obstacle's body.
pub(super) fn check_body(obstacle: &Obstacle, say: &mut impl FnMut(String)) {
    let Some(footprint) = &obstacle.footprint else {
        return;
    };
    let shape = footprint.shape();
    if let Some((a, b)) = crossing(shape) {
        say(format!(
            "outline crosses itself after corners {} and {}; its convex hull is used",
            a + 1,
            b + 1
        ));
    }
    if !matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic) {
        return;
    }
    size(obstacle, shape, say);
    let corners = footprint.corners();
    let Some(around) = Bounds::from_points(corners) else {
        return;
    };
    let off = around.squared_distance(&Point::origin()).sqrt();
    let large = (around.max - around.min).norm();
    if off > ELSEWHERE.max(large) {
        say(format!(
            "body is {off:.0} m from its position; shapes are relative to the obstacle's position"
        ));
    }
}

fn size(obstacle: &Obstacle, shape: &Shape, say: &mut impl FnMut(String)) {
    // A rectangle may be turned against its obstacle.
    let (length, width) = match shape {
        Shape::Rectangle { length, width, .. } => (*length, *width),
        other => other.size(),
    };
    let (sizes, kind) = (Sizes::for_kind(obstacle.kind), obstacle.kind);
    let fits = |value: f64, (least, most): (f64, f64)| (least..=most).contains(&value);
    let size = format!("{length:.2} m × {width:.2} m");
    if !fits(length, sizes.length) || !fits(width, sizes.width) {
        // Of a body without a direction, only its extent matters.
        let turned = matches!(shape, Shape::Polygon { .. } | Shape::Group(_))
            && fits(width, sizes.length)
            && fits(length, sizes.width);
        if !turned {
            say(format!("{size} is implausible for a {kind}; used as is"));
        }
        return;
    }
    let long = matches!(
        kind,
        ObstacleType::Car
            | ObstacleType::Taxi
            | ObstacleType::Truck
            | ObstacleType::Bus
            | ObstacleType::Motorcycle
            | ObstacleType::Bicycle
    );
    if long && matches!(shape, Shape::Rectangle { .. }) && width > 1.2 * length {
        say(format!(
            "{size}: wider than long; are length and width swapped?"
        ));
    }
}

/// Two edges of one of the polygons in a shape that cross.
pub(super) fn crossing(shape: &Shape) -> Option<(usize, usize)> {
    match shape {
        Shape::Polygon { vertices } => self_crossing(vertices, true),
        Shape::Group(members) => members.iter().find_map(crossing),
        _ => None,
    }
}

/// Bodies are shrunk to this share of their size before they are held against each other: grazing is possible.
const CORE: f64 = 0.8;

/// One body at the first step.
struct Body<'a> {
    obstacle: &'a Obstacle,
    place: usize,
    middle: Point,
    reach: f64,
}

/// Tells of obstacles that overlap where the scenario begins.
pub(super) fn check_overlaps(scenario: &Scenario, found: &mut Findings) {
    let step = scenario.steps().start;
    let all = scenario.obstacles.iter().enumerate();
    let mut bodies: Vec<Body<'_>> = all
        .filter(|(_, o)| matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic))
        // Where an obstacle may be, others may be, too.
        .filter(|(_, o)| !o.is_occupancy_at(step))
        .filter_map(|(place, obstacle)| {
            Some(Body {
                obstacle,
                place,
                middle: obstacle.motion_at(step)?.pose.position,
                reach: obstacle.footprint_at(step)?.reach(),
            })
        })
        .collect();
    let begin = |body: &Body<'_>| body.middle.x - body.reach;
    bodies.sort_by(|a, b| begin(a).total_cmp(&begin(b)));
    for (i, a) in bodies.iter().enumerate() {
        let end = a.middle.x + a.reach;
        let later = bodies[i + 1..].iter();
        for b in later.take_while(|b| begin(b) <= end) {
            if !may(a.obstacle, b.obstacle) || !inside(a, b, step) {
                continue;
            }
            let (first, second) = if a.place < b.place { (a, b) } else { (b, a) };
            found.warn(
                ElementRef::Obstacle(second.place),
                format!(
                    "obstacle {}: overlaps obstacle {} at time step {step}",
                    second.obstacle.id, first.obstacle.id
                ),
            );
        }
    }
}

/// Whether two obstacles must not overlap: roadside objects may, and groups of pedestrians.
fn may(a: &Obstacle, b: &Obstacle) -> bool {
    let moves = |o: &Obstacle| o.role == ObstacleRole::Dynamic;
    let walks = |o: &Obstacle| o.kind == ObstacleType::Pedestrian;
    (moves(a) || moves(b)) && !(walks(a) && walks(b))
}

fn inside(a: &Body<'_>, b: &Body<'_>, step: i64) -> bool {
    let apart = (a.middle - b.middle).norm();
    let placed = a.obstacle.placed_at(step).zip(b.obstacle.placed_at(step));
    apart <= a.reach + b.reach
        // The hulls of bodies that are not convex may overlap where the bodies do not.
        && placed.is_some_and(|(a, b)| a.distance(&b) <= 0.0)
        && core(a.obstacle, step)
            .zip(core(b.obstacle, step))
            .is_some_and(|(a, b)| convex_overlap(&a, &b))
}

/// The hull of an obstacle's body, shrunk to its middle.
fn core(obstacle: &Obstacle, step: i64) -> Option<Vec<Point>> {
    let corners: Vec<Point> = obstacle
        .placed_at(step)?
        .outlines()
        .into_iter()
        .flatten()
        .collect();
    let mut hull = convex_hull(&corners);
    let sum = hull
        .iter()
        .map(|p| p.coords)
        .sum::<nearmiss_base::geometry::Vector>();
    let middle = Point::from(sum / hull.len().max(1) as f64);
    for corner in &mut hull {
        *corner = middle + (*corner - middle) * CORE;
    }
    Some(hull)
}
