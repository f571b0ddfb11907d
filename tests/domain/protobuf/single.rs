//! A scenario as the single message of 2020a.

use nearmiss::scenario::{
    Bound, Environment, Intersection, Lanelet, ObstacleRole, Prediction, Scenario, Sign,
    TrafficLight,
};

use super::common::{date, kind, location, obstacle, occupancies, problem, region, tag};
use super::wire::{Bytes, message, point};

pub const MARKINGS: [&str; 12] = [
    "dashed",
    "solid",
    "solid_solid",
    "dashed_dashed",
    "solid_dashed",
    "dashed_solid",
    "curb",
    "lowered_curb",
    "broad_dashed",
    "broad_solid",
    "unknown",
    "no_marking",
];
pub const TYPES: [&str; 20] = [
    "urban",
    "country",
    "highway",
    "driveWay",
    "mainCarriageWay",
    "accessRamp",
    "exitRamp",
    "shoulder",
    "busLane",
    "busStop",
    "bicycleLane",
    "sidewalk",
    "crosswalk",
    "interstate",
    "intersection",
    "border",
    "parking",
    "restricted",
    "restricted_area",
    "unknown",
];
pub const USERS: [&str; 10] = [
    "vehicle",
    "car",
    "truck",
    "bus",
    "priorityVehicle",
    "motorcycle",
    "bicycle",
    "pedestrian",
    "train",
    "taxi",
];
pub const COLORS: [&str; 5] = ["red", "redYellow", "green", "yellow", "inactive"];
pub const DIRECTIONS: [&str; 7] = [
    "right",
    "straight",
    "left",
    "leftStraight",
    "straightRight",
    "leftRight",
    "all",
];
/// Places of German signs in the enumerations of both versions.
pub const SIGNS: [(&str, i64); 8] = [
    ("103-10", 2),
    ("124", 7),
    ("205", 16),
    ("274", 57),
    ("274.1", 58),
    ("276", 61),
    ("306", 71),
    ("350", 92),
];

/// The place of a word.
pub fn place(words: &[&str], word: &str) -> i64 {
    let place = words.iter().position(|w| *w == word);
    place.unwrap_or_else(|| panic!("no {word} in {words:?}")) as i64
}

pub fn places<T: ToString>(words: &[&str], values: &[T]) -> Vec<i64> {
    values
        .iter()
        .map(|v| place(words, &v.to_string()))
        .collect()
}

pub fn sign_place(id: &str) -> i64 {
    let found = SIGNS.iter().find(|(sign, _)| *sign == id);
    found.unwrap_or_else(|| panic!("no place for sign {id}")).1
}

pub fn encode(scenario: &Scenario) -> Vec<u8> {
    let header = &scenario.header;
    let text = |name: &str| header.attributes.get(name).map_or("", String::as_str);
    let information = message()
        .text(1, &header.version)
        .text(2, &header.benchmark_id)
        .inner(3, date(header.attributes.get("date")))
        .text(4, text("author"))
        .text(5, text("affiliation"))
        .text(6, text("source"))
        .double(7, header.time_step_size);
    let tags = message().each(&scenario.tags, |out, t| out.whole(1, tag(t)));
    let surroundings = scenario
        .location
        .as_ref()
        .and_then(|l| l.environment.as_ref());
    let location = surroundings.iter().fold(location(scenario), |out, e| {
        out.inner(
            5,
            environment(
                e,
                &["night", "day", "unknown"],
                &[
                    "sunny",
                    "light_rain",
                    "heavy_rain",
                    "fog",
                    "snow",
                    "hail",
                    "unknown",
                ],
            ),
        )
    });
    let network = &scenario.network;
    let of = |role| scenario.obstacles.iter().filter(move |o| o.role == role);
    message()
        .inner(1, information)
        .inner(2, tags)
        .inner(3, location)
        .each(&network.lanelets, |out, l| out.inner(4, lanelet(l)))
        .each(&network.signs, |out, s| out.inner(5, sign(s)))
        .each(&network.lights, |out, l| out.inner(6, light(l)))
        .each(&network.intersections, |out, i| {
            out.inner(7, intersection(i))
        })
        .each(of(ObstacleRole::Static), |out, o| {
            out.inner(8, obstacle(o, region))
        })
        .each(of(ObstacleRole::Dynamic), |out, o| {
            out.inner(9, obstacle(o, region))
        })
        .each(of(ObstacleRole::Environment), |out, o| {
            let shape = region(o.footprint.as_ref().unwrap().shape());
            out.inner(
                10,
                message()
                    .whole(1, o.id)
                    .whole(2, kind(o.kind))
                    .inner(3, shape),
            )
        })
        .each(of(ObstacleRole::Phantom), |out, o| {
            out.inner(11, phantom(o.id, &o.prediction))
        })
        .each(&scenario.planning_problems, |out, p| {
            out.inner(12, problem(p, None))
        })
        .0
}

pub fn phantom(id: i64, prediction: &Prediction) -> Bytes {
    let out = message().whole(1, id);
    match prediction {
        Prediction::None => out,
        prediction => out.inner(2, occupancies(prediction)),
    }
}

pub fn environment(environment: &Environment, times: &[&str], weathers: &[&str]) -> Bytes {
    let undergrounds = ["wet", "clean", "dirty", "damaged", "snow", "ice", "unknown"];
    let out = environment.time.iter().fold(message(), |out, time| {
        let part = |at: usize| time[at..at + 2].parse().unwrap();
        out.inner(1, message().whole(4, part(0)).whole(5, part(3)))
    });
    let words = [
        (2, &environment.time_of_day, times),
        (3, &environment.weather, weathers),
        (4, &environment.underground, &undergrounds),
    ];
    out.each(words, |out, (number, word, words)| {
        word.iter()
            .fold(out, |out, word| out.whole(number, place(words, word)))
    })
}

fn bound(bound: &Bound) -> Bytes {
    let out = message().each(&bound.points, |out, p| out.inner(1, point(p.x, p.y)));
    out.whole(2, place(&MARKINGS, bound.marking.name()))
}

fn lanelet(lanelet: &Lanelet) -> Bytes {
    let out = message()
        .whole(1, lanelet.id)
        .inner(2, bound(&lanelet.left))
        .inner(3, bound(&lanelet.right))
        .wholes(4, &lanelet.predecessors)
        .wholes(5, &lanelet.successors);
    let beside = [
        (6, 8, lanelet.adjacent_left),
        (7, 9, lanelet.adjacent_right),
    ];
    let out = out.each(beside, |out, (id, direction, adjacent)| {
        adjacent.into_iter().fold(out, |out, a| {
            out.whole(id, a.id)
                .whole(direction, i64::from(!a.same_direction))
        })
    });
    let out = lanelet.stop_line.iter().fold(out, |out, line| {
        let points = line.points.iter().flat_map(|(from, to)| [from, to]);
        let inner = message()
            .each(points, |out, p| out.inner(1, point(p.x, p.y)))
            .whole(2, place(&MARKINGS, line.marking.name()));
        out.inner(10, inner.wholes(3, &line.signs).wholes(4, &line.lights))
    });
    out.wholes(11, &places(&TYPES, &lanelet.types))
        .wholes(12, &places(&USERS, &lanelet.users_one_way))
        .wholes(13, &places(&USERS, &lanelet.users_bidirectional))
        .wholes(14, &lanelet.signs)
        .wholes(15, &lanelet.lights)
}

fn sign(sign: &Sign) -> Bytes {
    let out = message().whole(1, sign.id);
    let out = out.each(&sign.elements, |out, element| {
        // Zamunda's enumeration is field 2.
        let inner = message().whole(2, sign_place(&element.id));
        out.inner(2, inner.each(&element.values, |inner, v| inner.text(15, v)))
    });
    let out = sign
        .position
        .iter()
        .fold(out, |out, p| out.inner(4, point(p.x, p.y)));
    out.whole(5, i64::from(sign.is_virtual))
}

fn light(light: &TrafficLight) -> Bytes {
    let out = message()
        .whole(1, light.id)
        .each(&light.cycle, |out, phase| {
            let color = place(&COLORS, phase.color.name());
            out.inner(2, message().whole(1, phase.duration).whole(2, color))
        });
    let out = light
        .position
        .iter()
        .fold(out, |out, p| out.inner(3, point(p.x, p.y)))
        .whole(4, light.offset);
    let out = light
        .direction
        .iter()
        .fold(out, |out, d| out.whole(5, place(&DIRECTIONS, d.name())));
    out.whole(6, i64::from(light.active))
}

fn intersection(intersection: &Intersection) -> Bytes {
    let out = message().whole(1, intersection.id);
    let out = out.each(&intersection.incomings, |out, road| {
        let inner = message()
            .whole(1, road.id)
            .wholes(2, &road.lanelets)
            .wholes(3, &road.right)
            .wholes(4, &road.straight)
            .wholes(5, &road.left);
        out.inner(
            2,
            road.is_left_of
                .iter()
                .fold(inner, |inner, id| inner.whole(6, *id)),
        )
    });
    out.wholes(3, &intersection.crossings)
}
