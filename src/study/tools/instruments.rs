//! What is there, how it moves, and lanes: what an obstacle's lane is to the ego's, and where a lane leads.

use nearmiss_scene::metrics::{Direction, side_of_centre};
use nearmiss_scene::scenario::{LaneRelation, LaneRelations, LaneletNetwork, Motion};
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::{ObstacleId, ParticipantId};
use super::view::{Who, number, time};
use super::{Tool, ToolError, WindowView, answer, tool};

/// Arguments of a tool that computes at a moment; its time stands between the first and the last of them.
macro_rules! at_a_moment {
    ($name:ident { $($first:tt)* } $($last:tt)*) => {
        nearmiss_record::fields! {
            /// Arguments of a tool.
            pub struct $name {
                "arguments" {
                    $($first)*
                    /// Time relative to the end of the described window, 0 or negative; 0 where it is left out.
                    t: Option<f64>, Takes::Number(-1e5, 1e5), "s";
                    $($last)*
                }
            }
        }
    };
}
pub(super) use at_a_moment;

at_a_moment! {
    Around {}
    /// Obstacles whose body is farther from the ego's are left out; 100 where it is left out.
    radius: f64 = 100.0, Takes::Number(0.0, 1e4), "m";
}

#[derive(Serialize, JsonSchema)]
struct Obstacles {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// At most 40, the nearest first.
    obstacles: Vec<Near>,
    /// How many within the radius are left out of the list.
    more: usize,
}

#[derive(Serialize, JsonSchema)]
struct Near {
    /// Its id.
    id: i64,
    /// Its type, such as car or pedestrian.
    r#type: &'static str,
    /// Shortest distance of the two bodies.
    #[schemars(extend("unit" = "m"))]
    distance: f64,
    /// The side of the ego that it is on.
    side: &'static str,
    /// What its lane is to the ego's; missing on maps without lanes.
    #[serde(skip_serializing_if = "Option::is_none")]
    lane: Option<&'static str>,
}

pub(super) const LIST_OBSTACLES: Tool = tool::<Around, Obstacles>(
    "list_obstacles",
    "Lists the obstacles near the ego at a moment, the nearest first: type, distance of the bodies, side, lane.",
    |view, text| answer(view, text, list_obstacles),
);

/// Most obstacles of a list: more no model follows.
const MAX_ROWS: usize = 40;

fn list_obstacles(view: &WindowView<'_>, arguments: &Around) -> Result<Obstacles, ToolError> {
    let step = view.step(arguments.t)?;
    let (ego, _) = view.at(&Who::Ego, step)?;
    let lanes = LaneWords::new(view, ego);
    let mut near: Vec<_> = view
        .there()
        .iter()
        .filter_map(|(place, p)| {
            view.at(&Who::Other(*place, *p), step).ok()?;
            let encounter = view.context().encounter(*place, step)?;
            let apart = encounter.ego_placed().distance(&encounter.other_placed());
            (apart <= arguments.radius).then_some((apart, p, encounter))
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
        Near {
            id: p.obstacle.id,
            r#type: p.obstacle.kind.name(),
            distance: number(*apart),
            side: side.name(),
            lane: lanes.name(encounter.other),
        }
    });
    Ok(Obstacles {
        t: time(view.seconds(step)),
        obstacles: obstacles.collect(),
        more,
    })
}

at_a_moment! {
    OfOne {
        /// Id of the obstacle, or 0 for the ego.
        participant [required]: ParticipantId;
    }
}

#[derive(Serialize, JsonSchema)]
struct State {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// Position of the centre on the map.
    #[schemars(extend("unit" = "m"))]
    x: f64,
    /// Position of the centre on the map.
    #[schemars(extend("unit" = "m"))]
    y: f64,
    /// Counter-clockwise from the x axis of the map.
    #[schemars(extend("unit" = "°"))]
    heading: f64,
    /// Along the heading; negative in reverse.
    #[schemars(extend("unit" = "m/s"))]
    speed: f64,
    /// Length of the body.
    #[schemars(extend("unit" = "m"))]
    length: f64,
    /// Width of the body.
    #[schemars(extend("unit" = "m"))]
    width: f64,
    /// Along the heading; missing where the described window does not tell it.
    #[schemars(extend("unit" = "m/s²"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    acceleration: Option<f64>,
}

pub(super) const GET_STATE: Tool = tool::<OfOne, State>(
    "get_state",
    "State of the ego or of an obstacle at a moment: position and heading on the map, speed, acceleration, size.",
    |view, text| answer(view, text, get_state),
);

fn get_state(view: &WindowView<'_>, arguments: &OfOne) -> Result<State, ToolError> {
    let step = view.step(arguments.t)?;
    let who = view.participant(arguments.participant.0)?;
    let (motion, body) = view.at(&who, step)?;
    let (length, width) = body.shape().size();
    let is_known = view.knows_acceleration(&who, step);
    Ok(State {
        t: time(view.seconds(step)),
        x: number(motion.pose.position.x),
        y: number(motion.pose.position.y),
        heading: number(motion.pose.heading.to_degrees()),
        speed: number(motion.velocity),
        length: number(length),
        width: number(width),
        acceleration: is_known.then(|| number(motion.acceleration)),
    })
}

at_a_moment! {
    OfObstacle {
        /// Id of the obstacle.
        obstacle [required]: ObstacleId;
    }
}

#[derive(Serialize, JsonSchema)]
struct Related {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// Same lane, same lane ahead, left neighbour lane, oncoming lane, crossing lane, …
    #[serde(skip_serializing_if = "Option::is_none")]
    lane: Option<&'static str>,
    /// The ego left of the middle of its lane; missing off the road.
    #[schemars(extend("unit" = "m"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    ego_offset: Option<f64>,
    /// The obstacle left of the middle of its lane; missing off the road.
    #[schemars(extend("unit" = "m"))]
    #[serde(skip_serializing_if = "Option::is_none")]
    obstacle_offset: Option<f64>,
    /// Why there is no relation; missing where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    none: Option<&'static str>,
}

pub(super) const LANE_RELATION: Tool = tool::<OfObstacle, Related>(
    "lane_relation",
    "What the lane under an obstacle is to the ego's lane at a moment, and how far each is from the middle of its lane.",
    |view, text| answer(view, text, lane_relation),
);

fn lane_relation(view: &WindowView<'_>, arguments: &OfObstacle) -> Result<Related, ToolError> {
    let step = view.step(arguments.t)?;
    let who = view.participant(arguments.obstacle.0)?;
    if matches!(who, Who::Ego) {
        return Err(ToolError::new(
            "name an obstacle; its lane is related to the ego's",
        ));
    }
    let (ego, _) = view.at(&Who::Ego, step)?;
    let (other, _) = view.at(&who, step)?;
    let network = &view.context().scene().scenario.network;
    let lane = LaneWords::new(view, ego).name(other);
    Ok(Related {
        t: time(view.seconds(step)),
        lane,
        ego_offset: network.lane_offset(&ego.pose).map(number),
        obstacle_offset: network.lane_offset(&other.pose).map(number),
        none: lane.is_none().then_some("the map has no lanes"),
    })
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

at_a_moment! {
    Ahead {
        /// Id of the obstacle, or 0 for the ego.
        participant [required]: ParticipantId;
    }
    /// How far ahead; 50 where it is left out.
    distance: f64 = 50.0, Takes::Number(1.0, 200.0), "m";
    /// Between two points; 10 where it is left out.
    spacing: f64 = 10.0, Takes::Number(1.0, 100.0), "m";
}

#[derive(Serialize, JsonSchema)]
struct Points {
    /// Time relative to the end of the described window.
    #[schemars(extend("unit" = "s"))]
    t: f64,
    /// From the participant on.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    points: Vec<LanePoint>,
    /// Why there are no points; missing where there are some.
    #[serde(skip_serializing_if = "Option::is_none")]
    none: Option<String>,
}

#[derive(Serialize, JsonSchema)]
struct LanePoint {
    /// Distance along the lane.
    #[schemars(extend("unit" = "m"))]
    s: f64,
    /// Position on the map.
    #[schemars(extend("unit" = "m"))]
    x: f64,
    /// Position on the map.
    #[schemars(extend("unit" = "m"))]
    y: f64,
    /// Of the lane, counter-clockwise from the x axis.
    #[schemars(extend("unit" = "°"))]
    heading: f64,
}

pub(super) const POSITIONS_AHEAD: Tool = tool::<Ahead, Points>(
    "positions_ahead",
    "Points of the middle of the lane ahead of the ego or of an obstacle, straight on where it forks, at equal distances \
     along the lane.",
    |view, text| answer(view, text, positions_ahead),
);

/// Most points of one result.
const MOST_POINTS: usize = 60;

fn positions_ahead(view: &WindowView<'_>, arguments: &Ahead) -> Result<Points, ToolError> {
    let step = view.step(arguments.t)?;
    let who = view.participant(arguments.participant.0)?;
    let (motion, _) = view.at(&who, step)?;
    let (distance, spacing) = (arguments.distance, arguments.spacing);
    let graph = view.context().scene().scenario.network.lane_graph(None);
    let mut found = Points {
        t: time(view.seconds(step)),
        points: Vec::new(),
        none: None,
    };
    let route = match graph.road_ahead(&motion.pose, distance) {
        Ok(route) => route,
        Err(why) => {
            found.none = Some(why.to_string());
            return Ok(found);
        }
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
        LanePoint {
            s: number(s),
            x: number(pose.position.x),
            y: number(pose.position.y),
            heading: number(pose.heading.to_degrees()),
        }
    };
    found.points = (0..=count).map(point).collect();
    Ok(found)
}
