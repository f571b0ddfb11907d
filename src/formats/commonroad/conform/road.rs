//! Makes lanelets, signs, lights and intersections conform to the schema.

use std::collections::HashSet;

use super::Report;
use crate::commonroad::sign_ids;
use nearmiss_scene::scenario::{
    Intersection, Lanelet, LaneletNetwork, LaneletType, Sign, TrafficLight,
};

pub(super) fn network(network: &LaneletNetwork, report: &mut Report) -> LaneletNetwork {
    let signs: Vec<Sign> = network
        .signs
        .iter()
        .filter_map(|s| sign(s, report))
        .collect();
    let lights: Vec<TrafficLight> = network
        .lights
        .iter()
        .filter_map(|l| light(l, report))
        .collect();
    let known = Known {
        lanelets: network.lanelets.iter().map(|l| l.id).collect(),
        signs: signs.iter().map(|s| s.id).collect(),
        lights: lights.iter().map(|l| l.id).collect(),
    };
    let lanelets = network
        .lanelets
        .iter()
        .map(|l| lanelet(l, &known, report))
        .collect();
    let intersections = network
        .intersections
        .iter()
        .filter_map(|i| intersection(i, &known, report))
        .collect();
    LaneletNetwork::new(lanelets, signs, lights, intersections)
}

struct Known {
    lanelets: HashSet<i64>,
    signs: HashSet<i64>,
    lights: HashSet<i64>,
}

/// Keeps the references to what is there.
fn keep(ids: &mut Vec<i64>, known: &HashSet<i64>, from: &str, report: &mut Report) {
    ids.retain(|id| {
        let there = known.contains(id);
        if !there {
            report.change(format!("{from}: the reference to {id} was left out"));
        }
        there
    });
}

fn lanelet(lanelet: &Lanelet, known: &Known, report: &mut Report) -> Lanelet {
    let mut fitted = lanelet.clone();
    let name = format!("lanelet {}", lanelet.id);
    keep(&mut fitted.predecessors, &known.lanelets, &name, report);
    keep(&mut fitted.successors, &known.lanelets, &name, report);
    keep(&mut fitted.signs, &known.signs, &name, report);
    keep(&mut fitted.lights, &known.lights, &name, report);
    if let Some(line) = &mut fitted.stop_line {
        keep(&mut line.signs, &known.signs, &name, report);
        keep(&mut line.lights, &known.lights, &name, report);
    }
    for neighbour in [&mut fitted.adjacent_left, &mut fitted.adjacent_right] {
        if let Some(gone) = neighbour.take_if(|n| !known.lanelets.contains(&n.id)) {
            report.change(format!("{name}: the neighbour {} was left out", gone.id));
        }
    }
    if fitted.types.contains(&LaneletType::Tram) {
        report.change(format!("{name}: the type tram became unknown"));
        for kind in &mut fitted.types {
            if *kind == LaneletType::Tram {
                *kind = LaneletType::Unknown;
            }
        }
    }
    if fitted.types.is_empty() {
        report.change(format!("{name}: no type; written as unknown"));
        fitted.types.push(LaneletType::Unknown);
    }
    fitted
}

fn sign(sign: &Sign, report: &mut Report) -> Option<Sign> {
    let mut fitted = sign.clone();
    fitted.elements.retain(|element| {
        let known = sign_ids::in_schema(&element.id);
        if !known {
            let words = format!("sign {}: `{}` is not in the schema", sign.id, element.id);
            report.change(words + " and was left out");
        }
        known
    });
    if fitted.elements.is_empty() {
        report.change(format!("sign {} without elements was left out", sign.id));
        return None;
    }
    Some(fitted)
}

fn light(light: &TrafficLight, report: &mut Report) -> Option<TrafficLight> {
    let mut fitted = light.clone();
    fitted.cycle.retain(|phase| phase.duration > 0);
    if fitted.cycle.len() < light.cycle.len() {
        report.change(format!(
            "light {}: phases without duration were left out",
            light.id
        ));
    }
    if fitted.cycle.is_empty() {
        report.change(format!("light {} without a cycle was left out", light.id));
        return None;
    }
    if fitted.offset < 0 {
        // A cycle repeats for ever, so that a negative offset has a positive twin.
        let period: i64 = fitted.cycle.iter().map(|p| p.duration).sum();
        fitted.offset = fitted.offset.rem_euclid(period);
        report.change(format!("light {}: the offset was made positive", light.id));
    }
    Some(fitted)
}

fn intersection(
    intersection: &Intersection,
    known: &Known,
    report: &mut Report,
) -> Option<Intersection> {
    let mut fitted = intersection.clone();
    let name = format!("intersection {}", intersection.id);
    for road in &mut fitted.incomings {
        for ids in [
            &mut road.lanelets,
            &mut road.right,
            &mut road.straight,
            &mut road.left,
        ] {
            keep(ids, &known.lanelets, &name, report);
        }
    }
    fitted.incomings.retain(|road| {
        let leads_in = !road.lanelets.is_empty();
        if !leads_in {
            report.change(format!(
                "{name}: incoming {} has no lanelet and was left out",
                road.id
            ));
        }
        leads_in
    });
    let roads: HashSet<i64> = fitted.incomings.iter().map(|r| r.id).collect();
    for road in &mut fitted.incomings {
        if let Some(gone) = road.is_left_of.take_if(|id| !roads.contains(id)) {
            report.change(format!("{name}: `isLeftOf` {gone} was left out"));
        }
    }
    keep(&mut fitted.crossings, &known.lanelets, &name, report);
    if fitted.incomings.is_empty() {
        report.change(format!("{name} without incoming roads was left out"));
        return None;
    }
    Some(fitted)
}
