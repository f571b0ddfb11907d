//! Lanelets as JSON.

use serde_json::{Value, json};

use super::shapes::{point, points};
use crate::scenario::{Bound, Lanelet, StopLine};

pub fn lanelet(lanelet: &Lanelet) -> Value {
    let (left, right) = (&lanelet.left, &lanelet.right);
    let mut value = json!({
        "id": lanelet.id,
        "left_bound": points(&left.points),
        "left_line_marking": left.marking,
        "right_bound": points(&right.points),
        "right_line_marking": right.marking,
        "predecessors": lanelet.predecessors,
        "successors": lanelet.successors,
        "adjacent_left": lanelet.adjacent_left,
        "adjacent_right": lanelet.adjacent_right,
        "stop_line": lanelet.stop_line.as_ref().map(stop_line),
        "types": lanelet.types,
        "users_one_way": lanelet.users_one_way,
        "users_bidirectional": lanelet.users_bidirectional,
        "traffic_signs": lanelet.signs,
        "traffic_lights": lanelet.lights,
    });
    let mut put_heights = |name: &str, bound: &Bound| {
        if !bound.heights.is_empty() {
            value[name] = json!(bound.heights);
        }
    };
    put_heights("left_heights", left);
    put_heights("right_heights", right);
    value
}

/// Without points it lies at the end of the lanelet.
fn stop_line(line: &StopLine) -> Value {
    json!({
        "points": line.points.map(|(from, to)| [point(&from), point(&to)]),
        "line_marking": line.marking,
        "traffic_signs": line.signs,
        "traffic_lights": line.lights,
    })
}
