//! Tests of traffic boxes against exact distances.

use proptest::prelude::*;

use crate::planner::traffic::EgoBox;
use crate::planner::{Body, Traffic};
use nearmiss_base::geometry::{Footprint, Point, Pose, Shape};

fn own(pose: &Pose, length: f64, width: f64) -> EgoBox {
    let (sin, cos) = pose.heading.sin_cos();
    EgoBox {
        x: pose.position.x,
        y: pose.position.y,
        cos,
        sin,
        half_length: length / 2.0,
        half_width: width / 2.0,
    }
}

fn with(footprint: &Footprint, pose: &Pose) -> Traffic {
    let mut traffic = Traffic::new(2);
    let body = traffic.add(Body {
        id: 7,
        likelihood: 1.0,
        avoided: true,
    });
    traffic.occupy(body, 1, footprint, pose, 3.0);
    traffic
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn separation_has_the_sign_of_the_distance_and_is_never_more(
        at in (-9.0..9.0_f64, -9.0..9.0_f64, -4.0..4.0_f64),
        heading in -4.0..4.0_f64,
        ours in (0.5..8.0_f64, 0.5..3.0_f64),
        theirs in (0.5..12.0_f64, 0.5..3.0_f64),
    ) {
        let body = |(l, w)| Footprint::new(Shape::rectangle(l, w)).unwrap();
        let (mine, other) = (body(ours), body(theirs));
        let (here, there) = (Pose::new(3.0, -2.0, heading), Pose::new(at.0, at.1, at.2));
        let distance = mine.at(here).distance(&other.at(there));
        let traffic = with(&other, &there);
        let separation = traffic.at(1)[0].separation(&own(&here, ours.0, ours.1));
        prop_assert!(separation <= distance + 1e-9, "{separation} {distance}");
        // Exactly at contact rounding decides.
        if separation.abs() > 1e-9 {
            prop_assert_eq!(separation < 0.0, distance == 0.0, "{} {}", separation, distance);
        }
    }
}

#[test]
fn bodies_are_where_they_were_put() {
    let car = Footprint::new(Shape::rectangle(4.0, 2.0)).unwrap();
    let traffic = with(&car, &Pose::new(1.0, 2.0, 0.5));
    assert_eq!(traffic.horizon(), 2);
    assert_eq!(traffic.at(0).len() + traffic.at(2).len(), 0);
    assert_eq!(traffic.at(99), traffic.at(2));
    let there = traffic.at(1)[0];
    assert_eq!(
        (there.half_length, there.half_width, there.velocity),
        (2.0, 1.0, 3.0)
    );
    assert_eq!(traffic.bodies[there.body].id, 7);
    let mut late = with(&car, &Pose::new(0.0, 0.0, 0.0));
    late.occupy(0, 3, &car, &Pose::new(0.0, 0.0, 0.0), 0.0);
    assert_eq!(late.horizon(), 2);
}

#[test]
fn a_body_that_is_no_rectangle_is_covered() {
    let corners = [(0.0, 0.0), (6.0, 1.0), (2.0, 3.0)].map(|(x, y)| Point::new(x, y));
    let triangle = Footprint::new(Shape::Polygon {
        vertices: corners.to_vec(),
    })
    .unwrap();
    let pose = Pose::new(10.0, -4.0, 1.2);
    let traffic = with(&triangle, &pose);
    for corner in triangle.corners() {
        let at = pose.to_world(corner);
        let dot = own(
            &Pose {
                position: at,
                heading: 0.0,
            },
            1e-6,
            1e-6,
        );
        assert!(traffic.at(1)[0].separation(&dot) < 1e-6);
    }
}
