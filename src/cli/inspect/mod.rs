//! `nearmiss inspect`: what is in a scenario or a solution, and what is wrong with it.

mod solution;

use std::path::PathBuf;

use serde_json::{Value, json};

use super::{Failure, Outcome, open, output, routes};
use crate::geometry::{Point, Shape, Truck};
use crate::scenario::commonroad::{Root, root_of_file};
use crate::scenario::{
    Adjacent, Ego, EgoError, Entry, Goal, Lanelet, Obstacle, Place, Prediction, Quantity, Scenario,
    State, benchmark_id, in_short,
};

/// Arguments of `inspect`.
#[derive(Debug, clap::Args)]
pub struct Inspect {
    /// A CommonRoad scenario or solution, or the name of a bundled scenario.
    file: PathBuf,
    /// Everything that was read, as JSON.
    #[arg(long)]
    json: bool,
}

/// Runs `inspect`.
pub fn run(arguments: &Inspect) -> Outcome {
    let entry = open::entry(&arguments.file)?;
    if let Place::File(path) = &entry.place
        && root_of_file(path) == Root::Solution
    {
        return solution::run(path, arguments.json);
    }
    let scenario = entry.read().map_err(Failure::input)?;
    let ego = entry.recorded_ego(&scenario);
    if arguments.json {
        let mut document = document(&scenario);
        document["ego"] = match &ego {
            Ok(Some(ego)) => json!({
                "id": ego.id,
                "source": ego.source.to_string(),
                "steps": [ego.track.steps().start, ego.track.steps().end - 1],
                "diagnostics": ego.diagnostics,
            }),
            Ok(None) => Value::Null,
            Err(error) => json!({ "error": error.to_string() }),
        };
        output::json(&document)?;
    } else {
        output::text(&summary(&entry, &scenario, &ego))?;
    }
    // The scenario is shown all the same.
    ego.map(|_| ()).map_err(Failure::input)
}

fn summary(entry: &Entry, scenario: &Scenario, ego: &Result<Option<Ego>, EgoError>) -> String {
    let id = match scenario.header.benchmark_id.as_str() {
        "" => "(no benchmark id)",
        id => id,
    };
    let mut text = format!("{id}\n");
    let mut line = |word: &str, said: &str| text.push_str(&format!("  {word:<11} {said}\n"));
    line("file", &entry.display());
    line("hash", &scenario.hash.to_string());
    for (word, said) in scenario.summary() {
        line(word, &said);
    }
    let possible = scenario.possible_egos();
    match ego {
        Ok(Some(ego)) => {
            let (first, last) = (ego.track.steps().start, ego.track.steps().end - 1);
            line(
                "ego",
                &format!("{}, {}, steps {first} to {last}", ego.id, ego.source),
            );
            for (_, doubt) in in_short(&ego.diagnostics) {
                line("", &doubt);
            }
        }
        Ok(None) => line("ego", "no recording found"),
        Err(error) => line("ego", &format!("cannot be read: {error}")),
    }
    if possible.is_empty() {
        line("as ego", "no obstacle has a trajectory");
    } else {
        let ids: Vec<String> = possible.iter().map(i64::to_string).collect();
        line(
            "as ego",
            &format!("--ego takes obstacle {}", ids.join(", ")),
        );
    }
    text.push_str(&routes::summary(scenario));
    if scenario.diagnostics.is_empty() {
        text.push_str("  diagnostics none\n");
    }
    for (_, diagnostic) in in_short(&scenario.diagnostics) {
        text.push_str(&format!("  {diagnostic}\n"));
    }
    output::visible(&text)
}

fn document(scenario: &Scenario) -> Value {
    let network = &scenario.network;
    let ids = |ids: Vec<i64>| {
        ids.into_iter()
            .map(|id| json!({ "id": id }))
            .collect::<Vec<_>>()
    };
    json!({
        "benchmark_id": benchmark_id::normalized(&scenario.header.benchmark_id),
        "benchmark_id_as_written": scenario.header.benchmark_id,
        "version": scenario.header.version,
        "time_step_size": scenario.header.time_step_size,
        "attributes": scenario.header.attributes,
        "tags": scenario.tags,
        "hash": scenario.hash.to_string(),
        "lanelets": network.lanelets.iter().map(lanelet).collect::<Vec<_>>(),
        "traffic_signs": ids(network.signs.iter().map(|s| s.id).collect()),
        "traffic_lights": ids(network.lights.iter().map(|l| l.id).collect()),
        "intersections": ids(network.intersections.iter().map(|i| i.id).collect()),
        "obstacles": scenario.obstacles.iter().map(obstacle).collect::<Vec<_>>(),
        "planning_problems": scenario.planning_problems.iter().map(|p| json!({
            "id": p.id,
            "initial": initial_state(&p.initial),
            "goals": p.goals.iter().map(goal).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "routes": routes::document(scenario),
        "diagnostics": scenario.diagnostics,
    })
}

fn points(points: &[Point]) -> Vec<[f64; 2]> {
    points.iter().map(|p| [p.x, p.y]).collect()
}

fn lanelet(lanelet: &Lanelet) -> Value {
    let adjacent =
        |a: Option<Adjacent>| a.map(|a| json!({ "id": a.id, "same_direction": a.same_direction }));
    json!({
        "id": lanelet.id,
        "left_bound": points(&lanelet.left.points),
        "right_bound": points(&lanelet.right.points),
        "predecessors": lanelet.predecessors,
        "successors": lanelet.successors,
        "adjacent_left": adjacent(lanelet.adjacent_left),
        "adjacent_right": adjacent(lanelet.adjacent_right),
        "types": lanelet.types.iter().map(|t| t.name()).collect::<Vec<_>>(),
    })
}

fn obstacle(obstacle: &Obstacle) -> Value {
    let occupancies = match &obstacle.prediction {
        Prediction::Occupancies(occupancies) => occupancies.len(),
        _ => 0,
    };
    let first = obstacle.initial.iter().map(initial_state);
    let later = obstacle.states().skip(first.len()).map(state);
    let states: Vec<Value> = first.chain(later).collect();
    json!({
        "id": obstacle.id,
        "role": obstacle.role.name(),
        "type": obstacle.kind.name(),
        "shape": obstacle.footprint.as_ref().map(|f| shape(f.shape())),
        "states": states,
        "occupancies": occupancies,
    })
}

fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift,
        } => json!({
            "kind": "rectangle", "length": length, "width": width,
            "center": [center.x, center.y], "orientation": orientation, "origin_x_shift": origin_x_shift,
        }),
        Shape::Truck(t) => truck(t),
        Shape::SemiTrailerTruck {
            tractor,
            trailer,
            hitch_angle,
        } => json!({
            "kind": "semi_trailer_truck", "tractor": truck(tractor), "hitch_angle": hitch_angle,
            "trailer": {
                "length": trailer.length, "width": trailer.width, "wheelbase": trailer.wheelbase,
                "front_to_hitch": trailer.front_to_hitch,
            },
        }),
        Shape::Circle { radius, center } => {
            json!({ "kind": "circle", "radius": radius, "center": [center.x, center.y] })
        }
        Shape::Polygon { vertices } => json!({ "kind": "polygon", "vertices": points(vertices) }),
        Shape::Group(members) => {
            json!({ "kind": "group", "shapes": members.iter().map(self::shape).collect::<Vec<_>>() })
        }
    }
}

fn truck(truck: &Truck) -> Value {
    json!({
        "kind": "truck", "length": truck.length, "width": truck.width, "wheelbase": truck.wheelbase,
        "rear_to_rear_axle": truck.rear_to_rear_axle, "cabin_length": truck.cabin_length,
        "rear_axle_to_hitch": truck.rear_axle_to_hitch, "origin_x_shift": truck.origin_x_shift,
    })
}

fn quantity(quantity: Quantity) -> Value {
    match quantity {
        Quantity::Exact(value) => json!(value),
        Quantity::Interval(from, to) => json!([from, to]),
    }
}

fn state(state: &State) -> Value {
    let mut value = json!({ "time_step": state.time.from });
    let mut put = |name: &str, v: Option<Value>| {
        if let Some(v) = v {
            value[name] = v;
        }
    };
    put("x", state.point().map(|p| json!(p.x)));
    put("y", state.point().map(|p| json!(p.y)));
    let direction = state.point_mass_velocity().map(|v| json!(v.y.atan2(v.x)));
    put("orientation", state.orientation.map(quantity).or(direction));
    put("velocity", state.velocity.map(quantity));
    put("acceleration", state.acceleration.map(quantity));
    for (field, v) in &state.more {
        put(field.name(), Some(quantity(*v)));
    }
    value
}

/// An initial state; what it does not say is 0, as the format has it for initial states.
fn initial_state(initial: &State) -> Value {
    let mut value = state(initial);
    for name in ["orientation", "velocity"] {
        if value[name].is_null() {
            value[name] = json!(0.0);
        }
    }
    value
}

fn goal(goal: &Goal) -> Value {
    json!({
        "time_step": [goal.time.from, goal.time.to],
        "lanelets": goal.lanelets(),
        "velocity": goal.velocity.map(quantity),
        "orientation": goal.orientation.map(quantity),
    })
}
