//! Lanelets and intersections as JSON.

use serde_json::{Value, json};

use super::document::all;
use super::shapes::{point, points};
use crate::scenario::{Adjacent, Bound, Incoming, Intersection, Lanelet, RoadUser, StopLine};

pub fn lanelet(lanelet: &Lanelet) -> Value {
    let adjacent =
        |a: Option<Adjacent>| a.map(|a| json!({ "id": a.id, "same_direction": a.same_direction }));
    let users = |users: &[RoadUser]| users.iter().map(|u| u.name()).collect::<Vec<_>>();
    let (left, right) = (&lanelet.left, &lanelet.right);
    let mut value = json!({
        "id": lanelet.id,
        "left_bound": points(&left.points),
        "left_line_marking": left.marking.name(),
        "right_bound": points(&right.points),
        "right_line_marking": right.marking.name(),
        "predecessors": lanelet.predecessors,
        "successors": lanelet.successors,
        "adjacent_left": adjacent(lanelet.adjacent_left),
        "adjacent_right": adjacent(lanelet.adjacent_right),
        "stop_line": lanelet.stop_line.as_ref().map(stop_line),
        "types": lanelet.types.iter().map(|t| t.name()).collect::<Vec<_>>(),
        "users_one_way": users(&lanelet.users_one_way),
        "users_bidirectional": users(&lanelet.users_bidirectional),
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
        "line_marking": line.marking.name(),
        "traffic_signs": line.signs,
        "traffic_lights": line.lights,
    })
}

pub fn intersection(intersection: &Intersection) -> Value {
    json!({
        "id": intersection.id,
        "incomings": all(&intersection.incomings, incoming),
        "crossings": intersection.crossings,
    })
}

fn incoming(road: &Incoming) -> Value {
    json!({
        "id": road.id,
        "lanelets": road.lanelets,
        "successors_right": road.right,
        "successors_straight": road.straight,
        "successors_left": road.left,
        "is_left_of": road.is_left_of,
    })
}
