//! Motion that is predicted from one moment: constant velocity.

use serde_json::{Value, json};

use super::instruments::{AT, PARTICIPANT, T};
use super::view::{Who, number, time};
use super::{Argument, ArgumentKind, Arguments, Field, Tool, ToolError, WindowView};
use nearmiss_base::geometry::Pose;
use nearmiss_scene::scenario::Motion;

pub(super) const PREDICT: Tool = Tool {
    name: "predict_constant_velocity",
    about: "Where the ego or an obstacle would be if it kept velocity and heading from a moment on, and how far the \
            bodies of obstacle and ego would then be apart if the ego did so too. A prediction, not the recording.",
    arguments: &[
        PARTICIPANT,
        T,
        Argument {
            name: "horizon",
            kind: ArgumentKind::Number(0.1, 10.0),
            unit: "s",
            required: false,
            about: "How far it is predicted; 3 where it is left out.",
        },
        Argument {
            name: "interval",
            kind: ArgumentKind::Number(0.1, 10.0),
            unit: "s",
            required: false,
            about: "Between two positions; 0.5 where it is left out.",
        },
    ],
    result: &[
        AT,
        Field::list(
            "positions",
            "From the moment on.",
            &[
                Field::new("after", "number", "s", "Time after the moment."),
                Field::new("x", "number", "m", "Position on the map."),
                Field::new("y", "number", "m", "Position on the map."),
                Field::new(
                    "distance_to_ego",
                    "number",
                    "m",
                    "Between the bodies; missing for the ego.",
                ),
            ],
        ),
    ],
    call: predict,
};

/// Most positions of one result.
const MOST_POSITIONS: usize = 60;

fn predict(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let step = view.step(arguments.number("t"))?;
    let who = view.who(arguments.id("participant").unwrap_or(0))?;
    let (motion, body) = view.at(&who, step)?;
    let horizon = arguments.number("horizon").unwrap_or(3.0);
    let interval = arguments.number("interval").unwrap_or(0.5);
    let ego = match who {
        Who::Ego => None,
        Who::Other(..) => view.at(&Who::Ego, step).ok(),
    };
    // Half a microsecond covers the dust of binary fractions.
    let count = ((horizon + 5e-7) / interval).floor() as usize;
    if count > MOST_POSITIONS {
        return Err(ToolError::new(format!(
            "at most {MOST_POSITIONS} positions at once; choose a larger interval"
        )));
    }
    let position = |i: usize| {
        let after = i as f64 * interval;
        let there = moved(motion, after);
        let mut said = json!({
            "after": number(after),
            "x": number(there.position.x),
            "y": number(there.position.y),
        });
        if let Some((ego, ego_body)) = ego {
            let apart = body.at(there).distance(&ego_body.at(moved(ego, after)));
            said["distance_to_ego"] = number(apart);
        }
        said
    };
    let positions: Vec<Value> = (0..=count).map(position).collect();
    Ok(json!({"t": time(view.seconds(step)), "positions": positions}))
}

/// The pose after so many seconds of constant velocity.
fn moved(motion: &Motion, seconds: f64) -> Pose {
    Pose {
        position: motion.pose.position + motion.velocity_vector() * seconds,
        heading: motion.pose.heading,
    }
}
