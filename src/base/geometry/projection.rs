//! Projection onto a reference path: the nearest point of all of it, or of the part near a hint.

use std::ops::Range;

use super::frenet::{Frenet, FrenetError};
use super::spline::SQUARE;
use super::{PathPoint, Point, ReferencePath, Vector};

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
