//! Round trips through the Frenet frame: straight, bent, kinked and self-near roads, far from the origin.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::*;

fn path(points: impl IntoIterator<Item = (f64, f64)>) -> ReferencePath {
    ReferencePath::new(points.into_iter().map(|(x, y)| Point::new(x, y))).unwrap()
}

fn arc(radius: f64, from: f64, to: f64) -> Vec<(f64, f64)> {
    let angle = |i: i32| from + (to - from) * f64::from(i) / 100.0;
    (0..=100)
        .map(|i| (radius * angle(i).cos(), radius * angle(i).sin()))
        .collect()
}

/// The largest curvature of the path, 1/m.
fn bend(path: &ReferencePath) -> f64 {
    let steps = (path.length() / 0.05) as i32;
    (-20..=steps + 20)
        .map(|i| path.at(f64::from(i) * 0.05).curvature.abs())
        .fold(0.0, f64::max)
}

/// The error of plane → Frenet → plane, metres.
fn round_trip(path: &ReferencePath, p: &Point) -> f64 {
    (path.to_plane(path.project(p).unwrap()).unwrap() - p).norm()
}

#[test]
fn a_straight_road_is_exact() {
    let road = path([(0.0, 0.0), (3.0, 4.0), (30.0, 40.0)]);
    assert!((road.length() - 50.0).abs() < 1e-9 && road.deviation() < 1e-9);
    let at = road.project(&Point::new(-4.0 + 6.0, 3.0 + 8.0)).unwrap();
    assert!(
        (at.s - 10.0).abs() < 1e-9 && (at.d - 5.0).abs() < 1e-9,
        "{at:?}"
    );
    for s in [-30.0, -2.5, 0.0, 50.0, 90.0] {
        let p = road.to_plane(Frenet { s, d: -2.0 }).unwrap();
        let back = road.project(&p).unwrap();
        assert!(
            (back.s - s).abs() < 1e-9 && (back.d + 2.0).abs() < 1e-9,
            "{back:?}"
        );
    }
}

#[test]
fn a_circle_has_its_curvature() {
    let road = path(arc(20.0, 0.0, PI));
    assert!((road.length() - 20.0 * PI).abs() < 0.2 && road.deviation() < 0.1);
    let middle = road.at(road.length() / 2.0);
    assert!((middle.curvature - 0.05).abs() < 1e-3 && middle.curvature_rate.abs() < 2e-3);
    assert!((middle.heading.abs() - PI).abs() < 1e-2);
    // Every direction is square at the centre.
    let error = road.project(&Point::origin());
    assert!(error.is_err() || error.unwrap().d > 19.8, "{error:?}");
    let beyond = road.to_plane(Frenet { s: 30.0, d: 25.0 }).unwrap_err();
    assert!(
        matches!(beyond, FrenetError::BeyondCurvature { radius, .. } if (radius - 20.0).abs() < 0.5)
    );
}

/// The largest steps of heading, curvature and its rate between points `step` metres apart, beside what
/// the next derivative says; and of the distance beside the arc length.
fn jumps(road: &ReferencePath, step: f64) -> [f64; 4] {
    let mut most = [0.0_f64; 4];
    let mut before = road.at(-10.0);
    for i in 1..((road.length() + 20.0) / step) as i64 {
        let here = road.at(-10.0 + i as f64 * step);
        let mean = |of: fn(&PathPoint) -> f64| f64::midpoint(of(&before), of(&here)) * step;
        let found = [
            angle_between(before.heading, here.heading) - mean(|p| p.curvature),
            here.curvature - before.curvature - mean(|p| p.curvature_rate),
            here.curvature_rate - before.curvature_rate,
            (here.position - before.position).norm() - step,
        ];
        most = std::array::from_fn(|k| most[k].max(found[k].abs()));
        before = here;
    }
    most
}

#[test]
fn heading_curvature_and_its_rate_are_continuous() {
    let road = path([
        (0., 0.),
        (12., 0.),
        (20., 3.),
        (24., 11.),
        (24., 30.),
        (31., 38.),
    ]);
    let (coarse, fine) = (jumps(&road, 1e-2), jumps(&road, 1e-3));
    // By the trapezoidal rule the first two shrink with the cube of the step, the rate with the step.
    for (k, shrink) in [(0, 2e-3), (1, 2e-3), (2, 0.15), (3, 2e-3)] {
        assert!(
            fine[k] < shrink * coarse[k] + 1e-11,
            "{k}: {coarse:?} {fine:?}"
        );
    }
}

#[test]
fn corners_have_no_dead_wedge() {
    let road = path([(0., 0.), (30., 0.), (30., 30.)]);
    for i in 0..400 {
        let angle = TAU * f64::from(i) / 400.0;
        for reach in [0.05, 0.3, 1.0, 3.0] {
            let p = Point::new(30.0 + reach * angle.cos(), reach * angle.sin());
            // On the bisector inside the corner two points are equally near, and that is said.
            match road.project(&p) {
                Ok(at) => assert!((road.to_plane(at).unwrap() - p).norm() < 1e-9),
                Err(FrenetError::Ambiguous { s, .. }) => {
                    assert!(s.1 - s.0 > 1e-6 && (p.x - 30.0 + p.y).abs() < 1e-6);
                }
                Err(FrenetError::BeyondCurvature { .. }) => {}
                Err(error) => panic!("{error}"),
            }
        }
    }
}

#[test]
fn hairpins_loops_and_crossings_take_the_nearest_branch_or_the_hinted_one() {
    let mut hairpin: Vec<_> = (0..=40).map(|i| (f64::from(i), 0.0)).collect();
    hairpin.extend(
        arc(4.0, -FRAC_PI_2, FRAC_PI_2)
            .iter()
            .map(|(x, y)| (40.0 + x, 4.0 + y)),
    );
    hairpin.extend((0..=40).map(|i| (40.0 - f64::from(i), 8.0)));
    let hairpin = path(hairpin);
    let lower = hairpin.project(&Point::new(10.0, 3.5)).unwrap();
    let upper = hairpin.project(&Point::new(10.0, 4.5)).unwrap();
    assert!(
        (lower.s - 10.0).abs() < 0.1 && (lower.d - 3.5).abs() < 0.1,
        "{lower:?}"
    );
    assert!(upper.s > 60.0 && (upper.d - 3.5).abs() < 0.1, "{upper:?}");
    let kept = hairpin
        .project_near(&Point::new(10.0, 4.5), 9.0, 5.0)
        .unwrap();
    assert!(
        (kept.s - 10.0).abs() < 0.1 && (kept.d - 4.5).abs() < 0.1,
        "{kept:?}"
    );
    let far = hairpin.project_near(&Point::new(30.0, 1.0), 9.0, 5.0);
    assert!(matches!(far, Err(FrenetError::NotNear { .. })), "{far:?}");

    // A loop that crosses itself: the hint says which of the two passes is meant.
    let knot = path((0..=200).map(|i| {
        let t = -1.9 + 3.8 * f64::from(i) / 200.0;
        (20.0 * (t * t * t - 2.0 * t), 20.0 * t * t)
    }));
    let crossing = Point::new(0.0, 40.0);
    let first = knot.project(&Point::new(0.4, 40.0)).unwrap();
    let (early, late) = (knot.length() * 0.15, knot.length() * 0.85);
    let a = knot.project_near(&crossing, early, 30.0).unwrap();
    let b = knot.project_near(&crossing, late, 30.0).unwrap();
    assert!(
        b.s - a.s > 50.0 && a.d.abs() < 0.2 && b.d.abs() < 0.2,
        "{a:?} {b:?}"
    );
    assert!(round_trip(&knot, &Point::new(0.4, 40.0)) < 1e-9 && first.d.abs() < 0.5);
}

#[test]
fn equally_near_points_are_a_reason() {
    let road = path([(0., 0.), (50., 0.), (50., 8.), (0., 8.)]);
    let error = road.project(&Point::new(10.0, 4.0)).unwrap_err();
    assert!(
        matches!(error, FrenetError::Ambiguous { s: (a, b), distance } if b - a > 80.0 && (distance - 4.0).abs() < 1e-9),
        "{error}"
    );
    assert_eq!(
        road.project(&Point::new(f64::NAN, 4.0)),
        Err(FrenetError::NotFinite)
    );
    assert!(
        road.project_near(&Point::new(1.0, 1.0), f64::NAN, 5.0)
            .is_err()
    );
}

#[test]
fn lines_that_are_no_path_give_reasons() {
    let none = |points: &[(f64, f64)]| {
        ReferencePath::new(points.iter().map(|&(x, y)| Point::new(x, y))).unwrap_err()
    };
    assert_eq!(none(&[]), ReferencePathError::NoLength);
    assert_eq!(none(&[(1., 1.), (1., 1.)]), ReferencePathError::NoLength);
    assert!(
        matches!(none(&[(0., 0.), (20., 0.), (1., 0.)]), ReferencePathError::TurnsBack { s } if (s - 20.0).abs() < 2.0)
    );
    assert!(matches!(
        none(&[(0., 0.), (1e12, 0.)]),
        ReferencePathError::TooLong { .. }
    ));
    assert!(matches!(
        none(&[(0., 0.), (1e300, 1e300)]),
        ReferencePathError::TooLong { .. }
    ));
    // Millimetres back and forth, as maps have them at joints, are not a turn.
    let jitter = path([
        (0., 0.),
        (7.1, 0.1),
        (14.18, 0.17),
        (14.177, 0.17),
        (14.46, 0.16),
        (30., 0.2),
    ]);
    assert!(
        jitter.deviation() < 0.1 && bend(&jitter) < 0.2,
        "{}",
        bend(&jitter)
    );
}

#[test]
fn short_and_long_lines() {
    let short = path([(0.0, 0.0), (0.01, 0.0)]);
    assert!(round_trip(&short, &Point::new(7.0, 2.0)) < 1e-9);
    let long = path((0..=3000).map(|i| (f64::from(i), 30.0 * (f64::from(i) / 80.0).sin())));
    assert!(round_trip(&long, &Point::new(1511.3, 3.0)) < 1e-9 && long.deviation() < 0.1);
}

/// A road of pieces that turn by no more than `kink`, anywhere on Earth and in any direction.
fn road(kink: f64) -> impl Strategy<Value = (Vec<Point>, Pose)> {
    let pieces = prop::collection::vec((1.0..15.0, -kink..kink), 3..20);
    (pieces, -1e5..1e5, -1e5..1e5, -PI..PI).prop_map(|(pieces, x, y, turn)| {
        let mut at = Pose::new(0.0, 0.0, 0.0);
        let mut points = vec![at.position];
        for (length, bend) in pieces {
            at.heading += bend;
            at.position += at.forward() * length;
            points.push(at.position);
        }
        (points, Pose::new(x, y, turn))
    })
}

/// Checks points beside the road, and at its polyline's points; says how many had coordinates.
fn check(points: &[Point], frame: &Pose, width: f64, kinked: bool) -> Result<(), TestCaseError> {
    let moved: Vec<Point> = points.iter().map(|p| frame.to_world(p)).collect();
    let Ok(road) = ReferencePath::new(moved.iter().copied()) else {
        return Err(TestCaseError::reject("turns back"));
    };
    let here = ReferencePath::new(points.iter().copied()).unwrap();
    for p in &moved {
        prop_assert!(road.project(p).is_err() || round_trip(&road, p) < 1e-6);
    }
    for i in 0..80 {
        let s = -5.0 + (road.length() + 10.0) * f64::from(i) / 79.0;
        let at = road.at(s);
        let radius = at.curvature.abs().recip();
        for d in [-width, -0.3 * width, 0.0, 0.5 * width, width] {
            if d.abs() > 0.9 * radius {
                continue;
            }
            let p = road.to_plane(Frenet { s, d }).unwrap();
            match road.project(&p) {
                Ok(found) => {
                    prop_assert!((road.to_plane(found).unwrap() - p).norm() < 1e-6);
                    // Another part of the road may be nearer, but none is farther than asked for.
                    let on_the_line = s < 0.0 || s > road.length();
                    prop_assert!(on_the_line || found.d.abs() <= d.abs() + 1e-6);
                }
                Err(error) => {
                    let apart = matches!(
                        error,
                        FrenetError::Ambiguous { .. } | FrenetError::BeyondCurvature { .. }
                    );
                    prop_assert!(apart, "{error}");
                }
            }
            // In a kink another branch may be as near within a hand's breadth.
            let near = road.project_near(&p, s, 0.2);
            if !kinked || near.is_ok_and(|near| (near.s - s).abs() < 1e-3) {
                let near = near.unwrap();
                prop_assert!((near.s - s).abs() < 1e-6, "{near:?} {s} {d}");
                prop_assert!((near.d - d).abs() < 1e-6, "{near:?} {s} {d}");
            }
            let within = road.project_near(&p, s, 0.2).map(|near| near.d.abs());
            let fine = match within {
                Ok(found) => found <= d.abs() + 1e-6,
                Err(error) => matches!(error, FrenetError::Ambiguous { .. }),
            };
            prop_assert!(fine, "{within:?} {s} {d}");
            // The same road somewhere else has the same coordinates.
            let same = here.to_plane(Frenet { s, d }).unwrap();
            prop_assert!((frame.to_world(&same) - p).norm() < 1e-6);
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn smooth_roads_go_round((points, frame) in road(0.2)) {
        check(&points, &frame, 1.75, false)?;
    }

    #[test]
    fn kinked_roads_go_round((points, frame) in road(1.4)) {
        check(&points, &frame, 1.75, true)?;
    }

    #[test]
    fn motions_go_round(
        (points, frame) in road(0.5),
        share in 0.0..1.0,
        (d, v, a) in (-1.0..1.0_f64, prop::array::uniform2(-30.0..30.0), prop::array::uniform2(-9.0..9.0)),
    ) {
        let road = ReferencePath::new(points.iter().map(|p| frame.to_world(p))).unwrap();
        let s = share * road.length();
        prop_assume!((d * road.at(s).curvature).abs() < 0.9);
        let motion = PlaneMotion {
            position: road.to_plane(Frenet { s, d }).unwrap(),
            velocity: Vector::from(v),
            acceleration: Vector::from(a),
        };
        let there = road.motion_at(Frenet { s, d }, &motion).unwrap();
        let back = road.motion_to_plane(&there).unwrap();
        prop_assert!((back.position - motion.position).norm() < 1e-6);
        prop_assert!((back.velocity - motion.velocity).norm() < 1e-9);
        prop_assert!((back.acceleration - motion.acceleration).norm() < 1e-6);
        // The rates are those of the projection itself.
        let step = 1e-5;
        let later = motion.position + motion.velocity * step + motion.acceleration * (step * step / 2.0);
        let moved = road.project_near(&later, s, 1.0).unwrap();
        prop_assert!(((moved.s - s) / step - there.s[1] - there.s[2] * step / 2.0).abs() < 2e-2);
        prop_assert!(((moved.d - d) / step - there.d[1] - there.d[2] * step / 2.0).abs() < 2e-2);
        // Heading and curvature by the lateral profile are those of the motion.
        let speed = motion.velocity.norm();
        prop_assume!(speed > 1.0 && there.s[1].abs() > 1.0);
        let d_s = there.d[1] / there.s[1];
        let d_ss = (there.d[2] - d_s * there.s[2]) / (there.s[1] * there.s[1]);
        let profile = LateralProfile { d, d_s, d_ss };
        let (heading, curvature) = road.heading_and_curvature(s, &profile).unwrap();
        let forward = motion.velocity * there.s[1].signum();
        prop_assert!(angle_between(heading, forward.y.atan2(forward.x)).abs() < 1e-9);
        let bend = forward.perp(&motion.acceleration) / speed.powi(3);
        prop_assert!((curvature - bend).abs() < 1e-6 * (1.0 + bend.abs()), "{curvature} {bend}");
        let again = road.profile_at(Frenet { s, d }, heading, curvature).unwrap();
        prop_assert!((again.d_s - d_s).abs() < 1e-9 * (1.0 + d_s.abs()));
        prop_assert!((again.d_ss - d_ss).abs() < 1e-6 * (1.0 + d_ss.abs()), "{again:?} {profile:?}");
    }
}
