//! The drivable area: all lanelets that any user may use, as one area.

use crate::scenario::{Lanelet, LaneletNetwork, RoadUser};
use nearmiss_base::geometry::{Area, Outside, Placed, Point};

/// The road as one area: to be built once and asked often.
#[derive(Debug, Clone)]
pub struct DrivableArea {
    area: Area,
}

/// Gaps between lanelets up to this width are road, metres: maps have gaps of centimetres between
/// neighbours and at joints, and no vehicle would notice. Outer borders stay where they are.
const GAP: f64 = 0.1;

impl LaneletNetwork {
    /// The area of the lanelets that `user` may use, or of all.
    #[must_use]
    pub fn drivable_area(&self, user: Option<RoadUser>) -> DrivableArea {
        let lanelets = self.lanelets.iter();
        let rings: Vec<Vec<Point>> = lanelets
            .filter(|l| user.is_none_or(|user| l.may_use(user)))
            .map(Lanelet::ring)
            .collect();
        DrivableArea {
            area: Area::union(rings.iter().map(Vec::as_slice), GAP),
        }
    }
}

impl Lanelet {
    /// Whether `user` may use it in at least one direction; all may where the file names none.
    #[must_use]
    pub fn may_use(&self, user: RoadUser) -> bool {
        let unnamed = self.users_one_way.is_empty() && self.users_bidirectional.is_empty();
        unnamed || includes(&self.users_one_way, user) || includes(&self.users_bidirectional, user)
    }
}

/// Whether `users` include `user`: every motor vehicle is a `vehicle`.
pub(super) fn includes(users: &[RoadUser], user: RoadUser) -> bool {
    let motor = !matches!(
        user,
        RoadUser::Bicycle | RoadUser::Pedestrian | RoadUser::Train
    );
    users.contains(&user) || motor && users.contains(&RoadUser::Vehicle)
}

impl DrivableArea {
    /// Whether all of `body` is on the road; what sticks out by less than a millimetre is.
    #[must_use]
    pub fn covers(&self, body: &Placed<'_>) -> bool {
        self.area.covers(body)
    }

    /// Where `body` leaves the road; `None` if all of it is on the road.
    #[must_use]
    pub fn outside(&self, body: &Placed<'_>) -> Option<Outside> {
        self.area.outside(body)
    }

    /// Whether `p` is on the road, its border included.
    #[must_use]
    pub fn contains(&self, p: &Point) -> bool {
        self.area.contains(p)
    }

    /// The road's border, which no two lanelets share: rings (not closed) with the road on their left.
    pub fn border(&self) -> impl Iterator<Item = Vec<Point>> {
        self.area.border()
    }
}
