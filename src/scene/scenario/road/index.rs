//! Which lanelets lie where: an R-tree over their boxes, and the drivable area.

use std::sync::OnceLock;

use nearmiss_base::geometry::{Area, Bounds, Outside, Placed, Point, contains};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::scenario::{Lanelet, LaneletNetwork, RoadUser};

/// The tree of a network. It follows from the lanelets, so it says nothing about equality.
#[derive(Debug, Clone, Default)]
pub struct Index(OnceLock<RTree<Boxed>>);

/// A lanelet's box with its place in the network.
type Boxed = GeomWithData<Rectangle<[f64; 2]>, usize>;

impl PartialEq for Index {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Boxes are wider by this, metres: a point on a border is on the lanelet.
const BORDER: f64 = 1e-3;

impl Index {
    fn tree(&self, lanelets: &[Lanelet]) -> &RTree<Boxed> {
        self.0.get_or_init(|| {
            let boxed = |(place, lanelet): (usize, &Lanelet)| {
                let points = lanelet.left.points.iter().chain(&lanelet.right.points);
                let bounds = Bounds::from_points(points)?;
                let [min, max] = [bounds.min, bounds.max].map(|p| [p.x, p.y]);
                let wide =
                    Rectangle::from_corners(min.map(|c| c - BORDER), max.map(|c| c + BORDER));
                Some(GeomWithData::new(wide, place))
            };
            RTree::bulk_load(lanelets.iter().enumerate().filter_map(boxed).collect())
        })
    }

    /// Places of the lanelets whose boxes meet `bounds`, in the file's order.
    fn near(&self, lanelets: &[Lanelet], bounds: &Bounds) -> Vec<usize> {
        let [min, max] = [bounds.min, bounds.max].map(|p| [p.x, p.y]);
        let envelope = AABB::from_corners(min, max);
        let found = self
            .tree(lanelets)
            .locate_in_envelope_intersecting(envelope);
        let mut places: Vec<usize> = found.map(|b| b.data).collect();
        places.sort_unstable();
        places
    }

    /// The lanelet nearest to `p` by their borders, with its distance in metres.
    fn nearest(&self, lanelets: &[Lanelet], p: &Point) -> Option<(usize, f64)> {
        let mut best: Option<(usize, f64)> = None;
        let order = self
            .tree(lanelets)
            .nearest_neighbor_iter_with_distance_2([p.x, p.y]);
        for (boxed, squared) in order {
            if best.is_some_and(|(_, d)| squared.sqrt() > d) {
                break;
            }
            let distance = lanelets[boxed.data].distance(p);
            if best.is_none_or(|(_, d)| distance < d) {
                best = Some((boxed.data, distance));
            }
        }
        best
    }
}

impl LaneletNetwork {
    /// Ids of the lanelets under `p`, borders included, in the file's order.
    #[must_use]
    pub fn lanelets_at(&self, p: &Point) -> Vec<i64> {
        let places = self.places_at(p).into_iter();
        places.map(|place| self.lanelets[place].id).collect()
    }

    /// Ids of the lanelets that a body stands on with more than a border, in the file's order.
    #[must_use]
    pub fn lanelets_under(&self, body: &Placed<'_>) -> Vec<i64> {
        let places = self.places_under(body).into_iter();
        places.map(|place| self.lanelets[place].id).collect()
    }

    /// The lanelet nearest to `p` and how far it is, metres; 0 on it, nothing without lanelets.
    #[must_use]
    pub fn nearest_lanelet(&self, p: &Point) -> Option<(i64, f64)> {
        let (place, distance) = self.index.nearest(&self.lanelets, p)?;
        Some((self.lanelets[place].id, distance))
    }

    pub(super) fn places_at(&self, p: &Point) -> Vec<usize> {
        let mut places = self
            .index
            .near(&self.lanelets, &Bounds { min: *p, max: *p });
        places.retain(|&place| contains(&self.lanelets[place].ring(), p));
        places
    }

    pub(super) fn places_under(&self, body: &Placed<'_>) -> Vec<usize> {
        let mut places = self.index.near(&self.lanelets, &body.bounds());
        places.retain(|&place| body.overlaps_ring(&self.lanelets[place].ring()));
        places
    }
}

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
