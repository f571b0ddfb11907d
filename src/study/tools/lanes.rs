//! Lanes: what an obstacle's lane is to the ego's, and where a lane leads.

use serde_json::{Value, json};

use super::instruments::{AT, OBSTACLE, PARTICIPANT, T};
use super::view::{Who, number, time};
use super::{Argument, ArgumentKind, Arguments, Field, Tool, ToolError, WindowView};
use nearmiss_scene::scenario::{LaneRelation, LaneRelations, LaneletNetwork, Motion};

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
    let who = view.who(arguments.id("obstacle").unwrap_or(0))?;
    if matches!(who, Who::Ego) {
        return Err(ToolError::new(
            "name an obstacle; its lane is related to the ego's",
        ));
    }
    let (ego, _) = view.at(&Who::Ego, step)?;
    let (other, _) = view.at(&who, step)?;
    let network = &view.context().scene().scenario.network;
    let mut said = json!({"t": time(view.seconds(step))});
    match LaneWords::new(view, ego).of(other) {
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
    pub fn of(&self, other: &Motion) -> Option<&'static str> {
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
    let who = view.who(arguments.id("participant").unwrap_or(0))?;
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
