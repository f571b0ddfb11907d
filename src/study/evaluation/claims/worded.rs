//! Whether what is said of an obstacle in words holds at a step: motion, way, lane, contact denied and contact to come.

use nearmiss_base::geometry::{Placed, Pose, angle_between};
use nearmiss_scene::metrics::{Contact, Encounter, RiskAspect, measure, paper};
use nearmiss_scene::scenario::{LaneRelation, Motion, Participant, Scene};

use super::check::STANDING;
use super::truth::judge_side;
use super::{Claim, Compared, Dimension, Judgement, Predicate, Subject};

/// What is known of a predicate.
#[derive(Debug, Clone)]
pub struct Known {
    /// Whether it holds; why that cannot be told.
    pub holds: Result<bool, &'static str>,
    /// The truth, described.
    pub is: String,
}

/// Changes of distance below this are none, m/s.
pub(super) const STILL: f64 = 0.05;

/// Accelerations below this are none that words mean, and those above are plain, m/s².
const SLIGHT: f64 = 0.3;
const PLAIN: f64 = 1.0;

/// Accelerations above are hard, and those below are gentle, m/s².
const HARD: f64 = 3.0;
const GENTLE: f64 = 2.5;

/// Contact to come does so within this, seconds.
const SOON: f64 = 3.0;

/// Directions farther apart are not the same, and those farther are opposite, radians.
const ACROSS: f64 = std::f64::consts::FRAC_PI_2;
const SAME: f64 = std::f64::consts::FRAC_PI_4;
const SLANT: f64 = std::f64::consts::FRAC_PI_8;

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
        Predicate::KeepsDistance(axis) => keeps(encounter, before.as_ref(), (axis, dt)),
        Predicate::Braking
        | Predicate::Accelerating
        | Predicate::Hard(_)
        | Predicate::Gentle(_)
        | Predicate::Steady
        | Predicate::Moving
        | Predicate::Stops
        | Predicate::Turning(_)
        | Predicate::ChangesLane => {
            let was = before.as_ref().map(|before| before.other);
            let history = |back: i64| participant.at(step - back);
            let known = own_motion(predicate, scene, (encounter.other, was), &history);
            known.unwrap_or(Known {
                holds: Err("it cannot be told"),
                is: String::new(),
            })
        }
        Predicate::Crossing => {
            let apart =
                angle_between(encounter.ego.pose.heading, encounter.other.pose.heading).abs();
            let stands = encounter.other.velocity.abs() < STANDING;
            Known {
                holds: match apart {
                    _ if stands => Ok(false),
                    apart if (SAME..=std::f64::consts::PI - SAME).contains(&apart) => Ok(true),
                    apart if !(SAME / 4.0..=std::f64::consts::PI - SAME / 4.0).contains(&apart) => {
                        Ok(false)
                    }
                    _ => Err("it drives at a slant"),
                },
                is: format!("headings {:.0}° apart", apart.to_degrees()),
            }
        }
        Predicate::CutsIn => {
            let steps = subject
                .window
                .map_or(step..=step, |(first, _)| first..=step);
            let in_lane = |step: i64| {
                let encounter = Encounter::at(scene, participant, step)?;
                let lane = lane_of(scene, &encounter)?;
                Some(matches!(
                    lane,
                    LaneRelation::Same | LaneRelation::Ahead | LaneRelation::Behind
                ))
            };
            let all: Vec<bool> = steps.filter_map(in_lane).collect();
            let is_ahead = encounter.relation().gap_long >= 0.0;
            let came = all.windows(2).any(|two| !two[0] && two[1]);
            Known {
                holds: if came && is_ahead {
                    Ok(true)
                } else if all.len() < 2 {
                    Err("its lanes are not known")
                } else if encounter.relation().velocity.y * encounter.relation().gap_lat < 0.0
                    && all.last() == Some(&false)
                {
                    Err("it is on its way")
                } else {
                    Ok(false)
                },
                is: if came {
                    "it came into the ego's lane".into()
                } else {
                    "it did not change into the ego's lane".into()
                },
            }
        }
        Predicate::At(side) => {
            let relation = encounter.relation();
            Known {
                holds: match judge_side(side, &relation, encounter) {
                    Judgement::Right => Ok(true),
                    Judgement::Wrong => Ok(false),
                    Judgement::Unknown(why) => Err(why),
                },
                is: relation.direction.name().to_lowercase(),
            }
        }
        Predicate::CameFrom(side) => {
            let first = subject.window.map_or(step, |(first, _)| first);
            let first = (first..=step).find_map(|at| Encounter::at(scene, participant, at));
            let at = |encounter: &Encounter<'_>| judge_side(side, &encounter.relation(), encounter);
            let then = first.as_ref().map_or(Judgement::Wrong, at);
            Known {
                holds: match (then, at(encounter)) {
                    (Judgement::Right, _) => Ok(true),
                    (Judgement::Unknown(_), Judgement::Right) => Ok(true),
                    (Judgement::Unknown(why), _) => Err(why),
                    _ => Ok(false),
                },
                is: first.map_or(String::new(), |first| {
                    format!(
                        "{} at first",
                        first.relation().direction.name().to_lowercase()
                    )
                }),
            }
        }
        Predicate::Signed(long, is_positive) => {
            let own = encounter.relation().velocity;
            let mut all = vec![if long { own.x } else { own.y }];
            all.extend(told.iter().map(|told| {
                if long {
                    told.v_rel_long
                } else {
                    told.v_rel_lat
                }
            }));
            let sign = if is_positive { 1.0 } else { -1.0 };
            Known {
                holds: match all[0].abs() {
                    _ if all.iter().any(|v| sign * v > STILL) => Ok(true),
                    speed if speed <= STILL => Err("it is about 0"),
                    _ => Ok(false),
                },
                is: format!("{:.1} m/s", all[0]),
            }
        }
        Predicate::Beside => {
            let relation = encounter.relation();
            Known {
                holds: match relation.gap_long.abs() {
                    0.0 if relation.gap_lat != 0.0 => Ok(true),
                    gap if gap > 3.0 => Ok(false),
                    _ => Err("it is nearly beside"),
                },
                is: relation.direction.name().to_lowercase(),
            }
        }
        Predicate::NeighbourLane(left) => {
            let relation = lane_of(scene, encounter);
            let beside = match relation {
                Some(LaneRelation::Left | LaneRelation::FurtherLeft) => Some(true),
                Some(LaneRelation::Right | LaneRelation::FurtherRight) => Some(false),
                _ => None,
            };
            Known {
                holds: match (beside, relation) {
                    (Some(is), _) if is == left => Ok(true),
                    (Some(_), _) => Ok(false),
                    (_, None) => Err("its lane is not known"),
                    // The left lane of the road may be the ego's own.
                    (_, Some(LaneRelation::Same | LaneRelation::Ahead | LaneRelation::Behind)) => {
                        Err("it is in the ego's lane")
                    }
                    (_, Some(LaneRelation::Oncoming)) if left => Err("its lane goes the other way"),
                    _ => Ok(false),
                },
                is: relation.map_or("no lane".into(), |lane| lane.text().into()),
            }
        }
        Predicate::Compared(compared) => compare(compared, scene, participant, (encounter, step)),
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
        Predicate::SameWay | Predicate::Oncoming | Predicate::Parallel => {
            let apart =
                angle_between(encounter.ego.pose.heading, encounter.other.pose.heading).abs();
            let reverse = std::f64::consts::PI - apart;
            let (off, near, far, between) = match predicate {
                Predicate::Oncoming => (reverse, SAME, ACROSS, "it drives across"),
                Predicate::Parallel => (apart.min(reverse), SLANT, SAME, "it drives at a slant"),
                _ => (apart, SAME, ACROSS, "it drives across"),
            };
            let stands = encounter.other.velocity.abs() < STANDING;
            Known {
                holds: match off {
                    _ if stands => Err("it stands"),
                    off if off <= near => Ok(true),
                    off if off >= far => Ok(false),
                    _ => Err(between),
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

/// What is known of a body's own motion: of an obstacle or of the ego, at a step and at the one before. Nothing of other
/// predicates.
pub fn own_motion<'m>(
    predicate: Predicate,
    scene: &Scene,
    (now, before): (&Motion, Option<&Motion>),
    history: &dyn Fn(i64) -> Option<&'m Motion>,
) -> Option<Known> {
    let dt = scene.scenario.dt();
    let own = now.acceleration * now.velocity.signum();
    let known = match predicate {
        Predicate::Braking
        | Predicate::Accelerating
        | Predicate::Hard(_)
        | Predicate::Gentle(_)
        | Predicate::Steady => {
            let seen = before.map(|before| (now.velocity.abs() - before.velocity.abs()) / dt);
            let all: Vec<f64> = [Some(own), seen].into_iter().flatten().collect();
            let some = |is: &dyn Fn(f64) -> bool| all.iter().any(|a| is(*a));
            let holds = match predicate {
                Predicate::Braking if some(&|a| a < -SLIGHT) => Ok(true),
                Predicate::Braking if !some(&|a| a < 0.0) => Ok(false),
                Predicate::Accelerating if some(&|a| a > SLIGHT) => Ok(true),
                Predicate::Accelerating if !some(&|a| a > 0.0) => Ok(false),
                Predicate::Hard(brakes) | Predicate::Gentle(brakes) => {
                    let sign = if brakes { -1.0 } else { 1.0 };
                    let is_hard = matches!(predicate, Predicate::Hard(_));
                    match sign {
                        sign if !some(&|a| sign * a > 0.0) => Ok(false),
                        sign if is_hard && some(&|a| sign * a >= HARD) => Ok(true),
                        sign if !is_hard && some(&|a| (SLIGHT..=GENTLE).contains(&(sign * a))) => {
                            Ok(true)
                        }
                        _ => Err("how much the words mean is not told"),
                    }
                }
                Predicate::Steady if some(&|a| a.abs() < SLIGHT) => Ok(true),
                Predicate::Steady if !some(&|a| a.abs() < PLAIN) => Ok(false),
                _ => Err("its speed hardly changes"),
            };
            Known {
                holds,
                is: format!("{:.1} m/s²", own + 0.0),
            }
        }
        Predicate::Stops => Known {
            holds: match now.velocity.abs() {
                speed if speed < STANDING => Ok(true),
                _ => Err("it may stop later"),
            },
            is: format!("{:.1} m/s", now.velocity.abs()),
        },
        Predicate::Moving => Known {
            holds: match now.velocity.abs() {
                speed if speed < STANDING => Ok(false),
                speed if speed < 0.5 => Err("it hardly moves"),
                _ => Ok(true),
            },
            is: format!("{:.1} m/s", now.velocity.abs()),
        },
        Predicate::Turning(left) => {
            let back = (1.0 / dt).round() as i64;
            let was = (0..=back).rev().find_map(history)?;
            let turn = angle_between(was.pose.heading, now.pose.heading).to_degrees();
            let turn = if left { turn } else { -turn };
            Known {
                holds: match turn {
                    turn if turn > 4.0 => Ok(true),
                    turn if turn < 1.0 => Ok(false),
                    _ => Err("its heading hardly changes"),
                },
                is: format!(
                    "{:.0}° to the left within 1 s",
                    if left { turn } else { -turn } + 0.0
                ),
            }
        }
        Predicate::ChangesLane => {
            let network = &scene.scenario.network;
            let span = (3.0 / dt).round() as i64;
            let driven = |back: &mut dyn Iterator<Item = i64>| -> Vec<Vec<i64>> {
                back.filter_map(history)
                    .map(|motion| network.lanelets_driven(&motion.pose))
                    .filter(|ids| !ids.is_empty())
                    .collect()
            };
            let changes = |lanes: &[Vec<i64>]| {
                lanes.windows(2).any(|two| {
                    let relations = network.lane_relations(&two[0]);
                    two[1].iter().all(|id| {
                        !matches!(
                            relations.relation_to(*id),
                            LaneRelation::Same | LaneRelation::Ahead | LaneRelation::Behind
                        )
                    })
                })
            };
            let lanes = driven(&mut (0..=span).rev());
            let changed = changes(&lanes);
            let will = changes(&driven(&mut (-span..=0).rev()));
            Known {
                holds: match (changed, lanes.len()) {
                    (true, _) => Ok(true),
                    (false, 0..=1) => Err("its lanes are not known"),
                    _ => {
                        let drift = lanes.len() > 1
                            && before.is_some_and(|was| {
                                let moved = was.pose.to_local(&now.pose.position);
                                moved.y.abs() > 0.3 * dt
                            });
                        if drift && will {
                            Ok(true)
                        } else if drift || will {
                            Err("it may be on its way")
                        } else {
                            Ok(false)
                        }
                    }
                },
                is: if changed {
                    "it changed lanes within 3 s".into()
                } else {
                    "it kept its lane".into()
                },
            }
        }
        _ => return None,
    };
    Some(known)
}

/// The lane of the other seen from that of the ego, the closest relation of its lanelets.
pub fn lane_of(scene: &Scene, encounter: &Encounter<'_>) -> Option<LaneRelation> {
    let network = &scene.scenario.network;
    let own = network.lanelets_driven(&encounter.ego.pose);
    let other = network.lanelets_at(&encounter.other.pose.position);
    if own.is_empty() || other.is_empty() {
        return None;
    }
    let relations = network.lane_relations(&own);
    { other.iter() }.map(|id| relations.relation_to(*id)).min()
}

/// How an obstacle compares with another one, or with all that are there.
fn compare(
    compared: Compared,
    scene: &Scene,
    participant: &Participant<'_>,
    (encounter, step): (&Encounter<'_>, i64),
) -> Known {
    let value = |encounter: &Encounter<'_>| match compared.of {
        Dimension::Distance => Some(encounter.distance()),
        Dimension::Speed => Some(encounter.other.velocity.abs()),
        Dimension::Ttc => {
            let ttc = measure("ttc").and_then(|ttc| ttc.evaluate(encounter).value());
            Some(ttc.unwrap_or(f64::INFINITY))
        }
        Dimension::Braking => {
            Some(-encounter.other.acceleration * encounter.other.velocity.signum())
        }
        // Less is more dangerous.
        Dimension::Risk => Some(-f64::from(
            encounter
                .thresholds()
                .risk
                .aspect(encounter, RiskAspect::Overall),
        )),
    };
    let own = value(encounter).unwrap_or(f64::NAN);
    let others = scene.participants().filter(|who| match compared.than {
        Some(id) => who.obstacle.id == id,
        None => who.obstacle.id != participant.obstacle.id,
    });
    let others: Vec<(i64, f64)> = others
        .filter_map(|who| {
            let there = Encounter::at(scene, &who, step)?;
            Some((who.obstacle.id, value(&there)?))
        })
        .collect();
    let sign = if compared.is_more { 1.0 } else { -1.0 };
    if compared.rank > 0 {
        return ranked(
            usize::from(compared.rank),
            sign * own,
            { others.iter() }.map(|one| sign * one.1),
        );
    }
    let rival = { others.iter() }
        .max_by(|a, b| (sign * a.1).total_cmp(&(sign * b.1)))
        .copied();
    let Some((id, rival)) = rival else {
        return Known {
            holds: Err("nothing to compare it with"),
            is: String::new(),
        };
    };
    let margin = sign * (own - rival);
    Known {
        holds: match margin {
            margin if margin > 0.05 => Ok(true),
            margin if margin < -0.05 => Ok(false),
            _ if own == rival && own.is_infinite() => Err("neither is ever reached"),
            _ => Err("they are alike"),
        },
        is: format!("{:.2}, {id} {:.2}", own.abs(), rival.abs()),
    }
}

/// Whether so many values are plainly before one's own.
fn ranked(rank: usize, own: f64, others: impl Iterator<Item = f64>) -> Known {
    let (mut before, mut alike) = (0, 0);
    for other in others {
        before += usize::from(other > own + 0.05);
        alike += usize::from((other - own).abs() <= 0.05);
    }
    Known {
        holds: match rank {
            _ if !own.is_finite() => Err("it is never reached"),
            rank if alike == 0 && before == rank => Ok(true),
            rank if before > rank || before + alike < rank => Ok(false),
            _ => Err("they are alike"),
        },
        is: format!("{before} before it"),
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

/// Lanelets in words.
pub(super) fn lanelet_words(ids: &[i64]) -> String {
    let ids: Vec<String> = ids.iter().map(i64::to_string).collect();
    if ids.is_empty() {
        "no lanelet".into()
    } else {
        format!("lanelet {}", ids.join(" and "))
    }
}

/// Whether the distance, or the gap along an axis, stays as it is.
fn keeps(
    encounter: &Encounter<'_>,
    before: Option<&Encounter<'_>>,
    (axis, dt): (Option<bool>, f64),
) -> Known {
    let apart = |encounter: &Encounter<'_>| match axis {
        None => encounter.distance(),
        Some(true) => encounter.relation().gap_long.abs(),
        Some(false) => encounter.relation().gap_lat.abs(),
    };
    let change = before.map(|before| (apart(encounter) - apart(before)) / dt);
    Known {
        holds: match change.map(f64::abs) {
            None => Err("it was not there before"),
            Some(change) if change <= SLIGHT => Ok(true),
            Some(change) if change >= PLAIN => Ok(false),
            Some(_) => Err("the distance hardly changes"),
        },
        is: change.map_or(String::new(), |change| format!("{change:+.1} m/s")),
    }
}

/// On which lanelets it is, beside those of the ego.
fn lane(predicate: Predicate, scene: &Scene, encounter: &Encounter<'_>) -> Known {
    let network = &scene.scenario.network;
    let at = |pose: &Pose| network.lanelets_at(&pose.position);
    let (own, other) = (at(&encounter.ego.pose), at(&encounter.other.pose));
    let under = |body: Placed<'_>| network.lanelets_under(&body);
    let bodies = [
        under(encounter.ego_body.at(encounter.ego.pose)),
        under(encounter.other_body.at(encounter.other.pose)),
    ];
    let is = match predicate {
        Predicate::OnLanelet(_) => lanelet_words(&other),
        _ => format!(
            "{}, the ego on {}",
            lanelet_words(&other),
            lanelet_words(&own)
        ),
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
