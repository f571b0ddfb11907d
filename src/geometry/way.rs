//! Bodies on their way from one place to the next: when two first touch, and how near they come.
//!
//! The position goes evenly along a straight line, the heading evenly the shorter way round. Nothing is sampled: two
//! convex parts are separated by a line, which both can only reach after some share of the way, so everything up to
//! there is skipped (conservative advancement: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996).

use parry2d_f64::math;
use parry2d_f64::query::{self, ClosestPoints};
use parry2d_f64::shape::Shape;

use super::{Footprint, Placed, Point, Pose, Vector, angle_between, convert};

/// A body on its way from one place to another. Shares of the way are from 0 to 1.
#[derive(Debug, Clone, Copy)]
pub struct Way<'a> {
    from: Placed<'a>,
    to: Placed<'a>,
}

/// A larger turn on one way is a flip of the heading, no turn, radians.
const LARGEST_TURN: f64 = std::f64::consts::FRAC_PI_2;

/// A touch that lasts for less of the way is not looked for.
const SHORTEST: f64 = 1e-5;

/// A first touch is found to this share of the way.
const EXACT: f64 = 1e-9;

/// The smallest distance is found to this, metres.
const NEAREST: f64 = 1e-4;

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

impl<'a> Way<'a> {
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
        near.footprint.at(match self.flips() {
            true => Pose {
                heading: near.pose.heading,
                ..pose
            },
            false => pose,
        })
    }

    /// The share of the way after which the two first touch; 0 if they do from the beginning.
    #[must_use]
    pub fn first_touch(&self, other: &Self) -> Option<f64> {
        if !self.can_come_within(other, 0.0) {
            return None;
        }
        let mut stretches = Pair::of(self, other).into_iter();
        stretches.find_map(|stretch| {
            let touches = stretch.parts().filter_map(|(a, b)| stretch.touch(a, b));
            touches.min_by(f64::total_cmp)
        })
    }

    /// The share of the way at which the two are nearest, and their distance there, metres; `None` where they nowhere
    /// come nearer than `within`.
    #[must_use]
    pub fn nearest(&self, other: &Self, within: f64) -> Option<(f64, f64)> {
        if !self.can_come_within(other, within) {
            return None;
        }
        let mut best = (f64::NAN, within);
        for stretch in Pair::of(self, other) {
            for (a, b) in stretch.parts() {
                stretch.nearest(a, b, &mut best);
            }
        }
        (!best.0.is_nan()).then_some(best)
    }

    fn moved(&self) -> Vector {
        self.to.pose.position - self.from.pose.position
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

    /// Discs around both that never come so near spare everything else.
    fn can_come_within(&self, other: &Self, metres: f64) -> bool {
        let between = other.from.pose.position - self.from.pose.position;
        let moved = other.moved() - self.moved();
        let length = moved.norm_squared();
        let share = match length > 0.0 {
            true => (-between.dot(&moved) / length).clamp(0.0, 1.0),
            false => 0.0,
        };
        (between + moved * share).norm() <= self.reach() + other.reach() + metres
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
    fn of(a: &Way<'a>, b: &Way<'a>) -> Vec<Self> {
        let halves: &[(f64, f64)] = match a.changes() || b.changes() {
            true => &[(0.0, 0.5), (0.5, 1.0)],
            false => &[(0.0, 1.0)],
        };
        let origin = a.from.pose.position.coords;
        let stretch = |&(from, to): &(f64, f64)| {
            let start = [a, b].map(|way| {
                let heading = match way.flips() {
                    true => way.at(from).pose.heading,
                    false => way.from.pose.heading,
                };
                let position = way.from.pose.position - origin;
                Pose { position, heading }
            });
            Self {
                from,
                to,
                bodies: [a, b].map(|way| way.at(from).footprint),
                start,
                moved: [a, b].map(Way::moved),
                turned: [a, b].map(|way| if way.flips() { 0.0 } else { way.turned() }),
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
        convert::pose(&Pose {
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
        let n = convert::vector(&along);
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

    /// Makes `best`, a share and a distance, that of two parts where they come nearer.
    fn nearest(&self, a: Part<'_>, b: Part<'_>, best: &mut (f64, f64)) {
        let look = |share: f64, best: &mut (f64, f64)| {
            let gap = self.gap(a, b, share);
            let metres = gap.map_or(0.0, |gap| gap.metres.max(0.0));
            if metres < best.1 {
                *best = (share, metres);
            }
            gap
        };
        let ends = look(self.from, best).zip(look(self.to, best));
        let mut open: Vec<(Gap, Gap)> = ends.into_iter().collect();
        while let Some((left, right)) = open.pop() {
            // Lines from both ends that the distance is above; where they cross it is least.
            let (down, up) = (left.slope.0.min(0.0), right.slope.1.max(0.0));
            let length = right.share - left.share;
            let cross = (left.metres - right.metres + up * length) / (up - down);
            let cross = if up > down {
                cross.clamp(0.0, length)
            } else {
                0.0
            };
            if length < SHORTEST || left.metres + down * cross >= best.1 - NEAREST {
                continue;
            }
            let share = left.share + cross.clamp(length * 0.01, length * 0.99);
            if let Some(middle) = look(share, best) {
                open.extend([(middle, right), (left, middle)]);
            }
        }
    }
}

impl Gap {
    /// For this share of the way from here on, the two are apart.
    fn free(&self) -> f64 {
        match self.slope.0 < 0.0 {
            true => self.metres / -self.slope.0,
            false => f64::INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::Shape;
    use super::*;
    use proptest::prelude::*;

    fn boxed(length: f64, width: f64) -> Footprint {
        Footprint::new(Shape::rectangle(length, width)).unwrap()
    }

    fn way(body: &Footprint, from: (f64, f64, f64), to: (f64, f64, f64)) -> Way<'_> {
        let place = |(x, y, heading)| body.at(Pose::new(x, y, heading));
        Way::new(place(from), place(to))
    }

    #[test]
    fn bodies_that_pass_through_each_other_touch_on_the_way() {
        let car = boxed(4.0, 2.0);
        let east = way(&car, (0.0, 0.0, 0.0), (20.0, 0.0, 0.0));
        let west = way(&car, (20.0, 0.0, 0.0), (0.0, 0.0, 0.0));
        // 16 m between bumpers that close by 40 m.
        let touch = east.first_touch(&west).unwrap();
        assert!((touch - 0.4).abs() < 1e-6, "{touch}");
        // Beside each other they come no nearer than 1.5 m, where their fronts pass.
        let beside = way(&car, (20.0, 3.5, 0.0), (0.0, 3.5, 0.0));
        assert_eq!(east.first_touch(&beside), None);
        let (share, metres) = east.nearest(&beside, 9.0).unwrap();
        assert!((metres - 1.5).abs() < 1e-3 && (0.39..0.61).contains(&share));
        assert_eq!(east.nearest(&beside, 1.4), None);
        assert_eq!(east.first_touch(&east), Some(0.0));
    }

    #[test]
    fn a_tail_that_swings_out_touches() {
        let (bus, post) = (boxed(12.0, 2.5), boxed(0.2, 0.2));
        let turns = way(&bus, (0.0, 0.0, 0.0), (0.0, 0.0, 0.6));
        // Its side is 1.25 m away at x = 4; the post stands 1.4 m further out.
        let stands = (-4.0, -2.75, 0.0);
        let post = way(&post, stands, stands);
        let share = turns.first_touch(&post).unwrap();
        let apart = |share: f64| turns.at(share).distance(&post.at(share));
        assert!(apart(share) == 0.0 && apart(share - 1e-6) > 0.0);
        // A heading that flips does not turn.
        let flips = way(&bus, (0.0, 0.0, 0.0), (0.0, 0.0, std::f64::consts::PI));
        assert_eq!(flips.first_touch(&post), None);
    }

    #[test]
    fn a_body_that_changes_does_so_halfway() {
        let (small, large, other) = (boxed(2.0, 2.0), boxed(6.0, 2.0), boxed(2.0, 2.0));
        let place = |body| Placed {
            footprint: body,
            pose: Pose::new(0.0, 0.0, 0.0),
        };
        let grows = Way::new(place(&small), place(&large));
        let beside = way(&other, (3.5, 0.0, 0.0), (3.5, 0.0, 0.0));
        assert_eq!(grows.first_touch(&beside), Some(0.5));
    }

    fn shapes() -> impl Strategy<Value = Shape> {
        let rectangle = (0.5..12.0, 0.5..3.0).prop_map(|(l, w)| Shape::rectangle(l, w));
        let circle = (0.2..2.0, -1.0..1.0).prop_map(|(radius, x): (f64, f64)| Shape::Circle {
            radius,
            center: Point::new(x, 0.0),
        });
        let notched = (1.0..4.0_f64).prop_map(|a| Shape::Polygon {
            vertices: [(0., 0.), (a, 0.), (a, a), (a / 2., a / 4.), (0., a)]
                .map(|(x, y)| Point::new(x, y))
                .to_vec(),
        });
        prop_oneof![3 => rectangle, 1 => circle, 1 => notched]
    }

    fn ways() -> impl Strategy<Value = [(f64, f64, f64); 2]> {
        let place = (-12.0..12.0, -12.0..12.0, -3.2..3.2);
        (place, -25.0..25.0, -25.0..25.0, -1.5..1.5)
            .prop_map(|((x, y, h), dx, dy, turn)| [(x, y, h), (x + dx, y + dy, h + turn)])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn random_ways_agree_with_many_looks(
            a in shapes(), b in shapes(), one in ways(), other in ways(), far in 0.0..5e6_f64,
        ) {
            const LOOKS: u32 = 2000;
            let (a, b) = (Footprint::new(a).unwrap(), Footprint::new(b).unwrap());
            let moved = |[from, to]: [(f64, f64, f64); 2]| {
                [(from.0 + far, from.1, from.2), (to.0 + far, to.1, to.2)]
            };
            let [from, to] = moved(one);
            let one = way(&a, from, to);
            let [from, to] = moved(other);
            let other = way(&b, from, to);
            let apart = |share: f64| one.at(share).distance(&other.at(share));
            let looks = || (0..=LOOKS).map(|k| f64::from(k) / f64::from(LOOKS));
            let seen = looks().find(|share| apart(*share) == 0.0);
            let least = looks().map(apart).fold(f64::MAX, f64::min);
            match (one.first_touch(&other), seen) {
                (Some(touch), _) => {
                    // Never later than seen, and in truth a touch, before which there is none.
                    prop_assert!(seen.is_none_or(|seen| touch <= seen + 1e-6));
                    prop_assert!(apart(touch) < 1e-5, "{}", apart(touch));
                    prop_assert!(looks().all(|look| look >= touch - 1e-6 || apart(look) > 0.0));
                }
                (None, Some(seen)) => prop_assert!(seen == 1.0, "missed the touch at {seen}"),
                (None, None) => {}
            }
            match one.nearest(&other, 50.0) {
                Some((share, metres)) => {
                    prop_assert!(metres <= least + 2e-4, "{metres} is more than {least}");
                    prop_assert!((apart(share) - metres).abs() < 1e-6);
                }
                None => prop_assert!(least >= 50.0),
            }
        }
    }
}
