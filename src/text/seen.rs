//! On which side of the ego somebody is said to be, with contact called contact only where that is wanted.

use super::options::Options;
use crate::metrics::{Direction, Encounter, Relation};

/// The direction as a description has it. Where contact is not to be said, bodies that touch have the side of the ego
/// that the other's centre lies nearest to, as bodies have that nearly touch.
pub(super) fn direction(
    encounter: &Encounter<'_>,
    relation: &Relation,
    options: &Options,
) -> Direction {
    if relation.direction != Direction::Contact || options.contact {
        return relation.direction;
    }
    let center = encounter.ego.pose.to_local(&encounter.other.pose.position);
    let (length, width) = encounter.ego_body.shape().size();
    if center.x.abs() * width > center.y.abs() * length {
        if center.x > 0.0 {
            Direction::Front
        } else {
            Direction::Behind
        }
    } else if center.y > 0.0 {
        Direction::Left
    } else {
        Direction::Right
    }
}
