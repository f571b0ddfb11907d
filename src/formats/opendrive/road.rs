//! Roads: lanelets that lie beside each other in one direction, along one reference line.

use std::collections::HashSet;

use super::curve::Curve;
use super::paired::{Paired, crossing_squarely, paired};
use super::profile::{Profile, deviation, profile, samples};
use super::reference_line::{Laying, lay};
use nearmiss_base::geometry::{Point, Polyline};
use nearmiss_scene::scenario::{Adjacent, Lanelet, LaneletNetwork};

/// A road with its lanes, from the left to the right.
#[derive(Debug, Clone)]
pub struct Road {
    /// Places of its lanelets in the network, from the left to the right.
    pub lanelets: Vec<usize>,
    /// Its reference line.
    pub curve: Curve,
    /// How far to the left of it the leftmost border is.
    pub offset: Profile,
    /// Widths of its lanes.
    pub widths: Vec<Profile>,
    /// How far its borders are at most from those of the lanelets, metres.
    pub deviation: f64,
}

/// Neighbours are one road if their borders are written as near as this, metres.
const TOGETHER: f64 = 0.02;

/// Near enough not to try another reference line, metres.
const GOOD: f64 = 0.01;

/// Farther off, a road is also laid through pairs of points, metres.
const FINE: f64 = 0.02;

/// Where between the right (0) and the left border (1) a road through pairs of points runs.
const PAIRED: [f64; 5] = [0.5, 0.75, 0.25, 1.0, 0.0];

/// Where one that crosses the road squarely begins; beyond a border where that one does not run back.
const SQUARE: [f64; 9] = [0.5, 1.0, 0.0, 1.5, -0.5, 2.0, -1.0, 3.0, -2.0];

/// Corners of lanes of one road are as near to those of their lanelets, metres.
const MEETING: f64 = 0.003;

/// How near widths and offsets are to the borders, metres.
const WIDTHS: f64 = 0.001;

/// The ways in which a reference line is laid until the borders fit.
const LAYINGS: [(f64, f64, f64); 7] = [
    (0.5, 0.3, 3.0),
    (0.5, 0.1, 1.5),
    (0.5, 0.5, 8.0),
    (1.0, 0.2, 2.0),
    (0.0, 0.2, 2.0),
    (0.5, 0.05, 0.7),
    (0.5, 0.02, 0.25),
];

/// All lanelets as roads; those that have no length are not among them.
pub fn roads(network: &LaneletNetwork) -> Vec<Road> {
    let mut all = Vec::new();
    for group in groups(network) {
        let fits = |r: &Road| r.deviation < TOGETHER && r.ends_fit(network);
        let whole = road(network, &group).filter(|r| group.len() == 1 || fits(r));
        match whole {
            Some(road) => all.push(road),
            None => all.extend(group.iter().filter_map(|place| road(network, &[*place]))),
        }
    }
    all
}

/// Lanelets beside each other in the same direction whose borders are the same, from the left to the right.
fn groups(network: &LaneletNetwork) -> Vec<Vec<usize>> {
    let lanelets = &network.lanelets;
    let place = |id: i64| lanelets.iter().position(|l| l.id == id);
    let beside = |adjacent: Option<Adjacent>| adjacent.filter(|a| a.same_direction).map(|a| a.id);
    let right_of = |lanelet: &Lanelet| {
        let to = place(beside(lanelet.adjacent_right)?)?;
        let other = &lanelets[to];
        let mutual = beside(other.adjacent_left) == Some(lanelet.id);
        (mutual && same_border(lanelet, other)).then_some(to)
    };
    let rights: Vec<Option<usize>> = lanelets.iter().map(right_of).collect();
    let has_left: HashSet<usize> = rights.iter().flatten().copied().collect();
    let mut seen = HashSet::new();
    let mut found = Vec::new();
    let leftmost = (0..lanelets.len()).filter(|i| !has_left.contains(i));
    // A ring of neighbours has no leftmost one.
    for first in leftmost.chain(0..lanelets.len()) {
        let mut group = Vec::new();
        let mut next = Some(first);
        while let Some(place) = next.filter(|place| seen.insert(*place)) {
            group.push(place);
            next = rights[place];
        }
        if !group.is_empty() {
            found.push(group);
        }
    }
    found
}

fn same_border(left: &Lanelet, right: &Lanelet) -> bool {
    let (Some(a), Some(b)) = (line(&left.right.points), line(&right.left.points)) else {
        return false;
    };
    let near = |a: &Polyline, b: &Polyline| {
        let mut all = a.points().iter();
        all.all(|p| b.project(p).d.abs() < TOGETHER)
    };
    near(&a, &b) && near(&b, &a)
}

fn line(points: &[Point]) -> Option<Polyline> {
    Polyline::new(points.iter().copied())
}

/// The road of a group; `None` if a border of it has no length.
fn road(network: &LaneletNetwork, group: &[usize]) -> Option<Road> {
    let lanelet = |place: &usize| &network.lanelets[*place];
    let first = group.first().map(lanelet)?;
    let mut borders = vec![line(&first.left.points)?];
    for place in group {
        borders.push(line(&lanelet(place).right.points)?);
    }
    let (left, right) = (borders.first()?, borders.last()?);
    let mut best: Option<Road> = None;
    for (place, tolerance, shortest) in LAYINGS {
        let how = Laying {
            place,
            tolerance,
            shortest,
        };
        let Some(curve) = lay(left, right, how) else {
            continue;
        };
        let built = along(curve, &borders, group);
        let better = |best: &Road| built.deviation < best.deviation;
        if best.as_ref().is_none_or(better) {
            best = Some(built);
        }
        if best.as_ref().is_some_and(|best| best.deviation < GOOD) {
            break;
        }
    }
    if group.len() == 1 && best.as_ref().is_none_or(|best| best.deviation > FINE) {
        let tight = PAIRED.iter().map(|place| paired(left, right, *place));
        let square = SQUARE
            .iter()
            .map(|place| crossing_squarely(left, right, *place));
        for Paired { curve, left, right } in tight.chain(square).flatten() {
            if best.as_ref().is_some_and(|best| best.deviation < GOOD) {
                break;
            }
            let built = built(curve, &[left, right], &borders, group);
            if best
                .as_ref()
                .is_none_or(|best| built.deviation < best.deviation)
            {
                best = Some(built);
            }
        }
    }
    best
}

fn along(curve: Curve, borders: &[Polyline], group: &[usize]) -> Road {
    let at = samples(&curve);
    let places: Vec<Profile> = borders
        .iter()
        .map(|border| profile(&curve, border, &at))
        .collect();
    built(curve, &places, borders, group)
}

fn built(curve: Curve, places: &[Profile], borders: &[Polyline], group: &[usize]) -> Road {
    let offset = places
        .first()
        .map(|p| p.simplified(WIDTHS))
        .unwrap_or_default();
    let pairs = places.windows(2);
    let widths: Vec<Profile> = pairs
        .map(|pair| pair[0].less(&pair[1]).simplified(WIDTHS))
        .collect();
    let mut road = Road {
        lanelets: group.to_vec(),
        curve,
        offset,
        widths,
        deviation: 0.0,
    };
    let told = borders.iter().enumerate();
    road.deviation = told
        .map(|(i, border)| deviation(&road.curve, &road.border(i), border))
        .fold(0.0, f64::max);
    road
}

impl Road {
    /// Metres.
    pub fn length(&self) -> f64 {
        self.curve.length()
    }

    /// How far to the left the border to the right of so many lanes is, by the arc length.
    pub fn border(&self, lanes: usize) -> Profile {
        let inner = &self.widths[..lanes.min(self.widths.len())];
        let all = inner.iter().chain([&self.offset]).flat_map(|p| &p.0);
        let mut at: Vec<f64> = all.map(|(s, _)| *s).collect();
        at.sort_by(f64::total_cmp);
        at.dedup();
        let value = |s: f64| self.offset.at(s) - inner.iter().map(|w| w.at(s)).sum::<f64>();
        Profile(at.into_iter().map(|s| (s, value(s))).collect())
    }
}

impl Road {
    /// The ends of a border, to the right of so many lanes: at its beginning or its end.
    pub fn corner(&self, lanes: usize, at_end: bool) -> Point {
        let border = self.border(lanes).0;
        let place = if at_end {
            border.last()
        } else {
            border.first()
        };
        let (s, t) = place.copied().unwrap_or_default();
        self.curve.at(s).to_world(&Point::new(0.0, t))
    }

    /// Whether its lanes end where their lanelets do, so that they meet others there.
    fn ends_fit(&self, network: &LaneletNetwork) -> bool {
        let lanes = self.lanelets.iter().enumerate();
        let mut all = lanes.flat_map(|(lane, place)| {
            let lanelet = &network.lanelets[*place];
            [(&lanelet.left, lane), (&lanelet.right, lane + 1)]
        });
        all.all(|(bound, lanes)| {
            let ends = [(bound.points.first(), false), (bound.points.last(), true)];
            let off = |(p, at_end): (Option<&Point>, bool)| {
                p.map_or(0.0, |p| (self.corner(lanes, at_end) - p).norm())
            };
            ends.into_iter().all(|end| off(end) < MEETING)
        })
    }

    /// It up to an arc length, and the rest.
    pub fn split(&self, s: f64) -> (Self, Self) {
        let (head, tail) = self.curve.split(s);
        let part = |curve: Curve, from: f64, to: f64| Self {
            curve,
            offset: self.offset.part(from, to),
            widths: self.widths.iter().map(|w| w.part(from, to)).collect(),
            lanelets: self.lanelets.clone(),
            deviation: self.deviation,
        };
        (part(head, 0.0, s), part(tail, s, self.length()))
    }

    /// A road of some of its lanes, counted from the left.
    pub fn lanes(&self, range: std::ops::Range<usize>) -> Self {
        Self {
            offset: self.border(range.start),
            widths: self.widths[range.clone()].to_vec(),
            lanelets: self.lanelets[range].to_vec(),
            ..self.clone()
        }
    }
}
