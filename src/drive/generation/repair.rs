//! Turns requested waypoints or a manoeuvre into an attack that passes the gate.
//!
//! Written waypoints are rounded, and no curve through them is quite the motion of a vehicle. If the gate refuses only
//! for that reason, the nearest drivable motion takes their place, if it is near enough.

use super::manoeuvre::Plan;
use super::motion::{self, follow};
use super::{
    Attack, AttackContext, AttackSetup, Capability, Change, OpenLoopScreening, Reason, Refusal,
};
use crate::planner::Bound;
use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::Obstacle;
use nearmiss_scene::verdict::{Manoeuvre, ManoeuvreKind, Moment, Motion, Waypoint};

/// An attack as it was asked for.
#[derive(Debug, Clone)]
pub struct AdmittedAttack {
    /// The attack.
    pub attack: Attack,
    /// The repairs, if waypoints were not taken as they are.
    pub repair: Option<Repair>,
}

/// Changes made by a repair.
#[derive(Debug, Clone, PartialEq)]
pub struct Repair {
    /// How far it has moved the obstacle at most from where the curve through the waypoints has it, metres.
    pub moved: f64,
    /// The step at which it is so far.
    pub step: i64,
    /// The gate's refusals.
    pub refused: Vec<Refusal>,
}

/// A repair moves no obstacle farther than this at any step, metres: what needs more was asked otherwise.
pub const MAX_DISPLACEMENT: f64 = 1.0;

/// So much may heading (rad) and speed (m/s) differ from those of the waypoints, and from the recorded ones at the
/// start. Of fast motions a share of the speed: places say how fast it is, too.
const HEADING_TOLERANCE: f64 = 0.2;
const SPEED_TOLERANCE: f64 = 2.0;
const FASTER_SHARE: f64 = 0.15;

/// A body that leaves the road by no more than this is repaired, metres.
const MAX_OFF_ROAD: f64 = 0.1;

/// The attack that is asked of the obstacle with an id.
///
/// A manoeuvre that can take several ways takes the first that passes the gate.
///
/// # Errors
/// All reasons why there is none, never none.
pub fn admit(
    ground: &AttackSetup<'_>,
    id: i64,
    asked: &Motion,
) -> Result<AdmittedAttack, Vec<Refusal>> {
    let obstacle = ground.obstacle(id).map_err(|refusal| vec![refusal])?;
    match asked {
        Motion::Waypoints(points) => through(ground, obstacle, points),
        Motion::Manoeuvre(manoeuvre) => by_manoeuvre(ground, obstacle, manoeuvre),
    }
}

/// How many ways are tried that cross the ego's.
const MAX_CROSSING_PATHS: usize = 3;

fn by_manoeuvre(
    ground: &AttackSetup<'_>,
    obstacle: &Obstacle,
    manoeuvre: &Manoeuvre,
) -> Result<AdmittedAttack, Vec<Refusal>> {
    sensible(ground, obstacle, manoeuvre).map_err(|refusal| vec![refusal])?;
    let ways = match manoeuvre.kind {
        ManoeuvreKind::LateTurn | ManoeuvreKind::PullOut => MAX_CROSSING_PATHS,
        _ => 1,
    };
    let mut first = None;
    for way in 0..ways {
        let change = motion::of_manoeuvre(ground.stage, obstacle, manoeuvre, way);
        let attack = change
            .map_err(|refusal| vec![refusal])
            .and_then(|change| passing(ground, manoeuvre, change));
        match attack {
            Ok(attack) => {
                return Ok(AdmittedAttack {
                    attack,
                    repair: None,
                });
            }
            Err(refused) => drop(first.get_or_insert(refused)),
        }
    }
    Err(first.unwrap_or_default())
}

/// The attack with this motion, or all that is wrong with it.
fn passing(
    ground: &AttackSetup<'_>,
    manoeuvre: &Manoeuvre,
    change: Change,
) -> Result<Attack, Vec<Refusal>> {
    let asked = Motion::Manoeuvre(manoeuvre.clone());
    let attack = ground.attack(asked, change.clone());
    attack.map_err(|refusal| match refusal.reason {
        Reason::Answer(_) => vec![refusal],
        // The attack stops at the first reason.
        _ => match ground.gate.check(&change, None) {
            Err(all) => all,
            Ok(_) => vec![refusal],
        },
    })
}

/// Numbers beyond the scenario mean nothing, however they are answered.
fn sensible(
    ground: &AttackSetup<'_>,
    obstacle: &Obstacle,
    manoeuvre: &Manoeuvre,
) -> Result<(), Refusal> {
    let stage = ground.stage;
    let last = (obstacle.track().steps().end - 1).max(*stage.steps.end());
    let whole = last as f64 * stage.dt();
    let (start, duration) = (manoeuvre.start, manoeuvre.duration);
    let said = [manoeuvre.gap, manoeuvre.speed].into_iter().flatten();
    if !said.chain([start, duration]).all(f64::is_finite) {
        return Err(Refusal::answer("the manoeuvre has an invalid number"));
    }
    if start < 0.0 || duration <= 0.0 || start > whole || duration > whole {
        return Err(Refusal::answer(format!(
            "the manoeuvre starts at {start:.2} s and takes {duration:.2} s, but the scenario ends at {whole:.2} s"
        )));
    }
    let fastest = Capability::for_obstacle(obstacle, stage.style).map(|able| able.limits.speed);
    if let (Some(speed), Some(most)) = (manoeuvre.speed, fastest)
        && speed > most
    {
        let reason = Reason::Kinematics(Bound::Speed);
        return Err(Refusal::whole_motion(reason).with(speed, most));
    }
    Ok(())
}

fn through(
    ground: &AttackSetup<'_>,
    obstacle: &Obstacle,
    points: &[Waypoint],
) -> Result<AdmittedAttack, Vec<Refusal>> {
    let asked = Motion::Waypoints(points.to_vec());
    let given = motion::through_waypoints(ground.stage, obstacle, points)?;
    let Err(mut refused) = ground.gate.check(&given, None) else {
        let attack = ground.attack(asked, given).map_err(|refusal| vec![refusal]);
        return attack.map(|attack| AdmittedAttack {
            attack,
            repair: None,
        });
    };
    if !is_near(ground, obstacle, &given, &refused) {
        return Err(refused);
    }
    let from = given.motions[0].0;
    let plan = Plan {
        from,
        wanted: motion::targets_of(&given.motions),
    };
    let driven = match follow(ground.stage, obstacle, from, &plan) {
        Ok(driven) => driven,
        Err(refusal) => {
            refused.push(refusal);
            return Err(refused);
        }
    };
    let (step, moved) = farthest(&given, &driven);
    if let Some(words) = otherwise(ground.stage, points, &driven, step, moved) {
        refused.push(Refusal::answer(words));
        return Err(refused);
    }
    match ground.attack(asked, driven) {
        Ok(attack) => Ok(AdmittedAttack {
            attack,
            repair: Some(Repair {
                moved,
                step,
                refused,
            }),
        }),
        Err(refusal) => {
            refused.push(refusal);
            Err(refused)
        }
    }
}

/// Whether nothing is wrong but what a repair may put right, or what comes when the attack is over.
fn is_near(
    ground: &AttackSetup<'_>,
    obstacle: &Obstacle,
    given: &Change,
    refused: &[Refusal],
) -> bool {
    let finite = refused.iter().all(|r| r.reason != Reason::NotANumber);
    let seen = finite.then(|| OpenLoopScreening::evaluate(ground.stage, obstacle, given));
    let Some(over) = seen.flatten().map(|seen| ground.over(&seen)) else {
        return false;
    };
    refused.iter().all(|refusal| {
        let value = refusal.value.unwrap_or(0.0);
        let excess = value - refusal.limit.unwrap_or(0.0);
        match refusal.reason {
            Reason::Start("position") => value <= MAX_DISPLACEMENT,
            Reason::Start("heading") => value <= HEADING_TOLERANCE,
            Reason::Start(_) => value <= SPEED_TOLERANCE,
            Reason::Kinematics(_)
            | Reason::SpeedingUp
            | Reason::Lateral
            | Reason::Jerk
            | Reason::Acceleration
            | Reason::Heading
            | Reason::Velocity => true,
            Reason::Jump => excess <= MAX_DISPLACEMENT,
            Reason::OffRoad if excess <= MAX_OFF_ROAD => true,
            Reason::OffRoad | Reason::Overlap(_) => refusal.step.is_some_and(|step| step > over),
            _ => false,
        }
    })
}

/// Describes how a drivable motion departs from the request; `None` if it is near enough.
fn otherwise(
    stage: &AttackContext<'_>,
    points: &[Waypoint],
    driven: &Change,
    step: i64,
    moved: f64,
) -> Option<String> {
    if moved > MAX_DISPLACEMENT {
        return Some(format!(
            "the nearest drivable motion is {moved:.2} m away at step {step}; at most {MAX_DISPLACEMENT:.2} m are repaired"
        ));
    }
    points.iter().enumerate().find_map(|(place, point)| {
        let step = match point.at {
            Moment::Step(step) => step,
            Moment::Seconds(time) => stage.step_at(time),
        };
        let (_, motion) = driven.motions.iter().find(|(s, _)| *s == step)?;
        let turned = point.heading.map(|h| angle_between(h, motion.pose.heading).abs());
        let faster = point.velocity.map(|v| (v - motion.velocity).abs());
        let fastest = SPEED_TOLERANCE.max(FASTER_SHARE * point.velocity.unwrap_or(0.0).abs());
        let off = [(turned, HEADING_TOLERANCE, "rad"), (faster, fastest, "m/s")];
        let (value, most, unit) = off
            .into_iter()
            .find_map(|(value, most, unit)| Some((value.filter(|v| *v > most)?, most, unit)))?;
        Some(format!(
            "the nearest drivable motion differs by {value:.2} {unit} from waypoint {}; at most {most:.2} {unit} are repaired",
            place + 1
        ))
    })
}

/// Where two motions of the same steps are farthest from each other, and how far, metres.
fn farthest(a: &Change, b: &Change) -> (i64, f64) {
    let pairs = a.motions.iter().zip(&b.motions);
    let apart =
        pairs.map(|((step, a), (_, b))| (*step, (a.pose.position - b.pose.position).norm()));
    apart.fold(
        (0, 0.0),
        |most, one| if one.1 > most.1 { one } else { most },
    )
}
