//! The dynamic file of 2024: the traffic on a map, and what lights and signs do meanwhile.

use super::header::{self, Map};
use super::messages::{Body, Environment, SignValue, TrafficLightCycle};
use super::report::{At, Report};
use super::wire::{Field, Fields};
use super::words::ENVIRONMENT_2024;
use super::{obstacles, place, road, sign_values};
use crate::scenario::commonroad::ReadError;
use crate::scenario::{self, Header, LightPhase, ObstacleParts, SignElement};

/// What a dynamic file says.
pub(super) struct Dynamic {
    pub header: Header,
    pub environment: Option<scenario::Environment>,
    pub cycles: Vec<Cycle>,
    /// Signs by their ids, and what they say.
    pub signs: Vec<(i64, Vec<SignElement>)>,
    pub obstacles: Vec<ObstacleParts>,
}

/// What a traffic light does.
pub(super) struct Cycle {
    pub light: i64,
    pub phases: Vec<LightPhase>,
    pub offset: i64,
    pub active: bool,
}

/// What was read so far.
#[derive(Default)]
struct Found {
    information: Option<(Header, Map)>,
    environment: Option<Option<scenario::Environment>>,
    cycles: Vec<Cycle>,
    signs: Vec<SignValue>,
    fixed: Vec<ObstacleParts>,
    moving: Vec<ObstacleParts>,
    phantom: Vec<ObstacleParts>,
}

pub(super) fn read(r: &mut Report, root: &At<'_>, bytes: &[u8]) -> Result<Dynamic, ReadError> {
    let mut found = Found::default();
    for field in Fields::of(bytes) {
        let field = r.whole(root, field)?;
        found.add(r, root, &field)?;
    }
    let (header, map) = r.need(root, "dynamic_meta_information", found.information)?;
    let mut signs = Vec::with_capacity(found.signs.len());
    for (i, message) in found.signs.iter().enumerate() {
        let at = root.nth("traffic_sign_value", i);
        let id = r.need(&at, "traffic_sign_id", message.traffic_sign_id)?;
        let elements = &message.traffic_sign_elements;
        signs.push((
            id.into(),
            sign_values::elements(r, &at, elements, &map.country)?,
        ));
    }
    let roles = [found.fixed, found.moving, found.phantom];
    Ok(Dynamic {
        header,
        environment: r.need(root, "environment", found.environment)?,
        cycles: found.cycles,
        signs,
        obstacles: roles.into_iter().flatten().collect(),
    })
}

impl Found {
    fn add(&mut self, r: &mut Report, root: &At<'_>, field: &Field<'_>) -> Result<(), ReadError> {
        let at = |name| root.field(name);
        match field.number {
            1 => {
                let at = at("dynamic_meta_information");
                r.part(&at, field, &mut self.information, header::of_2024)
            }
            2 => r.part(
                &at("environment"),
                field,
                &mut self.environment,
                |r, at, m| {
                    let message: &Environment = m;
                    Ok(place::environment(r, at, message, &ENVIRONMENT_2024))
                },
            ),
            3 => {
                let at = root.nth("traffic_light_cycle", self.cycles.len());
                let message = r.decode(&at, field)?;
                self.cycles.push(cycle(r, &at, &message)?);
                Ok(())
            }
            4 => {
                let at = root.nth("traffic_sign_value", self.signs.len());
                self.signs.push(r.decode(&at, field)?);
                Ok(())
            }
            5 => {
                let (at, into) = (at("static_obstacles"), &mut self.fixed);
                r.element(&at, field, into, obstacles::fixed::<Body>, |o| o.id)
            }
            6 => {
                let (at, into) = (at("dynamic_obstacles"), &mut self.moving);
                r.element(&at, field, into, obstacles::moving::<Body>, |o| o.id)
            }
            7 => {
                let (at, into) = (at("phantom_obstacles"), &mut self.phantom);
                r.element(&at, field, into, obstacles::phantom, |o| o.id)
            }
            _ => {
                r.unknown(root, field);
                Ok(())
            }
        }
    }
}

fn cycle(r: &mut Report, at: &At<'_>, message: &TrafficLightCycle) -> Result<Cycle, ReadError> {
    Ok(Cycle {
        light: r
            .need(at, "traffic_light_id", message.traffic_light_id)?
            .into(),
        phases: road::cycle(r, at, &message.cycle_elements)?,
        offset: message.time_offset.unwrap_or(0).into(),
        active: message.active.unwrap_or(true),
    })
}
