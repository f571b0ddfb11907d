//! The dynamic file of 2024: the traffic on a map, and the changing states of lights and signs.

use std::collections::BTreeMap;

use super::elements::Elements;
use super::header::{self, Map};
use super::messages::{SignValue, TrafficLightCycle};
use super::report::{FieldPath, Report};
use super::shapes::body;
use super::words::ENVIRONMENT_2024;
use super::{obstacles, place, road, sign_values};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{ScenarioBuilder, SourceLocation};
use nearmiss_scene::scenario::{Environment, Header, LightPhase, Sign, SignElement, TrafficLight};

/// Contents of a dynamic file, except obstacles.
pub(super) struct Dynamic {
    pub header: Header,
    pub environment: Option<Environment>,
    pub changes: Changes,
}

/// Changes to the map's lights and signs, by id, each with its place in the file.
#[derive(Default)]
pub(super) struct Changes {
    cycles: BTreeMap<i64, (usize, Cycle)>,
    signs: BTreeMap<i64, (usize, Vec<SignElement>)>,
}

/// The cycle of a traffic light.
struct Cycle {
    phases: Vec<LightPhase>,
    offset: i64,
    active: bool,
}

/// Adds the traffic to a scenario.
pub(super) fn read(
    root: &FieldPath<'_>,
    bytes: &[u8],
    builder: &mut ScenarioBuilder,
) -> Result<Dynamic, ReadError> {
    let mut information: Option<(Header, Map)> = None;
    let (mut environment, mut signs, mut cycles) = (None, Vec::new(), 0);
    let mut changes = Changes::default();
    let mut elements = Elements::new(root, builder);
    root.each_field(bytes, |field| match field.number {
        1 => {
            let at = root.field("dynamic_meta_information");
            at.part(field, &mut information, header::of_2024)
        }
        2 => {
            let at = root.field("environment");
            at.part(field, &mut environment, |at, m| {
                Ok(place::environment(at, m, &ENVIRONMENT_2024))
            })
        }
        3 => elements.add("traffic_light_cycle", field, |_, at, m| {
            let (light, cycle) = cycle(at, m)?;
            changes.cycles.insert(light, (cycles, cycle));
            cycles += 1;
            Ok(())
        }),
        4 => elements.add("traffic_sign_value", field, |_, _, m: &SignValue| {
            signs.push(m.clone());
            Ok(())
        }),
        5 => elements.add("static_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::fixed(at, m, body)?);
            Ok(())
        }),
        6 => elements.add("dynamic_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::moving(at, m, body)?);
            Ok(())
        }),
        7 => elements.add("phantom_obstacles", field, |builder, at, m| {
            builder.obstacle(at, obstacles::phantom(at, m)?);
            Ok(())
        }),
        _ => {
            root.skip_unknown(field);
            Ok(())
        }
    })?;
    let (header, map) = root.need("dynamic_meta_information", information)?;
    for (i, message) in signs.iter().enumerate() {
        let at = root.nth("traffic_sign_value", i);
        let id = at.need("traffic_sign_id", message.traffic_sign_id)?;
        let elements = sign_values::elements(&at, &message.traffic_sign_elements, &map.country)?;
        changes.signs.insert(id.into(), (i, elements));
    }
    Ok(Dynamic {
        header,
        environment: root.need("environment", environment)?,
        changes,
    })
}

fn cycle(at: &FieldPath<'_>, message: &TrafficLightCycle) -> Result<(i64, Cycle), ReadError> {
    let light = at.need("traffic_light_id", message.traffic_light_id)?;
    let cycle = Cycle {
        phases: road::cycle(at, &message.cycle_elements)?,
        offset: message.time_offset.unwrap_or(0).into(),
        active: message.active.unwrap_or(true),
    };
    Ok((light.into(), cycle))
}

impl Changes {
    /// Gives a light of the map its cycle.
    pub fn apply_to_light(&mut self, light: &mut TrafficLight) {
        if let Some((_, cycle)) = self.cycles.remove(&light.id) {
            light.cycle = cycle.phases;
            (light.offset, light.active) = (cycle.offset, cycle.active);
        }
    }

    /// Gives a sign of the map what it says in this scenario.
    pub fn apply_to_sign(&mut self, sign: &mut Sign) {
        if let Some((_, elements)) = self.signs.remove(&sign.id) {
            sign.elements = elements;
        }
    }

    /// Warns of what no light or sign of the map took.
    pub fn warn_of_rest(&self, report: &Report) {
        let root = FieldPath::root(report, "dynamic");
        for (id, (i, _)) in &self.cycles {
            let at = root.nth("traffic_light_cycle", *i);
            at.warn(format!("refers to missing light {id}"));
        }
        for (id, (i, _)) in &self.signs {
            let at = root.nth("traffic_sign_value", *i);
            at.warn(format!("refers to missing sign {id}"));
        }
    }
}
