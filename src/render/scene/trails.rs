//! Where participants were and where they are recorded to go.

use super::{MapRequest, Owner, Viewport};
use nearmiss_base::geometry::{Bounds, Point};
use nearmiss_scene::scenario::{Motion, Track};

/// How much of a recorded motion is shown, seconds; `None` for all of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrailSpan {
    /// Of the past.
    pub past: Option<f64>,
    /// Of the recorded future.
    pub future: Option<f64>,
}

impl TrailSpan {
    /// All of it.
    pub const WHOLE: Self = Self {
        past: None,
        future: None,
    };
}

/// A recorded motion around a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trail<'a> {
    /// Whose.
    pub owner: Owner,
    /// Its owner's place among those that are pointed out.
    pub highlighted: Option<usize>,
    /// Steps and motions up to the step and with it.
    pub past: &'a [(i64, Motion)],
    /// The same from the step on.
    pub future: &'a [(i64, Motion)],
}

impl<'a> Trail<'a> {
    fn of(track: &'a Track, request: &MapRequest<'_>, owner: Owner, span: TrailSpan) -> Self {
        let (step, dt) = (request.step, request.subject.scenario.dt());
        let steps = |seconds: f64| (seconds / dt).ceil() as i64;
        let from = span
            .past
            .map_or(i64::MIN, |s| step.saturating_sub(steps(s)));
        let to = span
            .future
            .map_or(i64::MAX, |s| step.saturating_add(steps(s)));
        Self {
            owner,
            highlighted: match owner {
                Owner::Ego => None,
                Owner::Obstacle(id) => request.place(id),
            },
            past: track.during(&(from..=step)),
            future: track.during(&(step..=to)),
        }
    }

    fn is_seen(&self, viewport: &Viewport) -> bool {
        let all = self.past.iter().chain(self.future);
        let bounds = Bounds::from_points(all.map(|(_, motion)| &motion.pose.position));
        bounds.is_some_and(|bounds| viewport.sees(&bounds))
    }
}

/// The positions of recorded motions.
pub(super) fn positions(motions: &[(i64, Motion)]) -> Vec<Point> {
    motions.iter().map(|(_, m)| m.pose.position).collect()
}

/// Trails that are seen, the ego's last.
pub(super) fn seen<'a>(request: &MapRequest<'a>) -> Vec<Trail<'a>> {
    let [other, highlighted] = request.trails;
    let others = request.subject.others().map(|obstacle| {
        let span = match request.place(obstacle.id) {
            Some(_) => highlighted,
            None => other,
        };
        Trail::of(
            obstacle.track(),
            request,
            Owner::Obstacle(obstacle.id),
            span,
        )
    });
    let ego = request
        .subject
        .scene
        .map(|scene| Trail::of(&scene.ego.track, request, Owner::Ego, TrailSpan::WHOLE));
    // Who is still to come has no trail, unless all of it is shown.
    let others = others.filter(|trail| trail.highlighted.is_some() || !trail.past.is_empty());
    let all = others.chain(ego);
    all.filter(|trail| trail.is_seen(&request.viewport))
        .collect()
}
