//! Overtaking on a two-way road: the ego is still beside the lorry when oncoming traffic arrives.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{Dashed, NoMarking, Solid};

use super::cast::{CAR, Cast, ESTATE, MOTORCYCLE, SEMITRAILER, TRUCK, VAN};
use super::drive::{Drive, Speed};
use super::map::{Kind, Lane, Map, edge, limit};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    let road = Path::from(Pose::new(655.2, 1310.7, -1.94))
        .straight(40.0)
        .bend(480.0, -0.3, 70.0)
        .straight(60.0)
        .bend(620.0, 0.34, 80.0)
        .straight(70.0);
    let end = road.length();

    let mut map = Map::default();
    let lanes = [Lane::Along(Kind::Country), Lane::Against(Kind::Country)];
    let edges = [edge(-3.6, Solid), edge(0.0, Dashed), edge(3.6, Solid)];
    map.road(&road, (0.0, 300.0), 101, &edges, &lanes);
    let bay = [edges[0], edges[1], edge(3.6, Dashed), edge(6.8, NoMarking)];
    map.road(
        &road,
        (300.0, 345.0),
        111,
        &bay,
        &[lanes[0], lanes[1], Lane::Against(Kind::Parking)],
    );
    map.road(&road, (345.0, end), 121, &edges, &lanes);
    map.sign(
        201,
        &[("274", &limit(100.0))],
        road.point(15.0, -5.2),
        &[101, 111, 121],
    );
    map.sign(
        202,
        &[("274", &limit(100.0))],
        road.point(end - 15.0, 5.2),
        &[102, 112, 122],
    );

    let mut cast = Cast::until(95);
    let right = |s, speed| Drive::along(&road, s, -1.85, speed);
    cast.add(
        301,
        TRUCK,
        &right(106.0, Speed::of(17.5).hold(4.6).to(15.5, 1.5)),
    )?;
    cast.add(
        302,
        CAR,
        &right(196.0, Speed::of(20.0).hold(2.0).to(22.0, 0.6)),
    )?;
    cast.add(
        303,
        MOTORCYCLE,
        &right(44.0, Speed::of(22.0).hold(1.0).to(17.5, 1.6)),
    )?;
    cast.add(
        304,
        ESTATE,
        &right(12.0, Speed::of(21.0).hold(1.4).to(17.0, 1.5)),
    )?;
    let oncoming = road.reversed();
    let left = |s, speed| Drive::along(&oncoming, end - s, -1.85, speed);
    let evading =
        left(384.0, Speed::of(25.0).hold(4.2).to(17.0, 5.5)).shift(end - 296.0, 40.0, -2.45);
    cast.add(305, CAR, &evading)?;
    cast.add(
        306,
        SEMITRAILER,
        &left(452.0, Speed::of(21.0).hold(4.9).to(16.0, 3.0)),
    )?;
    cast.add(
        307,
        ESTATE,
        &left(490.0, Speed::of(21.0).hold(5.2).to(16.0, 3.0)),
    )?;
    cast.park(308, VAN, road.pose(318.0, 5.2))?;

    let passing = Speed::of(23.5).hold(0.2).to(29.5, 2.4);
    Ok(Story {
        name: "ZAM_Overtaking-1_1_T-1",
        title: "The ego overtakes a lorry on a country road and meets oncoming traffic",
        tags: &[
            "critical",
            "evasive",
            "lane_change",
            "oncoming_traffic",
            "rural",
            "simulated",
            "speed_limit",
            "two_lane",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: right(76.0, passing)
            .shift(82.0, 52.0, 1.7)
            .shift(199.0, 60.0, -1.85),
        last: 95,
        goal: &[111, 121],
        outcome: Outcome::NearMiss,
    })
}
