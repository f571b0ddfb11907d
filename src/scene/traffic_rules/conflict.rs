//! Where two lanes are too close for two vehicles.

use nearmiss_base::geometry::{Polyline, ReferencePath};

/// The parts of a way and of another lane on which vehicles would touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conflict {
    /// Arc lengths of the way, metres.
    pub own: (f64, f64),
    /// Distances along the other lane, metres.
    pub other: (f64, f64),
}

/// Two lanes whose middles are nearer than this have no room for two cars, metres: half the width of both and what they
/// keep beside them.
const WIDE: f64 = 2.2;

/// Between places that are looked at, metres.
const SPACING: f64 = 0.5;

/// The conflict on the part `span` (m) of a way with another lane from `inside` (m) on.
pub(super) fn conflict(
    path: &ReferencePath,
    span: (f64, f64),
    other: &Polyline,
    inside: f64,
) -> Option<Conflict> {
    let count = ((span.1 - span.0) / SPACING).clamp(0.0, MOST).ceil() as usize;
    let mut found: Option<Conflict> = None;
    for n in 0..=count {
        let s = span.0 + n as f64 * SPACING;
        let on = other.project(&path.pose_at(s).position);
        if on.d.abs() >= WIDE || on.s < inside {
            continue;
        }
        let known = found.get_or_insert(Conflict {
            own: (s, s),
            other: (on.s, on.s),
        });
        known.own.1 = s;
        known.other = (known.other.0.min(on.s), known.other.1.max(on.s));
    }
    found
}

/// Places that are looked at, at most.
const MOST: f64 = 1000.0;
