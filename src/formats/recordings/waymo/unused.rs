//! Fields of a Waymo scenario that are not used: decoding passes over them without a word.

use crate::commonroad::wire::{Fields, Value};
use crate::recordings::leftovers::Leftovers;

/// A field that a message can have: its number, its name, and what is known of the message in it.
type Field = (u32, &'static str, Of);

/// What is made of a field.
#[derive(Clone, Copy)]
enum Of {
    /// Its value is used.
    Used,
    /// Nothing.
    Unused,
    /// It is a message with such fields.
    Message(&'static [Field]),
}

use Of::{Message, Unused, Used};

const POINT: &[Field] = &[(1, "x", Used), (2, "y", Used), (3, "z", Used)];
const LINE: &[Field] = &[(1, "type", Unused), (2, "polyline", Message(POINT))];
const POLYGON: &[Field] = &[(1, "polygon", Message(POINT))];
const NEIGHBOUR: &[Field] = &[
    (1, "feature_id", Used),
    (2, "self_start_index", Used),
    (3, "self_end_index", Used),
    (4, "neighbor_start_index", Unused),
    (5, "neighbor_end_index", Unused),
    (6, "boundaries", Unused),
];
const BOUNDARY: &[Field] = &[
    (1, "lane_start_index", Used),
    (2, "lane_end_index", Used),
    (3, "boundary_feature_id", Used),
    (4, "boundary_type", Used),
];
const LANE: &[Field] = &[
    (1, "speed_limit_mph", Used),
    (2, "type", Used),
    (3, "interpolating", Unused),
    (8, "polyline", Message(POINT)),
    (9, "entry_lanes", Used),
    (10, "exit_lanes", Used),
    (11, "left_neighbors", Message(NEIGHBOUR)),
    (12, "right_neighbors", Message(NEIGHBOUR)),
    (13, "left_boundaries", Message(BOUNDARY)),
    (14, "right_boundaries", Message(BOUNDARY)),
];
const STOP_SIGN: &[Field] = &[(1, "lane", Used), (2, "position", Message(POINT))];
const MAP_FEATURE: &[Field] = &[
    (1, "id", Used),
    (3, "lane", Message(LANE)),
    (4, "road_line", Message(LINE)),
    (5, "road_edge", Message(LINE)),
    (7, "stop_sign", Message(STOP_SIGN)),
    (8, "crosswalk", Message(POLYGON)),
    (9, "speed_bump", Unused),
    (10, "driveway", Unused),
];
const LANE_STATE: &[Field] = &[
    (1, "lane", Used),
    (2, "state", Used),
    (3, "stop_point", Message(POINT)),
];
const MAP_STATE: &[Field] = &[(1, "lane_states", Message(LANE_STATE))];
const STATE: &[Field] = &[
    (2, "center_x", Used),
    (3, "center_y", Used),
    (4, "center_z", Unused),
    (5, "length", Used),
    (6, "width", Used),
    (7, "height", Unused),
    (8, "heading", Used),
    (9, "velocity_x", Used),
    (10, "velocity_y", Used),
    (11, "valid", Used),
];
const TRACK: &[Field] = &[
    (1, "id", Used),
    (2, "object_type", Used),
    (3, "states", Message(STATE)),
];
const SCENARIO: &[Field] = &[
    (1, "timestamps_seconds", Used),
    (2, "tracks", Message(TRACK)),
    (4, "objects_of_interest", Unused),
    (5, "scenario_id", Used),
    (6, "sdc_track_index", Used),
    (7, "dynamic_map_states", Message(MAP_STATE)),
    (8, "map_features", Message(MAP_FEATURE)),
    (10, "current_time_index", Unused),
    (11, "tracks_to_predict", Unused),
    (12, "compressed_frame_laser_data", Unused),
    (13, "frame_camera_tokens", Unused),
];

/// Counts the fields of a scenario that are not used.
pub fn count(scenario: &[u8]) -> Leftovers {
    let mut leftovers = Leftovers::default();
    fields(scenario, SCENARIO, "", &mut leftovers);
    leftovers
}

fn fields(message: &[u8], known: &[Field], within: &str, leftovers: &mut Leftovers) {
    for field in Fields::new(message).map_while(Result::ok) {
        let found = known.iter().find(|(number, ..)| *number == field.number);
        match (found, field.value) {
            (Some((.., Used)), _) => {}
            (Some((_, name, Message(known))), Value::Bytes(bytes)) => {
                let within = match within {
                    "" => (*name).to_string(),
                    _ => format!("{within}/{name}"),
                };
                fields(bytes, known, &within, leftovers);
            }
            (Some((_, name, _)), _) => leftovers.field(within, name),
            (None, _) => leftovers.field(within, &format!("field {}", field.number)),
        }
    }
}
