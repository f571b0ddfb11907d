//! The storyboard: where entities begin, the trajectories they follow, when they appear and vanish.

use std::collections::HashMap;

use nearmiss_base::geometry::Pose;

use super::motion::{Fires, Motions, fires, start};
use super::trajectory::{Followed, TimedVertex, has_heading, position_of, unread_position};
use crate::commonroad::ReadError;
use crate::recordings::Report;
use crate::recordings::opendrive::Network;
use crate::recordings::opendrive::tree::Node;

/// The end of a scenario, where it is a moment, seconds.
pub fn end(root: &Node) -> Option<f64> {
    match fires(root.at(&["Storyboard", "StopTrigger"])?) {
        Ok(Fires::At(moment)) => Some(moment),
        _ => None,
    }
}

/// Motions of entities by name.
pub type AllMotions = HashMap<String, Motions>;

/// What is known while the storyboard is read.
struct Reader<'a> {
    network: Option<&'a Network>,
    report: &'a Report,
    all: AllMotions,
    /// Entities of which something is told later than at the beginning from where others are, and these.
    told_from: Vec<(String, String)>,
}

/// The motions of all entities.
pub fn motions(
    root: &Node,
    network: Option<&Network>,
    report: &Report,
) -> Result<AllMotions, ReadError> {
    let Some(board) = root.child("Storyboard") else {
        return Err(root.fail(without_storyboard(root)));
    };
    let mut reader = Reader {
        network,
        report,
        all: HashMap::new(),
        told_from: Vec::new(),
    };
    if let Some(init) = board.at(&["Init", "Actions"]) {
        reader.begin(init)?;
    }
    for act in board.within("Act") {
        let begins = start(act)?;
        for group in act.all("ManeuverGroup") {
            reader.group(group, begins)?;
        }
    }
    reader.finish();
    Ok(reader.all)
}

impl Reader<'_> {
    fn begin(&mut self, init: &Node) -> Result<(), ReadError> {
        let mut placed = Vec::new();
        for private in init.all("Private") {
            let name = private.needed("entityRef")?;
            for action in private
                .all("PrivateAction")
                .filter(|a| a.has("TeleportAction"))
            {
                if let Some(position) = action.at(&["TeleportAction", "Position"]) {
                    placed.push((name, position));
                }
            }
        }
        self.place(placed)?;
        for global in init.all("GlobalAction") {
            self.entity_action(global, None)?;
        }
        for private in init.all("Private") {
            let name = private.needed("entityRef")?;
            for action in private.all("PrivateAction") {
                self.all.entry(name.to_string()).or_default();
                if !action.has("TeleportAction") && !self.first_speed(action, name)? {
                    self.private_action(action, name, 0.0)?;
                }
            }
        }
        Ok(())
    }

    /// Places entities, those that others are told from first, whatever their order in the file.
    fn place(&mut self, mut open: Vec<(&str, &Node)>) -> Result<(), ReadError> {
        while !open.is_empty() {
            let waits = |(name, position): &(&str, &Node)| {
                let base = position.children().next().and_then(|p| p.text("entityRef"));
                base.is_some_and(|base| base != *name && open.iter().any(|(n, _)| *n == base))
            };
            let (later, ready): (Vec<_>, Vec<_>) = open.iter().copied().partition(waits);
            if let ([(name, position), ..], []) = (&later[..], &ready[..]) {
                return Err(position.fail(format!(
                    "the position of `{name}` is told from another entity whose position is told from it in turn"
                )));
            }
            for (name, position) in ready {
                let unread = unread_position(position, &self.all);
                let pose = match unread {
                    Some(_) => None,
                    None => Some(self.pose(position, None, 0.0)?),
                };
                let motion = self.all.entry(name.to_string()).or_default();
                motion.start = pose;
                motion.other = unread.map(|word| format!("begins at a <{word}>"));
            }
            open = later;
        }
        Ok(())
    }

    /// The pose of a position at a moment; `own` is an entity with where it is.
    fn pose(&self, position: &Node, own: Option<(&str, Pose)>, at: f64) -> Result<Pose, ReadError> {
        let known = |name: &str| match own {
            Some((own, pose)) if own == name => Some(pose),
            _ => self.all.get(name)?.pose_at(at),
        };
        position_of(position, &known, self.network, self.report)
    }

    /// Whether an action of the beginning is a speed, which is taken then.
    fn first_speed(&mut self, action: &Node, actor: &str) -> Result<bool, ReadError> {
        if !action.has("LongitudinalAction") {
            return Ok(false);
        }
        let target = [
            "LongitudinalAction",
            "SpeedAction",
            "SpeedActionTarget",
            "AbsoluteTargetSpeed",
        ];
        let Some(target) = action.at(&target) else {
            return Ok(false);
        };
        let speed = target.or_zero("value")?;
        if let Some(dynamics) =
            action.at(&["LongitudinalAction", "SpeedAction", "SpeedActionDynamics"])
        {
            // Whether it takes time does not matter: what has a speed at first is driven by a player.
            dynamics.skip();
        }
        self.all.entry(actor.to_string()).or_default().speed = speed;
        Ok(true)
    }

    fn group(&mut self, group: &Node, begins: Fires) -> Result<(), ReadError> {
        let actors = group
            .child("Actors")
            .into_iter()
            .flat_map(|a| a.all("EntityRef"));
        let actors: Result<Vec<&str>, ReadError> = actors.map(|a| a.needed("entityRef")).collect();
        let actors = actors?;
        group.takes("maximumExecutionCount", "1");
        if group.has("CatalogReference") && begins != Fires::Never {
            for actor in &actors {
                let motion = self.all.entry((*actor).to_string()).or_default();
                motion.other = Some("acts by a maneuver of a catalog".into());
            }
        }
        for event in group.within("Event") {
            event.takes("maximumExecutionCount", "1");
            // Later actions take over from earlier ones.
            for priority in ["override", "overwrite", "parallel"] {
                event.takes("priority", priority);
            }
            let fires = begins.and(start(event)?);
            for action in event.all("Action") {
                match (action.child("GlobalAction"), fires) {
                    (Some(global), Fires::At(at)) => self.entity_action(global, Some(at))?,
                    (Some(global), Fires::Depends) => self.entity_depends(global)?,
                    _ => {}
                }
                let Some(private) = action.child("PrivateAction") else {
                    continue;
                };
                for actor in &actors {
                    match fires {
                        Fires::At(at) => self.private_action(private, actor, at)?,
                        Fires::Never => {}
                        // What happens depends on the others.
                        Fires::Depends => self.depends(private, actor),
                    }
                }
            }
        }
        Ok(())
    }

    fn depends(&mut self, private: &Node, actor: &str) {
        let motion = self.all.entry(actor.to_string()).or_default();
        if is_harmless(private) {
            motion.is_controlled |= activates(private)
        } else {
            motion.other = Some(moves_by(private))
        }
    }

    /// Entities that appear or vanish; at the beginning without a moment.
    fn entity_action(&mut self, global: &Node, at: Option<f64>) -> Result<(), ReadError> {
        let Some(action) = entity_action(global) else {
            return Ok(());
        };
        let name = action.needed("entityRef")?;
        let moment = at.unwrap_or(0.0);
        if let Some(added) = action.child("AddEntityAction") {
            let position = added.child("Position");
            let unread = position.and_then(|p| unread_position(p, &self.all));
            let pose = match (position, &unread) {
                (Some(position), None) => {
                    self.note_base(position, name, moment);
                    Some(self.pose(position, None, moment)?)
                }
                _ => None,
            };
            let motion = self.all.entry(name.to_string()).or_default();
            motion.appears.push(moment);
            motion.placed.extend(pose.map(|pose| (moment, pose)));
            if let Some(word) = unread {
                motion.other = Some(format!("appears at a <{word}>"));
            }
        }
        if action.child("DeleteEntityAction").is_some() {
            let motion = self.all.entry(name.to_string()).or_default();
            match at {
                None => motion.is_late = true,
                Some(at) => motion.vanishes.push(at),
            }
        }
        Ok(())
    }

    /// Entities that appear or vanish when something happens that only a player works out.
    fn entity_depends(&mut self, global: &Node) -> Result<(), ReadError> {
        let Some(action) = entity_action(global) else {
            return Ok(());
        };
        let motion = self
            .all
            .entry(action.needed("entityRef")?.to_string())
            .or_default();
        let does = if action.has("AddEntityAction") {
            "appears"
        } else {
            "vanishes"
        };
        motion.other = Some(format!("{does} when something else happens"));
        Ok(())
    }

    fn private_action(&mut self, action: &Node, actor: &str, at: f64) -> Result<(), ReadError> {
        if is_harmless(action) {
            let motion = self.all.entry(actor.to_string()).or_default();
            motion.is_controlled |= activates(action);
            return Ok(());
        }
        let follow = action.first(|a| a.name == "RoutingAction" && a.has("FollowTrajectoryAction"));
        let found = match follow.and_then(|a| a.child("FollowTrajectoryAction")) {
            Some(follow) => self.followed(follow, actor, at)?,
            None => Err(moves_by(action)),
        };
        let motion = self.all.entry(actor.to_string()).or_default();
        match found {
            Ok(followed) => motion.followed.push(followed),
            Err(words) => motion.other = Some(words),
        }
        Ok(())
    }

    /// A trajectory; words where only a player works it out.
    fn followed(
        &mut self,
        follow: &Node,
        actor: &str,
        at: f64,
    ) -> Result<Result<Followed, String>, ReadError> {
        let trajectory = follow.child("Trajectory");
        let Some(trajectory) = trajectory.or_else(|| follow.at(&["TrajectoryRef", "Trajectory"]))
        else {
            return Ok(Err("follows a trajectory of a catalog".into()));
        };
        let shape = trajectory.child("Shape").and_then(|s| s.children().next());
        let line = match shape {
            Some(line) if line.name == "Polyline" => line,
            Some(other) => {
                return Ok(Err(format!(
                    "follows a trajectory along a <{}>",
                    other.name
                )));
            }
            None => return Err(trajectory.fail("no <Shape> in it")),
        };
        let without_times = || Ok(Err("follows a trajectory without times".into()));
        let Some(timing) = follow.at(&["TimeReference", "Timing"]) else {
            return without_times();
        };
        if follow.or_zero("initialDistanceOffset")? != 0.0 {
            return Ok(Err("begins amid a trajectory".into()));
        }
        let (scale, mut offset) = (
            timing.number("scale")?.unwrap_or(1.0),
            timing.or_zero("offset")?,
        );
        if timing.text("domainAbsoluteRelative") == Some("relative") {
            offset += at;
        }
        if let Some(mode) = follow.child("TrajectoryFollowingMode") {
            mode.takes("followingMode", "position");
        }
        let own = self.all.get(actor).and_then(|m| m.pose_at(at));
        let mut told: Vec<TimedVertex> = Vec::new();
        for vertex in line.all("Vertex") {
            let Some(time) = vertex.number("time")? else {
                return without_times();
            };
            let position = vertex
                .child("Position")
                .ok_or_else(|| vertex.fail("no <Position> in it"))?;
            if let Some(word) = unread_position(position, &self.all) {
                return Ok(Err(format!("follows a trajectory through a <{word}>")));
            }
            self.note_base(position, actor, at);
            // What tells no place before follows from the first vertex.
            let own = own.or(told.first().map(|first| first.pose));
            let pose = self.pose(position, own.map(|pose| (actor, pose)), at)?;
            let time = time * scale + offset;
            if let Some(before) = told.last().filter(|before| time < before.time) {
                return Err(vertex.fail(format!(
                    "a vertex at {time} s after one at {} s: times of a trajectory do not decrease",
                    before.time
                )));
            }
            told.push(TimedVertex {
                time,
                pose,
                has_heading: has_heading(position),
            });
        }
        Followed::through(told, at)
            .map(Ok)
            .ok_or_else(|| line.fail("no <Vertex> in it"))
    }

    /// Notes that something later than the beginning is told from where another entity is then.
    fn note_base(&mut self, position: &Node, actor: &str, at: f64) {
        let base = position.children().next().and_then(|p| p.text("entityRef"));
        if let Some(base) = base.filter(|base| *base != actor && at > 0.0) {
            self.told_from.push((actor.to_string(), base.to_string()));
        }
    }

    /// Where something was told from an entity that moves, only a player works it out.
    fn finish(&mut self) {
        for (actor, base) in std::mem::take(&mut self.told_from) {
            let stands = |m: &Motions| m.followed.is_empty() && m.unknown().is_none();
            if self.all.get(&base).is_some_and(stands) {
                continue;
            }
            let motion = self.all.entry(actor).or_default();
            let moves = || format!("moves from where `{base}` is then");
            motion.other.get_or_insert_with(moves);
        }
    }
}

/// The action of a global one that lets entities appear or vanish.
fn entity_action(global: &Node) -> Option<&Node> {
    global.first(|a| a.name == "EntityAction")
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

/// Actions that do not move an entity by themselves.
const HARMLESS: [&str; 4] = [
    "ControllerAction",
    "VisibilityAction",
    "ActivateControllerAction",
    "AppearanceAction",
];

/// Controllers, visibility, lights and the like do not move an entity by themselves.
pub fn is_harmless(action: &Node) -> bool {
    HARMLESS.iter().any(|name| action.has(name))
}

/// Whether an action makes a controller active, which may move the entity then.
pub fn activates(action: &Node) -> bool {
    const SWITCHES: [&str; 4] = [
        "lateral",
        "longitudinal",
        "activateLateral",
        "activateLongitudinal",
    ];
    let all =
        ["ActivateControllerAction", "AssignControllerAction"].map(|name| action.within(name));
    let mut any = false;
    for node in all.into_iter().flatten() {
        for switch in SWITCHES {
            any |= node.text(switch) == Some("true");
        }
    }
    let overrides = action.within("OverrideControllerValueAction");
    let active = |o: &&Node| o.children().any(|v| v.text("active") == Some("true"));
    any || overrides.iter().any(active)
}

/// How an action moves an entity, in words.
pub fn moves_by(action: &Node) -> String {
    let mut node = action;
    while let Some(child) = node.children().next() {
        node = child;
        if node.name != "RoutingAction"
            && node.name != "LongitudinalAction"
            && node.name != "LateralAction"
        {
            break;
        }
    }
    format!("moves by <{}>", node.name)
}
