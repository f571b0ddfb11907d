//! Traffic signs and lights as JSON, with the lanelets and stop lines that refer to them.

use std::collections::HashMap;

use serde::Serialize;

use nearmiss_scene::scenario::{Lanelet, LaneletNetwork, Sign, TrafficLight};

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

    pub fn to_sign<'n>(&self, sign: &'n Sign) -> Referred<'n, Sign> {
        self.signs.with(sign, sign.id)
    }

    pub fn to_light<'n>(&self, light: &'n TrafficLight) -> Referred<'n, TrafficLight> {
        self.lights.with(light, light.id)
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

/// A sign or light with the lanelets that refer to it.
#[derive(Serialize)]
pub struct Referred<'n, T> {
    #[serde(flatten)]
    itself: &'n T,
    lanelets: Vec<i64>,
    stop_lines: Vec<i64>,
}

impl Referring {
    fn with<'n, T>(&self, itself: &'n T, id: i64) -> Referred<'n, T> {
        let ids = |to: &HashMap<i64, Vec<i64>>| to.get(&id).cloned().unwrap_or_default();
        Referred {
            itself,
            lanelets: ids(&self.lanelets),
            stop_lines: ids(&self.stop_lines),
        }
    }
}
