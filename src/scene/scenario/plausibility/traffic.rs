//! Checks signs, lights and intersections.

use std::collections::{HashMap, HashSet};

use super::{ElementRef, Findings, beyond};
use crate::scenario::{
    Intersection, LaneletNetwork, Scenario, Severity, Sign, SignMeaning, TrafficLight,
};
use nearmiss_base::geometry::{Bounds, Point};

/// Signs and lights stand no farther from the road, metres; maps that were cut out of larger ones keep distant ones.
const MAX_ROAD_DISTANCE: f64 = 5_000.0;

/// No limit is higher, m/s: 360 km/h, and 225 mph.
const HIGHEST_LIMIT: f64 = 100.0;

/// No light takes longer for its phases, seconds.
const LONGEST_CYCLE: f64 = 3_600.0;

pub(super) fn check(scenario: &Scenario, found: &mut Findings) {
    let network = &scenario.network;
    let around = network.bounds();
    for (i, one) in network.signs.iter().enumerate() {
        let about = ElementRef::Sign(i);
        sign(one, &mut |message| {
            found.warn(about, format!("sign {}: {message}", one.id));
        });
        if let Some(message) = misplaced(around.as_ref(), one.position) {
            found.warn(about, format!("sign {}: {message}", one.id));
        }
    }
    for (i, one) in network.lights.iter().enumerate() {
        let about = ElementRef::Light(i);
        light(one, scenario.dt(), about, found);
        if let Some(message) = misplaced(around.as_ref(), one.position) {
            found.warn(about, format!("light {}: {message}", one.id));
        }
    }
    for (i, one) in network.intersections.iter().enumerate() {
        intersection(one, network, &mut |severity, message| {
            found.push(
                severity,
                ElementRef::Intersection(i),
                format!("intersection {}: {message}", one.id),
            );
        });
    }
}

fn misplaced(around: Option<&Bounds>, position: Option<Point>) -> Option<String> {
    let off = beyond(around?, &position?);
    (off > MAX_ROAD_DISTANCE).then(|| format!("{off:.0} m from the road; is a coordinate wrong?"))
}

fn sign(sign: &Sign, say: &mut impl FnMut(String)) {
    for element in &sign.elements {
        let value = element.values.first().map_or("", String::as_str);
        match element.meaning() {
            Some(SignMeaning::SpeedLimit(limit) | SignMeaning::LeastSpeed(limit))
                if limit <= 0.0 || limit > HIGHEST_LIMIT =>
            {
                say(format!("a speed limit of {limit} m/s is implausible"));
            }
            Some(SignMeaning::Words("speed limit" | "minimum speed")) => {
                let value: String = value.chars().take(40).collect();
                say(format!("`{value}` is not a speed in m/s; ignored"));
            }
            _ => {}
        }
    }
}

fn light(light: &TrafficLight, dt: f64, about: ElementRef, found: &mut Findings) {
    let id = light.id;
    let bad = light.cycle.iter().filter(|phase| phase.duration <= 0);
    if let Some(first) = bad.clone().next() {
        let message = format!(
            "light {id}: a phase lasts {} time steps and is never shown",
            first.duration
        );
        found.warn(about, super::and_more(message, bad.count() - 1));
    }
    let whole: i128 = light
        .cycle
        .iter()
        .map(|p| i128::from(p.duration.max(0)))
        .sum();
    let seconds = whole as f64 * dt;
    if seconds > LONGEST_CYCLE {
        found.warn(about, format!("light {id}: its cycle takes {seconds:.0} s"));
    }
    if light.offset < 0 {
        found.note(
            about,
            format!("light {id}: a negative offset, {}", light.offset),
        );
    } else if light.offset as f64 * dt > 10.0 * LONGEST_CYCLE {
        found.warn(
            about,
            format!(
                "light {id}: its first phase begins at step {}",
                light.offset
            ),
        );
    }
}

fn intersection(
    one: &Intersection,
    network: &LaneletNetwork,
    say: &mut impl FnMut(Severity, String),
) {
    let mut leads_in: HashMap<i64, i64> = HashMap::new();
    for road in &one.incomings {
        if road.is_left_of == Some(road.id) {
            // Converters write this where there is no other road.
            say(
                Severity::Note,
                format!("incoming road {} is left of itself", road.id),
            );
        }
        for lanelet in &road.lanelets {
            let other = leads_in.insert(*lanelet, road.id);
            if let Some(other) = other.filter(|other| *other != road.id) {
                say(
                    Severity::Warning,
                    format!(
                        "lanelet {lanelet} is part of incoming roads {other} and {}",
                        road.id
                    ),
                );
            }
        }
        let lanelets = road.lanelets.iter().filter_map(|id| network.lanelet(*id));
        let next: HashSet<i64> = lanelets.flat_map(|l| &l.successors).copied().collect();
        let mut ways: HashMap<i64, &str> = HashMap::new();
        let all = [
            ("right", &road.right),
            ("straight on", &road.straight),
            ("left", &road.left),
        ];
        for (way, ids) in all {
            for id in ids {
                if let Some(other) = ways.insert(*id, way).filter(|other| *other != way) {
                    say(
                        Severity::Note,
                        format!(
                            "from road {}, lanelet {id} leads {other} and {way}",
                            road.id
                        ),
                    );
                }
                if network.lanelet(*id).is_some() && !next.contains(id) {
                    say(
                        Severity::Warning,
                        format!(
                            "lanelet {id}, which road {} reaches going {way}, is not a successor of its lanelets",
                            road.id
                        ),
                    );
                }
            }
        }
    }
}
