//! The position of a state along and across the path.

use super::lateral::Start;
use super::samples::start;
use super::{ReferenceTrack, VehicleState};

/// The start may lie this far from where the route has it, metres.
const FIRST: f64 = 20.0;

/// From one cycle to the next the place on the path moves less than this, metres.
const HINT: f64 = 15.0;

/// An obstacle that points farther away from the path than this cosine is not along it.
const ALONG: f64 = 0.1;

/// Arc length with its speed and acceleration, and the offset, of `now`; near arc length `hint` (m) where that is
/// known. Nothing for an obstacle that points across the path or away from it.
pub(super) fn place(
    guide: &ReferenceTrack,
    now: &VehicleState,
    hint: Option<f64>,
) -> Option<([f64; 3], Start)> {
    let path = &guide.path;
    let rear = &now.rear;
    let near = |s: f64, within: f64| path.project_near(&rear.position, s, within).ok();
    let at = hint
        .and_then(|s| near(s, HINT))
        .or_else(|| near(guide.start, FIRST))
        .or_else(|| path.project(&rear.position).ok())?;
    let profile = path.profile_at(at, rear.heading, now.curvature).ok()?;
    let point = path.at(at.s);
    let stretch = point.stretch(at).ok()?;
    let (sin, cos) = (rear.heading - point.heading).sin_cos();
    if cos <= ALONG {
        return None;
    }
    let tan = sin / cos;
    let s1 = now.velocity * cos / stretch;
    let drift = point.curvature_rate * at.d + point.curvature * profile.d_s;
    let turn = now.curvature * stretch / cos - point.curvature;
    let s2 = (now.acceleration * cos - s1 * s1 * (stretch * tan * turn - drift)) / stretch;
    let along = [at.s, s1, s2];
    Some((along, start([profile.d, profile.d_s, profile.d_ss], along)))
}
