//! Traffic signs and lights as JSON, with the lanelets and stop lines that refer to them.

use std::collections::HashMap;

use serde_json::{Value, json};

use super::shapes::point;
use crate::scenario::{Lanelet, LaneletNetwork, Sign, TrafficLight};

/// References to signs and lights: lanelet ids by the id referred to.
pub struct References {
    signs: Referring,
    lights: Referring,
}

#[derive(Default)]
struct Referring {
    lanelets: HashMap<i64, Vec<i64>>,
    stop_lines: HashMap<i64, Vec<i64>>,
}

impl References {
    pub fn from_network(network: &LaneletNetwork) -> Self {
        let mut found = Self {
            signs: Referring::default(),
            lights: Referring::default(),
        };
        for lanelet in &network.lanelets {
            note(&mut found.signs.lanelets, lanelet, &lanelet.signs);
            note(&mut found.lights.lanelets, lanelet, &lanelet.lights);
            if let Some(line) = &lanelet.stop_line {
                note(&mut found.signs.stop_lines, lanelet, &line.signs);
                note(&mut found.lights.stop_lines, lanelet, &line.lights);
            }
        }
        found
    }
}

fn note(into: &mut HashMap<i64, Vec<i64>>, lanelet: &Lanelet, ids: &[i64]) {
    for id in ids {
        let referring = into.entry(*id).or_default();
        // A lanelet may refer to the same thing twice.
        if referring.last() != Some(&lanelet.id) {
            referring.push(lanelet.id);
        }
    }
}

fn referring(to: &HashMap<i64, Vec<i64>>, id: i64) -> &[i64] {
    to.get(&id).map_or(&[], Vec::as_slice)
}

pub fn sign(sign: &Sign, references: &References) -> Value {
    json!({
        "id": sign.id,
        "position": sign.position.as_ref().map(point),
        "virtual": sign.is_virtual,
        "elements": sign.elements,
        "lanelets": referring(&references.signs.lanelets, sign.id),
        "stop_lines": referring(&references.signs.stop_lines, sign.id),
    })
}

pub fn light(light: &TrafficLight, references: &References) -> Value {
    json!({
        "id": light.id,
        "position": light.position.as_ref().map(point),
        "active": light.active,
        "direction": light.direction,
        "time_offset": light.offset,
        "cycle": light.cycle,
        "lanelets": referring(&references.lights.lanelets, light.id),
        "stop_lines": referring(&references.lights.stop_lines, light.id),
    })
}
