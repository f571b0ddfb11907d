//! A cut-in on a motorway: a car stuck behind a lorry pulls out right in front of the ego.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{BroadSolid, Dashed, NoMarking, Solid};

use super::cast::{CAR, Cast, ESTATE, MOTORCYCLE, SEMITRAILER, VAN};
use super::drive::{Drive, Speed};
use super::map::{Kind, Lane, Map, edge, limit};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    // The right border of the right lane.
    let road = Path::from(Pose::new(1204.5, 388.1, 2.31))
        .straight(60.0)
        .bend(850.0, 0.42, 110.0)
        .straight(90.0);
    let end = road.length();

    let mut map = Map::default();
    let shoulder = Kind::Shoulder;
    let ours = [
        edge(-2.5, NoMarking),
        edge(0.0, BroadSolid),
        edge(3.75, Dashed),
        edge(7.5, Dashed),
        edge(11.25, Solid),
    ];
    let lane = Lane::Along(Kind::Motorway);
    map.road(
        &road,
        (0.0, end),
        100,
        &ours,
        &[Lane::Along(shoulder), lane, lane, lane],
    );
    let theirs = [
        edge(15.25, Solid),
        edge(19.0, Dashed),
        edge(22.75, Dashed),
        edge(26.5, BroadSolid),
        edge(29.0, NoMarking),
    ];
    let lane = Lane::Against(Kind::Motorway);
    map.road(
        &road,
        (0.0, end),
        111,
        &theirs,
        &[lane, lane, lane, Lane::Against(shoulder)],
    );
    map.sign(
        201,
        &[("274", &limit(130.0))],
        road.point(30.0, -4.0),
        &[101, 102, 103],
    );
    map.sign(
        202,
        &[("274", &limit(130.0))],
        road.point(end - 30.0, 30.5),
        &[111, 112, 113],
    );

    let mut cast = Cast::until(90);
    let (right, middle, left) = (1.875, 5.625, 9.375);
    let cut_in = Speed::of(26.0).hold(2.4).to(28.5, 1.4);
    cast.add(
        301,
        CAR,
        &Drive::along(&road, 122.0, right, cut_in).shift(200.0, 72.0, middle),
    )?;
    cast.add(
        302,
        SEMITRAILER,
        &Drive::along(&road, 194.0, right, Speed::of(22.8)),
    )?;
    cast.add(
        303,
        SEMITRAILER,
        &Drive::along(&road, 24.0, right, Speed::of(22.5)),
    )?;
    cast.add(
        304,
        ESTATE,
        &Drive::along(&road, 76.0, left, Speed::of(35.0).hold(3.6).to(33.0, 1.0)),
    )?;
    cast.add(305, CAR, &Drive::along(&road, 26.0, left, Speed::of(35.5)))?;
    cast.add(
        306,
        VAN,
        &Drive::along(&road, 196.0, middle, Speed::of(30.5)),
    )?;
    cast.add(
        307,
        ESTATE,
        &Drive::along(&road, 40.0, middle, Speed::of(33.5).hold(4.6).to(26.5, 4.5)),
    )?;
    cast.add(
        308,
        MOTORCYCLE,
        &Drive::along(&road, 160.0, left, Speed::of(36.0)),
    )?;
    let oncoming = road.reversed();
    cast.add(
        309,
        CAR,
        &Drive::along(&oncoming, end - 420.0, -20.875, Speed::of(34.0)),
    )?;
    cast.add(
        310,
        SEMITRAILER,
        &Drive::along(&oncoming, end - 330.0, -24.625, Speed::of(22.5)),
    )?;

    Ok(Story {
        name: "ZAM_CutIn-1_1_T-1",
        title: "A car behind a lorry pulls out right in front of the ego on a motorway",
        tags: &[
            "interstate",
            "critical",
            "cut_in",
            "multi_lane",
            "parallel_lanes",
            "simulated",
            "speed_limit",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: Drive::along(
            &road,
            82.0,
            middle,
            Speed::of(34.0)
                .hold(4.2)
                .to(26.0, 7.2)
                .hold(0.6)
                .to(28.0, 1.2),
        ),
        last: 90,
        goal: &[102],
        outcome: Outcome::NearMiss,
    })
}
