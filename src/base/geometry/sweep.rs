//! Bodies on their way from one place to the next: when two first touch.
//!
//! The position goes evenly along a straight line, the heading evenly the shorter way round. Nothing is sampled: two
//! convex parts are separated by a line, which both can only reach after some share of the way, so everything up to
//! there is skipped (conservative advancement: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996).

use parry2d_f64::math;
use parry2d_f64::query::{self, ClosestPoints};
use parry2d_f64::shape::Shape;

use super::{Footprint, Placed, Point, Pose, Vector, angle_between};

/// A body on its way from one place to another. Shares of the way are from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub struct Sweep<'a> {
    from: Placed<'a>,
    to: Placed<'a>,
}

/// A larger turn on one way is a flip of the heading, no turn, radians.
const LARGEST_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// A touch that lasts for less of the way is not looked for.
const SHORTEST: f64 = 1e-5;

/// A first touch is found to this share of the way.
const EXACT: f64 = 1e-9;

/// What is touched only on the way counts where bodies get deeper into each other than this, metres. A body that
/// brakes or turns with 8 m/s² is as far off the straight line within 0.1 s.
const MAX_GRAZE: f64 = 0.01;

impl Pose {
    /// The pose a share of the way on to another: the position along a straight line, the heading the shorter way round.
    #[must_use]
    pub fn towards(&self, to: &Self, share: f64) -> Self {
        Self {
            position: self.position + (to.position - self.position) * share,
            heading: self.heading + angle_between(self.heading, to.heading) * share,
        }
    }
}

impl<'a> Sweep<'a> {
    /// The way from one place to another. A body that is not the same at both (a trailer bends) changes halfway.
    #[must_use]
    pub fn new(from: Placed<'a>, to: Placed<'a>) -> Self {
        Self { from, to }
    }

    /// The body a share of the way on.
    #[must_use]
    pub fn at(&self, share: f64) -> Placed<'a> {
        let near = if share < 0.5 { &self.from } else { &self.to };
        let pose = self.from.pose.towards(&self.to.pose, share);
        near.footprint.at(if self.flips() {
            Pose {
                heading: near.pose.heading,
                ..pose
            }
        } else {
            pose
        })
    }

    /// The share of the way after which the two first touch; 0 if they do from the beginning. A graze of less than 1 cm
    /// that neither end shows is none: it is less than straight lines tell.
    #[must_use]
    pub fn first_touch(&self, other: &Self) -> Option<f64> {
        if !self.can_touch(other) {
            return None;
        }
        let stretches = Pair::all(self, other);
        let touch = stretches.iter().find_map(|stretch| {
            let touches = stretch.parts().filter_map(|(a, b)| stretch.touch(a, b));
            touches.min_by(f64::total_cmp)
        })?;
        let told = |share| self.at(share).distance(&other.at(share)) <= 0.0;
        let deep = || stretches.iter().any(|stretch| stretch.gets_deep(touch));
        (touch <= 0.0 || told(1.0) || deep()).then_some(touch)
    }

    fn moved(&self) -> Vector {
        self.to.pose.position - self.from.pose.position
    }

    /// By how much the body turns on the way, radians.
    #[must_use]
    pub fn turn(&self) -> f64 {
        if self.flips() { 0.0 } else { self.turned() }
    }

    fn turned(&self) -> f64 {
        angle_between(self.from.pose.heading, self.to.pose.heading)
    }

    /// Whether the heading is another one from halfway on, without a turn.
    fn flips(&self) -> bool {
        self.turned().abs() > LARGEST_TURN
    }

    /// Whether it goes on halfway with another body or heading.
    fn changes(&self) -> bool {
        self.flips() || !std::ptr::eq(self.from.footprint, self.to.footprint)
    }

    fn reach(&self) -> f64 {
        self.from.footprint.reach().max(self.to.footprint.reach())
    }

    /// Discs around both that never meet spare everything else.
    fn can_touch(&self, other: &Self) -> bool {
        let between = other.from.pose.position - self.from.pose.position;
        let moved = other.moved() - self.moved();
        let length = moved.norm_squared();
        let share = if length > 0.0 {
            (-between.dot(&moved) / length).clamp(0.0, 1.0)
        } else {
            0.0
        };
        (between + moved * share).norm() <= self.reach() + other.reach()
    }
}

/// Two bodies on a stretch of their ways, on which neither changes.
struct Pair<'a> {
    from: f64,
    to: f64,
    bodies: [&'a Footprint; 2],
    /// At the beginning of the whole way, from the first body's place there.
    start: [Pose; 2],
    /// On the whole way.
    moved: [Vector; 2],
    turned: [f64; 2],
}

/// A convex part of a body and its place in it.
type Part<'a> = (math::Pose, &'a dyn Shape);

/// What separates two convex parts somewhere on the way.
#[derive(Clone, Copy)]
struct Gap {
    share: f64,
    /// Their distance along a direction from the first to the second, metres.
    metres: f64,
    /// Bounds of its change on the whole way, metres.
    slope: (f64, f64),
}

impl<'a> Pair<'a> {
    fn all(a: &Sweep<'a>, b: &Sweep<'a>) -> Vec<Self> {
        let halves: &[(f64, f64)] = if a.changes() || b.changes() {
            &[(0.0, 0.5), (0.5, 1.0)]
        } else {
            &[(0.0, 1.0)]
        };
        let origin = a.from.pose.position.coords;
        let stretch = |&(from, to): &(f64, f64)| {
            let start = [a, b].map(|way| {
                let heading = if way.flips() {
                    way.at(from).pose.heading
                } else {
                    way.from.pose.heading
                };
                let position = way.from.pose.position - origin;
                Pose { position, heading }
            });
            Self {
                from,
                to,
                bodies: [a, b].map(|way| way.at(from).footprint),
                start,
                moved: [a, b].map(Sweep::moved),
                turned: [a, b].map(Sweep::turn),
            }
        };
        halves.iter().map(stretch).collect()
    }

    /// Each part of one body with each of the other.
    fn parts(&self) -> impl Iterator<Item = (Part<'a>, Part<'a>)> + use<'a> {
        let [a, b] = self.bodies.map(Footprint::parts);
        { a.into_iter() }.flat_map(move |one| b.clone().into_iter().map(move |other| (one, other)))
    }

    fn pose(&self, which: usize, share: f64) -> math::Pose {
        let start = &self.start[which];
        super::pose(&Pose {
            position: start.position + self.moved[which] * share,
            heading: start.heading + self.turned[which] * share,
        })
    }

    /// What separates two parts there; `None` where they touch.
    fn gap(&self, a: Part<'_>, b: Part<'_>, share: f64) -> Option<Gap> {
        let (here, there) = (self.pose(0, share) * a.0, self.pose(1, share) * b.0);
        let found = query::closest_points(&here, a.1, &there, b.1, f64::MAX);
        let Ok(ClosestPoints::WithinMargin(p, q)) = found else {
            return None;
        };
        let (near, far) = (Point::new(p.x, p.y), Point::new(q.x, q.y));
        let turning: f64 = { self.turned.iter().zip(self.bodies) }
            .map(|(turned, body)| turned.abs() * body.reach())
            .sum();
        let moved = self.moved[1] - self.moved[0];
        let along = (far - near).try_normalize(f64::MIN_POSITIVE);
        let separated = along.zip(a.1.as_support_map()).zip(b.1.as_support_map());
        let Some(((along, a), b)) = separated else {
            let most = moved.norm() + turning;
            return Some(Gap {
                share,
                metres: 0.0,
                slope: (-most, most),
            });
        };
        let n = super::vector(&along);
        let metres = (b.support_point(&there, -n) - a.support_point(&here, n)).dot(n);
        let slope = moved.dot(&along);
        Some(Gap {
            share,
            metres,
            slope: (slope - turning, slope + turning),
        })
    }

    /// The share of the way after which two parts first touch. That they do at the very end is not looked for.
    fn touch(&self, a: Part<'_>, b: Part<'_>) -> Option<f64> {
        let Some(mut gap) = self.gap(a, b, self.from) else {
            return Some(self.from);
        };
        let touching = loop {
            let free = gap.free();
            if gap.share + free >= self.to {
                return None;
            }
            let share = (gap.share + free.max(SHORTEST)).min(self.to);
            match self.gap(a, b, share) {
                Some(_) if share >= self.to => return None,
                Some(next) => gap = next,
                None => break share,
            }
        };
        let (mut apart, mut touching) = (gap.share, touching);
        while touching - apart > EXACT {
            let middle = f64::midpoint(apart, touching);
            match self.gap(a, b, middle) {
                Some(_) => apart = middle,
                None => touching = middle,
            }
        }
        Some(touching)
    }

    /// Whether any two parts get deeper into each other than a graze, from a share of the way on.
    fn gets_deep(&self, from: f64) -> bool {
        let turning: f64 = { self.turned.iter().zip(self.bodies) }
            .map(|(turned, body)| turned.abs() * body.reach())
            .sum();
        let fastest = (self.moved[1] - self.moved[0]).norm() + turning;
        self.parts().any(|(a, b)| {
            let mut share = from.max(self.from);
            while share <= self.to {
                let left = MAX_GRAZE - self.depth(a, b, share);
                if left <= 0.0 {
                    return true;
                }
                // No point gets there sooner.
                share += (left / fastest).max(SHORTEST);
            }
            false
        })
    }

    /// How deep two parts are in each other there, metres; their distance is negative.
    fn depth(&self, a: Part<'_>, b: Part<'_>, share: f64) -> f64 {
        let (here, there) = (self.pose(0, share) * a.0, self.pose(1, share) * b.0);
        // Of what is far apart it finds nothing, and of what is deep in each other only without a margin.
        match query::contact(&here, a.1, &there, b.1, 0.0) {
            Ok(Some(contact)) => -contact.dist,
            _ => query::distance(&here, a.1, &there, b.1).map_or(0.0, |apart| -apart.distance),
        }
    }
}

impl Gap {
    /// For this share of the way from here on, the two are apart.
    fn free(&self) -> f64 {
        if self.slope.0 < 0.0 {
            self.metres / -self.slope.0
        } else {
            f64::INFINITY
        }
    }
}
