//! What the ego sees of an obstacle; contact is named only on request.

use super::options::Options;
use super::writer::{Writer, degrees};
use crate::metrics::{Direction, Encounter, Relation, side_of_centre};

/// An obstacle as the ego sees it at one step.
pub(super) struct Seen {
    /// The side of the ego that it is on, as descriptions have it.
    pub direction: Direction,
    /// The shortest way between the bodies, metres; 0 where they touch.
    pub distance: f64,
    /// Its heading minus the ego's, degrees, positive to the left.
    pub heading: f64,
    /// Gaps and relative motion.
    pub relation: Relation,
}

impl Seen {
    pub fn new(encounter: &Encounter<'_>, options: &Options) -> Self {
        let relation = encounter.relation();
        Self {
            direction: direction(encounter, &relation, options),
            distance: encounter.distance(),
            heading: degrees(encounter.other.pose.heading - encounter.ego.pose.heading),
            relation,
        }
    }

    /// The relative velocity along and across the ego's heading as it is written.
    pub fn written_velocity(&self, w: &Writer) -> (f64, f64) {
        let velocity = &self.relation.velocity;
        (
            w.written("v_rel_long", velocity.x),
            w.written("v_rel_lat", velocity.y),
        )
    }
}

/// Where contact is not to be said, bodies that touch have the side of the ego that the other's centre lies nearest to,
/// as bodies have that nearly touch.
fn direction(encounter: &Encounter<'_>, relation: &Relation, options: &Options) -> Direction {
    if relation.direction != Direction::Contact || options.contact {
        return relation.direction;
    }
    side_of_centre(encounter)
}
