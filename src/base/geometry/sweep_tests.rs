//! Bodies on their ways: cases that can be worked out by hand, and random ones against many looks.

#![allow(clippy::unwrap_used)]
use super::{Footprint, Placed, Point, Pose, Shape, Sweep};
use proptest::prelude::*;

fn boxed(length: f64, width: f64) -> Footprint {
    Footprint::new(Shape::rectangle(length, width)).unwrap()
}

fn way(body: &Footprint, from: (f64, f64, f64), to: (f64, f64, f64)) -> Sweep<'_> {
    let place = |(x, y, heading)| body.at(Pose::new(x, y, heading));
    Sweep::new(place(from), place(to))
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
    assert!(apart(share) < 1e-6 && apart(share - 1e-4) > 0.0);
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
    let grows = Sweep::new(place(&small), place(&large));
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
        match (one.first_touch(&other), seen) {
            (Some(touch), _) => {
                // Never later than seen, and in truth a touch, before which there is none.
                prop_assert!(seen.is_none_or(|seen| touch <= seen + 1e-6));
                prop_assert!(apart(touch) < 1e-5, "{}", apart(touch));
                prop_assert!(looks().all(|look| look >= touch - 1e-6 || apart(look) > 0.0));
            }
            (None, Some(seen)) => {
                // A graze: they are in each other by no more than a centimetre.
                let overlap = |share: f64| one.at(share).overlap(&other.at(share));
                let deepest = looks().map(overlap).fold(0.0, f64::max);
                prop_assert!(deepest <= 0.0101, "missed the touch at {seen}: {deepest} m");
            }
            (None, None) => {}
        }
    }
}

#[test]
fn a_graze_that_neither_end_shows_is_no_touch() {
    let car = boxed(4.0, 2.0);
    let east = way(&car, (0.0, 0.0, 0.0), (20.0, 0.0, 0.0));
    let passes = |aside: f64| way(&car, (20.0, aside, 0.0), (0.0, aside, 0.0));
    assert_eq!(east.first_touch(&passes(1.995)), None, "5 mm");
    let touch = east.first_touch(&passes(1.98)).unwrap();
    assert!((touch - 0.4).abs() < 1e-6, "{touch}");
    // What overlaps at the end is touched by however little.
    let ends = way(&car, (40.0, 1.995, 0.0), (18.0, 1.995, 0.0));
    assert!(east.first_touch(&ends).is_some());
}
