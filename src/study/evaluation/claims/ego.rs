//! What is said of the ego itself, and of all around it.

use nearmiss_scene::metrics::Encounter;
use nearmiss_scene::scenario::{Motion, ObstacleType, Scene};

use super::check::{CheckedClaim, Judgement};
use super::worded::{Known, STILL, lanelet_words, own_motion, state};
use super::{ClaimedValue, Compared, Counted, Dimension, Predicate, Subject};

/// What is said of the ego itself.
pub(super) fn of_ego(checked: &mut CheckedClaim, subject: &Subject<'_>) {
    let (step, scene) = (checked.step, subject.scene);
    let Some(ego) = scene.ego.track.at(step) else {
        return;
    };
    match checked.claim.stated {
        ClaimedValue::Count { number, of, types } => {
            let (least, most) = counted((of, types), subject, step);
            let number = usize::from(number);
            checked.truth = (least == most).then_some(least as f64);
            checked.is = if least == most {
                least.to_string()
            } else {
                format!("{least} to {most}")
            };
            checked.judgement = match (least, most) {
                // "One car is ahead" tells of one of them.
                _ if number == 1 && least > 1 => Judgement::Unknown("there are more of them"),
                _ if !(least..=most).contains(&number) => Judgement::Wrong,
                _ if least == most => Judgement::Right,
                _ => Judgement::Unknown("of some it cannot be told"),
            };
        }
        ClaimedValue::Place(x, y, decimals) => {
            let place = ego.pose.position;
            let digit = (0.5 * 10_f64.powi(-i32::from(decimals))).max(0.05) + 1e-9;
            checked.is = format!("({:.2}, {:.2})", place.x, place.y);
            checked.judgement = if (place.x - x).abs() <= digit && (place.y - y).abs() <= digit {
                Judgement::Right
            } else {
                Judgement::Wrong
            };
        }
        ClaimedValue::Word {
            predicate,
            is_denied,
        } => {
            let before = scene.ego.track.at(step - 1);
            let history = |back: i64| scene.ego.track.at(step - back);
            let known = match predicate {
                Predicate::OnLanelet(id) => Some(on_lanelet(id, scene, ego, step)),
                Predicate::Compared(compared) => faster(compared, scene, ego, step),
                _ => own_motion(predicate, scene, (ego, before), &history),
            };
            let Some(Known { holds, is }) = known else {
                return;
            };
            checked.is = is;
            checked.judgement = match holds {
                Err(why) => Judgement::Unknown(why),
                Ok(holds) if holds != is_denied => Judgement::Right,
                Ok(_) => Judgement::Wrong,
            };
        }
        _ => {}
    }
}

/// Whether the ego is on a lanelet.
fn on_lanelet(id: i64, scene: &Scene, ego: &Motion, step: i64) -> Known {
    let network = &scene.scenario.network;
    let own = network.lanelets_at(&ego.pose.position);
    let under = network.lanelets_under(&scene.ego_footprint_at(step).at(ego.pose));
    Known {
        holds: match own.contains(&id) {
            true => Ok(true),
            false if own.is_empty() => Err("the ego is on no lanelet"),
            false if under.contains(&id) => Err("its body reaches over there"),
            false => Ok(false),
        },
        is: lanelet_words(&own),
    }
}

/// Whether the ego is faster or slower than an obstacle; nothing of other comparisons.
fn faster(compared: Compared, scene: &Scene, ego: &Motion, step: i64) -> Option<Known> {
    let other = scene
        .participants()
        .find(|who| Some(who.obstacle.id) == compared.than)?;
    let other = other.at(step)?.velocity.abs();
    let own = ego.velocity.abs();
    let more = if compared.is_more {
        own - other
    } else {
        other - own
    };
    (compared.of == Dimension::Speed).then(|| Known {
        holds: if more.abs() <= STILL {
            Err("both are as fast")
        } else {
            Ok(more > 0.0)
        },
        is: format!("{own:.1} m/s, {other:.1} m/s"),
    })
}

/// Who is farther along the road than this is not in the way, metres.
const FREE: f64 = 8.0;

/// Of how many something holds at a step, at least and at most; "cars" may mean all vehicles.
fn counted(
    (of, types): (Counted, Option<(ObstacleType, ObstacleType)>),
    subject: &Subject<'_>,
    step: i64,
) -> (usize, usize) {
    let (mut least, mut most) = (0, 0);
    for who in subject.scene.participants() {
        let Some(encounter) = Encounter::at(subject.scene, &who, step) else {
            continue;
        };
        let word = |predicate| state(predicate, subject, &who, (&encounter, step), &[]).holds;
        let holds = match of {
            Counted::There => Ok(true),
            Counted::Within(metres) => Ok(encounter.distance() <= metres),
            Counted::Word(predicate) => word(predicate),
            Counted::Both(one, other) => match (word(one), word(other)) {
                (Ok(false), _) | (_, Ok(false)) => Ok(false),
                (Ok(true), Ok(true)) => Ok(true),
                (Err(why), _) | (_, Err(why)) => Err(why),
            },
            // A lane is free of those who are far.
            Counted::Near(left) => match word(Predicate::NeighbourLane(left)) {
                Ok(true) if encounter.relation().gap_long.abs() > FREE => Err("it is not near"),
                holds => holds,
            },
        };
        let kind = who.obstacle.kind;
        // "Vehicles" may be all that are there.
        let is_of = types.map_or(kind != ObstacleType::Pedestrian, |(one, other)| {
            kind == one || kind == other
        });
        let may_be = is_of || types.is_none_or(|(one, _)| one == ObstacleType::Car);
        least += usize::from(holds == Ok(true) && is_of);
        most += usize::from(holds != Ok(false) && may_be);
    }
    (least, most)
}
