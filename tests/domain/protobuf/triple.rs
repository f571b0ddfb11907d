//! A scenario as the three files of 2024.

use std::path::{Path, PathBuf};

use nearmiss::scenario::{Bound, Lanelet, ObstacleRole, Scenario};

use super::common::{body, date, location, obstacle, problem, region, tag};
use super::single::{
    COLORS, DIRECTIONS, MARKINGS, TYPES, USERS, environment, phantom, place, places, sign_place,
};
use super::wire::{Bytes, message, point};

/// The bytes of the files.
pub struct Triple {
    pub map: Vec<u8>,
    pub dynamic: Vec<u8>,
    pub scenario: Vec<u8>,
}

/// What the files are called, without the ending.
pub struct Names {
    pub map: String,
    pub dynamic: String,
    pub scenario: String,
}

/// The usual names: those of the ids.
pub fn names(scenario: &Scenario) -> Names {
    let id = &scenario.header.benchmark_id;
    let mut parts = id.split('_');
    Names {
        map: format!("{}_{}", parts.next().unwrap(), parts.next().unwrap()),
        dynamic: id.clone(),
        scenario: format!("{id}-SC"),
    }
}

/// Writes the files into a folder and gives back the path of the scenario file.
pub fn write(folder: &Path, triple: &Triple, names: &Names) -> PathBuf {
    let path = |name: &str| folder.join(format!("{name}.pb"));
    std::fs::write(path(&names.map), &triple.map).unwrap();
    std::fs::write(path(&names.dynamic), &triple.dynamic).unwrap();
    std::fs::write(path(&names.scenario), &triple.scenario).unwrap();
    path(&names.scenario)
}

pub fn encode(scenario: &Scenario) -> Triple {
    let names = names(scenario);
    let tags = message().each(&scenario.tags, |out, t| out.whole(1, tag(t)));
    let tasks = message()
        .inner(1, meta(scenario))
        .text(3, &names.map)
        .text(4, &names.dynamic)
        .each(&scenario.planning_problems, |out, p| {
            out.inner(5, problem(p, Some(tags.clone())))
        });
    Triple {
        map: map(scenario).0,
        dynamic: dynamic(scenario).0,
        scenario: tasks.0,
    }
}

/// Country, name and number of the map, from a benchmark id without what comes before the country.
fn map_id(scenario: &Scenario) -> Bytes {
    let name = names(scenario).map;
    let (country, rest) = name.split_once('_').unwrap();
    let (name, number) = rest.split_once('-').unwrap();
    message()
        .text(1, country)
        .text(2, name)
        .whole(3, number.parse().unwrap())
}

fn file(scenario: &Scenario) -> Bytes {
    let attributes = &scenario.header.attributes;
    let text = |name: &str| attributes.get(name).map_or("", String::as_str);
    message()
        .text(1, "")
        .inner(3, date(attributes.get("date")))
        .text(4, text("author"))
        .text(5, text("affiliation"))
        .text(6, text("source"))
}

/// For ids of the form `ZAM_Name-1_2_T-3`.
fn meta(scenario: &Scenario) -> Bytes {
    let parts: Vec<&str> = scenario.header.benchmark_id.split('_').collect();
    let (behavior, prediction) = parts[3].split_once('-').unwrap();
    let id = message()
        .whole(1, 0)
        .inner(2, map_id(scenario))
        .whole(3, parts[2].parse().unwrap())
        .text(4, behavior)
        .whole(5, prediction.parse().unwrap())
        .text(6, &scenario.header.version);
    let step = scenario.header.time_step_size;
    message()
        .inner(1, id)
        .inner(2, file(scenario))
        .double(3, step)
}

fn map(scenario: &Scenario) -> Bytes {
    let network = &scenario.network;
    let out = message()
        .inner(
            1,
            message()
                .inner(1, map_id(scenario))
                .inner(2, file(scenario)),
        )
        .inner(2, location(scenario));
    let numbered = || network.lanelets.iter().zip(0..);
    let out = out.each(numbered(), |out, (l, i)| out.inner(3, lanelet(l, i)));
    let lines = numbered().filter_map(|(l, i)| Some((l.stop_line.as_ref()?, i)));
    let out = out.each(lines, |out, (line, i)| {
        let (from, to) = line.points.unwrap();
        let inner = message().whole(1, i).inner(2, point(from.x, from.y));
        let inner = inner.inner(3, point(to.x, to.y));
        out.inner(4, inner.whole(4, place(&MARKINGS, line.marking.name())))
    });
    let out = out.each(numbered(), |out, (l, i)| {
        out.inner(5, boundary(&l.left, 2 * i, false))
            .inner(5, boundary(&l.right, 2 * i + 1, true))
    });
    let out = out.each(&network.signs, |out, sign| {
        let at = sign.position.unwrap();
        let inner = message().whole(1, sign.id).inner(3, point(at.x, at.y));
        out.inner(7, inner.whole(4, i64::from(sign.is_virtual)))
    });
    let out = out.each(&network.lights, |out, light| {
        let at = light.position.unwrap();
        let inner = message().whole(1, light.id).inner(2, point(at.x, at.y));
        let direction = light.direction.iter();
        out.inner(
            8,
            direction.fold(inner, |out, d| out.whole(4, place(&DIRECTIONS, d.name()))),
        )
    });
    let out = out.each(&network.intersections, |out, intersection| {
        let inner = message().whole(1, intersection.id);
        let inner = inner.each(&intersection.incomings, |out, road| {
            let group = message()
                .whole(1, road.id)
                .wholes(2, &road.lanelets)
                .wholes(4, &road.right)
                .wholes(5, &road.straight);
            out.inner(2, group.wholes(6, &road.left))
        });
        let crossings = intersection.crossings.iter().zip(7_000_000..);
        out.inner(
            9,
            inner.each(crossings, |out, (lanelet, id)| {
                out.inner(4, message().whole(1, id).wholes(2, &[*lanelet]))
            }),
        )
    });
    let kinds = [
        "unknown",
        "building",
        "roadBoundary",
        "pillar",
        "median_strip",
    ];
    let fixtures = scenario
        .obstacles
        .iter()
        .filter(|o| o.role == ObstacleRole::Environment);
    out.each(fixtures, |out, o| {
        let shape = region(o.footprint.as_ref().unwrap().shape());
        let inner = message()
            .whole(1, o.id)
            .whole(2, place(&kinds, o.kind.name()));
        out.inner(10, inner.inner(3, shape))
    })
}

fn boundary(bound: &Bound, id: i64, reverse: bool) -> Bytes {
    let mut points: Vec<_> = bound.points.iter().enumerate().collect();
    if reverse {
        points.reverse();
    }
    let out = message().whole(1, id).each(points, |out, (i, p)| {
        let inner = point(p.x, p.y);
        out.inner(
            2,
            bound
                .heights
                .get(i)
                .into_iter()
                .fold(inner, |out, z| out.double(3, *z)),
        )
    });
    out.whole(3, place(&MARKINGS, bound.marking.name()))
}

/// Its right border is kept against the driving direction, as if it were that of a road the other way.
fn lanelet(lanelet: &Lanelet, i: i64) -> Bytes {
    let out = message()
        .whole(1, lanelet.id)
        .whole(2, 2 * i)
        .whole(3, 2 * i + 1)
        .whole(5, 1)
        .wholes(6, &lanelet.predecessors)
        .wholes(7, &lanelet.successors);
    let beside = [
        (8, 10, lanelet.adjacent_left),
        (9, 11, lanelet.adjacent_right),
    ];
    let out = out.each(beside, |out, (id, opposite, adjacent)| {
        adjacent.into_iter().fold(out, |out, a| {
            out.whole(id, a.id)
                .whole(opposite, i64::from(!a.same_direction))
        })
    });
    let out = lanelet
        .stop_line
        .iter()
        .fold(out, |out, _| out.whole(12, i));
    out.wholes(13, &places(&TYPES, &lanelet.types))
        .wholes(14, &places(&USERS, &lanelet.users_one_way))
        .wholes(15, &places(&USERS, &lanelet.users_bidirectional))
        .wholes(16, &lanelet.signs)
        .wholes(17, &lanelet.lights)
}

fn dynamic(scenario: &Scenario) -> Bytes {
    let surroundings = scenario
        .location
        .as_ref()
        .and_then(|l| l.environment.clone());
    let times = ["night", "sunset", "afternoon", "noon", "morning", "unknown"];
    let weathers = [
        "clear",
        "light_rain",
        "mid_rain",
        "heavy_rain",
        "fog",
        "snow",
        "hail",
        "cloudy",
        "unknown",
    ];
    let surroundings = environment(&surroundings.unwrap_or_default(), &times, &weathers);
    let out = message().inner(1, meta(scenario)).inner(2, surroundings);
    let out = out.each(&scenario.network.lights, |out, light| {
        let inner = message()
            .whole(1, light.id)
            .each(&light.cycle, |out, phase| {
                let color = place(&COLORS, phase.color.name());
                out.inner(2, message().whole(1, phase.duration).whole(2, color))
            });
        out.inner(
            3,
            inner
                .whole(4, light.offset)
                .whole(6, i64::from(light.active)),
        )
    });
    let out = out.each(&scenario.network.signs, |out, sign| {
        let inner = message()
            .whole(1, sign.id)
            .each(&sign.elements, |out, element| {
                let inner = message().whole(1, sign_place(&element.id));
                out.inner(2, inner.each(&element.values, |out, v| out.text(2, v)))
            });
        out.inner(4, inner)
    });
    let of = |role| scenario.obstacles.iter().filter(move |o| o.role == role);
    out.each(of(ObstacleRole::Static), |out, o| {
        out.inner(5, obstacle(o, body))
    })
    .each(of(ObstacleRole::Dynamic), |out, o| {
        out.inner(6, obstacle(o, body))
    })
    .each(of(ObstacleRole::Phantom), |out, o| {
        out.inner(7, phantom(o.id, &o.prediction))
    })
}
