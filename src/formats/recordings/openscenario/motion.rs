//! Motion in a storyboard: where entities begin, the trajectories they follow, when they appear and vanish.

use std::collections::HashMap;

use super::position::{has_heading, position_of, unread_position};
use crate::formats::commonroad::ReadError;
use crate::formats::recordings::opendrive::Network;
use crate::formats::recordings::opendrive::tree::Node;
use crate::geometry::{Pose, angle_between};

/// A trajectory with its times.
#[derive(Debug, Clone, Default)]
pub struct Followed {
    /// Seconds from the beginning, and poses.
    pub vertices: Vec<(f64, Pose)>,
}

/// What an entity does.
#[derive(Debug, Clone, Default)]
pub struct Motions {
    /// Where it begins.
    pub start: Option<Pose>,
    /// Its speed at first, m/s.
    pub speed: f64,
    pub followed: Vec<Followed>,
    /// Moments at which it appears and vanishes, seconds.
    pub appears: Vec<f64>,
    pub vanishes: Vec<f64>,
    /// Whether it is not there at first.
    pub is_late: bool,
    /// What it does that only a player works out, in words.
    pub other: Option<String>,
    /// Whether it has a controller, which may move it.
    pub is_controlled: bool,
}

impl Motions {
    /// Whether it begins with a speed and follows nothing, so that a driver under test drives it.
    pub fn is_free(&self) -> bool {
        self.followed.is_empty() && self.speed.abs() > 1e-3
    }
}

/// The end of a scenario, where it is a moment, seconds.
pub fn end(root: &Node) -> Option<f64> {
    moment(root.at(&["Storyboard", "StopTrigger"])?)
        .ok()
        .flatten()
}

/// The motions of all entities, by name.
pub fn motions(
    root: &Node,
    network: Option<&Network>,
) -> Result<HashMap<String, Motions>, ReadError> {
    let mut all: HashMap<String, Motions> = HashMap::new();
    let Some(board) = root.child("Storyboard") else {
        return Err(root.fail(without_storyboard(root)));
    };
    let init = board.at(&["Init", "Actions"]);
    for private in init.iter().flat_map(|i| i.all("Private")) {
        let name = private.needed("entityRef")?.to_string();
        for action in private.all("PrivateAction") {
            if let Some(position) = action.at(&["TeleportAction", "Position"]) {
                let starts: HashMap<&str, Pose> = all
                    .iter()
                    .filter_map(|(n, m)| Some((n.as_str(), m.start?)))
                    .collect();
                let unread = unread_position(position, &all);
                let pose = match &unread {
                    Some(_) => None,
                    None => Some(position_of(position, &starts, network)?),
                };
                let motion = all.entry(name.clone()).or_default();
                motion.start = pose;
                motion.other = unread.map(|word| format!("begins at a <{word}>"));
            }
        }
    }
    let starts: HashMap<String, Pose> = all
        .iter()
        .filter_map(|(n, m)| Some((n.clone(), m.start?)))
        .collect();
    for private in init.iter().flat_map(|i| i.all("Private")) {
        let name = private.needed("entityRef")?;
        for action in private.all("PrivateAction") {
            let motion = all.entry(name.to_string()).or_default();
            private_action(action, name, motion, &starts, network, 0.0, true)?;
        }
    }
    for global in init.iter().flat_map(|i| i.all("GlobalAction")) {
        entity_action(global, &mut all, 0.0, true)?;
    }
    for group in board.within("ManeuverGroup") {
        let actors = group
            .child("Actors")
            .into_iter()
            .flat_map(|a| a.all("EntityRef"));
        let actors: Result<Vec<&str>, ReadError> = actors.map(|a| a.needed("entityRef")).collect();
        let actors = actors?;
        for event in group.within("Event") {
            let at = event
                .child("StartTrigger")
                .map(moment)
                .transpose()?
                .flatten();
            for action in event.all("Action") {
                if let Some(global) = action.child("GlobalAction") {
                    entity_action(global, &mut all, at.unwrap_or(0.0), false)?;
                }
                let Some(private) = action.child("PrivateAction") else {
                    continue;
                };
                for actor in &actors {
                    let motion = all.entry((*actor).to_string()).or_default();
                    match at {
                        Some(at) => {
                            let late = appearance(motion, at);
                            let mut own = starts.clone();
                            own.extend(late.map(|pose| ((*actor).to_string(), pose)));
                            private_action(private, actor, motion, &own, network, at, false)?;
                        }
                        None if is_harmless(private) => {}
                        // What happens depends on the others.
                        None => motion.other = Some(moves_by(private)),
                    }
                }
            }
        }
    }
    Ok(all)
}

/// Where an entity is that appeared shortly before.
fn appearance(motion: &Motions, at: f64) -> Option<Pose> {
    let just = motion.appears.last().is_some_and(|a| (a - at).abs() < 1e-6);
    motion.start.filter(|_| just)
}

/// The moment at which a trigger fires; nothing where it asks for something else.
fn moment(trigger: &Node) -> Result<Option<f64>, ReadError> {
    let conditions = trigger.within("Condition");
    let [condition] = conditions[..] else {
        return Ok(None);
    };
    let Some(time) = condition.at(&["ByValueCondition", "SimulationTimeCondition"]) else {
        return Ok(None);
    };
    let delay = condition.or_zero("delay")?;
    Ok(Some(time.needed_number("value")? + delay))
}

fn entity_action(
    global: &Node,
    all: &mut HashMap<String, Motions>,
    at: f64,
    is_first: bool,
) -> Result<(), ReadError> {
    let Some(action) = global.child("EntityAction") else {
        return Ok(());
    };
    let motion = all
        .entry(action.needed("entityRef")?.to_string())
        .or_default();
    if let Some(added) = action.child("AddEntityAction") {
        motion.appears.push(at);
        if let Some(position) = added.child("Position") {
            motion.start = Some(position_of(position, &HashMap::new(), None)?);
        }
    }
    if action.child("DeleteEntityAction").is_some() {
        match is_first {
            true => motion.is_late = true,
            false => motion.vanishes.push(at),
        }
    }
    Ok(())
}

fn action_name(action: &Node) -> String {
    let mut node = action;
    while let Some(child) = node.children.first() {
        node = child;
        if node.name != "RoutingAction"
            && node.name != "LongitudinalAction"
            && node.name != "LateralAction"
        {
            break;
        }
    }
    node.name.clone()
}

fn private_action(
    action: &Node,
    actor: &str,
    motion: &mut Motions,
    starts: &HashMap<String, Pose>,
    network: Option<&Network>,
    at: f64,
    is_first: bool,
) -> Result<(), ReadError> {
    if action.child("TeleportAction").is_some() && is_first {
        return Ok(());
    }
    if let Some(speed) = action.at(&["LongitudinalAction", "SpeedAction"])
        && is_first
    {
        let target = speed.at(&["SpeedActionTarget", "AbsoluteTargetSpeed"]);
        motion.speed = target.map_or(Ok(0.0), |t| t.or_zero("value"))?;
        return Ok(());
    }
    if is_harmless(action) {
        let controllers = ["ControllerAction", "ActivateControllerAction"];
        motion.is_controlled |= controllers.iter().any(|name| action.child(name).is_some());
        return Ok(());
    }
    let Some(follow) = action.at(&["RoutingAction", "FollowTrajectoryAction"]) else {
        motion.other = Some(moves_by(action));
        return Ok(());
    };
    match followed(follow, actor, starts, network, at)? {
        Some(followed) => motion.followed.push(followed),
        None => motion.other = Some(follows(follow)),
    }
    Ok(())
}

/// Controllers, visibility, lights and the like do not move an entity by themselves.
fn is_harmless(action: &Node) -> bool {
    let harmless = [
        "ControllerAction",
        "VisibilityAction",
        "ActivateControllerAction",
        "AppearanceAction",
    ];
    harmless.iter().any(|name| action.child(name).is_some())
}

fn moves_by(action: &Node) -> String {
    format!("moves by <{}>", action_name(action))
}

/// How it follows a trajectory that is not worked out here.
fn follows(follow: &Node) -> String {
    let shapes = follow.within("Shape");
    let shape = shapes.first().and_then(|s| s.children.first());
    match shape.map(|s| s.name.as_str()) {
        None => "follows a trajectory of a catalog".into(),
        Some("Polyline") => "follows a trajectory without times".into(),
        Some(other) => format!("follows a trajectory along a <{other}>"),
    }
}

/// Why a document without a storyboard is no scenario.
fn without_storyboard(root: &Node) -> String {
    if let Some(named) = root.at(&["ParameterValueDistribution", "ScenarioFile"]) {
        let file = named.text("filepath").unwrap_or_default();
        return format!("values for the parameters of a scenario, not a scenario: open `{file}`");
    }
    match root.child("Catalog") {
        Some(_) => "a catalog, not a scenario".into(),
        None => "no <Storyboard> in it".into(),
    }
}

fn followed(
    follow: &Node,
    actor: &str,
    starts: &HashMap<String, Pose>,
    network: Option<&Network>,
    at: f64,
) -> Result<Option<Followed>, ReadError> {
    let trajectory = follow.child("Trajectory");
    let Some(trajectory) = trajectory.or_else(|| follow.at(&["TrajectoryRef", "Trajectory"]))
    else {
        return Ok(None);
    };
    let Some(line) = trajectory.at(&["Shape", "Polyline"]) else {
        return Ok(None);
    };
    let Some(timing) = follow.at(&["TimeReference", "Timing"]) else {
        return Ok(None);
    };
    let (scale, mut offset) = (
        timing.number("scale")?.unwrap_or(1.0),
        timing.or_zero("offset")?,
    );
    if timing.text("domainAbsoluteRelative") == Some("relative") {
        offset += at;
    }
    let starts: HashMap<&str, Pose> = starts.iter().map(|(n, p)| (n.as_str(), *p)).collect();
    let mut vertices: Vec<(f64, Pose, bool)> = Vec::new();
    for vertex in line.all("Vertex") {
        let time = vertex.needed_number("time")? * scale + offset;
        let position = vertex
            .child("Position")
            .ok_or_else(|| vertex.fail("no <Position> in it"))?;
        // The first vertex is where the others are told from.
        let mut known = starts.clone();
        if let Some((_, first, _)) = vertices.first() {
            known.insert(actor, *first);
        }
        let pose = position_of(position, &known, network)?;
        vertices.push((time, pose, has_heading(position)));
    }
    vertices.sort_by(|a, b| a.0.total_cmp(&b.0));
    Ok(Some(Followed {
        vertices: with_headings(vertices),
    }))
}

/// Vertices without a heading look where they go.
fn with_headings(vertices: Vec<(f64, Pose, bool)>) -> Vec<(f64, Pose)> {
    let mut held = None;
    let mut all = Vec::with_capacity(vertices.len());
    for (i, (time, pose, told)) in vertices.iter().enumerate() {
        let mut pose = *pose;
        if !told {
            let next = vertices.get(i + 1).map(|n| n.1.position - pose.position);
            let before = i
                .checked_sub(1)
                .map(|b| pose.position - vertices[b].1.position);
            let moved = [next, before]
                .into_iter()
                .flatten()
                .find(|v| v.norm() > 1e-3);
            let looks = moved.map(|v| v.y.atan2(v.x)).or(held);
            pose.heading = looks.unwrap_or(pose.heading);
        }
        held = Some(pose.heading);
        all.push((*time, pose));
    }
    all
}

impl Followed {
    /// The pose at a moment; nothing before its first and after its last vertex.
    pub fn at(&self, time: f64) -> Option<Pose> {
        const SAME: f64 = 1e-6;
        let next = self.vertices.partition_point(|(t, _)| *t <= time + SAME);
        let (t, pose) = self.vertices.get(next.checked_sub(1)?)?;
        let Some((then, to)) = self.vertices.get(next) else {
            return (time - t < SAME).then_some(*pose);
        };
        if time - t < SAME {
            return Some(*pose);
        }
        let share = (time - t) / (then - t);
        Some(Pose {
            position: pose.position + (to.position - pose.position) * share,
            heading: pose.heading + angle_between(pose.heading, to.heading) * share,
        })
    }
}
