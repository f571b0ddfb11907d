//! The storyboard: where entities begin, what they follow, when they appear and vanish.

use super::actor::{Actor, nudged};
use super::formula::Formula;
use crate::commonroad::WriteError;
use crate::commonroad::writer::{XmlWriter, number};
use nearmiss_base::geometry::Pose;
use nearmiss_scene::scenario::{Motion, Scenario};

/// The times of a scenario.
#[derive(Debug, Clone, Copy)]
pub struct Clock {
    /// Seconds between two steps.
    pub dt: f64,
    /// The step at time 0.
    pub origin: i64,
    /// The last step.
    pub last: i64,
}

impl Clock {
    fn time(&self, step: i64) -> f64 {
        let time = (step - self.origin) as f64 * self.dt;
        // Without the digits that are only rounding.
        (time * 1e9).round() / 1e9
    }

    /// A moment a little before a step, so that sums of time steps reach it in spite of rounding.
    fn just_before(&self, step: i64) -> f64 {
        (self.time(step) - self.dt * 1e-3).max(0.0)
    }
}

/// Vertices nearer than this to the one before are given from the entity's first place, metres: esmini merges
/// absolute ones that are nearer than 10 cm.
const POSITION_TOLERANCE: f64 = 0.11;

/// A step shorter than this is a standstill, metres.
const STANDSTILL: f64 = 1e-5;

/// How far apart two headings at one place are written, metres.
const NUDGE: f64 = 1e-4;

/// A turn that matters, radians.
const TURN: f64 = 1e-4;

/// Writes it.
pub fn storyboard(
    out: &mut XmlWriter,
    scenario: &Scenario,
    actors: &[Actor],
    clock: Clock,
) -> Result<(), WriteError> {
    out.element("Storyboard", &[], |out| {
        out.element("Init", &[], |out| {
            out.element("Actions", &[], |out| {
                super::write_environment(out, scenario)?;
                for actor in actors.iter().filter(|a| is_late(a, clock)) {
                    out.element("GlobalAction", &[], |out| delete(out, &actor.name))?;
                }
                actors.iter().try_for_each(|a| init(out, a, clock))
            })
        })?;
        let busy: Vec<&Actor> = actors.iter().filter(|a| has_events(a, clock)).collect();
        if !busy.is_empty() {
            out.element("Story", &[("name", "traffic".into())], |out| {
                out.element("Act", &[("name", "traffic".into())], |out| {
                    busy.iter().try_for_each(|a| group(out, a, clock))?;
                    trigger(out, "StartTrigger", "begin", 0.0)
                })
            })?;
        }
        trigger(out, "StopTrigger", "end", clock.just_before(clock.last))
    })
}

fn first_step(actor: &Actor) -> i64 {
    let first = actor.stretches.first().and_then(|s| s.first());
    first.map_or(0, |(step, _)| *step)
}

fn is_late(actor: &Actor, clock: Clock) -> bool {
    !actor.stands && !actor.is_free && first_step(actor) > clock.origin
}

fn last_of(stretch: &[(i64, Motion)]) -> i64 {
    stretch.last().map_or(0, |(step, _)| *step)
}

fn has_events(actor: &Actor, clock: Clock) -> bool {
    let ends = actor.stretches.iter().any(|s| last_of(s) < clock.last);
    !actor.stands && !actor.is_free && (is_late(actor, clock) || ends)
}

/// Where an entity begins, and what it follows if it is there from the first moment.
fn init(out: &mut XmlWriter, actor: &Actor, clock: Clock) -> Result<(), WriteError> {
    let Some(stretch) = actor.stretches.first() else {
        return Ok(());
    };
    let Some((_, first)) = stretch.first() else {
        return Ok(());
    };
    out.element("Private", &[("entityRef", actor.name.clone())], |out| {
        out.element("PrivateAction", &[], |out| {
            out.element("TeleportAction", &[], |out| begin(out, actor, stretch))
        })?;
        if actor.is_free {
            return speed(out, first.velocity);
        }
        if actor.stands || is_late(actor, clock) || stretch.len() < 2 {
            return Ok(());
        }
        follow(out, actor, stretch, 0, clock)
    })
}

fn speed(out: &mut XmlWriter, velocity: f64) -> Result<(), WriteError> {
    let dynamics = [
        ("dynamicsShape", "step".into()),
        ("value", "0.0".into()),
        ("dynamicsDimension", "time".into()),
    ];
    out.element("PrivateAction", &[], |out| {
        out.element("LongitudinalAction", &[], |out| {
            out.element("SpeedAction", &[], |out| {
                out.empty("SpeedActionDynamics", &dynamics)?;
                out.element("SpeedActionTarget", &[], |out| {
                    out.empty("AbsoluteTargetSpeed", &[("value", number(velocity))])
                })
            })
        })
    })
}

fn delete(out: &mut XmlWriter, name: &str) -> Result<(), WriteError> {
    out.element("EntityAction", &[("entityRef", name.to_string())], |out| {
        out.empty("DeleteEntityAction", &[])
    })
}

/// The events of an entity that appears later, vanishes earlier, or is away for a while.
fn group(out: &mut XmlWriter, actor: &Actor, clock: Clock) -> Result<(), WriteError> {
    let name = |what: &str| [("name", format!("{what} {}", actor.name))];
    let attributes = [
        ("name", format!("entity {}", actor.name)),
        ("maximumExecutionCount", "1".into()),
    ];
    out.element("ManeuverGroup", &attributes, |out| {
        let actors = [("selectTriggeringEntities", "false".into())];
        out.element("Actors", &actors, |out| {
            out.empty("EntityRef", &[("entityRef", actor.name.clone())])
        })?;
        out.element("Maneuver", &name("presence of"), |out| {
            for (i, stretch) in actor.stretches.iter().enumerate() {
                let Some((step, _)) = stretch.first() else {
                    continue;
                };
                if *step > clock.origin {
                    // Players do what is triggered at a moment in the step that begins there.
                    let at = clock.just_before(step - 1);
                    event(out, actor, &format!("appears {i}"), at, |out| {
                        out.element("GlobalAction", &[], |out| {
                            let entity = [("entityRef", actor.name.clone())];
                            out.element("EntityAction", &entity, |out| {
                                out.element("AddEntityAction", &[], |out| {
                                    begin(out, actor, stretch)
                                })
                            })
                        })
                    })?;
                    if stretch.len() > 1 {
                        event(out, actor, &format!("drives {i}"), at, |out| {
                            follow(out, actor, stretch, i, clock)
                        })?;
                    }
                }
                if last_of(stretch) < clock.last {
                    let at = clock.just_before(last_of(stretch));
                    event(out, actor, &format!("vanishes {i}"), at, |out| {
                        out.element("GlobalAction", &[], |out| delete(out, &actor.name))
                    })?;
                }
            }
            Ok(())
        })
    })
}

fn event(
    out: &mut XmlWriter,
    actor: &Actor,
    what: &str,
    at: f64,
    action: impl FnOnce(&mut XmlWriter) -> Result<(), WriteError>,
) -> Result<(), WriteError> {
    let name = format!("{} {what}", actor.name);
    let attributes = [
        ("name", name.clone()),
        ("priority", "parallel".into()),
        ("maximumExecutionCount", "1".into()),
    ];
    out.element("Event", &attributes, |out| {
        out.element("Action", &[("name", name.clone())], action)?;
        trigger(out, "StartTrigger", &name, at)
    })
}

fn trigger(out: &mut XmlWriter, element: &str, name: &str, at: f64) -> Result<(), WriteError> {
    let condition = [
        ("name", name.to_string()),
        ("delay", "0.0".into()),
        ("conditionEdge", "none".into()),
    ];
    let time = [("value", number(at)), ("rule", "greaterOrEqual".into())];
    out.element(element, &[], |out| {
        out.element("ConditionGroup", &[], |out| {
            out.element("Condition", &condition, |out| {
                out.element("ByValueCondition", &[], |out| {
                    out.empty("SimulationTimeCondition", &time)
                })
            })
        })
    })
}

fn position(out: &mut XmlWriter, [x, y, h]: [&Formula; 3]) -> Result<(), WriteError> {
    let at = [
        ("x", x.to_string()),
        ("y", y.to_string()),
        ("h", h.to_string()),
    ];
    out.element("Position", &[], |out| out.empty("WorldPosition", &at))
}

/// A position from the place where the entity is when it begins to follow its trajectory.
fn from_start(
    out: &mut XmlWriter,
    actor: &Actor,
    start: &Vertex,
    vertex: &Vertex,
) -> Result<(), WriteError> {
    let attributes = [
        ("entityRef", actor.name.clone()),
        ("dx", (&vertex.x - &start.x).to_string()),
        ("dy", (&vertex.y - &start.y).to_string()),
    ];
    let orientation = [("type", "absolute".into()), ("h", vertex.h.to_string())];
    out.element("Position", &[], |out| {
        out.element("RelativeWorldPosition", &attributes, |out| {
            out.empty("Orientation", &orientation)
        })
    })
}

/// A place of a trajectory as it is written.
struct Vertex {
    /// Seconds.
    time: Formula,
    x: Formula,
    y: Formula,
    h: Formula,
    /// Metres from the one before, as recorded.
    away: Option<f64>,
}

impl Vertex {
    fn place(&self) -> [&Formula; 3] {
        [&self.x, &self.y, &self.h]
    }
}

/// Where an entity begins in a stretch: at a recorded place, or at the one that parameters say.
fn begin(out: &mut XmlWriter, actor: &Actor, stretch: &[(i64, Motion)]) -> Result<(), WriteError> {
    let Some((step, first)) = stretch.first() else {
        return Ok(());
    };
    if let Some(varied) = actor.varied.iter().find(|vertex| vertex.step == *step) {
        return position(out, [&varied.x, &varied.y, &varied.heading]);
    }
    let Pose {
        position: at,
        heading,
    } = first.pose;
    position(out, [&at.x.into(), &at.y.into(), &heading.into()])
}

/// The trajectory of a stretch.
fn vertices(actor: &Actor, stretch: &[(i64, Motion)], clock: Clock) -> Vec<Vertex> {
    let time = |step: i64| Formula::from(clock.time(step));
    if !actor.varied.is_empty() {
        let all = actor.varied.iter().map(|vertex| Vertex {
            time: time(vertex.step) + &vertex.later,
            x: vertex.x.clone(),
            y: vertex.y.clone(),
            h: vertex.heading.clone(),
            away: None,
        });
        return all.collect();
    }
    let poses = written(stretch);
    let before = std::iter::once(None).chain(poses.iter().map(Some));
    let recorded = stretch.iter().zip(&poses).zip(before);
    let all = recorded.map(|(((step, _), pose), before)| Vertex {
        time: time(*step),
        x: pose.position.x.into(),
        y: pose.position.y.into(),
        h: pose.heading.into(),
        away: before.map(|before| (pose.position - before.position).norm()),
    });
    all.collect()
}

fn follow(
    out: &mut XmlWriter,
    actor: &Actor,
    stretch: &[(i64, Motion)],
    place: usize,
    clock: Clock,
) -> Result<(), WriteError> {
    let vertices = vertices(actor, stretch, clock);
    let Some(start) = vertices.first() else {
        return Ok(());
    };
    let trajectory = [
        ("name", format!("motion {place} of {}", actor.name)),
        ("closed", "false".into()),
    ];
    let timing = [
        ("domainAbsoluteRelative", "absolute".into()),
        ("scale", "1.0".into()),
        ("offset", "0.0".into()),
    ];
    out.element("PrivateAction", &[], |out| {
        out.element("RoutingAction", &[], |out| {
            out.element("FollowTrajectoryAction", &[], |out| {
                out.element("TimeReference", &[], |out| out.empty("Timing", &timing))?;
                out.element("TrajectoryRef", &[], |out| {
                    out.element("Trajectory", &trajectory, |out| {
                        out.element("Shape", &[], |out| {
                            out.element("Polyline", &[], |out| {
                                vertices.iter().try_for_each(|vertex| {
                                    let time = [("time", vertex.time.to_string())];
                                    out.element("Vertex", &time, |out| match vertex.away {
                                        Some(away) if away < POSITION_TOLERANCE => {
                                            from_start(out, actor, start, vertex)
                                        }
                                        _ => position(out, vertex.place()),
                                    })
                                })
                            })
                        })
                    })
                })?;
                out.empty(
                    "TrajectoryFollowingMode",
                    &[("followingMode", "position".into())],
                )
            })
        })
    })
}

/// The poses of a stretch, apart where only the heading changes.
fn written(stretch: &[(i64, Motion)]) -> Vec<Pose> {
    let mut all: Vec<Pose> = Vec::with_capacity(stretch.len());
    for (i, (_, motion)) in stretch.iter().enumerate() {
        let pose = motion.pose;
        let turns_in_place = |other: Option<&(i64, Motion)>| {
            other.is_some_and(|(_, m)| {
                (m.pose.position - pose.position).norm() < STANDSTILL
                    && (m.pose.heading - pose.heading).abs() > TURN
            })
        };
        let before = i.checked_sub(1).and_then(|i| stretch.get(i));
        // The first one stays, as everything is told from it.
        let apart = before.is_some() && turns_in_place(before);
        all.push(if apart && i % 2 == 1 {
            nudged(&pose, NUDGE)
        } else {
            pose
        });
    }
    all
}
