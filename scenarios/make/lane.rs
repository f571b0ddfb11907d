//! What kinds of lanes there are, and a lanelet of each kind before it is linked to others.

use nearmiss::scenario::{Bound, Lanelet, LaneletType, RoadUser};

/// What a lane is, which decides its types and users.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Country,
    Town,
    Junction,
    Motorway,
    Ramp,
    Shoulder,
    Parking,
    Bicycle,
    Sidewalk,
    Crosswalk,
}

/// A lanelet of a kind between two borders, with nothing around it.
pub fn lanelet(id: i64, kind: Kind, left: Bound, right: Bound) -> Lanelet {
    use LaneletType as T;
    let wheels = [RoadUser::Vehicle, RoadUser::Bicycle];
    let (types, one_way, both): (&[T], &[RoadUser], &[RoadUser]) = match kind {
        Kind::Country => (&[T::Country], &wheels, &[]),
        Kind::Town => (&[T::Urban], &wheels, &[]),
        Kind::Junction => (&[T::Urban, T::Intersection], &wheels, &[]),
        Kind::Motorway => (&[T::Interstate, T::MainCarriageWay], &wheels[..1], &[]),
        Kind::Ramp => (&[T::Interstate, T::AccessRamp], &wheels[..1], &[]),
        Kind::Shoulder => (&[T::Shoulder], &[RoadUser::PriorityVehicle], &[]),
        Kind::Parking => (&[T::Parking], &wheels[..1], &[]),
        Kind::Bicycle => (&[T::BicycleLane], &wheels[1..], &[]),
        Kind::Sidewalk => (&[T::Sidewalk], &[], &[RoadUser::Pedestrian]),
        Kind::Crosswalk => (&[T::Crosswalk], &[], &[RoadUser::Pedestrian]),
    };
    Lanelet {
        id,
        left,
        right,
        predecessors: Vec::new(),
        successors: Vec::new(),
        adjacent_left: None,
        adjacent_right: None,
        stop_line: None,
        types: types.to_vec(),
        users_one_way: one_way.to_vec(),
        users_bidirectional: both.to_vec(),
        signs: Vec::new(),
        lights: Vec::new(),
    }
}
