//! Lanes and connectors of a map around a recording, as lanelets.

use std::collections::{HashMap, HashSet};

use super::layers::{Lane, Layers};
use crate::commonroad::builder::SourceLocation;
use crate::recordings::Report;
use crate::recordings::assembly::Ids;
use crate::recordings::lane_shape::{self, borders, matched, without_repeats};
use nearmiss_base::geometry::{Bounds, Point, Vector};
use nearmiss_scene::scenario::{Adjacent, Bound, Lanelet, LaneletType, LineMarking, RoadUser};

/// Half of a lane without borders, metres.
const HALF_LANE: f64 = 1.75;

/// A lane that is there.
pub struct Placed<'m> {
    pub lane: &'m Lane,
    /// Along its middle.
    pub middle: Vec<Point>,
    pub lanelet: Lanelet,
}

/// The lanes around a recording: first lanes, then connectors.
pub struct LaneSection<'m> {
    pub layers: &'m Layers,
    pub all: Vec<Placed<'m>>,
    /// Places of lanes, and of connectors, by their ids in the map.
    pub places: [HashMap<i64, usize>; 2],
    /// From the map's coordinates to those of the scenario.
    shift: Vector,
}

impl<'m> LaneSection<'m> {
    /// What of a map is around some places; `origin` is what coordinates are relative to, metres.
    pub fn around(
        report: &Report,
        layers: &'m Layers,
        around: &Bounds,
        origin: (f64, f64),
        ids: &mut Ids,
    ) -> Self {
        let mut cut = Self {
            layers,
            all: Vec::new(),
            places: Default::default(),
            shift: Vector::new(-origin.0, -origin.1),
        };
        let wide = cut.back(around);
        let mut assumed = 0;
        for lane in layers.lanes.iter().chain(&layers.connectors) {
            if !lane.bounds.is_some_and(|bounds| bounds.overlaps(&wide)) {
                continue;
            }
            let of = usize::from(lane.connector.is_some());
            let at = report.at(format!("{} {}", ["lane", "lane connector"][of], lane.id));
            if cut.places[of].contains_key(&lane.id) {
                at.warn("is there twice; the first is used");
                continue;
            }
            let Some((placed, is_assumed)) = cut.placed(lane) else {
                at.warn("neither a line along its middle nor both borders; left out");
                continue;
            };
            assumed += usize::from(is_assumed);
            cut.places[of].insert(lane.id, cut.all.len());
            cut.all.push(placed);
        }
        for placed in &mut cut.all {
            placed.lanelet.id = ids.keep(placed.lane.id);
        }
        report.note_count(assumed, |n| {
            format!("lanes without a border: {n}; that side is {HALF_LANE} m from the middle")
        });
        cut.link(report);
        cut.set_beside();
        cut
    }

    /// Bounds of the scenario in the map.
    fn back(&self, bounds: &Bounds) -> Bounds {
        Bounds {
            min: bounds.min - self.shift,
            max: bounds.max - self.shift,
        }
    }

    /// A line of the map in the scenario, without points that repeat the one before.
    pub fn line(&self, line: &[Point]) -> Vec<Point> {
        let moved = line.iter().map(|p| p + self.shift).collect();
        without_repeats(moved, Vec::new()).0
    }

    /// A ring of the map in the scenario, not closed.
    pub fn ring(&self, ring: &[Point]) -> Vec<Point> {
        let mut ring = self.line(ring);
        if ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        ring
    }

    /// A lane with its borders, and whether one of them is assumed.
    fn placed(&self, lane: &'m Lane) -> Option<(Placed<'m>, bool)> {
        let layers = self.layers;
        let middle = layers.middles[usize::from(lane.connector.is_some())]
            .get(&lane.id)
            .map(|line| self.line(line))
            .filter(|line| line.len() > 1);
        let border = |id: Option<i64>| {
            let (line, marking) = layers.borders.get(&id?)?;
            let line = self.line(line);
            (line.len() > 1).then_some((line, *marking))
        };
        let (left, right) = (border(lane.left), border(lane.right));
        let assumed = left.is_none() || right.is_none();
        let middle = match (middle, &left, &right) {
            (Some(middle), ..) => middle,
            (None, Some((left, _)), Some((right, _))) => {
                let right = along(right.clone(), left);
                let (left, right) = matched(left.clone(), right);
                let pairs = left.iter().zip(&right);
                pairs.map(|(a, b)| nalgebra::center(a, b)).collect()
            }
            _ => return None,
        };
        let widths = vec![(HALF_LANE, HALF_LANE); middle.len()];
        let usual = borders(&middle, &[], &widths);
        let side = |border: Option<(Vec<Point>, LineMarking)>, usual: Bound| match border {
            Some((line, marking)) => (along(line, &middle), marking),
            None => (usual.points, LineMarking::Unknown),
        };
        let (left, right) = (side(left, usual.0), side(right, usual.1));
        let (left_points, right_points) = matched(left.0, right.0);
        let bound = |points, marking| Bound {
            points,
            heights: Vec::new(),
            marking,
        };
        let (kind, user) = if lane.is_for_bicycles {
            (LaneletType::BicycleLane, RoadUser::Bicycle)
        } else {
            (LaneletType::Urban, RoadUser::Vehicle)
        };
        let lanelet = Lanelet {
            left: bound(left_points, left.1),
            right: bound(right_points, right.1),
            types: vec![kind],
            users_one_way: vec![user],
            ..Lanelet::default()
        };
        let placed = Placed {
            lane,
            middle,
            lanelet,
        };
        Some((placed, assumed))
    }

    /// The id of a lane of the map in the scenario.
    pub fn id(&self, place: usize) -> i64 {
        self.all[place].lanelet.id
    }

    /// The lane that a connector comes from, if that is there.
    pub fn from(&self, connector: &Lane) -> Option<usize> {
        let from = connector.connector.as_ref()?.from?;
        self.places[0].get(&from).copied()
    }

    /// Connectors continue lanes.
    fn link(&mut self, report: &Report) {
        let mut beyond = 0;
        for lane in &self.layers.connectors {
            let Some(connector) = &lane.connector else {
                continue;
            };
            let place = self.places[1].get(&lane.id).copied();
            let ends = [connector.from, connector.to].map(|id| self.places[0].get(&id?).copied());
            for (is_end, end) in ends.into_iter().enumerate() {
                match (place, end) {
                    (Some(place), Some(end)) => {
                        let (own, other) = (self.id(place), self.id(end));
                        let [before, after] = match is_end {
                            0 => [end, place],
                            _ => [place, end],
                        };
                        let ids = if is_end == 0 {
                            [other, own]
                        } else {
                            [own, other]
                        };
                        self.all[before].lanelet.successors.push(ids[1]);
                        self.all[after].lanelet.predecessors.push(ids[0]);
                    }
                    (None, None) => {}
                    _ => beyond += 1,
                }
            }
        }
        report.note_count(beyond, |n| {
            format!("links to lanes beyond the cut-out of the map left out: {n}")
        });
    }

    /// Lanes of a group lie beside each other, counted from the left.
    fn set_beside(&mut self) {
        let groups = self
            .all
            .iter()
            .zip(0..)
            .filter_map(|(placed, place)| Some((placed.lane.group?, place)));
        let groups: HashMap<(i64, i64), usize> = groups.collect();
        for ((group, index), place) in &groups {
            let beside = |index: Option<i64>| {
                let other = groups.get(&(*group, index?))?;
                Some(Adjacent {
                    id: self.id(*other),
                    same_direction: true,
                })
            };
            let (left, right) = (beside(index.checked_sub(1)), beside(index.checked_add(1)));
            let lanelet = &mut self.all[*place].lanelet;
            (lanelet.adjacent_left, lanelet.adjacent_right) = (left, right);
        }
    }

    /// The pedestrian crossings, as lanelets.
    pub fn crossings(&self, report: &Report, around: &Bounds, ids: &mut Ids) -> Vec<Lanelet> {
        let mut seen = HashSet::new();
        let mut crossings = Vec::new();
        for (id, ring) in &self.layers.crossings {
            let ring = self.ring(ring);
            if !Bounds::from_points(&ring).is_some_and(|bounds| bounds.overlaps(around)) {
                continue;
            }
            let own = if seen.insert(*id) {
                ids.keep(*id)
            } else {
                ids.fresh()
            };
            match lane_shape::of_ring(own, &ring) {
                Some(lanelet) => crossings.push(lanelet),
                None => report
                    .at(format!("crosswalk {id}"))
                    .warn("encloses no area; left out"),
            }
        }
        crossings
    }
}

/// A line in the direction of another one beside it: starts near starts.
fn along(mut line: Vec<Point>, other: &[Point]) -> Vec<Point> {
    let ends = |line: &[Point]| Some((*line.first()?, *line.last()?));
    if let (Some((a, b)), Some((c, d))) = (ends(&line), ends(other)) {
        let straight = (a - c).norm() + (b - d).norm();
        let crossed = (a - d).norm() + (b - c).norm();
        if crossed < straight {
            line.reverse();
        }
    }
    line
}
