//! What versions before 2018b have in other places: times in seconds, first states, and shapes in world coordinates.

use super::builder::SourceLocation;
use crate::geometry::{Footprint, Pose, Shape};
use crate::scenario::{
    ObstacleParts, ObstacleRole, Position, Prediction, Quantity, State, Steps, in_frame,
};

/// Whether a version, a year and a letter, is one of these.
pub(super) fn is_meant(version: &str) -> bool {
    let year = version.trim().get(..4).and_then(|y| y.parse::<u16>().ok());
    let letter = version.trim().get(4..).unwrap_or_default();
    match year {
        Some(year) if year >= 2000 => (year, letter) < (2018, "b"),
        _ => false,
    }
}

/// Gives an obstacle the initial state that later versions have: the first state of its trajectory, or where the shape
/// of a static one says that it is. Shapes in world coordinates come into the obstacle's own frame.
pub(super) fn complete(at: &impl SourceLocation, parts: &mut ObstacleParts) {
    if parts.initial.is_some() {
        return;
    }
    match &mut parts.prediction {
        Prediction::Trajectory(states) if !states.is_empty() => {
            let first = states.remove(0);
            own_frame(at, &first, &mut parts.footprint);
            parts.initial = Some(first);
        }
        Prediction::None if parts.role == ObstacleRole::Static => {
            parts.initial = parts.footprint.as_mut().and_then(standing);
        }
        _ => {}
    }
    if parts.prediction == Prediction::Trajectory(Vec::new()) {
        parts.prediction = Prediction::None;
    }
}

/// The state of a body that stands where its shape is; the shape comes into its frame.
fn standing(body: &mut Footprint) -> Option<State> {
    let shape = body.shape();
    let heading = match shape {
        Shape::Rectangle { orientation, .. } => *orientation,
        _ => 0.0,
    };
    let position = shape.centroid()?;
    *body = Footprint::new(in_frame(shape, &Pose { position, heading })).ok()?;
    Some(State {
        position: Some(Position::Point(position)),
        orientation: Some(Quantity::Exact(heading)),
        ..State::at(Steps::exact(0))
    })
}

/// Brings a shape that lies beside the obstacle's own origin into its frame: it is in world coordinates.
fn own_frame(at: &impl SourceLocation, first: &State, body: &mut Option<Footprint>) {
    let Some(shape) = body.as_ref().map(Footprint::shape) else {
        return;
    };
    let (Some(centre), Some(position)) = (shape.centroid(), first.point()) else {
        return;
    };
    let corners = shape.outlines().into_iter().flatten();
    let reach = corners.map(|p| (p - centre).norm()).fold(0.0, f64::max);
    let off = centre.coords.norm();
    if off <= reach {
        return;
    }
    let heading = first.orientation.map_or(0.0, |q| q.middle());
    let own = Footprint::new(in_frame(shape, &Pose { position, heading }));
    if let Ok(own) = own {
        at.warn(format!(
            "the shape's centre is {off:.1} m from the obstacle's own origin; taken as in world coordinates at its first state"
        ));
        *body = Some(own);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_in_order() {
        for (version, before) in [
            ("2017a", true),
            ("2018a", true),
            ("2018b", false),
            ("2018c", false),
            ("2020a", false),
            ("", false),
            ("v1", false),
            ("1.0", false),
        ] {
            assert_eq!(is_meant(version), before, "{version}");
        }
    }
}
