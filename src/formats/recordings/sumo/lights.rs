//! Programs of SUMO's traffic lights.

use crate::commonroad::ReadError;
use crate::commonroad::xml::{Element, Xml};
use crate::recordings::leftovers::Leftovers;
use nearmiss_scene::scenario::{LightPhase, SignalColor, TrafficDirection, TrafficLight};

/// A program: its phases one after the other.
pub struct Program {
    pub is_static: bool,
    /// Seconds by which it is delayed.
    offset: f64,
    /// Seconds, and the signal of each connection.
    phases: Vec<(f64, String)>,
}

/// Phases longer than this are none, seconds.
const LONGEST: f64 = 1e6;

/// Reads a program, with the id of its light.
pub fn program<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    leftovers: &mut Leftovers,
) -> Result<(String, Program), ReadError> {
    leftovers.attributes(xml, element, &["id", "type", "offset", "programID"]);
    let id = xml
        .attribute(element, "id")
        .unwrap_or_default()
        .into_owned();
    let kind = xml.attribute(element, "type");
    let is_static = kind.is_none_or(|kind| kind == "static");
    let offset = xml
        .attribute(element, "offset")
        .and_then(|o| o.parse::<f64>().ok());
    let mut phases = Vec::new();
    while let Some(child) = xml.next()? {
        if child.name != "phase" {
            leftovers.element(xml, "tlLogic", child)?;
            continue;
        }
        leftovers.attributes(xml, child, &["duration", "state"]);
        let text = xml.attribute(child, "duration").unwrap_or_default();
        let seconds = text
            .parse::<f64>()
            .ok()
            .filter(|s| (0.0..=LONGEST).contains(s))
            .ok_or_else(|| {
                let shown: String = text.chars().take(40).collect();
                xml.fail(
                    child.at,
                    format!("duration=\"{shown}\" is not a number of seconds"),
                )
            })?;
        let state = xml
            .attribute(child, "state")
            .unwrap_or_default()
            .into_owned();
        phases.push((seconds, state));
        xml.check_count(element, phases.len(), "phases")?;
        xml.skip()?;
    }
    let offset = offset.filter(|o| o.is_finite() && o.abs() < LONGEST);
    let program = Program {
        is_static,
        offset: offset.unwrap_or(0.0),
        phases,
    };
    Ok((id, program))
}

impl Program {
    /// The light of a connection as it is from `start` on, in steps of `dt` seconds; its id is still to be given.
    pub fn light(&self, link: usize, start: f64, dt: f64) -> Option<TrafficLight> {
        let steps = |seconds: f64| (seconds / dt).round() as i64;
        let mut cycle: Vec<LightPhase> = Vec::new();
        for (seconds, state) in &self.phases {
            let color = match state.as_bytes().get(link)? {
                b'r' => SignalColor::Red,
                b'y' | b'Y' => SignalColor::Yellow,
                b'g' | b'G' | b's' => SignalColor::Green,
                b'u' => SignalColor::RedYellow,
                _ => SignalColor::Inactive,
            };
            let duration = steps(*seconds);
            match cycle.last_mut() {
                Some(phase) if phase.color == color => phase.duration += duration,
                _ => cycle.push(LightPhase { duration, color }),
            }
        }
        let whole: i64 = cycle.iter().map(|p| p.duration).sum();
        if whole <= 0 {
            return None;
        }
        Some(TrafficLight {
            id: 0,
            position: None,
            active: true,
            direction: Some(TrafficDirection::All),
            offset: steps(self.offset - start).rem_euclid(whole),
            cycle,
        })
    }
}
