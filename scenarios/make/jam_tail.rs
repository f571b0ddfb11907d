//! The tail of a jam behind a bend: the ego reads the brake lights early and stops with room to spare.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{BroadSolid, Dashed, NoMarking, Solid};

use super::cast::{BUS, CAR, Cast, ESTATE, MOTORCYCLE, SEMITRAILER, TAXI, TRUCK, VAN};
use super::drive::{Drive, Speed};
use super::map::{Kind, Lane, Map, edge, limit};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    // The right border of the right lane.
    let road = Path::from(Pose::new(96.4, -940.8, 1.12))
        .straight(50.0)
        .bend(430.0, -0.78, 100.0)
        .straight(80.0);
    let end = road.length();

    let mut map = Map::default();
    let edges = [
        edge(-3.0, NoMarking),
        edge(0.0, BroadSolid),
        edge(3.6, Dashed),
        edge(7.2, Solid),
    ];
    let lane = Lane::Along(Kind::Motorway);
    let lanes = [Lane::Along(Kind::Shoulder), lane, lane];
    map.road(&road, (0.0, 150.0), 100, &edges, &lanes);
    map.road(&road, (150.0, end), 110, &edges, &lanes);
    map.sign(
        201,
        &[("274", &limit(100.0))],
        road.point(20.0, -4.2),
        &[101, 102],
    );
    map.sign(
        202,
        &[("124", ""), ("274", &limit(80.0))],
        road.point(150.0, -4.2),
        &[111, 112],
    );

    let mut cast = Cast::until(115);
    let (right, left) = (1.8, 5.4);
    let on = |s, d, speed| Drive::along(&road, s, d, speed);
    let crawl = |velocity: f64, later: f64| {
        Speed::of(velocity)
            .hold(later)
            .to(0.4, 0.9)
            .hold(3.0)
            .to(2.0, 0.5)
    };
    cast.add(301, SEMITRAILER, &on(356.0, right, crawl(4.0, 1.0)))?;
    cast.add(302, TRUCK, &on(376.0, right, crawl(4.0, 0.6)))?;
    cast.add(303, CAR, &on(392.0, right, crawl(4.0, 0.2)))?;
    cast.add(304, VAN, &on(349.0, left, crawl(5.0, 0.8)))?;
    cast.add(305, TAXI, &on(363.0, left, crawl(5.0, 0.4)))?;
    cast.add(306, BUS, &on(381.0, left, crawl(5.0, 0.1)))?;
    cast.add(
        307,
        ESTATE,
        &on(260.0, right, Speed::of(22.0).hold(0.4).to(1.5, 3.0)),
    )?;
    cast.add(
        308,
        CAR,
        &on(86.0, right, Speed::of(25.0).hold(1.8).to(2.0, 2.6)),
    )?;
    cast.add(
        309,
        MOTORCYCLE,
        &on(108.0, left, Speed::of(26.0).hold(1.5).to(2.0, 2.6)),
    )?;
    cast.park(310, VAN, road.pose(318.0, -1.7))?;

    Ok(Story {
        name: "ZAM_JamTail-1_1_T-1",
        title: "A jam ends behind a bend of the motorway; the ego brakes early and stops with room to spare",
        tags: &[
            "interstate",
            "comfort",
            "lane_following",
            "multi_lane",
            "no_oncoming_traffic",
            "simulated",
            "speed_limit",
            "traffic_jam",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: on(156.0, left, Speed::of(27.0).hold(1.2).to(0.0, 2.4)),
        last: 115,
        goal: &[112],
        outcome: Outcome::Safe,
    })
}
