//! Hard braking ahead on a curved country road: a queue brakes for a lorry that turns off, and the ego follows too close.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{Dashed, NoMarking, Solid};

use super::cast::{CAR, Cast, ESTATE, MOTORCYCLE, SEMITRAILER, TRUCK, VAN};
use super::drive::{Drive, Speed};
use super::map::{Kind, Lane, Map, edge, limit};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    let road = Path::from(Pose::new(-418.6, 236.2, 0.38))
        .straight(70.0)
        .bend(270.0, 0.74, 60.0)
        .straight(15.0)
        .bend(215.0, -0.66, 55.0)
        .straight(55.0);
    let end = road.length();

    let mut map = Map::default();
    let lanes = [Lane::Along(Kind::Country), Lane::Against(Kind::Country)];
    let edges = [edge(-3.5, Solid), edge(0.0, Dashed), edge(3.5, Solid)];
    let no_passing = [edge(-3.5, Solid), edge(0.0, Solid), edge(3.5, Solid)];
    map.road(&road, (0.0, 110.0), 101, &edges, &lanes);
    map.road(&road, (110.0, 300.0), 111, &no_passing, &lanes);
    // A lay-by on the outside of the bend.
    let lay_by = [
        edge(-6.7, NoMarking),
        edge(-3.5, Dashed),
        edge(0.0, Solid),
        edge(3.5, Solid),
    ];
    let three = [Lane::Along(Kind::Parking), lanes[0], lanes[1]];
    map.road(&road, (300.0, 350.0), 120, &lay_by, &three);
    map.road(&road, (350.0, end), 131, &no_passing, &lanes);
    map.sign(
        201,
        &[("274", &limit(80.0)), ("276", "")],
        road.point(108.0, -5.2),
        &[111, 121, 131],
    );
    map.sign(202, &[("103-10", "")], road.point(60.0, -5.2), &[101]);
    map.sign(
        203,
        &[("274", &limit(80.0))],
        road.point(end - 20.0, 5.2),
        &[132, 122, 112],
    );

    let mut cast = Cast::until(100);
    let right = |s, speed| Drive::along(&road, s, -1.75, speed);
    let cruise = Speed::of(22.4).hold(3.9);
    cast.add(301, ESTATE, &right(112.0, cruise.clone().to(0.0, 7.6)))?;
    cast.add(
        302,
        VAN,
        &right(
            146.0,
            Speed::of(22.0)
                .hold(2.9)
                .to(3.2, 5.2)
                .hold(0.8)
                .to(6.0, 1.2),
        ),
    )?;
    cast.add(
        303,
        TRUCK,
        &right(
            184.0,
            Speed::of(20.0)
                .hold(2.0)
                .to(4.5, 3.4)
                .hold(1.0)
                .to(8.0, 0.9),
        ),
    )?;
    cast.add(
        304,
        CAR,
        &right(60.0, Speed::of(22.0).hold(5.0).to(0.0, 6.8)),
    )?;
    cast.add(
        305,
        MOTORCYCLE,
        &right(26.0, Speed::of(21.5).hold(4.8).to(2.0, 4.0)).shift(0.0, 60.0, -2.3),
    )?;
    let oncoming = road.reversed();
    let left = |s, speed| Drive::along(&oncoming, end - s, -1.8, speed);
    cast.add(306, CAR, &left(300.0, Speed::of(21.0)))?;
    cast.add(307, SEMITRAILER, &left(375.0, Speed::of(19.0)))?;
    cast.add(308, ESTATE, &left(430.0, Speed::of(19.5)))?;
    cast.park(309, VAN, road.pose(322.0, -5.1))?;

    Ok(Story {
        name: "ZAM_HardBraking-1_1_T-1",
        title: "Hard braking ahead on a curved country road; the ego follows too close",
        tags: &[
            "critical",
            "lane_following",
            "oncoming_traffic",
            "rural",
            "simulated",
            "speed_limit",
            "two_lane",
            "emergency_braking",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: right(94.0, Speed::of(22.8).hold(5.1).to(0.0, 6.6)),
        last: 100,
        goal: &[121, 131],
        outcome: Outcome::Collision(301),
    })
}
