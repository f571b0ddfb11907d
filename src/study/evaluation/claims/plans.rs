//! What a text says that the ego will do, held against the trajectory that came with it.

use nearmiss_base::geometry::{Vector, angle_between};

use super::clauses::{Clause, Who};
use super::tokens::Token;
use super::verbs::{Act, VERBS};
use super::{Judgement, Predicate, Waypoint};

/// Speeds below this are a standstill, m/s.
const STOPPED: f64 = 0.5;

/// Changes of speed below this are none that words mean, and larger ones are plain, m/s.
const SLIGHT: f64 = 0.3;
const PLAIN: f64 = 1.0;

/// A turn of the heading that is one, and one that is none, radians: 10° and 3°.
const TURN: f64 = 0.174;
const STRAIGHT: f64 = 0.052;

/// What the ego of a clause is said to do: its tokens, what, and whether it is denied. Nothing of conditions and questions.
pub fn plans(tokens: &[Token], clause: &Clause) -> Vec<(std::ops::Range<usize>, Predicate, bool)> {
    let words = &tokens[clause.at.clone()];
    let says = |all: &str| words.iter().any(|t| t.is(all));
    let is_limited = says("if unless could might may would had was only need refuse nothing let ?")
        || tokens
            .get(clause.at.end)
            .is_some_and(|t| t.is("if unless when once until"));
    if clause.who != Who::Ego || is_limited {
        return Vec::new();
    }
    let is_denied = says("not no never without cannot avoid");
    let all = VERBS.all(tokens, clause.at.clone()).into_iter();
    let found = all.filter_map(|(act, at)| {
        let stem = tokens[at.start].stem.as_str();
        let predicate = match act {
            Act::Stands => Predicate::Stops,
            Act::Own(predicate) => match predicate {
                Predicate::Braking if stem == "stop" => Predicate::Stops,
                predicate => predicate,
            },
            _ => return None,
        };
        Some((at, predicate, is_denied))
    });
    let mut found: Vec<_> = found.collect();
    // "I must stop": the bare verb is no state.
    let bare = clause
        .at
        .clone()
        .find(|i| tokens[*i].is("stop yield wait halt"));
    if let Some(at) = bare
        && found.is_empty()
        && !tokens.get(at + 1).is_some_and(|t| t.is("sign line light"))
    {
        found.push((at..at + 1, Predicate::Stops, is_denied));
    }
    found
}

/// Whether a trajectory does what is said, and what it does instead, in words.
pub fn follow(predicate: Predicate, is_denied: bool, way: &[Waypoint]) -> (Judgement, String) {
    let legs: Vec<(f64, Vector)> = way
        .windows(2)
        .filter(|two| two[1].time > two[0].time)
        .map(|two| {
            let step = Vector::new(two[1].x - two[0].x, two[1].y - two[0].y);
            (step.norm() / (two[1].time - two[0].time), step)
        })
        .collect();
    let (Some(first), Some(last)) = (legs.first(), legs.last()) else {
        return (
            Judgement::Unknown("the trajectory has fewer than two points"),
            String::new(),
        );
    };
    let slowest = legs.iter().map(|leg| leg.0).fold(f64::INFINITY, f64::min);
    let fastest = legs.iter().map(|leg| leg.0).fold(0.0, f64::max);
    let headings: Vec<f64> = { legs.iter() }
        .filter(|leg| leg.1.norm() > 0.05)
        .map(|leg| leg.1.y.atan2(leg.1.x))
        .collect();
    let turn = headings
        .windows(2)
        .map(|two| angle_between(two[0], two[1]))
        .sum::<f64>();
    let (from, to) = (first.0, last.0);
    let speeds = format!("{from:.1} to {to:.1} m/s");
    let holds = match predicate {
        Predicate::Stops if slowest < STOPPED => Some(true),
        // It may stop beyond the end.
        Predicate::Stops if to < from - PLAIN => None,
        Predicate::Stops => Some(false),
        Predicate::Braking => change(from - slowest),
        Predicate::Accelerating => change(fastest - from),
        Predicate::Steady => match (fastest - slowest).abs() {
            range if range < PLAIN => Some(true),
            range if range < 2.0 * PLAIN => None,
            _ => Some(false),
        },
        Predicate::Turning(left) => match if left { turn } else { -turn } {
            turn if turn > TURN => Some(true),
            turn if turn < STRAIGHT => Some(false),
            _ => None,
        },
        _ => {
            return (
                Judgement::Unknown("a trajectory alone does not tell"),
                speeds,
            );
        }
    };
    let is = match predicate {
        Predicate::Turning(_) => format!("{:.0}° to the left", turn.to_degrees() + 0.0),
        _ => speeds,
    };
    let judgement = match holds {
        None => Judgement::Unknown("the trajectory does so only a little, or ends before"),
        Some(holds) if holds != is_denied => Judgement::Right,
        Some(_) => Judgement::Wrong,
    };
    (judgement, is)
}

/// Whether a speed changes by so much that words mean it.
fn change(by: f64) -> Option<bool> {
    match by {
        by if by > PLAIN => Some(true),
        by if by < SLIGHT => Some(false),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// At 10 m/s, getting slower by `braking` m/s², turning by `turn` radians a second.
    fn way(braking: f64, turn: f64) -> Vec<Waypoint> {
        let (mut x, mut y, mut speed, mut heading) = (0.0, 0.0, 10.0_f64, 0.0_f64);
        (0..40)
            .map(|i| {
                let point = Waypoint {
                    time: f64::from(i) * 0.1,
                    x,
                    y,
                };
                x += 0.1 * speed * heading.cos();
                y += 0.1 * speed * heading.sin();
                speed = (speed - 0.1 * braking).max(0.0);
                heading += 0.1 * turn;
                point
            })
            .collect()
    }

    #[test]
    fn a_trajectory_does_what_is_said_or_not() {
        use Predicate::{Accelerating, Braking, Steady, Stops, Turning};
        let of = |predicate, way: &[Waypoint]| follow(predicate, false, way).0;
        let (stop, keep, left) = (way(4.0, 0.0), way(0.0, 0.0), way(0.0, 0.3));
        for (predicate, good, bad) in [
            (Stops, &stop, &keep),
            (Braking, &stop, &keep),
            (Steady, &keep, &stop),
            (Turning(true), &left, &keep),
        ] {
            assert_eq!(of(predicate, good), Judgement::Right, "{predicate}");
            assert_eq!(of(predicate, bad), Judgement::Wrong, "{predicate}");
            assert_eq!(
                follow(predicate, true, good).0,
                Judgement::Wrong,
                "{predicate}"
            );
        }
        assert_eq!(of(Accelerating, &stop), Judgement::Wrong);
        assert!(matches!(of(Stops, &way(1.0, 0.0)), Judgement::Unknown(_)));
        assert!(matches!(of(Stops, &keep[..1]), Judgement::Unknown(_)));
    }
}
