//! A pedestrian crossing in town: a person steps out between parked cars, and the ego stops in good time.

use std::error::Error;

use nearmiss::geometry::Pose;
use nearmiss::scenario::LineMarking::{Curb, Dashed, NoMarking};

use super::cast::{BICYCLE, BUS, CAR, Cast, ESTATE, PEDESTRIAN, TAXI, VAN};
use super::drive::{Drive, Speed};
use super::map::{Kind, Lane, Map, edge, limit};
use super::path::Path;
use super::story::{Outcome, Story};

pub fn story() -> Result<Story, Box<dyn Error>> {
    let street = Path::from(Pose::new(-12.7, 48.3, -0.74))
        .straight(25.0)
        .bend(130.0, 0.62, 35.0)
        .straight(105.0)
        .bend(150.0, -0.5, 35.0)
        .straight(20.0);
    let end = street.length();
    // Where people cross; parked cars keep away from it.
    let zebra = 208.0;

    let mut map = Map::default();
    let (walk, town) = (Lane::Along(Kind::Sidewalk), Lane::Along(Kind::Town));
    let (opposite, parking) = (Lane::Against(Kind::Town), Lane::Along(Kind::Parking));
    let plain = [
        edge(-8.0, NoMarking),
        edge(-5.5, Curb),
        edge(0.0, Dashed),
        edge(3.4, Curb),
        edge(6.4, NoMarking),
    ];
    let narrow = [
        edge(-6.4, NoMarking),
        edge(-3.4, Curb),
        plain[2],
        plain[3],
        plain[4],
    ];
    let parked = [
        plain[0],
        plain[1],
        edge(-3.4, Dashed),
        plain[2],
        plain[3],
        plain[4],
    ];
    let lanes = [walk, town, opposite, walk];
    map.road(&street, (0.0, 140.0), 101, &narrow, &lanes);
    map.road(
        &street,
        (140.0, zebra - 12.0),
        111,
        &parked,
        &[walk, parking, town, opposite, walk],
    );
    map.road(&street, (zebra - 12.0, end), 121, &narrow, &lanes);
    map.crossing(171, &street, zebra, 6.4, 3.6);
    map.sign(
        201,
        &[("274", &limit(50.0))],
        street.point(12.0, -4.1),
        &[102, 113, 122],
    );
    map.sign(
        202,
        &[("274", &limit(50.0))],
        street.point(end - 12.0, 4.1),
        &[123, 114, 103],
    );
    map.sign(203, &[("350", "")], street.point(zebra - 2.6, -4.1), &[122]);
    map.sign(204, &[("350", "")], street.point(zebra + 2.6, 4.1), &[123]);

    let across = Path::from(Pose {
        heading: street.pose(zebra, 0.0).heading + std::f64::consts::FRAC_PI_2,
        ..street.pose(zebra, -6.3)
    })
    .straight(12.6);
    let over = across.reversed();
    let back = street.reversed();
    let along = |s, d, speed| Drive::along(&street, s, d, speed);
    let against = |s, d, speed| Drive::along(&back, end - s, d, speed);

    let mut cast = Cast::until(110);
    let steps_out = Speed::of(0.0).hold(0.8).to(1.45, 1.2);
    cast.add(
        301,
        PEDESTRIAN,
        &Drive::along(&across, 0.8, 0.5, steps_out.hold(6.4).to(0.0, 1.2)),
    )?;
    let hurries = Speed::of(0.0).hold(2.0).to(1.6, 1.2).hold(4.6).to(0.0, 1.2);
    cast.add(302, PEDESTRIAN, &Drive::along(&over, 1.4, 0.7, hurries))?;
    cast.add(303, PEDESTRIAN, &along(zebra - 48.0, -6.6, Speed::of(1.3)))?;
    cast.add(
        304,
        BUS,
        &against(zebra + 64.5, -1.7, Speed::of(10.0).hold(1.6).to(0.0, 1.35)),
    )?;
    cast.add(
        305,
        TAXI,
        &against(zebra + 90.5, -1.7, Speed::of(10.5).hold(1.9).to(0.0, 1.5)),
    )?;
    cast.add(306, BICYCLE, &against(zebra - 18.0, -2.75, Speed::of(4.6)))?;
    cast.add(
        307,
        ESTATE,
        &along(zebra - 99.0, -1.6, Speed::of(11.6).hold(1.6).to(0.0, 1.6)),
    )?;
    let stands = |s| street.pose(s, -4.5);
    cast.park(308, CAR, stands(zebra - 20.0))?;
    cast.park(309, VAN, stands(zebra - 29.5))?;
    cast.park(310, ESTATE, stands(zebra - 43.0))?;

    Ok(Story {
        name: "ZAM_Pedestrian-1_1_T-1",
        title: "Somebody steps onto a crossing behind parked cars, and the ego stops in good time",
        tags: &[
            "urban",
            "comfort",
            "oncoming_traffic",
            "simulated",
            "single_lane",
            "speed_limit",
        ],
        network: map.finish(),
        obstacles: cast.obstacles,
        ego: 1,
        drive: along(
            zebra - 63.5,
            -1.5,
            Speed::of(12.6)
                .hold(1.1)
                .to(0.0, 2.2)
                .hold(1.3)
                .to(7.0, 1.6),
        ),
        last: 110,
        goal: &[122],
        outcome: Outcome::Safe,
    })
}
