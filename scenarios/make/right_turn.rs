//! A right turn across a bicycle lane: the ego sees the cyclist beside it at the last moment.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{Curb, Dashed, NoMarking, Solid};

use super::cast::{BICYCLE, CAR, Cast, ESTATE, MOTORCYCLE, PEDESTRIAN, TRUCK, VAN};
use super::drive::{Drive, Speed};
use super::junction::{self, Arm};
use super::map::{Kind, Lane, Map, edge, limit};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    // The main street with bicycle lanes, and a side street to the right at `X`.
    const X: f64 = 162.0;
    let street = Path::from(Pose::new(318.9, -502.2, 1.92))
        .straight(14.0)
        .bend(120.0, -0.42, 32.0)
        .straight(98.0)
        .bend(140.0, 0.46, 32.0);
    let corner = street.pose(X, 0.0);
    let side = Path::from(Pose {
        heading: corner.heading - 1.62,
        ..corner
    })
    .straight(42.0)
    .bend(75.0, 0.6, 24.0)
    .straight(10.0);
    let (far, away) = (street.length(), side.length());

    let mut map = Map::default();
    let (walk, town, bicycle) = (
        Lane::Along(Kind::Sidewalk),
        Lane::Along(Kind::Town),
        Lane::Along(Kind::Bicycle),
    );
    let main = [
        edge(-7.6, NoMarking),
        edge(-5.1, Curb),
        edge(-3.3, Solid),
        edge(0.0, Dashed),
        edge(3.3, Solid),
        edge(5.1, Curb),
        edge(7.6, NoMarking),
    ];
    let (opposite, bicycle_back) = (Lane::Against(Kind::Town), Lane::Against(Kind::Bicycle));
    let lanes = [walk, bicycle, town, opposite, bicycle_back, walk];
    let (before, after) = (X - 13.0, X + 13.0);
    map.road(&street, (0.0, before), 101, &main, &lanes);
    map.road(&street, (after, far), 111, &main, &lanes);
    // Bicycle lanes and the left sidewalk go on across the mouth of the side street.
    map.road(
        &street,
        (before, after),
        121,
        &[edge(-5.1, Dashed), edge(-3.3, Dashed)],
        &[bicycle],
    );
    let through = [edge(3.3, Solid), edge(5.1, Curb), edge(7.6, NoMarking)];
    map.road(
        &street,
        (before, after),
        122,
        &through,
        &[bicycle_back, walk],
    );
    let quiet = [
        edge(-5.2, NoMarking),
        edge(-3.1, Curb),
        edge(0.0, NoMarking),
        edge(3.1, Curb),
        edge(5.2, NoMarking),
    ];
    map.road(
        &side,
        (12.5, away),
        131,
        &quiet,
        &[walk, town, opposite, walk],
    );
    let arm = |path, s, along, entering, leaving, centre: &'static [f64], width| Arm {
        path,
        s,
        along,
        entering,
        leaving,
        centres: centre,
        width,
    };
    let arms = [
        arm(&street, before, true, &[103], &[104], &[1.65], 3.3),
        arm(&side, 12.5, false, &[133], &[132], &[1.55], 3.1),
        arm(&street, after, false, &[114], &[113], &[1.65], 3.3),
    ];
    junction::lay(&mut map, 400, 141, &arms)?;
    map.crossing(171, &side, 11.0, 5.2, 3.0);
    map.sign(
        201,
        &[("274", &limit(50.0)), ("306", "")],
        street.point(30.0, -5.6),
        &[103],
    );
    map.sign(
        202,
        &[("274", &limit(50.0)), ("306", "")],
        street.point(far - 20.0, 5.6),
        &[114],
    );
    map.sign(
        203,
        &[("274.1", &limit(30.0))],
        side.point(18.0, -3.7),
        &[132],
    );
    map.sign(204, &[("205", "")], side.point(13.0, 3.7), &[133]);
    map.stop_line(&[133], Some(204), None);

    let mut cast = Cast::until(100);
    let along = |s, d, speed| Drive::along(&street, s, d, speed);
    let north = street.reversed();
    let against = |s, d, speed| Drive::along(&north, far - s, d, speed);
    let mouth = side.reversed();
    let out = |s, d, speed| Drive::along(&mouth, away - s, d, speed);
    cast.add(301, BICYCLE, &along(X - 56.0, -4.2, Speed::of(6.6)))?;
    cast.add(302, BICYCLE, &along(X - 78.0, -4.15, Speed::of(5.4)))?;
    cast.add(
        303,
        ESTATE,
        &along(X - 96.0, -1.65, Speed::of(11.0).hold(1.2).to(3.2, 1.6)),
    )?;
    cast.add(
        304,
        TRUCK,
        &along(X + 6.0, -1.65, Speed::of(9.5).to(11.0, 0.5)),
    )?;
    cast.add(305, MOTORCYCLE, &against(X + 48.0, -1.6, Speed::of(13.0)))?;
    cast.add(306, CAR, &against(X + 74.0, -1.65, Speed::of(12.0)))?;
    cast.add(307, BICYCLE, &against(X - 22.0, -4.2, Speed::of(5.0)))?;
    cast.add(308, VAN, &out(16.2, -1.55, Speed::of(0.0)))?;
    cast.add(309, PEDESTRIAN, &along(X - 40.0, -6.5, Speed::of(1.3)))?;
    cast.add(310, PEDESTRIAN, &against(X + 20.0, -6.3, Speed::of(1.5)))?;

    let lane = street.pose(X - 62.0, -1.65);
    let way = Path::between(
        lane,
        side.pose(40.0, -1.55),
        junction::RIGHT.0,
        junction::RIGHT.1,
    );
    let way = way.ok_or("no room for the ego to turn")?;
    Ok(Story {
        name: "ZAM_RightTurn-1_1_T-1",
        title: "The ego turns right across a bicycle lane and sees the cyclist at the last moment",
        tags: &[
            "urban",
            "critical",
            "intersection",
            "simulated",
            "speed_limit",
            "turn_right",
            "emergency_braking",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: Drive::along(
            &way,
            0.0,
            0.0,
            Speed::of(11.5)
                .hold(1.0)
                .to(5.0, 2.0)
                .hold(2.1)
                .to(0.0, 7.5),
        ),
        last: 100,
        goal: &[132],
        outcome: Outcome::NearMiss,
    })
}
