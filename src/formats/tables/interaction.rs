//! A table in the shape of the INTERACTION Dataset (Zhan et al., arXiv 1910.03088), with everyone in it.

use nearmiss_record::csv;
use nearmiss_scene::scenario::ObstacleType;

use super::{Recording, User, WrittenTables, number};

const COLUMNS: [&str; 11] = [
    "track_id",
    "frame_id",
    "timestamp_ms",
    "agent_type",
    "x",
    "y",
    "vx",
    "vy",
    "psi_rad",
    "length",
    "width",
];

/// The time between its frames, seconds.
const TIME_STEP: f64 = 0.1;

pub fn write(recording: &Recording) -> WrittenTables {
    let header = std::iter::once(COLUMNS.map(str::to_string));
    let rows = recording.users.iter().flat_map(|user| {
        let states = user.states.iter();
        states.map(|(step, motion)| {
            let (pose, velocity) = (motion.pose, motion.velocity_vector());
            let frame = step - recording.steps.0 + 1;
            [
                user.id.to_string(),
                frame.to_string(),
                number((frame as f64 * recording.time_step * 1e6).round() / 1e3),
                class(user.kind).to_string(),
                number(pose.position.x),
                number(pose.position.y),
                number(velocity.x),
                number(velocity.y),
                number(pose.heading),
                number(user.length),
                number(user.width),
            ]
        })
    });
    let mut notes = Vec::new();
    let others = recording.users.iter().filter(|user| !is_exact(user));
    match others.count() {
        0 => {}
        count => notes.push(format!(
            "{count} road users are neither cars nor pedestrians, and written as what this shape has next to it: car or pedestrian/bicycle"
        )),
    }
    if (recording.time_step - TIME_STEP).abs() > 1e-9 {
        notes.push(format!(
            "steps are {} s; those of the data set are {TIME_STEP} s",
            recording.time_step
        ));
    }
    notes.extend(recording.ego_in_words());
    WrittenTables {
        files: vec![("", csv(header.chain(rows)))],
        notes,
    }
}

/// Its two classes.
fn class(kind: ObstacleType) -> &'static str {
    match kind {
        ObstacleType::Pedestrian | ObstacleType::Bicycle => "pedestrian/bicycle",
        _ => "car",
    }
}

fn is_exact(user: &User) -> bool {
    matches!(user.kind, ObstacleType::Car | ObstacleType::Pedestrian)
}
