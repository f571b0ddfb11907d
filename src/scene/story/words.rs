//! The facts of a story in plain English.

use super::{Action, Beside, Course, Fact, Who};
use crate::metrics::Direction;
use crate::scenario::ObstacleType;

/// A road user in words: `car 30640`, `parked vehicle 309`.
pub(super) fn name(kind: ObstacleType, id: i64) -> String {
    let mut words = kind.words();
    if words == "unknown" {
        words = "obstacle".into();
    }
    format!("{words} {id}")
}

/// Facts as a sentence; the other is `subject` where it is named, else `it`.
pub(super) fn sentence(subject: &str, facts: &[Fact]) -> String {
    let mut said = String::new();
    // The one that the clause before is about, what it does there and until when.
    let mut before: Option<(Who, Action, f64)> = None;
    for (place, fact) in facts.iter().enumerate() {
        let does = as_does(fact);
        let after = does.zip(before).filter(|(does, before)| does.0 == before.0);
        let is_last = !facts[place + 1..]
            .iter()
            .any(|fact| as_does(fact).is_some());
        let link = match (fact, after) {
            _ if place == 0 => "",
            (Fact::ShortTtc { .. }, _) => ", ",
            _ if is_outside(fact) => " ",
            (_, None) => "; ",
            (_, Some(_)) if is_last => " and ",
            (_, Some(_)) => ", ",
        };
        said.push_str(link);
        if let Fact::Does { from, .. } = fact
            && after.is_some_and(|(_, (.., until))| *from >= until)
        {
            said.push_str("then ");
        }
        let again = after.is_some_and(|((_, now, _), (_, last, _))| now.verb() == last.verb());
        said.push_str(&clause(subject, fact, after.is_some(), again, facts));
        before = does.or(before);
    }
    let mut letters = said.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

/// Whether it is of the whole recording, and in brackets behind that of the story.
fn is_outside(fact: &Fact) -> bool {
    match fact {
        Fact::LowestTtc { is_outside, .. } | Fact::Nearest { is_outside, .. } => *is_outside,
        _ => false,
    }
}

fn as_does(fact: &Fact) -> Option<(Who, Action, f64)> {
    match *fact {
        Fact::Does {
            who, to, action, ..
        } => Some((who, action, to)),
        _ => None,
    }
}

impl Action {
    fn verb(&self) -> &'static str {
        match self {
            Self::Brake { .. } => "brakes",
            Self::SlowDown { .. } => "slows down",
            Self::SpeedUp { from_speed, .. } if *from_speed < super::STANDING => "starts",
            Self::SpeedUp { .. } => "speeds up",
            Self::Turn { degrees } if *degrees > 0.0 => "turns left",
            Self::Turn { .. } => "turns right",
            Self::ChangeLanes { lane } => match lane {
                Beside::Left => "changes lanes to the left",
                Beside::Right => "changes lanes to the right",
                Beside::Oncoming => "moves into the oncoming lane",
                Beside::Own => "moves out of the oncoming lane",
            },
            Self::NotBrake => "does not brake",
            Self::KeepOn { .. } => "keeps on",
        }
    }

    /// What is said after the verb.
    fn object(&self) -> String {
        let to = |speed: f64| match speed {
            speed if speed < super::STANDING => "to a stand".into(),
            speed => format!("to {speed:.1} m/s"),
        };
        let from = |speed: f64, to_speed: f64| match to_speed {
            to_speed if to_speed < super::STANDING => format!("from {speed:.1} m/s"),
            _ => format!("from {speed:.1}"),
        };
        match *self {
            Self::Brake {
                from_speed,
                to_speed,
                ..
            }
            | Self::SlowDown {
                from_speed,
                to_speed,
            } => format!("{} {}", from(from_speed, to_speed), to(to_speed)),
            Self::SpeedUp {
                from_speed,
                to_speed,
            } if from_speed < super::STANDING => format!("and speeds up {}", to(to_speed)),
            Self::SpeedUp {
                from_speed,
                to_speed,
            } => format!("{} {}", from(from_speed, to_speed), to(to_speed)),
            Self::Turn { degrees } => format!("by {:.0}°", degrees.abs()),
            Self::ChangeLanes { .. } | Self::NotBrake => String::new(),
            Self::KeepOn { low, high } => match (format!("{low:.1}"), format!("{high:.1}")) {
                (low, high) if low == high => format!("with {low} m/s"),
                (low, high) => format!("with {low} to {high} m/s"),
            },
        }
    }
}

fn moves(course: Course, place: Direction) -> &'static str {
    match course {
        Course::Region => "may be",
        Course::Stands => "stands",
        Course::SameWay => "moves the same way",
        Course::Towards => "moves the opposite way",
        Course::ToTheLeft if place.is_left() => "moves away to the left",
        Course::ToTheRight if place.is_right() => "moves away to the right",
        Course::ToTheLeft => "moves across from right to left",
        Course::ToTheRight => "moves across from left to right",
    }
}

fn clause(subject: &str, fact: &Fact, same: bool, again: bool, facts: &[Fact]) -> String {
    let one = |who: Who| match (who, same) {
        (_, true) => "",
        (Who::Ego, _) => "the ego ",
        (Who::Other, _) => "it ",
    };
    match *fact {
        Fact::Begin {
            time,
            ego_speed,
            other_speed,
            distance,
            place,
            course,
            later,
        } => {
            let ego = match ego_speed {
                speed if speed < super::STANDING => "stands".into(),
                speed => format!("drives {speed:.1} m/s"),
            };
            let speed = match course {
                Course::Region | Course::Stands => String::new(),
                _ => format!(" with {other_speed:.1} m/s"),
            };
            // Who creeps soon goes another way.
            let creeps = if later.is_some() { "creeps" } else { "moves" };
            let later = later.map_or(String::new(), |later| {
                format!(" and then {}", moves(later, place))
            });
            let moves = moves(course, place).replace("moves", creeps);
            let there = match place {
                Direction::Contact => side(place).into(),
                place => format!("{distance:.1} m away {}", side(place)),
            };
            format!("at {time:.1} s the ego {ego}; {subject}, {there}, {moves}{speed}{later}")
        }
        Fact::Does {
            who,
            from,
            to,
            action,
        } => {
            let (verb, object) = (action.verb(), action.object());
            let again = if again { " again" } else { "" };
            let object = if object.is_empty() {
                object
            } else {
                format!(" {object}")
            };
            let when = if from == to {
                format!("at {from:.1} s")
            } else {
                format!("between {from:.1} and {to:.1} s")
            };
            let most = match action {
                Action::Brake { most, .. } if most > GRIP => {
                    format!(", with up to {most:.1} m/s² (more than tyres hold)")
                }
                Action::Brake { most, .. } => format!(", with up to {most:.1} m/s²"),
                _ => String::new(),
            };
            format!("{}{verb}{again}{object} {when}{most}", one(who))
        }
        Fact::Pass {
            first,
            left,
            entered,
        } => {
            let (first, second) = match first {
                Who::Ego => ("the ego", subject),
                Who::Other => ("it", "the ego"),
            };
            let after = entered - left;
            format!(
                "{first} leaves the place where their ways overlap at {left:.1} s, {after:.1} s before {second} comes there"
            )
        }
        Fact::LowestTtc {
            time,
            seconds,
            is_outside,
            is_last,
        } => {
            let seconds = least(seconds, "s", 2);
            if is_outside
                && !matches!(
                    facts[0],
                    Fact::LowestTtc {
                        is_outside: true,
                        ..
                    }
                )
            {
                return format!("(in the whole recording at {time:.1} s: {seconds})");
            }
            let whole = if is_outside {
                " in the whole recording"
            } else {
                ""
            };
            let last = if is_last {
                ", the last step with both"
            } else {
                ""
            };
            format!("their time to collision is lowest{whole} at {time:.1} s{last}: {seconds}")
        }
        Fact::ShortTtc { time, .. } => match facts {
            [Fact::ShortTtc { .. }, ..] => {
                format!("their time to collision stays at most 3 s from {time:.1} s on")
            }
            _ => {
                let late = facts.iter().find_map(|fact| match fact {
                    Fact::Does {
                        from,
                        action: Action::Brake { .. },
                        ..
                    } => Some(from - time),
                    _ => None,
                });
                format!(
                    "{:.1} s after their time to collision last fell to 3 s or less at {time:.1} s",
                    late.unwrap_or_default()
                )
            }
        },
        Fact::NoCourse => "going straight on they would at no time touch within 10 s".into(),
        Fact::Contact {
            time,
            closing_speed,
            by_places,
            is_possible,
        } => {
            let touch = if is_possible { "may touch" } else { "touch" };
            let speed = match (format!("{closing_speed:.1}").as_str(), by_places) {
                // Who moves as the other does has no speed to tell.
                ("0.0", None) => String::new(),
                (speed, None) => format!(", with {speed} m/s relative to each other"),
                (speed, Some(by_places)) => format!(
                    ", with {speed} m/s relative to each other as recorded and {by_places:.1} m/s by places"
                ),
            };
            format!("at {time:.1} s they {touch}{speed}")
        }
        Fact::Nearest {
            time,
            distance,
            place,
            is_outside,
        } => {
            let (distance, place) = (least(distance, "m", 2), side(place));
            if is_outside {
                format!("(in the whole recording at {time:.1} s: {distance}, {place})")
            } else {
                format!("they are nearest at {time:.1} s: {distance}, with {subject} {place}")
            }
        }
        Fact::Uncertain { overlap } => format!(
            "whether they touch between two steps is not certain: on straight ways they would, by {}",
            least(overlap, "m", 2)
        ),
        Fact::SpeedsOff { who, by } => {
            let whose = match who {
                Who::Ego => "the ego",
                Who::Other => subject,
            };
            format!("recorded speeds of {whose} are off those by its places by up to {by:.1} m/s")
        }
    }
}

/// Tyres hold no more, m/s².
const GRIP: f64 = 10.0;

/// A number of which the last digit is not all that is left.
fn least(value: f64, unit: &str, digits: usize) -> String {
    let last = 0.1_f64.powi(digits as i32);
    if value > 0.0 && value < last {
        format!("less than {last:.digits$} {unit}")
    } else {
        format!("{value:.digits$} {unit}")
    }
}

/// Where the other is, seen from the ego's body.
fn side(place: Direction) -> &'static str {
    match place {
        Direction::Front => "ahead",
        Direction::FrontLeft => "ahead on the left",
        Direction::FrontRight => "ahead on the right",
        Direction::Behind => "behind",
        Direction::RearLeft => "behind on the left",
        Direction::RearRight => "behind on the right",
        Direction::Left => "on the left",
        Direction::Right => "on the right",
        Direction::Contact => "in contact",
    }
}
