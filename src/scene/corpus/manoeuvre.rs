//! What a road user does to the ego between two steps, and on which kind of road.

use nearmiss_base::geometry::{Point, Vector, angle_between};
use strum::{IntoStaticStr, VariantArray};

use crate::scenario::{LaneRelation, LaneletNetwork, LaneletType, Motion};

/// What the other road user does to the ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Manoeuvre {
    /// It changes into the ego's lane, ahead of the ego.
    CutIn,
    /// The ego changes into its lane.
    LaneChange,
    /// Its lane joins that of the ego, and it ends up ahead.
    Merging,
    /// The ego follows it.
    Following,
    /// It follows the ego.
    Followed,
    /// It drives in another lane of the same direction.
    Parallel,
    /// It comes towards the ego.
    Oncoming,
    /// Its way crosses that of the ego.
    Crossing,
    /// They come towards each other, and one turns across the way of the other.
    TurningAcross,
    /// It is a static obstacle.
    Standing,
    /// None of these.
    Other,
}

nearmiss_record::named!(Manoeuvre);

/// Both at the ends of a window.
#[derive(Debug, Clone, Copy)]
pub(super) struct PairMotion<'a> {
    /// The ego at the first and at the last step.
    pub ego: [&'a Motion; 2],
    /// The other at the first and at the last step.
    pub other: [&'a Motion; 2],
    /// The lane of the other, seen from that of the ego, at the first and at the last step; nothing without lanes.
    pub lanes: [Option<LaneRelation>; 2],
    /// How far the other is left of the ego's way, metres; where there are lanes, it is not asked for.
    pub aside: [Option<f64>; 2],
    /// The lane of the other at the last step, seen from that of the ego at the first.
    pub to_first_lane: Option<LaneRelation>,
    /// The change of heading of the ego and of the other, around the window too, radians.
    pub turns: [f64; 2],
    /// Where the ego and the other were heading a little before and after the window, added up.
    pub along: [Vector; 2],
    /// The angle between their headings a little before the window, radians.
    pub angle_before: f64,
    /// The other is a static obstacle.
    pub stands: bool,
}

/// Directions that differ by less are the same one, radians.
const SAME_WAY: f64 = std::f64::consts::FRAC_PI_4;

/// Directions that differ by more are opposite, radians.
const OPPOSITE: f64 = 3.0 * std::f64::consts::FRAC_PI_4;

/// Before a turn across, directions differ by more than this, radians.
const FACING: f64 = 2.0 * std::f64::consts::FRAC_PI_3;

/// Who changes the heading by more than this turns, radians: 25°.
pub(super) const TURN: f64 = 0.436;

/// Half of a lane's width where there are no lanes, metres.
pub(super) const HALF_LANE: f64 = 1.75;

impl Manoeuvre {
    pub(super) fn classify(pair: &PairMotion<'_>) -> Self {
        if pair.stands {
            return Self::Standing;
        }
        let heading = |m: &Motion| m.pose.heading;
        let angle = angle_between(heading(pair.ego[1]), heading(pair.other[1])).abs();
        let turns = pair.turns.iter().any(|turn| turn.abs() > TURN);
        if pair.angle_before > FACING && turns && angle < OPPOSITE {
            return Self::TurningAcross;
        }
        if angle <= SAME_WAY {
            return pair.same_way();
        }
        if angle >= OPPOSITE {
            return Self::Oncoming;
        }
        Self::Crossing
    }
}

/// Whether a lane is the ego's own, ahead or behind.
pub(super) fn in_line(lane: LaneRelation) -> bool {
    matches!(
        lane,
        LaneRelation::Same | LaneRelation::Ahead | LaneRelation::Behind
    )
}

/// Whether who is so far from the ego's way is in it, where there are no lanes.
pub(super) fn is_inside(aside: f64) -> bool {
    aside.abs() <= HALF_LANE
}

impl PairMotion<'_> {
    /// Where the other's centre is in the ego's frame at the first or last step.
    fn at(&self, end: usize) -> Point {
        let other = &self.other[end].pose.position;
        self.ego[end].pose.to_local(other)
    }

    /// Whether the other's centre is in the ego's lane at the first and at the last step.
    fn inside(&self) -> [bool; 2] {
        if let [Some(first), Some(last)] = self.lanes {
            return [first, last].map(in_line);
        }
        [0, 1].map(|end| is_inside(self.aside[end].unwrap_or_else(|| self.at(end).y)))
    }

    /// Whether the other changed lanes, not the ego: without lanes, who moved farther across where it was heading on the whole.
    fn other_moved(&self, into: bool) -> bool {
        if self.lanes.iter().all(Option::is_some) {
            return self.to_first_lane.is_some_and(in_line) == into;
        }
        let across = |[from, to]: [&Motion; 2], along: Vector| {
            along.perp(&(to.pose.position - from.pose.position)).abs()
        };
        across(self.other, self.along[1]) > across(self.ego, self.along[0])
    }

    /// Whether the other was ahead of the ego in its lane and left it.
    pub fn cuts_out(&self) -> bool {
        let headings = [self.ego[0], self.other[0]].map(|motion| motion.pose.heading);
        let [before, after] = self.inside();
        let was_ahead =
            self.at(0).x > 0.0 && angle_between(headings[0], headings[1]).abs() <= SAME_WAY;
        !self.stands && was_ahead && before && !after && self.other_moved(false)
    }

    /// Of two that end up driving in the same direction.
    fn same_way(&self) -> Manoeuvre {
        use LaneRelation as Lane;
        let is_ahead = self.at(1).x > 0.0;
        let came = || self.other_moved(true);
        let [Some(first), Some(last)] = self.lanes else {
            return match self.inside() {
                [false, true] if is_ahead && came() => Manoeuvre::CutIn,
                [false, true] if is_ahead => Manoeuvre::LaneChange,
                [_, true] if is_ahead => Manoeuvre::Following,
                [_, true] => Manoeuvre::Followed,
                _ => Manoeuvre::Parallel,
            };
        };
        match (first, last) {
            (Lane::Merging, l) if in_line(l) && is_ahead => Manoeuvre::Merging,
            (f, l) if !in_line(f) && in_line(l) && is_ahead && came() => Manoeuvre::CutIn,
            (f, l) if !in_line(f) && in_line(l) => Manoeuvre::LaneChange,
            (_, l) if in_line(l) && is_ahead => Manoeuvre::Following,
            (_, l) if in_line(l) => Manoeuvre::Followed,
            (_, Lane::Left | Lane::Right | Lane::FurtherLeft | Lane::FurtherRight) => {
                Manoeuvre::Parallel
            }
            (_, Lane::Crossing) => Manoeuvre::Crossing,
            (_, Lane::Merging | Lane::Diverging) => Manoeuvre::Parallel,
            _ => Manoeuvre::Other,
        }
    }
}

/// The kind of road under the ego.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
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

nearmiss_record::named!(RoadType, "road");

impl RoadType {
    /// The road that these lanelets are part of.
    #[must_use]
    pub fn classify(network: &LaneletNetwork, lanelets: &[i64]) -> Self {
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
