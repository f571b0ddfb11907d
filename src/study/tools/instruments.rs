//! What is there, how it moves, and lanes: what an obstacle's lane is to the ego's, and where a lane leads.

use nearmiss_scene::metrics::{Direction, side_of_centre};
use nearmiss_scene::scenario::{LaneRelation, LaneRelations, LaneletNetwork, Motion};
use serde_json::{Value, json};

use super::view::{Who, number, time};
use super::{Argument, ArgumentKind, Arguments, Field, Tool, ToolError, WindowView};

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
const MAX_ROWS: usize = 40;

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
    let more = near.len().saturating_sub(MAX_ROWS);
    let obstacles = near.iter().take(MAX_ROWS).map(|(apart, p, encounter)| {
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
        if let Some(words) = lanes.name(encounter.other) {
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
    let who = view.participant(arguments.id("participant").unwrap_or(0))?;
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

pub(super) const LANE_RELATION: Tool = Tool {
    name: "lane_relation",
    about: "What the lane under an obstacle is to the ego's lane at a moment, and how far each is from the middle of its lane.",
    arguments: &[OBSTACLE, T],
    result: &[
        AT,
        Field::new(
            "lane",
            "string",
            "",
            "Same lane, same lane ahead, left neighbour lane, oncoming lane, crossing lane, …",
        ),
        Field::new(
            "ego_offset",
            "number",
            "m",
            "The ego left of the middle of its lane; missing off the road.",
        ),
        Field::new(
            "obstacle_offset",
            "number",
            "m",
            "The obstacle left of the middle of its lane; missing off the road.",
        ),
        Field::new(
            "none",
            "string",
            "",
            "Why there is no relation; missing where there is one.",
        ),
    ],
    call: lane_relation,
};

fn lane_relation(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let step = view.step(arguments.number("t"))?;
    let who = view.participant(arguments.id("obstacle").unwrap_or(0))?;
    if matches!(who, Who::Ego) {
        return Err(ToolError::new(
            "name an obstacle; its lane is related to the ego's",
        ));
    }
    let (ego, _) = view.at(&Who::Ego, step)?;
    let (other, _) = view.at(&who, step)?;
    let network = &view.context().scene().scenario.network;
    let mut said = json!({"t": time(view.seconds(step))});
    match LaneWords::new(view, ego).name(other) {
        Some(words) => said["lane"] = words.into(),
        None => said["none"] = "the map has no lanes".into(),
    }
    for (key, motion) in [("ego_offset", ego), ("obstacle_offset", other)] {
        if let Some(offset) = network.lane_offset(&motion.pose) {
            said[key] = number(offset);
        }
    }
    Ok(said)
}

/// What lanes are to the one under the ego at a moment, in the words of descriptions.
pub(super) struct LaneWords<'s> {
    network: &'s LaneletNetwork,
    /// Nothing where the ego is on no lane.
    relations: Option<LaneRelations<'s>>,
}

impl<'s> LaneWords<'s> {
    pub fn new(view: &WindowView<'s>, ego: &Motion) -> Self {
        let network = &view.context().scene().scenario.network;
        let ours = network.lanelets_driven(&ego.pose);
        let relations = (!ours.is_empty()).then(|| network.lane_relations(&ours));
        Self { network, relations }
    }

    /// The words for the lane under another; nothing on maps without lanes.
    pub fn name(&self, other: &Motion) -> Option<&'static str> {
        if self.network.lanelets.is_empty() {
            return None;
        }
        let theirs = self.network.lanelets_driven(&other.pose);
        if theirs.is_empty() {
            return Some("off the road");
        }
        match &self.relations {
            Some(relations) => {
                let all = theirs.iter().map(|id| relations.relation_to(*id));
                all.min().map(LaneRelation::text)
            }
            None => Some("on the road"),
        }
    }
}

pub(super) const POSITIONS_AHEAD: Tool = Tool {
    name: "positions_ahead",
    about: "Points of the middle of the lane ahead of the ego or of an obstacle, straight on where it forks, at equal \
            distances along the lane.",
    arguments: &[
        PARTICIPANT,
        T,
        Argument {
            name: "distance",
            kind: ArgumentKind::Number(1.0, 200.0),
            unit: "m",
            required: false,
            about: "How far ahead; 50 where it is left out.",
        },
        Argument {
            name: "spacing",
            kind: ArgumentKind::Number(1.0, 100.0),
            unit: "m",
            required: false,
            about: "Between two points; 10 where it is left out.",
        },
    ],
    result: &[
        AT,
        Field::list(
            "points",
            "From the participant on.",
            &[
                Field::new("s", "number", "m", "Distance along the lane."),
                Field::new("x", "number", "m", "Position on the map."),
                Field::new("y", "number", "m", "Position on the map."),
                Field::new(
                    "heading",
                    "number",
                    "°",
                    "Of the lane, counter-clockwise from the x axis.",
                ),
            ],
        ),
        Field::new(
            "none",
            "string",
            "",
            "Why there are no points; missing where there are some.",
        ),
    ],
    call: positions_ahead,
};

/// Most points of one result.
const MOST_POINTS: usize = 60;

fn positions_ahead(view: &WindowView<'_>, arguments: &Arguments) -> Result<Value, ToolError> {
    let step = view.step(arguments.number("t"))?;
    let who = view.participant(arguments.id("participant").unwrap_or(0))?;
    let (motion, _) = view.at(&who, step)?;
    let distance = arguments.number("distance").unwrap_or(50.0);
    let spacing = arguments.number("spacing").unwrap_or(10.0);
    let graph = view.context().scene().scenario.network.lane_graph(None);
    let t = time(view.seconds(step));
    let route = match graph.road_ahead(&motion.pose, distance) {
        Ok(route) => route,
        Err(why) => return Ok(json!({"t": t, "none": why.to_string()})),
    };
    let reach = route.length().min(distance);
    let count = (reach / spacing).floor() as usize;
    if count > MOST_POINTS {
        return Err(ToolError::new(format!(
            "at most {MOST_POINTS} points at once; choose a larger spacing"
        )));
    }
    let point = |i: usize| {
        let s = i as f64 * spacing;
        let pose = route.path.pose_at(route.start + s);
        json!({
            "s": number(s),
            "x": number(pose.position.x),
            "y": number(pose.position.y),
            "heading": number(pose.heading.to_degrees()),
        })
    };
    let points: Vec<Value> = (0..=count).map(point).collect();
    Ok(json!({"t": t, "points": points}))
}
