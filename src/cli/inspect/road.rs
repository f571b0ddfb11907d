//! Lanelets as JSON.

use serde_json::{Value, json};

use crate::scenario::{Bound, Lanelet};

pub fn lanelet(lanelet: &Lanelet) -> Value {
    let (left, right) = (&lanelet.left, &lanelet.right);
    let mut value = json!({
        "id": lanelet.id,
        "left_bound": left.points,
        "left_line_marking": left.marking,
        "right_bound": right.points,
        "right_line_marking": right.marking,
        "predecessors": lanelet.predecessors,
        "successors": lanelet.successors,
        "adjacent_left": lanelet.adjacent_left,
        "adjacent_right": lanelet.adjacent_right,
        "stop_line": lanelet.stop_line,
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
