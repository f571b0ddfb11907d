//! How hard contacts are: Δv by hand and by the conservation of momentum, sides, angles, and who is hurt.

use std::f64::consts::{FRAC_PI_2, PI};

use nearmiss::geometry::{Footprint, Shape};
use nearmiss::metrics::{Contact, ContactSide, Impact, NoValue};
use nearmiss::scenario::*;

use super::definitions::{car, scene};
use ObstacleType::{Bicycle, Car, Motorcycle, Pedestrian, Truck};

/// Masses of the kinds, kg.
fn mass(kind: ObstacleType) -> f64 {
    match kind {
        Car => 1500.0,
        Truck => 15_000.0,
        Motorcycle => 275.0,
        Bicycle => 90.0,
        Pedestrian => 75.0,
        other => panic!("{other}"),
    }
}

/// What moves: its kind, first place, heading and speed.
type Mover = (ObstacleType, (f64, f64), f64, f64);

/// The first contact of the ego, which is at the origin, with another.
fn impact(ego: (ObstacleType, f64), other: Mover) -> Impact {
    contact(ego, other).unwrap()
}

fn contact((ego, v): (ObstacleType, f64), (other, at, heading, w): Mover) -> Option<Impact> {
    let of = |id, kind, at, heading, v| {
        let body = car(id, at, heading, v, 0.0);
        let round = Shape::Circle {
            radius: 0.3,
            center: nearmiss::geometry::Point::origin(),
        };
        let parts = ObstacleParts {
            id,
            role: body.role,
            kind,
            footprint: match kind {
                Pedestrian => Some(Footprint::new(round).unwrap()),
                _ => body.footprint.clone(),
            },
            initial: body.initial.clone(),
            prediction: body.prediction.clone(),
            signals: Vec::new(),
        };
        Obstacle::new(parts, 0.1)
    };
    let scene = scene(vec![
        of(1, ego, (0.0, 0.0), 0.0, v),
        of(2, other, at, heading, w),
    ]);
    let participant = scene.participants().next().unwrap();
    Some(Contact::first(&scene, &participant)?.impact)
}

#[track_caller]
fn near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-3, "{found} for {expected}");
}

#[test]
fn central_impacts_are_shared_by_mass() {
    for (ego, other) in [(Car, Car), (Car, Truck), (Truck, Car), (Car, Motorcycle)] {
        // Into one that stands, into one that is slower, and into one that comes.
        for (heading, w, v) in [(0.0, 0.0, 10.0), (0.0, 4.0, 10.0), (PI, 8.0, 12.0)] {
            let closing: f64 = if heading == 0.0 { v - w } else { v + w };
            let found = impact((ego, v), (other, (40.0, 0.0), heading, w));
            let all = mass(ego) + mass(other);
            let [own, others] = found.delta_v.unwrap();
            near(found.closing_speed, closing);
            near(own, mass(other) / all * closing);
            near(others, mass(ego) / all * closing);
            near(found.overlap, 1.0);
            near(found.angle, heading);
            let rear = if heading == 0.0 {
                ContactSide::Rear
            } else {
                ContactSide::Front
            };
            assert_eq!(found.sides, [ContactSide::Front, rear]);
        }
    }
}

#[test]
fn who_is_hit_beside_the_middle_turns_away() {
    // Bodies of 4 m × 2 m, 1 m beside each other: levers of (2, 0.5) m, and (16 + 4) / 12 m² of gyration.
    let found = impact((Car, 10.0), (Car, (40.0, 1.0), 0.0, 0.0));
    let [own, others] = found.delta_v.unwrap();
    near(found.overlap, 0.5);
    near(own, others);
    // An impulse of 1 across and along the surface: 2.3 / m, -1.2 / m and 6.8 / m. Friction holds the surfaces together.
    let determinant = 2.3 * 6.8 - 1.2 * 1.2;
    near(own, 10.0 * f64::hypot(6.8, 1.2) / determinant);
}

#[test]
fn a_scrape_is_no_crash() {
    // The ego drives 20 m/s past one that comes with 20 m/s and drifts into its side by 1 m/s.
    let drift = PI - 0.05;
    let scrape = impact((Car, 20.0), (Car, (60.0, -3.55), drift, 20.0));
    let crash = impact((Car, 20.0), (Car, (60.0, 0.0), PI, 20.0));
    assert!(scrape.closing_speed > 39.0);
    assert!(scrape.delta_v.unwrap()[0] < 2.0, "{scrape:?}");
    near(crash.delta_v.unwrap()[0], 20.0);
    assert!(crash.p_serious.unwrap() > 50.0 * scrape.p_serious.unwrap());
}

#[test]
fn momentum_is_conserved_whatever_happens() {
    let mut hit = 0;
    for other in [Car, Truck, Motorcycle, Bicycle, Pedestrian] {
        for turn in 0..12 {
            let heading = f64::from(turn) * PI / 6.0;
            for aside in [-1.4, -0.3, 0.0, 0.9] {
                let other_moves = (other, (30.0, aside), heading, 0.5);
                let Some(found) = contact((Car, 13.0), other_moves) else {
                    continue;
                };
                let [own, others] = found.delta_v.unwrap();
                near(mass(Car) * own / 100.0, mass(other) * others / 100.0);
                assert!(own + others <= found.closing_speed + 1e-9, "{found:?}");
                assert!((0.0..=1.0).contains(&found.overlap));
                hit += 1;
            }
        }
    }
    assert!(hit > 180, "{hit}");
}

#[test]
fn people_on_foot_take_the_speed_of_the_front() {
    let found = impact((Car, 10.0), (Pedestrian, (20.0, 0.0), FRAC_PI_2, 0.0));
    let [own, others] = found.delta_v.unwrap();
    near(others, 10.0 * 1500.0 / 1575.0);
    near(own, 10.0 * 75.0 / 1575.0);
    // 36 km/h: 1 / (1 + e^-(-6.190 + 0.038 · 46 + 0.078 · 36)).
    near(found.p_serious.unwrap(), 1.0 / (1.0 + f64::exp(1.634)));
    let truck = impact((Truck, 10.0), (Pedestrian, (20.0, 0.0), FRAC_PI_2, 0.0));
    assert_eq!(truck.p_serious, Err(NoValue::NoCurve));
}
