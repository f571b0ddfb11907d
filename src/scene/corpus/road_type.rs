//! The kind of road under the ego.

use crate::scenario::{LaneletNetwork, LaneletType};

/// The kind of road under the ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum RoadType {
    /// Inside an intersection.
    Intersection,
    /// A motorway, its carriageways included.
    Highway,
    /// A ramp of a motorway.
    Ramp,
    /// A street in a town.
    Urban,
    /// A road in the country.
    Country,
    /// A lanelet without one of these types.
    Untyped,
    /// No lanelet.
    OffRoad,
}

impl RoadType {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Intersection,
        Self::Highway,
        Self::Ramp,
        Self::Urban,
        Self::Country,
        Self::Untyped,
        Self::OffRoad,
    ];

    /// Its word in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Intersection => "intersection",
            Self::Highway => "highway",
            Self::Ramp => "ramp",
            Self::Urban => "urban",
            Self::Country => "country",
            Self::Untyped => "untyped",
            Self::OffRoad => "off_road",
        }
    }

    /// The road that these lanelets are part of.
    #[must_use]
    pub fn of(network: &LaneletNetwork, lanelets: &[i64]) -> Self {
        let known: Vec<_> = lanelets
            .iter()
            .filter_map(|id| network.lanelet(*id))
            .collect();
        if known.is_empty() {
            return Self::OffRoad;
        }
        let has = |kinds: &[LaneletType]| {
            known
                .iter()
                .any(|lanelet| lanelet.types.iter().any(|t| kinds.contains(t)))
        };
        let turns = |id: &i64| {
            let incomings = network.intersections.iter().flat_map(|i| &i.incomings);
            incomings
                .flat_map(|i| [&i.left, &i.straight, &i.right])
                .any(|successors| successors.contains(id))
        };
        if has(&[LaneletType::Intersection]) || lanelets.iter().any(turns) {
            Self::Intersection
        } else if has(&[LaneletType::AccessRamp, LaneletType::ExitRamp]) {
            Self::Ramp
        } else if has(&[
            LaneletType::Highway,
            LaneletType::Interstate,
            LaneletType::MainCarriageWay,
        ]) {
            Self::Highway
        } else if has(&[LaneletType::Urban]) {
            Self::Urban
        } else if has(&[LaneletType::Country]) {
            Self::Country
        } else {
            Self::Untyped
        }
    }
}
