//! An intersection in town: a car hidden behind a waiting lorry runs the red light from the right.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{Curb, Dashed, NoMarking, Solid};
use nearmiss::scenario::SignalColor::{Green, Red, RedYellow, Yellow};

use super::cast::{BICYCLE, BUS, CAR, Cast, ESTATE, MOTORCYCLE, PEDESTRIAN, TAXI, TRUCK};
use super::drive::{Drive, Speed};
use super::junction::{self, Arm};
use super::map::{Kind, Lane, Map, edge, limit};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    // The ego's street, with one lane each way; it meets the other one at `X`.
    const X: f64 = 152.0;
    let street = Path::from(Pose::new(-73.4, -158.9, 0.52))
        .bend(165.0, 0.45, 38.0)
        .straight(74.0)
        .bend(190.0, -0.4, 40.0);
    // The avenue, with two lanes each way, crosses it from right to left at `Y`.
    const Y: f64 = 112.0;
    let middle = street.pose(X, 0.0);
    let across = Pose {
        heading: middle.heading + 1.51,
        ..middle
    };
    let from = Pose {
        position: across.position - across.forward() * Y,
        ..across
    };
    let avenue = Path::from(from)
        .straight(Y + 28.0)
        .bend(110.0, 0.5, 30.0)
        .straight(15.0);
    let (far, away) = (street.length(), avenue.length());

    let mut map = Map::default();
    let (walk, town) = (Lane::Along(Kind::Sidewalk), Lane::Along(Kind::Town));
    let opposite = Lane::Against(Kind::Town);
    let narrow = [
        edge(-6.0, NoMarking),
        edge(-3.5, Curb),
        edge(0.0, Dashed),
        edge(3.5, Curb),
        edge(6.0, NoMarking),
    ];
    let two = [walk, town, opposite, walk];
    map.road(&street, (0.0, X - 14.0), 101, &narrow, &two);
    map.road(&street, (X + 14.0, far), 111, &narrow, &two);
    let wide = [
        edge(-9.0, NoMarking),
        edge(-6.5, Curb),
        edge(-3.25, Dashed),
        edge(0.0, Solid),
        edge(3.25, Dashed),
        edge(6.5, Curb),
        edge(9.0, NoMarking),
    ];
    let four = [walk, town, town, opposite, opposite, walk];
    map.road(&avenue, (0.0, Y - 11.5), 121, &wide, &four);
    map.road(&avenue, (Y + 11.5, away), 131, &wide, &four);
    let arm = |path, s, along, entering, leaving, wide: bool| Arm {
        path,
        s,
        along,
        entering,
        leaving,
        centres: if wide { &[4.875, 1.625] } else { &[1.75] },
        width: if wide { 3.25 } else { 3.5 },
    };
    let arms = [
        arm(&street, X - 14.0, true, &[102], &[103], false),
        arm(&avenue, Y - 11.5, true, &[122, 123], &[125, 124], true),
        arm(&street, X + 14.0, false, &[113], &[112], false),
        arm(&avenue, Y + 11.5, false, &[135, 134], &[132, 133], true),
    ];
    junction::lay(&mut map, 400, 141, &arms)?;
    for (id, path, s, half) in [
        (171, &street, X - 12.4, 6.0),
        (172, &avenue, Y - 9.9, 9.0),
        (173, &street, X + 12.4, 6.0),
        (174, &avenue, Y + 9.9, 9.0),
    ] {
        map.crossing(id, path, s, half, 3.2);
    }
    let phases = [(10, RedYellow), (150, Green), (30, Yellow), (170, Red)];
    map.light(211, &phases, 320, street.point(X - 14.0, -4.2), &[102]);
    map.light(213, &phases, 320, street.point(X + 14.0, 4.2), &[113]);
    let phases = [(10, RedYellow), (120, Green), (30, Yellow), (200, Red)];
    map.light(212, &phases, 160, avenue.point(Y - 11.5, -7.2), &[122, 123]);
    map.light(214, &phases, 160, avenue.point(Y + 11.5, 7.2), &[134, 135]);
    map.sign(
        201,
        &[("274", &limit(50.0))],
        street.point(20.0, -4.2),
        &[102],
    );
    map.sign(
        202,
        &[("274", &limit(60.0))],
        avenue.point(15.0, -7.2),
        &[122, 123],
    );

    let mut cast = Cast::until(90);
    let along = |s, d, speed| Drive::along(&avenue, s, d, speed);
    let standing = Speed::of(0.0);
    cast.add(
        301,
        CAR,
        &along(
            14.0,
            -4.875,
            Speed::of(15.6)
                .hold(1.0)
                .to(16.4, 0.8)
                .hold(4.1)
                .to(4.0, 7.0),
        ),
    )?;
    cast.add(302, TRUCK, &along(Y - 17.4, -1.625, standing.clone()))?;
    cast.add(
        303,
        TAXI,
        &along(Y - 67.0, -1.6, Speed::of(9.0).hold(1.2).to(0.0, 1.6)),
    )?;
    let south = street.reversed();
    let against = |s, d, speed| Drive::along(&south, far - s, d, speed);
    cast.add(304, BUS, &against(X - 24.0, -1.75, Speed::of(10.5)))?;
    cast.add(
        305,
        ESTATE,
        &against(X + 56.0, -1.75, Speed::of(11.0).hold(1.2).to(0.0, 1.9)),
    )?;
    cast.add(306, BICYCLE, &against(X - 2.0, -2.75, Speed::of(5.2)))?;
    let east = avenue.reversed();
    let eastbound = |s, d, speed| Drive::along(&east, away - s, d, speed);
    cast.add(307, ESTATE, &eastbound(Y + 15.0, -1.625, standing.clone()))?;
    cast.add(
        308,
        MOTORCYCLE,
        &eastbound(Y + 40.0, -4.7, Speed::of(9.5).hold(0.4).to(0.0, 2.2)),
    )?;
    cast.add(
        309,
        CAR,
        &Drive::along(
            &street,
            X - 112.0,
            -1.75,
            Speed::of(13.2).hold(6.2).to(0.0, 5.5),
        ),
    )?;
    cast.add(
        310,
        PEDESTRIAN,
        &Drive::along(&street, X - 40.0, -4.7, Speed::of(1.4)),
    )?;
    cast.add(311, PEDESTRIAN, &against(X + 15.0, -5.0, standing))?;

    Ok(Story {
        name: "ZAM_RedLight-1_1_T-1",
        title: "A car hidden behind a waiting lorry runs the red light from the right",
        tags: &[
            "urban",
            "critical",
            "intersection",
            "oncoming_traffic",
            "simulated",
            "speed_limit",
            "emergency_braking",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: Drive::along(
            &street,
            X - 78.0,
            -1.75,
            Speed::of(13.7).hold(5.4).to(0.0, 7.4),
        ),
        last: 90,
        goal: &[112],
        outcome: Outcome::Collision(301),
    })
}
