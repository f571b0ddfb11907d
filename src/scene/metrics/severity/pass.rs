//! Crossings and cut-ins that passed closely in space and time, as recorded.

use super::{Grade, Graded, Hazard, LATEST_PASS, NEAR_MISS, PairPaths, STANDING, same_direction};
use crate::metrics::Encounter;
use crate::metrics::recorded::post_encroachment;
use nearmiss_base::geometry::Placed;

/// Who waits for another that crosses would have touched it within this time, seconds.
const YIELDED: f64 = 3.0;

/// Bodies that never come nearer than this do not pass closely, metres: 2 s at 40 m/s.
const FARTHEST: f64 = 80.0;

/// What of the pair passed closely.
pub(super) fn passes(pair: &PairPaths<'_, '_>) -> Vec<Graded> {
    let mut all = Vec::new();
    all.extend(crossing(pair));
    all.extend(cut_ins(pair));
    all
}

/// The crossing of both paths, at the step at which the bodies are nearest.
fn crossing(pair: &PairPaths<'_, '_>) -> Option<Graded> {
    let context = pair.context;
    let steps = context.steps().zip(context.distances(pair.participant));
    let present = steps.filter_map(|(step, distance)| Some((step, (*distance)?)));
    let (step, metres) = present.min_by(|a, b| a.1.total_cmp(&b.1))?;
    if metres > FARTHEST {
        return None;
    }
    let nearest = context.encounter(pair.participant, step)?;
    let [ego, other] = [nearest.ego, nearest.other].map(|motion| motion.pose.forward());
    let seconds = (!same_direction(&ego, &other))
        .then(|| (post_encroachment::MEASURE.compute)(&nearest).value())
        .flatten();
    // An area that both sweep for long is left and entered far apart.
    let fastest = nearest.ego.velocity.abs().max(nearest.other.velocity.abs());
    let seconds = seconds.map(|seconds| seconds.max(metres / fastest.max(STANDING)));
    let close = match seconds {
        Some(seconds) => seconds.min(metres),
        // Without an area that both sweep, one waited: how near it came counts, if it would have come to contact.
        None if metres <= NEAR_MISS && yielded(pair, step) => metres,
        None => return None,
    };
    let grade = grade(seconds.unwrap_or(f64::INFINITY), metres)?;
    Some((step, grade, close, Hazard::Crossing { seconds, metres }))
}

/// Whether shortly before a step both were on courses along their ways that end in contact.
fn yielded(pair: &PairPaths<'_, '_>, step: i64) -> bool {
    let context = pair.context;
    let before = (YIELDED / context.dt()).ceil() as i64;
    let steps = (step - before).max(context.steps().start)..=step;
    steps.rev().any(|step| {
        let encounter = context.encounter(pair.participant, step);
        encounter.is_some_and(|encounter| {
            let course = super::course::meet(pair.ego, &pair.other, &encounter, step);
            course.is_some_and(|course| course.crosses && course.seconds <= YIELDED)
        })
    })
}

/// Each step at which one of the two comes onto the way of the other, before or behind it.
fn cut_ins(pair: &PairPaths<'_, '_>) -> Vec<Graded> {
    let mut found = Vec::new();
    let mut before = None;
    for step in pair.context.steps() {
        let encounter = pair.context.encounter(pair.participant, step);
        let Some(encounter) = encounter.filter(near_and_along) else {
            before = None;
            continue;
        };
        let (ego, other) = (encounter.ego_placed(), encounter.other_placed());
        let wide = half_width(&ego) + half_width(&other);
        let on = [
            pair.other.aside(&ego.pose.position),
            pair.ego.aside(&other.pose.position),
        ]
        .map(|aside| aside.map(|aside| aside < wide));
        let was: Option<[Option<bool>; 2]> = before.replace(on);
        let comes = |(was, on)| (was, on) == (Some(false), Some(true));
        if !was.is_some_and(|was| was.into_iter().zip(on).any(comes)) {
            continue;
        }
        let metres = encounter.distance();
        let between = other.pose.position - ego.pose.position;
        let behind = if between.dot(&ego.pose.forward()) > 0.0 {
            encounter.ego
        } else {
            encounter.other
        };
        let seconds = metres / behind.velocity.abs();
        if let Some(grade) = grade(seconds, metres) {
            let hazard = Hazard::CutIn { seconds, metres };
            found.push((step, grade, seconds.min(metres), hazard));
        }
    }
    found
}

/// Whether both move the same way, and one could be where the other is soon.
fn near_and_along(encounter: &Encounter<'_>) -> bool {
    let speeds = [encounter.ego, encounter.other].map(|motion| motion.velocity.abs());
    let [ego, other] = [encounter.ego, encounter.other].map(|motion| motion.pose.forward());
    let reachable = encounter.distance() <= LATEST_PASS * speeds[0].max(speeds[1]);
    let moving = speeds.into_iter().all(|speed| speed >= STANDING);
    reachable && moving && same_direction(&ego, &other)
}

/// Half of how wide a body is across its heading, metres.
fn half_width(body: &Placed<'_>) -> f64 {
    let across = body.footprint.corners().iter().map(|corner| corner.y.abs());
    across.fold(0.0, f64::max)
}

fn grade(seconds: f64, metres: f64) -> Option<Grade> {
    match seconds.min(metres) {
        close if close <= NEAR_MISS => Some(Grade::NearMiss),
        _ if seconds <= LATEST_PASS => Some(Grade::Pass),
        _ => None,
    }
}
