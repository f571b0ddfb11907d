//! A scenario's complete contents as JSON: metres, radians, m/s, time steps, in the format's terms.

use serde_json::{Value, json};

use super::{obstacles, planning, traffic};
use crate::routes;
use nearmiss_formats::{EgoError, Entry};
use nearmiss_scene::scenario::{Ego, Motion, Scenario, identity};

pub fn document(
    entry: &Entry,
    scenario: &Scenario,
    of_ego: &Result<Option<Ego>, EgoError>,
) -> Value {
    let (header, network) = (&scenario.header, &scenario.network);
    let references = traffic::References::from_network(network);
    json!({
        "scenario": entry.name,
        "file": entry.display(),
        "benchmark_id": identity::normalized(&header.benchmark_id),
        "benchmark_id_as_written": header.benchmark_id,
        "version": header.version,
        "time_step_size": header.time_step_size,
        "attributes": header.attributes,
        "location": scenario.location,
        "tags": scenario.tags,
        "hash": scenario.hash.to_string(),
        "lanelets": network.lanelets,
        "traffic_signs": all(&network.signs, |sign| traffic::sign(sign, &references)),
        "traffic_lights": all(&network.lights, |light| traffic::light(light, &references)),
        "intersections": network.intersections,
        "obstacles": all(&scenario.obstacles, obstacles::obstacle),
        "planning_problems": all(&scenario.planning_problems, planning::problem),
        "ego": ego(of_ego),
        "routes": routes::document(scenario),
        "diagnostics": scenario.diagnostics,
    })
}

pub fn all<'a, T>(things: &'a [T], of: impl Fn(&'a T) -> Value) -> Vec<Value> {
    things.iter().map(of).collect()
}

/// A recorded step, as the states of obstacles are.
fn motion((step, motion): (i64, &Motion)) -> Value {
    json!({
        "time_step": step,
        "x": motion.pose.position.x,
        "y": motion.pose.position.y,
        "orientation": motion.pose.heading,
        "velocity": motion.velocity,
        "acceleration": motion.acceleration,
    })
}

fn ego(ego: &Result<Option<Ego>, EgoError>) -> Value {
    match ego {
        Ok(Some(ego)) => json!({
            "id": ego.id,
            "source": ego.source.to_string(),
            "steps": [ego.track.steps().start, ego.track.steps().end - 1],
            "states": ego.track.iter().map(motion).collect::<Vec<_>>(),
            "diagnostics": ego.diagnostics,
        }),
        Ok(None) => Value::Null,
        Err(error) => json!({ "error": error.to_string() }),
    }
}
