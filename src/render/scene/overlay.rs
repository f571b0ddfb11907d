//! Lines and outlines over the traffic: both motions of a variant's attackers, and what a caller adds.

use super::super::view::Variation;
use super::trails::positions;
use super::{MapRequest, Role};
use nearmiss_base::geometry::Point;

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineStyle {
    /// Unbroken.
    Solid,
    /// Unbroken, and broader than others.
    Thick,
    /// Dashes.
    Dashed,
    /// Single dots.
    Dotted,
    /// A row of crosses.
    Crossed,
}

/// Something drawn over the traffic.
#[derive(Debug, Clone, PartialEq)]
pub enum Overlay {
    /// An open line.
    Path(Path),
    /// A hollow body.
    Outline(Outline),
}

/// An open line.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// What it is.
    pub role: Role,
    /// How it is drawn.
    pub style: LineStyle,
    /// Its points.
    pub points: Vec<Point>,
}

/// A body that is not there now: hollow.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// What it is.
    pub role: Role,
    /// Whether only its corners are drawn.
    pub faint: bool,
    /// Its outlines, each a ring (not closed).
    pub rings: Vec<Vec<Point>>,
    /// What it is called, if it has a label.
    pub name: Option<String>,
}

impl Overlay {
    /// An open line.
    #[must_use]
    pub fn path(role: Role, style: LineStyle, points: Vec<Point>) -> Self {
        Self::Path(Path {
            role,
            style,
            points,
        })
    }
}

/// The recorded motion of each attacker of a variant dashed, the changed one a thick line, and the body that is not driven in
/// what is shown hollow, where the two are not in one place.
pub(super) fn of_variation(request: &MapRequest<'_>) -> Vec<Overlay> {
    let all = request.variations.iter().enumerate();
    all.flat_map(|(place, both)| of_attacker(request, place, both))
        .collect()
}

fn of_attacker(request: &MapRequest<'_>, place: usize, both: &Variation<'_>) -> Vec<Overlay> {
    let attacker = Role::Attacker(place);
    let after = both.from..=i64::MAX;
    let way =
        |obstacle: &nearmiss_scene::scenario::Obstacle| positions(obstacle.track().during(&after));
    let mut found = vec![
        Overlay::path(Role::Recorded, LineStyle::Dashed, way(both.recorded)),
        Overlay::path(attacker, LineStyle::Thick, way(both.changed)),
    ];
    let (role, other, word) = if both.shows_changed {
        (Role::Recorded, both.recorded, "recorded")
    } else {
        (attacker, both.changed, "changed")
    };
    if let Some(placed) = other.placed_at(request.step)
        && request.step > both.from
    {
        found.push(Overlay::Outline(Outline {
            role,
            faint: false,
            rings: placed.outlines(),
            name: Some(format!("{} {word}", other.id)),
        }));
    }
    found
}
