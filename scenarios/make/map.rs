//! The road: lanelets cut out of roads along a path, linked where their borders meet, with signs and lights.

use std::f64::consts::PI;

use nearmiss::geometry::{Point, Pose};
use nearmiss::scenario::{
    Adjacent, Bound, Intersection, Lanelet, LaneletNetwork, LightPhase, LineMarking, Sign,
    SignElement, SignalColor, StopLine, TrafficDirection, TrafficLight,
};

pub use super::lane::Kind;
use super::lane::lanelet;
use super::path::Path;
use super::{place, rounded};

/// A lane of a cross-section, by its direction against the path.
#[derive(Debug, Clone, Copy)]
pub enum Lane {
    /// Driven along the path.
    Along(Kind),
    /// Driven against it.
    Against(Kind),
}

/// A border in a cross-section: offset from the path at the section's start and end, and what is painted there.
#[derive(Debug, Clone, Copy)]
pub struct Edge {
    from: f64,
    to: f64,
    marking: LineMarking,
}

/// A border at the same offset all along.
pub fn edge(offset: f64, marking: LineMarking) -> Edge {
    taper(offset, offset, marking)
}

/// A border whose offset changes smoothly along the section.
pub fn taper(from: f64, to: f64, marking: LineMarking) -> Edge {
    Edge { from, to, marking }
}

/// The road as it is being built.
#[derive(Debug, Default)]
pub struct Map {
    lanelets: Vec<Lanelet>,
    signs: Vec<Sign>,
    lights: Vec<TrafficLight>,
    intersections: Vec<Intersection>,
}

impl Map {
    /// Adds the lanelets of a stretch of road between two arc lengths of `path`.
    ///
    /// `edges` go from right to left and enclose the `lanes`, which get the ids from `first` on.
    pub fn road(
        &mut self,
        path: &Path,
        (from, to): (f64, f64),
        first: i64,
        edges: &[Edge],
        lanes: &[Lane],
    ) {
        let stations = stations(path, from, to);
        let line = |edge: &Edge| Bound {
            points: stations
                .iter()
                .map(|&s| {
                    let u = ((s - from) / (to - from)).clamp(0.0, 1.0);
                    let part = u * u * (3.0 - 2.0 * u);
                    place(path.point(s, edge.from + (edge.to - edge.from) * part))
                })
                .collect(),
            heights: Vec::new(),
            marking: edge.marking,
        };
        for ((id, pair), lane) in (first..).zip(edges.windows(2)).zip(lanes) {
            let (right, left) = (line(&pair[0]), line(&pair[1]));
            self.lanelets.push(match *lane {
                Lane::Along(kind) => lanelet(id, kind, left, right),
                Lane::Against(kind) => lanelet(id, kind, turned(right), turned(left)),
            });
        }
    }

    /// Adds one lane of a width around its own centre line.
    pub fn lane(&mut self, id: i64, path: &Path, width: f64, kind: Kind, marking: LineMarking) {
        let half = width / 2.0;
        let edges = [edge(-half, marking), edge(half, marking)];
        self.road(path, (0.0, path.length()), id, &edges, &[Lane::Along(kind)]);
    }

    /// Adds a crossing for people on foot, `length` metres along the road and to `half` on both sides of it.
    pub fn crossing(&mut self, id: i64, path: &Path, s: f64, half: f64, length: f64) {
        let right = path.pose(s, -half);
        let start = Pose {
            heading: right.heading + PI / 2.0,
            ..right
        };
        let across = Path::from(start).straight(2.0 * half);
        self.lane(id, &across, length, Kind::Crosswalk, LineMarking::Dashed);
    }

    /// Puts up a sign (German numbers, which CommonRoad takes for ZAM too) for some lanelets.
    pub fn sign(&mut self, id: i64, what: &[(&str, &str)], at: Point, lanelets: &[i64]) {
        let element = |(id, value): &(&str, &str)| SignElement {
            id: (*id).to_string(),
            values: if value.is_empty() {
                vec![]
            } else {
                vec![(*value).to_string()]
            },
        };
        self.signs.push(Sign {
            id,
            elements: what.iter().map(element).collect(),
            position: Some(place(at)),
            is_virtual: false,
        });
        for lanelet in self.of(lanelets) {
            lanelet.signs.push(id);
        }
    }

    /// Puts up a traffic light that holds at the ends of some lanelets.
    pub fn light(
        &mut self,
        id: i64,
        phases: &[(i64, SignalColor)],
        offset: i64,
        at: Point,
        lanelets: &[i64],
    ) {
        let phase = |&(duration, color): &(i64, SignalColor)| LightPhase { duration, color };
        self.lights.push(TrafficLight {
            id,
            cycle: phases.iter().map(phase).collect(),
            offset,
            position: Some(place(at)),
            direction: Some(TrafficDirection::All),
            active: true,
        });
        for lanelet in self.of(lanelets) {
            lanelet.lights.push(id);
        }
        self.stop_line(lanelets, None, Some(id));
    }

    /// Paints stop lines across the ends of some lanelets, for a sign or a light.
    pub fn stop_line(&mut self, lanelets: &[i64], sign: Option<i64>, light: Option<i64>) {
        for lanelet in self.of(lanelets) {
            let ends = (lanelet.left.points.last(), lanelet.right.points.last());
            lanelet.stop_line = Some(StopLine {
                points: ends.0.copied().zip(ends.1.copied()),
                marking: LineMarking::BroadSolid,
                signs: sign.into_iter().collect(),
                lights: light.into_iter().collect(),
            });
        }
    }

    /// Adds an intersection.
    pub fn intersection(&mut self, intersection: Intersection) {
        self.intersections.push(intersection);
    }

    fn of(&mut self, ids: &[i64]) -> impl Iterator<Item = &mut Lanelet> {
        self.lanelets.iter_mut().filter(|l| ids.contains(&l.id))
    }

    /// The network, with neighbours, successors and predecessors found by their borders.
    pub fn finish(self) -> LaneletNetwork {
        let linked = self
            .lanelets
            .iter()
            .map(|l| linked(l, &self.lanelets))
            .collect();
        LaneletNetwork::new(linked, self.signs, self.lights, self.intersections)
    }
}

/// The value of a speed-limit sign, m/s.
pub fn limit(kilometres_per_hour: f64) -> String {
    rounded(kilometres_per_hour / 3.6).to_string()
}

/// A pose turned round.
pub fn back(pose: Pose) -> Pose {
    Pose {
        heading: pose.heading + PI,
        ..pose
    }
}

/// Where borders get points: close together in bends, so that chords stay within a centimetre or two.
fn stations(path: &Path, from: f64, to: f64) -> Vec<f64> {
    let mut stations = vec![from];
    let mut s = from;
    loop {
        let sharpest = [0.0, 2.5, 5.0].map(|ahead| path.curvature(s + ahead).abs());
        let sharpest = sharpest.into_iter().fold(1e-6, f64::max);
        let step = (0.12 / sharpest).sqrt().clamp(1.0, 10.0);
        // The rest is not left as a sliver.
        if to - s < 1.5 * step {
            break;
        }
        s += step;
        stations.push(s);
    }
    stations.push(to);
    stations
}

fn turned(mut bound: Bound) -> Bound {
    bound.points.reverse();
    bound
}

/// A lanelet with references to those of `all` that it touches.
fn linked(lanelet: &Lanelet, all: &[Lanelet]) -> Lanelet {
    let others = || {
        all.iter()
            .filter(|o| o.id != lanelet.id && driven(o) == driven(lanelet))
    };
    let adjacent =
        |mine: &Bound, same: fn(&Lanelet) -> &Bound, opposite: fn(&Lanelet) -> &Bound| {
            let mut others = all.iter().filter(|o| o.id != lanelet.id);
            others.find_map(|other| {
                let along = same(other).points == mine.points;
                let against = opposite(other).points.iter().rev().eq(&mine.points);
                (along || against).then_some(Adjacent {
                    id: other.id,
                    same_direction: along,
                })
            })
        };
    Lanelet {
        successors: others()
            .filter(|o| follows(lanelet, o))
            .map(|o| o.id)
            .collect(),
        predecessors: others()
            .filter(|o| follows(o, lanelet))
            .map(|o| o.id)
            .collect(),
        adjacent_left: adjacent(&lanelet.left, |o| &o.right, |o| &o.left),
        adjacent_right: adjacent(&lanelet.right, |o| &o.left, |o| &o.right),
        ..lanelet.clone()
    }
}

/// Whether lanelets are for wheels or for feet: the two are not linked.
fn driven(lanelet: &Lanelet) -> bool {
    lanelet.users_bidirectional.is_empty()
}

fn follows(before: &Lanelet, after: &Lanelet) -> bool {
    // Borders of different paths meet within rounding, not exactly.
    let meet = |a: &Bound, b: &Bound| match (a.points.last(), b.points.first()) {
        (Some(end), Some(start)) => (end - start).norm() < 1e-3,
        _ => false,
    };
    meet(&before.left, &after.left) && meet(&before.right, &after.right)
}
