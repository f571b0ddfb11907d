//! What the map says along a way: limits, lights, stop signs, intersections.

use super::junction::{Passage, Turn, passages};
use super::right_of_way::SignRank;
use super::stopping::{LightLine, StopSignLine, is_for};
use crate::scenario::{
    DirectedLanelet, Direction, Lane, Lanelet, LaneletNetwork, Route, SignMeaning, TrafficLight,
};
use nearmiss_base::geometry::{Bounds, Point, ReferencePath, contains};

/// The rules of the road along a way.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Regulations {
    /// Where speeds are limited, in the way's order; stretches may overlap.
    pub limits: Vec<LimitedStretch>,
    /// Lines of lights, in the way's order.
    pub lights: Vec<LightLine>,
    /// Lines of stop signs, in the way's order.
    pub stops: Vec<StopSignLine>,
    /// Intersections, in the way's order.
    pub passages: Vec<Passage>,
    /// The lanelets of the way.
    pub(super) stretches: Vec<Stretch>,
}

/// A part of a way on which no vehicle may be faster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitedStretch {
    /// Arc length of its beginning, metres.
    pub from: f64,
    /// Of its end, metres.
    pub to: f64,
    /// m/s.
    pub speed: f64,
    /// The lanelet.
    pub lanelet: i64,
}

/// A lanelet of a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    pub lanelet: i64,
    /// Whether it is driven in its direction.
    pub along: bool,
    /// Arc lengths of its beginning and end, metres.
    pub from: f64,
    pub to: f64,
    /// Arc length of its stop line, else of its end.
    pub line: f64,
    /// Whether the way leaves it at its end: not by a lane change.
    pub ends: bool,
}

/// Between places of a path that are looked at, metres.
const SPACING: f64 = 1.0;

/// A line is looked for this far from where it should be, metres.
const LINE_SEARCH_RADIUS: f64 = 12.0;

/// Lines nearer to each other than this are one, metres.
const ONE: f64 = 4.0;

impl Regulations {
    /// Those along the path of a route.
    #[must_use]
    pub fn along(network: &LaneletNetwork, route: &Route, path: &ReferencePath) -> Self {
        let legs = route.legs.iter().map(|leg| leg.driven);
        let before = route.before.iter().copied();
        let way: Vec<DirectedLanelet> = before
            .chain(legs)
            .chain(route.after.iter().copied())
            .collect();
        let stretches = stretches(network, &way, path);
        let mut passages = passages(network, path, &stretches);
        let lights = light_lines(network, &stretches, &passages);
        for passage in &mut passages {
            passage.lights = lights
                .iter()
                .any(|line| (line.s - passage.line).abs() < LINE_SEARCH_RADIUS);
        }
        let stops = stop_lines(network, &stretches, &lights, &passages);
        Self {
            limits: limits(network, &stretches),
            lights,
            stops,
            passages,
            stretches,
        }
    }

    /// Whether there is nothing to obey along the way.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.limits.is_empty()
            && self.lights.is_empty()
            && self.stops.is_empty()
            && self.passages.is_empty()
    }

    /// The speed limit (m/s) at arc length `s` (m): of lanelets that overlap there, the higher one.
    #[must_use]
    pub fn limit_at(&self, s: f64) -> Option<&LimitedStretch> {
        let here = self.limits.iter().filter(|l| l.from <= s && s < l.to);
        here.max_by(|a, b| a.speed.total_cmp(&b.speed))
    }

    /// Whether the lights of a passage show something at a step.
    #[must_use]
    pub fn is_lit(&self, passage: &Passage, step: i64) -> bool {
        let near = |line: &&LightLine| (line.s - passage.line).abs() < LINE_SEARCH_RADIUS;
        let mut lines = self.lights.iter().filter(near);
        lines.any(|line| line.color_at(step) != crate::scenario::SignalColor::Inactive)
    }

    /// The lanelet at an arc length.
    pub(super) fn lanelet_at(&self, s: f64) -> Option<i64> {
        let here = self.stretches.iter().find(|l| l.from <= s && s <= l.to);
        here.map(|stretch| stretch.lanelet)
    }
}

/// Where the lanelets of a way lie along its path.
fn stretches(
    network: &LaneletNetwork,
    way: &[DirectedLanelet],
    path: &ReferencePath,
) -> Vec<Stretch> {
    let count = (path.length() / SPACING)
        .floor()
        .clamp(0.0, MAX_PATH_LENGTH) as usize;
    let points: Vec<Point> = (0..=count)
        .map(|n| path.pose_at(n as f64 * SPACING).position)
        .collect();
    let mut found = Vec::new();
    for driven in way {
        let Some(lanelet) = network.lanelet(driven.lanelet) else {
            continue;
        };
        let ring = lanelet.ring();
        let Some(bounds) = Bounds::from_points(&ring) else {
            continue;
        };
        let inside = |p: &Point| bounds.contains(p) && contains(&ring, p);
        let Some(first) = points.iter().position(inside) else {
            continue;
        };
        let more = points[first..].iter().take_while(|p| inside(p)).count();
        let (from, to) = (first as f64 * SPACING, (first + more - 1) as f64 * SPACING);
        let along = driven.direction == Direction::Along;
        let ends = ends_of(lanelet).map(|(a, b)| if along { (a, b) } else { (b, a) });
        let begin = ends.and_then(|(begin, _)| near(path, &begin, from));
        let end = ends.and_then(|(_, end)| near(path, &end, to));
        let line = lanelet
            .stop_line_ends()
            .filter(|_| along)
            .and_then(|(a, b)| near(path, &nalgebra::center(&a, &b), to));
        found.push(Stretch {
            lanelet: driven.lanelet,
            along,
            from: begin
                .filter(|s| (s - from).abs() <= 2.0 * SPACING)
                .unwrap_or(from),
            to: end
                .filter(|s| (s - to).abs() <= 2.0 * SPACING)
                .unwrap_or(to),
            line: line.or(end).unwrap_or(to),
            ends: end.is_some_and(|s| (s - to).abs() <= 2.0 * SPACING),
        });
    }
    found
}

/// Metres of a path that are looked at, at most.
const MAX_PATH_LENGTH: f64 = 20_000.0;

/// The middles of a lanelet's beginning and end.
fn ends_of(lanelet: &Lanelet) -> Option<(Point, Point)> {
    let lane = Lane::from_lanelet(lanelet)?;
    let points = lane.centre().points();
    Some((*points.first()?, *points.last()?))
}

/// The arc length beside a point, where the path passes it.
fn near(path: &ReferencePath, point: &Point, s: f64) -> Option<f64> {
    let at = path.project_near(point, s, LINE_SEARCH_RADIUS).ok()?;
    (at.d.abs() < 3.0).then_some(at.s)
}

fn limits(network: &LaneletNetwork, stretches: &[Stretch]) -> Vec<LimitedStretch> {
    let limit = |stretch: &Stretch| {
        let lanelet = network.lanelet(stretch.lanelet)?;
        let limits = lanelet.signs.iter().flat_map(|id| {
            let sign = network.signs.iter().find(|sign| sign.id == *id);
            let elements = sign.into_iter().flat_map(|sign| &sign.elements);
            elements.filter_map(|element| match element.meaning() {
                Some(SignMeaning::SpeedLimit(limit)) if limit > 0.0 => Some(limit),
                _ => None,
            })
        });
        Some(LimitedStretch {
            from: stretch.from,
            to: stretch.to,
            speed: limits.min_by(f64::total_cmp)?,
            lanelet: stretch.lanelet,
        })
    };
    stretches.iter().filter_map(limit).collect()
}

/// The turn of the way at the intersection to which a lanelet leads or in which it lies, and whether it lies inside.
fn turn_at(passages: &[Passage], stretch: &Stretch) -> (Option<Turn>, bool) {
    for passage in passages {
        if passage.lanelet == stretch.lanelet && stretch.from < passage.line {
            return (Some(passage.turn), false);
        }
        let inside = stretch.from >= passage.line - ONE && stretch.to <= passage.until + ONE;
        if inside && passage.lanelet != stretch.lanelet {
            return (Some(passage.turn), true);
        }
    }
    (None, false)
}

fn light_lines(
    network: &LaneletNetwork,
    stretches: &[Stretch],
    passages: &[Passage],
) -> Vec<LightLine> {
    let mut lines: Vec<LightLine> = Vec::new();
    let held = |lanelet: &Lanelet| -> Vec<i64> {
        let line = lanelet.stop_line.iter().flat_map(|line| &line.lights);
        lanelet.lights.iter().chain(line).copied().collect()
    };
    for (place, stretch) in stretches.iter().enumerate() {
        let Some(lanelet) = network.lanelet(stretch.lanelet).filter(|_| stretch.along) else {
            continue;
        };
        let (turn, inside) = turn_at(passages, stretch);
        let ids = held(lanelet);
        // The lights of the next lanelet are met at its end.
        let next = stretches
            .get(place + 1)
            .and_then(|s| network.lanelet(s.lanelet));
        let later = |id: &i64| !inside && next.is_some_and(|next| held(next).contains(id));
        let leaves = stretch.ends || lanelet.stop_line.is_some();
        let lights: Vec<TrafficLight> = network
            .lights
            .iter()
            .filter(|light| ids.contains(&light.id) && !later(&light.id))
            .filter(|light| is_for(light, turn) && leaves)
            .cloned()
            .collect();
        let s = if inside && lanelet.stop_line.is_none() {
            stretch.from
        } else {
            stretch.line
        };
        let known = |line: &LightLine| {
            (line.s - s).abs() < ONE
                && line
                    .lights
                    .iter()
                    .any(|l| lights.iter().any(|m| m.id == l.id))
        };
        if lights.is_empty() || lines.iter().any(known) {
            continue;
        }
        lines.push(LightLine {
            s,
            lanelet: stretch.lanelet,
            lights,
        });
    }
    lines.sort_by(|a, b| a.s.total_cmp(&b.s));
    lines
}

fn stop_lines(
    network: &LaneletNetwork,
    stretches: &[Stretch],
    lights: &[LightLine],
    passages: &[Passage],
) -> Vec<StopSignLine> {
    let says_stop = |stretch: &Stretch| {
        let lanelet = network.lanelet(stretch.lanelet).filter(|_| stretch.along);
        lanelet.is_some_and(|lanelet| SignRank::from_signs(network, [lanelet]) == SignRank::Stop)
    };
    let mut lines: Vec<StopSignLine> = Vec::new();
    for (place, stretch) in stretches.iter().enumerate() {
        let (_, inside) = turn_at(passages, stretch);
        let again = stretches.get(place + 1).is_some_and(says_stop);
        if !says_stop(stretch) || !stretch.ends || !inside && again {
            continue;
        }
        let s = if inside { stretch.from } else { stretch.line };
        let lit = lights
            .iter()
            .any(|line| (line.s - s).abs() < LINE_SEARCH_RADIUS);
        if lit || lines.iter().any(|line| (line.s - s).abs() < ONE) {
            continue;
        }
        lines.push(StopSignLine {
            s,
            lanelet: stretch.lanelet,
        });
    }
    lines
}
