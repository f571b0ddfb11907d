//! What is there, and how it moves.

use serde_json::{Value, json};

use super::lanes::LaneWords;
use super::view::{Who, number, time};
use super::{Argument, ArgumentKind, Arguments, Field, Tool, ToolError, WindowView};
use nearmiss_scene::metrics::{Direction, side_of_centre};

/// The moment that a tool computes at.
pub(super) const T: Argument = Argument {
    name: "t",
    kind: ArgumentKind::Number(-1e5, 1e5),
    unit: "s",
    required: false,
    about: "Time relative to the end of the described window, 0 or negative; 0 where it is left out.",
};

/// An obstacle by its id.
pub(super) const OBSTACLE: Argument = Argument {
    name: "obstacle",
    kind: ArgumentKind::Obstacle,
    unit: "",
    required: true,
    about: "Id of the obstacle.",
};

/// The ego or an obstacle.
pub(super) const PARTICIPANT: Argument = Argument {
    name: "participant",
    kind: ArgumentKind::Participant,
    unit: "",
    required: true,
    about: "Id of the obstacle, or 0 for the ego.",
};

/// The time that a result holds at.
pub(super) const AT: Field = Field::new(
    "t",
    "number",
    "s",
    "Time relative to the end of the described window.",
);

pub(super) const LIST_OBSTACLES: Tool = Tool {
    name: "list_obstacles",
    about: "Lists the obstacles near the ego at a moment, the nearest first: type, distance of the bodies, side, lane.",
    arguments: &[
        T,
        Argument {
            name: "radius",
            kind: ArgumentKind::Number(0.0, 1e4),
            unit: "m",
            required: false,
            about: "Obstacles whose body is farther from the ego's are left out; 100 where it is left out.",
        },
    ],
    result: &[
        AT,
        Field::list(
            "obstacles",
            "At most 40, the nearest first.",
            &[
                Field::new("id", "integer", "", "Its id."),
                Field::new("type", "string", "", "Its type, such as car or pedestrian."),
                Field::new(
                    "distance",
                    "number",
                    "m",
                    "Shortest distance of the two bodies.",
                ),
                Field::new("side", "string", "", "The side of the ego that it is on."),
                Field::new(
                    "lane",
                    "string",
                    "",
                    "What its lane is to the ego's; missing on maps without lanes.",
                ),
            ],
        ),
        Field::new(
            "more",
            "integer",
            "",
            "How many within the radius are left out of the list.",
        ),
    ],
    call: list_obstacles,
};

/// Most obstacles of a list: more no model follows.
const MOST: usize = 40;

fn list_obstacles(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let step = view.step(arguments.number("t"))?;
    let radius = arguments.number("radius").unwrap_or(100.0);
    let (ego, _) = view.at(&Who::Ego, step)?;
    let lanes = LaneWords::new(view, ego);
    let mut near: Vec<_> = view
        .there()
        .iter()
        .filter_map(|(place, p)| {
            view.at(&Who::Other(*place, *p), step).ok()?;
            let encounter = view.context().encounter(*place, step)?;
            let apart = encounter.ego_placed().distance(&encounter.other_placed());
            (apart <= radius).then_some((apart, p, encounter))
        })
        .collect();
    near.sort_by(|a, b| {
        a.0.total_cmp(&b.0)
            .then(a.1.obstacle.id.cmp(&b.1.obstacle.id))
    });
    let more = near.len().saturating_sub(MOST);
    let obstacles = near.iter().take(MOST).map(|(apart, p, encounter)| {
        let side = match encounter.relation().direction {
            // Whether bodies touch is told by their distance.
            Direction::Contact => side_of_centre(encounter),
            side => side,
        };
        let mut entry = json!({
            "id": p.obstacle.id,
            "type": p.obstacle.kind.name(),
            "distance": number(*apart),
            "side": side.name(),
        });
        if let Some(words) = lanes.of(encounter.other) {
            entry["lane"] = words.into();
        }
        entry
    });
    let obstacles: Vec<Value> = obstacles.collect();
    Ok(json!({"t": time(view.seconds(step)), "obstacles": obstacles, "more": more}))
}

pub(super) const GET_STATE: Tool = Tool {
    name: "get_state",
    about: "State of the ego or of an obstacle at a moment: position and heading on the map, speed, acceleration, size.",
    arguments: &[PARTICIPANT, T],
    result: &[
        AT,
        Field::new("x", "number", "m", "Position of the centre on the map."),
        Field::new("y", "number", "m", "Position of the centre on the map."),
        Field::new(
            "heading",
            "number",
            "°",
            "Counter-clockwise from the x axis of the map.",
        ),
        Field::new(
            "speed",
            "number",
            "m/s",
            "Along the heading; negative in reverse.",
        ),
        Field::new(
            "acceleration",
            "number",
            "m/s²",
            "Along the heading; missing where the described window does not tell it.",
        ),
        Field::new("length", "number", "m", "Length of the body."),
        Field::new("width", "number", "m", "Width of the body."),
    ],
    call: get_state,
};

fn get_state(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let step = view.step(arguments.number("t"))?;
    let who = view.who(arguments.id("participant").unwrap_or(0))?;
    let (motion, body) = view.at(&who, step)?;
    let (length, width) = body.shape().size();
    let mut state = json!({
        "t": time(view.seconds(step)),
        "x": number(motion.pose.position.x),
        "y": number(motion.pose.position.y),
        "heading": number(motion.pose.heading.to_degrees()),
        "speed": number(motion.velocity),
        "length": number(length),
        "width": number(width),
    });
    if view.knows_acceleration(&who, step) {
        state["acceleration"] = number(motion.acceleration);
    }
    Ok(state)
}
