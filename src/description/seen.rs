//! The side of the ego an obstacle is on; contact is named only on request.

use super::options::Options;
use crate::metrics::{Direction, Encounter, Relation, side_of_centre};

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
    side_of_centre(encounter)
}
