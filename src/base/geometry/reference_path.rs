//! Smooth reference paths: a curve with continuous curvature rate along a polyline, and the nearest point on it.

use std::ops::Range;

use super::curve::{SQUARE, Span};
use super::frenet::{Frenet, FrenetError};
use super::{Bounds, BoxTree, Point, Polyline, Pose, Vector};

/// A smooth curve along a polyline, continued straight beyond both ends.
///
/// It is a uniform quintic B-spline whose control points lie on the polyline at equal distances of at
/// most 2 m, halved until the curve stays within 0.1 m of the polyline or they are 0.25 m apart. So
/// heading, curvature, its rate and the rate's rate are continuous, at the ends too: they fade to a
/// straight line. Arc length is 0 beside the polyline's first point and [`Self::length`] beside its last.
#[derive(Debug, Clone)]
pub struct ReferencePath {
    /// Coordinates are taken from here, so that far from the origin no digits are lost.
    pub(super) origin: Point,
    pub(super) spans: Vec<Span>,
    /// Arc length at the beginning of each span and the end of the last, metres.
    pub(super) arc: Vec<f64>,
    pub(super) chords: BoxTree,
    /// No span leaves its chord by more than this, metres.
    pub(super) sagitta: f64,
    deviation: f64,
    length: f64,
    /// Length of the polyline between two control points, metres.
    spacing: f64,
}

/// The curve at one arc length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// Position, metres.
    pub position: Point,
    /// Heading θ, radians in (−π, π].
    pub heading: f64,
    /// Curvature κ, 1/m; positive in left turns.
    pub curvature: f64,
    /// Change of curvature along the arc length dκ/ds, 1/m².
    pub curvature_rate: f64,
}

/// The curve at one arc length, with its direction instead of its heading: quicker, where no angle is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathFrame {
    /// Position, metres.
    pub position: Point,
    /// The unit vector along the path.
    pub tangent: Vector,
    /// Curvature κ, 1/m; positive in left turns.
    pub curvature: f64,
    /// Change of curvature along the arc length dκ/ds, 1/m².
    pub curvature_rate: f64,
}

impl From<PathFrame> for PathPoint {
    fn from(frame: PathFrame) -> Self {
        Self {
            position: frame.position,
            heading: frame.tangent.y.atan2(frame.tangent.x),
            curvature: frame.curvature,
            curvature_rate: frame.curvature_rate,
        }
    }
}

/// Why there is no smooth path along a polyline.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum ReferencePathError {
    /// Fewer than two different points.
    #[error("the line has no length")]
    NoLength,
    /// The line turns back on itself, so that no smooth curve follows it.
    #[error("the line turns back on itself at {s:.1} m of its length")]
    TurnsBack {
        /// Where, metres along the line.
        s: f64,
    },
    /// Longer than any road.
    #[error("the line is {length:e} m long; at most {MOST_SPANS} m are supported")]
    TooLong {
        /// Metres.
        length: f64,
    },
}

/// Distances between control points that are tried, metres: the widest that keeps to the line is smoothest.
const SPACINGS: [f64; 4] = [2.0, 1.0, 0.5, 0.25];

/// Parts of a piece that rounding may add to a line.
const ROUNDING_SHARE: f64 = 1e-6;

/// How far the curve may leave the line, metres, while closer control points could bring it nearer.
const DEVIATION: f64 = 0.1;

/// Memory is bounded: a line of this many metres and more is refused.
const MOST_SPANS: u32 = 200_000;

/// A curve slower than this share of the spacing has a cusp in all but name.
const SLOWEST: f64 = 0.05;

impl ReferencePath {
    /// The smooth path along `points`; repeated neighbours are dropped.
    ///
    /// # Errors
    /// The line has no length, turns back on itself, or is longer than any road.
    pub fn new(points: impl IntoIterator<Item = Point>) -> Result<Self, ReferencePathError> {
        let line = Polyline::new(points).ok_or(ReferencePathError::NoLength)?;
        let length = line.length();
        if !length.is_finite() || length > f64::from(MOST_SPANS) {
            return Err(ReferencePathError::TooLong { length });
        }
        let mut best: Option<Self> = None;
        let mut cusp = None;
        for spacing in SPACINGS {
            let path = Self::with_spacing(&line, spacing);
            if let Some(s) = path.cusp() {
                cusp.get_or_insert(s);
                continue;
            }
            let near_enough = path.deviation <= DEVIATION;
            if best.as_ref().is_none_or(|b| path.deviation < b.deviation) {
                best = Some(path);
            }
            if near_enough {
                break;
            }
        }
        best.ok_or(ReferencePathError::TurnsBack {
            s: cusp.unwrap_or(0.0),
        })
    }

    fn with_spacing(line: &Polyline, spacing: f64) -> Self {
        // A line as long as a whole number of pieces must not get one more from rounding.
        let pieces = (line.length() / spacing - ROUNDING_SHARE).ceil().max(1.0);
        let spacing = line.length() / pieces;
        let last = pieces as i64;
        let origin = line.points()[0];
        // Beyond its ends the line goes on straight, so that the curve does after one more span.
        let first_two = [line.pose_at(0.0), line.pose_at(spacing)].map(|p| p.position);
        let last_two = [line.length(), line.length() - spacing].map(|s| line.pose_at(s).position);
        let control = |i: i64| -> Vector {
            let beyond = |[end, inner]: [Point; 2], n: i64| end + (end - inner) * n as f64;
            let at = if i < 0 {
                beyond(first_two, -i)
            } else if i > last {
                beyond(last_two, i - last)
            } else {
                line.pose_at(i as f64 * spacing).position
            };
            at - origin
        };
        let control: Vec<Vector> = (-3..=last + 3).map(control).collect();
        let spans: Vec<Span> = control
            .array_windows()
            .map(|six: &[Vector; 6]| Span::new(six))
            .collect();
        let mut arc = vec![-spans[0].arc_to(1.0)];
        for span in &spans {
            arc.push(arc[arc.len() - 1] + span.arc_to(1.0));
        }
        let chord = |span: &Span| {
            let [from, to] = [span.at(0.0), span.at(1.0)].map(Point::from);
            Bounds {
                min: from.inf(&to),
                max: from.sup(&to),
            }
        };
        let mut path = Self {
            origin,
            chords: BoxTree::new(spans.iter().map(chord)),
            sagitta: spans.iter().map(|s| s.sagitta).fold(0.0, f64::max),
            length: arc[arc.len() - 2],
            spans,
            arc,
            deviation: 0.0,
            spacing,
        };
        path.deviation = path.deviation_from(line);
        path
    }

    /// Where the curve all but stops, metres along the line.
    fn cusp(&self) -> Option<f64> {
        let slow = |span: &Span| {
            let speeds = (0..8).map(|i| span.first(f64::from(i) / 8.0).norm());
            speeds.fold(f64::MAX, f64::min) < SLOWEST * self.spacing
        };
        let place = self.spans.iter().position(slow)?;
        Some((place as f64 - 0.5).max(0.0) * self.spacing)
    }

    /// The largest distance from the polyline's points to the curve, and from the curve to the polyline.
    fn deviation_from(&self, line: &Polyline) -> f64 {
        let mut most = 0.0_f64;
        let arcs = line.arc_lengths();
        for (point, arc) in line.points().iter().zip(arcs) {
            // The curve runs beside the line: span n + 1 begins at control point n.
            let middle = (arc / self.spacing) as usize + 1;
            let around = middle.saturating_sub(2)..(middle + 3).min(self.spans.len());
            let p = point - self.origin;
            let distances = self.spans[around]
                .iter()
                .map(|span| (span.at(span.nearest(&p)) - p).norm());
            most = most.max(distances.fold(f64::MAX, f64::min));
        }
        for (n, span) in self.spans[1..self.spans.len() - 1].iter().enumerate() {
            for u in [0.0, 0.25, 0.5, 0.75, 1.0] {
                let s = (n as f64 + u) * self.spacing;
                let window = s - 1.5 * self.spacing..s + 1.5 * self.spacing;
                most = most.max(line.distance_within(&(self.origin + span.at(u)), window));
            }
        }
        most
    }

    /// Arc length from beside the polyline's first point to beside its last, metres.
    #[must_use]
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The largest distance between the curve and the polyline it was made of, metres.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviation
    }

    /// The arc length of the curve beside the point `along` metres along the polyline it was made of.
    #[must_use]
    pub fn station(&self, along: f64) -> f64 {
        let at = (along / self.spacing + 1.0).clamp(0.0, self.spans.len() as f64);
        let place = (at as usize).min(self.spans.len() - 1);
        self.arc[place] + self.spans[place].arc_to(at - place as f64)
    }

    /// The curve at arc length `s`, any number of metres.
    #[must_use]
    pub fn at(&self, s: f64) -> PathPoint {
        self.frame_at(s).into()
    }

    /// The same without angles.
    #[must_use]
    pub fn frame_at(&self, s: f64) -> PathFrame {
        let last = self.spans.len();
        if s <= self.arc[0] || s >= self.arc[last] {
            let (end, place, u) = if s <= self.arc[0] {
                (self.arc[0], 0, 0.0)
            } else {
                (self.arc[last], last - 1, 1.0)
            };
            let along = self.spans[place].first(u).normalize();
            return PathFrame {
                position: self.origin + self.spans[place].at(u) + along * (s - end),
                tangent: along,
                curvature: 0.0,
                curvature_rate: 0.0,
            };
        }
        let place = self.arc.partition_point(|&a| a <= s).clamp(1, last) - 1;
        let span = &self.spans[place];
        let length = self.arc[place + 1] - self.arc[place];
        self.frame(place, span.parameter_at(s - self.arc[place], length))
    }

    /// The pose at arc length `s`.
    #[must_use]
    pub fn pose_at(&self, s: f64) -> Pose {
        let PathPoint {
            position, heading, ..
        } = self.at(s);
        Pose { position, heading }
    }

    pub(super) fn point(&self, place: usize, u: f64) -> PathPoint {
        self.frame(place, u).into()
    }

    fn frame(&self, place: usize, u: f64) -> PathFrame {
        let jet = self.spans[place].jet(u);
        let speed = jet.first.norm();
        let curvature = jet.first.perp(&jet.second) / speed.powi(3);
        let by_u = jet.first.perp(&jet.third) / speed.powi(3)
            - 3.0 * curvature * jet.first.dot(&jet.second) / speed.powi(2);
        PathFrame {
            position: self.origin + jet.at,
            tangent: jet.first / speed,
            curvature,
            curvature_rate: by_u / speed,
        }
    }
}

/// Feet whose distances differ by less are equally near, metres.
const EQUALLY_NEAR: f64 = 1e-10;

/// Feet nearer to each other along the path are one foot, metres: near a foot the distance hardly changes.
const SAME_FOOT: f64 = 1e-2;

/// The foot of a perpendicular on the curve.
#[derive(Debug, Clone, Copy)]
struct Foot {
    place: usize,
    u: f64,
    distance: f64,
}

impl ReferencePath {
    /// The coordinates of `p` by the nearest point of the whole path.
    ///
    /// A point whose nearest point is an end of the path is measured along the straight line that
    /// continues it. A tree of the curve's pieces spares all but the few that can be nearest.
    ///
    /// # Errors
    /// Two points of the path are equally near, or `p` is the centre of the curve there.
    pub fn project(&self, p: &Point) -> Result<Frenet, FrenetError> {
        Ok(self.project_point(p)?.0)
    }

    /// As [`Self::project`], with the point of the path beside `p`.
    ///
    /// # Errors
    /// Those of [`Self::project`].
    pub fn project_point(&self, p: &Point) -> Result<(Frenet, PathPoint), FrenetError> {
        let local = self.local(p)?;
        let mut search = Search::default();
        self.chords.visit_near(&Point::from(local), |place| {
            let span = &self.spans[place];
            if span.distance_to_chord(&local) - span.sagitta <= search.reach() {
                search.try_foot(self, place, span.nearest(&local), &local);
            }
            search.reach() + self.sagitta
        });
        let at = self.settle(&search, &local)?;
        at.ok_or(FrenetError::NotNear {
            from: self.arc[0],
            to: self.arc[self.spans.len()],
        })
    }

    /// The coordinates of `p` by the nearest point of the path within `within` metres along it of
    /// arc length `hint`: for following something that passes near other parts of the path.
    ///
    /// # Errors
    /// No part of the path within reach lies beside `p`, or those of [`Self::project`].
    pub fn project_near(&self, p: &Point, hint: f64, within: f64) -> Result<Frenet, FrenetError> {
        let local = self.local(p)?;
        let window = hint - within.abs()..hint + within.abs();
        let not_near = FrenetError::NotNear {
            from: window.start,
            to: window.end,
        };
        let mut search = Search::default();
        for place in self.spans_within(&window) {
            let span = &self.spans[place];
            if span.distance_to_chord(&local) - span.sagitta > search.reach() {
                continue;
            }
            let from = self.parameter(place, window.start, 0.0);
            let to = self.parameter(place, window.end, 1.0);
            if let Some(u) = span.foot(&local, from, to) {
                search.try_foot(self, place, u, &local);
            }
        }
        let beside = self.settle(&search, &local)?;
        let [first, last] = [false, true].map(|last| self.beyond(last, &local));
        let candidates = [
            beside.map(|(at, _)| at),
            (first.s <= self.arc[0]).then_some(first),
            (last.s >= self.arc[self.spans.len()]).then_some(last),
        ];
        let inside = |at: &Frenet| at.s >= window.start && at.s <= window.end;
        let near = candidates.into_iter().flatten().filter(inside);
        near.min_by(|a, b| a.d.abs().total_cmp(&b.d.abs()))
            .ok_or(not_near)
    }

    fn local(&self, p: &Point) -> Result<Vector, FrenetError> {
        let local = p - self.origin;
        let finite = local.x.is_finite() && local.y.is_finite();
        finite.then_some(local).ok_or(FrenetError::NotFinite)
    }

    fn spans_within(&self, window: &Range<f64>) -> Range<usize> {
        let from = self.arc.partition_point(|&a| a <= window.start);
        let to = self.arc.partition_point(|&a| a < window.end);
        from.saturating_sub(1)..to.min(self.spans.len())
    }

    /// The parameter of a span at arc length `s`; `end` where `s` is not inside it.
    fn parameter(&self, place: usize, s: f64, end: f64) -> f64 {
        let (from, to) = (self.arc[place], self.arc[place + 1]);
        if s > from && s < to {
            self.spans[place].parameter_at(s - from, to - from)
        } else {
            end
        }
    }

    /// Coordinates along the straight line beyond an end.
    fn beyond(&self, last: bool, p: &Vector) -> Frenet {
        let (place, u, s) = if last {
            (self.spans.len() - 1, 1.0, self.arc[self.spans.len()])
        } else {
            (0, 0.0, self.arc[0])
        };
        let along = self.spans[place].first(u).normalize();
        let off = p - self.spans[place].at(u);
        Frenet {
            s: s + off.dot(&along),
            d: along.perp(&off),
        }
    }

    /// The coordinates by the foot found; `None` if it is not perpendicular to the path.
    fn settle(
        &self,
        search: &Search,
        p: &Vector,
    ) -> Result<Option<(Frenet, PathPoint)>, FrenetError> {
        let Some(best) = search.best else {
            return Ok(None);
        };
        let s = self.arc_at(best);
        if let Some(other) = search.rival.map(|foot| self.arc_at(foot))
            && (other - s).abs() > SAME_FOOT
        {
            return Err(FrenetError::Ambiguous {
                s: (s.min(other), s.max(other)),
                distance: best.distance,
            });
        }
        let span = &self.spans[best.place];
        let (off, along) = (p - span.at(best.u), span.first(best.u).normalize());
        let beside = off.dot(&along);
        let first_end = best.place == 0 && best.u == 0.0 && beside < 0.0;
        let last_end = best.place + 1 == self.spans.len() && best.u == 1.0 && beside > 0.0;
        if first_end || last_end {
            let at = self.beyond(last_end, p);
            return Ok(Some((at, self.at(at.s))));
        }
        if beside.abs() > 10.0 * SQUARE {
            return Ok(None);
        }
        let at = Frenet {
            s,
            d: along.perp(&off),
        };
        // Refuses the centre of curvature, where every direction is square.
        let here = self.point(best.place, best.u);
        here.stretch(at)?;
        Ok(Some((at, here)))
    }

    fn arc_at(&self, foot: Foot) -> f64 {
        self.arc[foot.place] + self.spans[foot.place].arc_to(foot.u)
    }
}

/// The nearest foot so far, and a second one at the same distance.
#[derive(Default)]
struct Search {
    best: Option<Foot>,
    rival: Option<Foot>,
}

impl Search {
    /// Feet farther away are ignored, metres.
    fn reach(&self) -> f64 {
        self.best.map_or(f64::MAX, |b| b.distance + EQUALLY_NEAR)
    }

    fn try_foot(&mut self, path: &ReferencePath, place: usize, u: f64, p: &Vector) {
        let distance = (path.spans[place].at(u) - p).norm();
        let foot = Foot { place, u, distance };
        match self.best {
            Some(best) if distance >= best.distance => {
                let near = distance - best.distance < EQUALLY_NEAR;
                if near && !meets(path, best, foot) {
                    self.rival = Some(foot);
                }
            }
            Some(best) => {
                let near = best.distance - distance < EQUALLY_NEAR;
                if !near {
                    self.rival = None;
                } else if !meets(path, best, foot) {
                    self.rival = Some(best);
                }
                self.best = Some(foot);
            }
            None => self.best = Some(foot),
        }
    }
}

/// Whether two feet are one, on both sides of a joint.
fn meets(path: &ReferencePath, a: Foot, b: Foot) -> bool {
    (path.arc_at(a) - path.arc_at(b)).abs() <= SAME_FOOT
}
