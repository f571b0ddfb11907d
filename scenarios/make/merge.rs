//! A merge onto a motorway: from a loop ramp the ego gathers speed and takes a fair gap between a lorry and a car.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{BroadDashed, BroadSolid, Dashed, NoMarking, Solid};

use super::cast::{BUS, CAR, Cast, ESTATE, MOTORCYCLE, SEMITRAILER, VAN};
use super::drive::{Drive, Speed};
use super::map::{Kind, Lane, Map, back, edge, limit, taper};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    // The right border of the right lane; the ramp comes in at `NOSE`, its lane is gone at `GONE`.
    const NOSE: f64 = 200.0;
    const GONE: f64 = 480.0;
    let road = Path::from(Pose::new(-842.0, 517.3, -0.28))
        .bend(900.0, 0.07, 60.0)
        .straight(330.0)
        .bend(1100.0, -0.16, 90.0);
    let end = road.length();
    let loop_back = Path::from(back(road.pose(NOSE, -1.875)))
        .straight(12.0)
        .bend(58.0, 2.3, 40.0)
        .straight(30.0);
    let ramp = loop_back.reversed();

    let mut map = Map::default();
    let lane = Lane::Along(Kind::Motorway);
    let right = |d: f64| [edge(d, Dashed), edge(d + 3.75, Solid)];
    let [middle, median] = right(3.75);
    map.road(
        &road,
        (0.0, NOSE),
        101,
        &[edge(0.0, BroadSolid), middle, median],
        &[lane, lane],
    );
    let gaining = [
        edge(-3.75, BroadSolid),
        edge(0.0, BroadDashed),
        middle,
        median,
    ];
    let three = [Lane::Along(Kind::Ramp), lane, lane];
    map.road(&road, (NOSE, GONE - 70.0), 110, &gaining, &three);
    let closing = [taper(-3.75, -0.4, BroadSolid), gaining[1], middle, median];
    map.road(&road, (GONE - 70.0, GONE), 120, &closing, &three);
    map.road(
        &road,
        (GONE, end),
        131,
        &[edge(0.0, BroadSolid), middle, median],
        &[lane, lane],
    );
    let oncoming = Lane::Against(Kind::Motorway);
    let theirs = [
        edge(11.5, Solid),
        edge(15.25, Dashed),
        edge(19.0, BroadSolid),
        edge(21.5, NoMarking),
    ];
    map.road(
        &road,
        (0.0, end),
        141,
        &theirs,
        &[oncoming, oncoming, Lane::Against(Kind::Shoulder)],
    );
    map.lane(151, &ramp, 3.75, Kind::Ramp, Solid);
    map.sign(
        201,
        &[("274", &limit(100.0))],
        road.point(NOSE - 25.0, 9.0),
        &[101, 102, 111, 112, 121, 122, 131, 132],
    );
    map.sign(
        202,
        &[("274", &limit(60.0))],
        ramp.point(30.0, -3.2),
        &[151],
    );
    map.sign(
        203,
        &[("274", &limit(120.0))],
        road.point(end - 25.0, 22.5),
        &[141, 142],
    );
    map.sign(
        204,
        &[("205", "")],
        ramp.point(ramp.length() - 8.0, -3.2),
        &[151],
    );

    let mut cast = Cast::until(115);
    let (near, far) = (1.875, 5.625);
    let on = |s, d, speed| Drive::along(&road, s, d, speed);
    cast.add(301, SEMITRAILER, &on(136.0, near, Speed::of(23.0)))?;
    cast.add(
        302,
        ESTATE,
        &on(32.0, near, Speed::of(26.5).hold(4.0).to(24.5, 0.8)),
    )?;
    cast.add(
        303,
        CAR,
        &on(20.0, far, Speed::of(30.0).hold(2.0).to(29.0, 0.5)),
    )?;
    cast.add(304, VAN, &on(112.0, far, Speed::of(28.0)))?;
    cast.add(305, MOTORCYCLE, &on(66.0, far + 0.4, Speed::of(29.0)))?;
    cast.add(306, CAR, &Drive::along(&ramp, 8.0, 0.0, Speed::of(11.0)))?;
    let other_way = road.reversed();
    let theirs = |s, d: f64, speed| Drive::along(&other_way, end - s, -d, speed);
    cast.add(307, BUS, &theirs(470.0, 17.125, Speed::of(24.0)))?;
    cast.add(308, CAR, &theirs(540.0, 13.375, Speed::of(31.0)))?;

    // The ego drives along the ramp and on along the motorway, which is straight from the nose on.
    let entry = loop_back.reversed().straight(270.0);
    let nose = ramp.length();
    let gather = Speed::of(12.4).hold(1.6).to(24.6, 2.4);
    Ok(Story {
        name: "ZAM_Merge-1_1_T-1",
        title: "The ego merges from a loop ramp into a fair gap between a lorry and a car",
        tags: &[
            "interstate",
            "comfort",
            "lane_change",
            "merging_lanes",
            "multi_lane",
            "simulated",
            "slip_road",
            "speed_limit",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: Drive::along(&entry, nose - 62.0, 0.0, gather).shift(nose + 60.0, 95.0, 3.75),
        last: 115,
        goal: &[111, 121, 131],
        outcome: Outcome::Safe,
    })
}
