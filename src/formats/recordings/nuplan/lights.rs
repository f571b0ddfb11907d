//! Traffic lights of a log: what each connector of lanes is shown at every step.

use std::collections::BTreeMap;

use super::clock::Clock;
use super::sqlite::Database;
use crate::commonroad::ReadError;
use nearmiss_scene::scenario::{LightPhase, SignalColor};

/// What connectors are shown, by their ids in the map.
pub type Lights = BTreeMap<i64, Vec<LightPhase>>;

const COLUMNS: [&str; 3] = ["token", "lane_connector_id", "status"];

fn color(status: &str) -> SignalColor {
    match status {
        "green" => SignalColor::Green,
        "yellow" => SignalColor::Yellow,
        "red" => SignalColor::Red,
        _ => SignalColor::Inactive,
    }
}

/// The lights of some sweeps.
///
/// # Errors
/// A row is damaged.
pub fn read(database: &Database, clock: &Clock<'_>) -> Result<Lights, ReadError> {
    let table = "traffic_light_status";
    let mut said: BTreeMap<i64, BTreeMap<i64, SignalColor>> = BTreeMap::new();
    if !database.has(table) {
        return Ok(Lights::new());
    }
    let lights = &clock.log.lights;
    lights.each(database, table, &COLUMNS, clock, &mut |row, step| {
        let colors = said.entry(row.whole(1)?).or_default();
        colors.insert(step, color(&row.text(2)));
        Ok(())
    })?;
    let lights = said.into_iter().map(|(connector, colors)| {
        let mut cycle: Vec<LightPhase> = Vec::new();
        for (n, (_, step)) in clock.sweeps.iter().enumerate() {
            // Up to the next sweep; where nothing is said, it is not known.
            let next = clock.sweeps.get(n + 1).map_or(step + 1, |(_, next)| *next);
            let color = colors.get(step).copied().unwrap_or(SignalColor::Inactive);
            let duration = next - step;
            match cycle.last_mut() {
                Some(phase) if phase.color == color => phase.duration += duration,
                _ => cycle.push(LightPhase { duration, color }),
            }
        }
        (connector, cycle)
    });
    Ok(lights.collect())
}
