//! Whether what is said of an obstacle in words holds at a step: motion, way, lane, contact denied and contact to come.

use nearmiss_base::geometry::{Placed, Pose, angle_between};
use nearmiss_scene::metrics::{Contact, Encounter, RiskAspect, measure, paper};
use nearmiss_scene::scenario::{LaneRelation, Participant, Scene};

use super::check::STANDING;
use super::{Claim, Judgement, Predicate, Subject};

/// What is known of a predicate.
#[derive(Debug, Clone)]
pub struct Known {
    /// Whether it holds; why that cannot be told.
    pub holds: Result<bool, &'static str>,
    /// The truth, described.
    pub is: String,
}

/// Changes of distance below this are none, m/s.
const STILL: f64 = 0.05;

/// Accelerations below this are none that words mean, and those above are plain, m/s².
const SLIGHT: f64 = 0.3;
const PLAIN: f64 = 1.0;

/// Contact to come does so within this, seconds.
const SOON: f64 = 3.0;

/// Directions farther apart are not the same, and those farther are opposite, radians.
const ACROSS: f64 = std::f64::consts::FRAC_PI_2;
const SAME: f64 = std::f64::consts::FRAC_PI_4;

/// What is known of a predicate of a participant at a step; `told` are the relations in the paper's convention.
pub fn state(
    predicate: Predicate,
    subject: &Subject<'_>,
    participant: &Participant<'_>,
    (encounter, step): (&Encounter<'_>, i64),
    told: &[paper::Relation],
) -> Known {
    let scene = subject.scene;
    let before = Encounter::at(scene, participant, step - 1);
    let dt = scene.scenario.dt();
    match predicate {
        Predicate::Approaching(axis) => closing(encounter, before.as_ref(), (axis, dt), told, 1.0),
        Predicate::Receding(axis) => closing(encounter, before.as_ref(), (axis, dt), told, -1.0),
        Predicate::Braking | Predicate::Accelerating | Predicate::Steady => {
            let speed = |encounter: &Encounter<'_>| encounter.other.velocity.abs();
            let own = encounter.other.acceleration * encounter.other.velocity.signum();
            let seen = before.map(|before| (speed(encounter) - speed(&before)) / dt);
            let all: Vec<f64> = [Some(own), seen].into_iter().flatten().collect();
            let some = |is: &dyn Fn(f64) -> bool| all.iter().any(|a| is(*a));
            let holds = match predicate {
                Predicate::Braking if some(&|a| a < -SLIGHT) => Ok(true),
                Predicate::Braking if !some(&|a| a < 0.0) => Ok(false),
                Predicate::Accelerating if some(&|a| a > SLIGHT) => Ok(true),
                Predicate::Accelerating if !some(&|a| a > 0.0) => Ok(false),
                Predicate::Steady if some(&|a| a.abs() < SLIGHT) => Ok(true),
                Predicate::Steady if !some(&|a| a.abs() < PLAIN) => Ok(false),
                _ => Err("its speed hardly changes"),
            };
            Known {
                holds,
                is: format!("{:.1} m/s²", own + 0.0),
            }
        }
        Predicate::FasterThanEgo | Predicate::SlowerThanEgo => {
            let more = encounter.other.velocity.abs() - encounter.ego.velocity.abs();
            let more = if predicate == Predicate::SlowerThanEgo {
                -more
            } else {
                more
            };
            Known {
                holds: if more.abs() <= STILL {
                    Err("both are as fast")
                } else {
                    Ok(more > 0.0)
                },
                is: format!(
                    "{:.1} m/s, the ego {:.1} m/s",
                    encounter.other.velocity.abs(),
                    encounter.ego.velocity.abs()
                ),
            }
        }
        Predicate::SameWay | Predicate::Oncoming => {
            let apart =
                angle_between(encounter.ego.pose.heading, encounter.other.pose.heading).abs();
            let apart_from = if predicate == Predicate::Oncoming {
                std::f64::consts::PI - apart
            } else {
                apart
            };
            let stands = encounter.other.velocity.abs() < STANDING;
            Known {
                holds: match apart_from {
                    _ if stands => Err("it stands"),
                    apart if apart <= SAME => Ok(true),
                    apart if apart >= ACROSS => Ok(false),
                    _ => Err("it drives across"),
                },
                is: format!("headings {:.0}° apart", apart.to_degrees()),
            }
        }
        Predicate::SameLane
        | Predicate::OtherLane
        | Predicate::SameLanelet
        | Predicate::OtherLanelet
        | Predicate::OnLanelet(_) => lane(predicate, scene, encounter),
        Predicate::Touches => {
            let steps = subject
                .window
                .map_or(step..=step, |(first, _)| first..=step);
            let touched = { steps }.find(|at| {
                Encounter::at(scene, participant, *at).is_some_and(|e| e.contact().is_some())
            });
            Known {
                holds: Ok(touched.is_some()),
                is: match touched {
                    Some(at) => format!("contact at step {at}"),
                    None => "no contact".into(),
                },
            }
        }
        Predicate::WillTouch => {
            let first = Contact::first(scene, participant).map(|contact| contact.step);
            let left = (scene.last_step() - step) as f64 * dt;
            let ttc = measure("ttc").and_then(|ttc| ttc.evaluate(encounter).value());
            let (holds, is) = match first {
                Some(at) if (at - step) as f64 * dt <= SOON && at >= step => {
                    (Ok(true), format!("contact at step {at}"))
                }
                _ if ttc.is_some_and(|ttc| ttc <= SOON) => {
                    (Err("its time to collision is short"), "no contact".into())
                }
                None if left < SOON => (Err("the recording ends"), "no contact".into()),
                Some(at) if at >= step => (Ok(false), format!("contact at step {at}")),
                _ => (Ok(false), "no contact".into()),
            };
            Known { holds, is }
        }
    }
}

/// Whether the distance, or the gap along an axis, shrinks (`sign` 1) or grows (-1).
fn closing(
    encounter: &Encounter<'_>,
    before: Option<&Encounter<'_>>,
    (axis, dt): (Option<bool>, f64),
    told: &[paper::Relation],
    sign: f64,
) -> Known {
    let away = encounter.other.pose.position - encounter.ego.pose.position;
    let velocity = encounter.other.velocity_vector() - encounter.ego.velocity_vector();
    let relation = encounter.relation();
    // A gap and its change, at both steps.
    let along = |gap: f64, velocity: f64, was: Option<f64>| {
        let seen = was.filter(|was| was * gap > 0.0);
        let seen = seen.map(|was| (was.abs() - gap.abs()) / dt);
        let told = (gap != 0.0).then(|| -gap.signum() * velocity);
        told.into_iter().chain(seen).collect::<Vec<f64>>()
    };
    let was = before.map(Encounter::relation);
    let long = || {
        along(
            relation.gap_long,
            relation.velocity.x,
            was.as_ref().map(|r| r.gap_long),
        )
    };
    let lat = || {
        along(
            relation.gap_lat,
            relation.velocity.y,
            was.as_ref().map(|r| r.gap_lat),
        )
    };
    let mut all = match axis {
        None => {
            let own = (away.norm() > 0.0).then(|| -away.dot(&velocity) / away.norm());
            let seen = before.map(|before| (before.distance() - encounter.distance()) / dt);
            own.into_iter().chain(seen).collect()
        }
        Some(true) => long(),
        Some(false) => lat(),
    };
    for told in told {
        match axis {
            None => {}
            Some(true) => all.extend(along(told.adjusted_d_long, told.v_rel_long, None)),
            Some(false) => all.extend(along(told.adjusted_d_lat, told.v_rel_lat, None)),
        }
    }
    let is = match all.first() {
        None => "side by side along this axis".into(),
        Some(speed) if speed.abs() <= STILL => "at about the same distance".into(),
        Some(speed) if *speed > 0.0 => format!("closing with {speed:.1} m/s"),
        Some(speed) => format!("moving away with {:.1} m/s", -speed),
    };
    let holds = if all.is_empty() {
        Err("the bodies overlap along this axis")
    } else if all.iter().any(|speed| sign * speed > STILL) {
        Ok(true)
    } else if all.iter().any(|speed| speed.abs() <= STILL) {
        Err("the distance hardly changes")
    } else if axis.is_none() && { long().into_iter().chain(lat()) }
        .any(|speed| sign * speed > STILL)
    {
        Err("true along one axis")
    } else {
        Ok(false)
    };
    Known { holds, is }
}

/// On which lanelets it is, beside those of the ego.
fn lane(predicate: Predicate, scene: &Scene, encounter: &Encounter<'_>) -> Known {
    let network = &scene.scenario.network;
    let at = |pose: &Pose| network.lanelets_at(&pose.position);
    let (own, other) = (at(&encounter.ego.pose), at(&encounter.other.pose));
    let words = |ids: &[i64]| {
        let ids: Vec<String> = ids.iter().map(i64::to_string).collect();
        if ids.is_empty() {
            "no lanelet".into()
        } else {
            format!("lanelet {}", ids.join(" and "))
        }
    };
    let under = |body: Placed<'_>| network.lanelets_under(&body);
    let bodies = [
        under(encounter.ego_body.at(encounter.ego.pose)),
        under(encounter.other_body.at(encounter.other.pose)),
    ];
    let is = match predicate {
        Predicate::OnLanelet(_) => words(&other),
        _ => format!("{}, the ego on {}", words(&other), words(&own)),
    };
    let holds = match predicate {
        _ if other.is_empty() => Err("it is on no lanelet"),
        Predicate::OnLanelet(id) if other.contains(&id) => Ok(true),
        Predicate::OnLanelet(id) if bodies[1].contains(&id) => Err("its body reaches over there"),
        Predicate::OnLanelet(_) => Ok(false),
        _ if own.is_empty() => Err("the ego is on no lanelet"),
        predicate => {
            let is_shared = own.iter().any(|id| other.contains(id));
            let overlaps = bodies[0].iter().any(|id| bodies[1].contains(id));
            let relations = network.lane_relations(&network.lanelets_driven(&encounter.ego.pose));
            let is_followed = other.iter().any(|id| {
                matches!(
                    relations.relation_to(*id),
                    LaneRelation::Same | LaneRelation::Ahead | LaneRelation::Behind
                )
            });
            let same = match predicate {
                Predicate::SameLane | Predicate::OtherLane => is_shared || is_followed,
                _ => is_shared,
            };
            match predicate {
                _ if !same && overlaps => Err("their bodies share a lanelet"),
                // A lanelet ahead is another one in the same lane: what is meant is open.
                Predicate::SameLane | Predicate::OtherLane if is_followed && !is_shared => {
                    Err("its lanelet is ahead or behind in the ego's lane")
                }
                Predicate::SameLane | Predicate::SameLanelet => Ok(same),
                _ => Ok(!same),
            }
        }
    };
    Known { holds, is }
}

/// The risk score of an obstacle that a claim is about, and whether the claim holds: at its step, or where none is named at the
/// present or at the worst step of the window; of a window that is not known that cannot be told.
pub fn risk(
    claim: &Claim,
    subject: &Subject<'_>,
    participant: &Participant<'_>,
    encounter: &Encounter<'_>,
    (score, of): (u8, RiskAspect),
) -> (u8, Judgement) {
    let at = |encounter: &Encounter<'_>| encounter.thresholds().risk.aspect(encounter, of);
    let risk = at(encounter);
    if risk == score {
        return (risk, Judgement::Right);
    }
    if claim.step.is_some() {
        return (risk, Judgement::Wrong);
    }
    let Some((first, last)) = subject.window else {
        return (risk, Judgement::Unknown("the described steps are unknown"));
    };
    // Of what was described, and nothing of the future.
    let all = (first..=last).filter_map(|step| Encounter::at(subject.scene, participant, step));
    match all.map(|encounter| at(&encounter)).min() {
        Some(worst) if worst == score => (worst, Judgement::Right),
        _ => (risk, Judgement::Wrong),
    }
}

/// An axis before a noun.
pub fn axis_word(axis: Option<bool>) -> &'static str {
    match axis {
        None => "",
        Some(true) => "longitudinal ",
        Some(false) => "lateral ",
    }
}
