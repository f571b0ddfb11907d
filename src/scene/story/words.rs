//! The facts of a story in plain English.

use super::{Course, Fact, Who};
use crate::metrics::Direction;
use crate::scenario::ObstacleType;

/// A road user in words: `car 30640`, `parked vehicle 309`.
pub(super) fn name(kind: ObstacleType, id: i64) -> String {
    let mut words = String::new();
    for letter in kind.name().chars() {
        if letter.is_ascii_uppercase() {
            words.push(' ');
        }
        words.push(letter.to_ascii_lowercase());
    }
    if words == "unknown" {
        words = "obstacle".into();
    }
    format!("{words} {id}")
}

/// Facts as a sentence; the other is `subject` where it is named, else `it`.
pub(super) fn sentence(subject: &str, facts: &[Fact]) -> String {
    let mut said = String::new();
    let mut about = None;
    for (place, fact) in facts.iter().enumerate() {
        let who = who_of(fact);
        let same = who.is_some() && who == about;
        let next = facts.get(place + 1);
        let goes_on = next.is_some_and(|next| who_of(next) == who && !is_then(fact, next));
        let link = match (fact, place) {
            (_, 0) => "",
            (Fact::ShortTtc { .. }, _) => ", ",
            _ if is_then(&facts[place - 1], fact) => ", then ",
            (Fact::Pass { .. }, _) => "; ",
            (Fact::Contact { .. } | Fact::Nearest { .. }, _) => "; ",
            _ if same && goes_on => ", ",
            _ if same => " and ",
            _ => "; ",
        };
        said.push_str(link);
        said.push_str(&clause(subject, fact, same, facts));
        about = who.or(about);
    }
    let mut letters = said.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

/// Whether what one does is said to follow a braking.
fn is_then(before: &Fact, fact: &Fact) -> bool {
    let after_braking = matches!(before, Fact::Brake { .. } | Fact::ShortTtc { .. });
    after_braking && who_of(fact).is_some()
}

fn who_of(fact: &Fact) -> Option<Who> {
    match fact {
        Fact::Turn { who, .. }
        | Fact::Brake { who, .. }
        | Fact::NoBrake { who, .. }
        | Fact::SpeedUp { who, .. }
        | Fact::SlowDown { who, .. }
        | Fact::Speeds { who, .. } => Some(*who),
        _ => None,
    }
}

fn clause(subject: &str, fact: &Fact, same: bool, facts: &[Fact]) -> String {
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
        } => {
            let ego = match ego_speed {
                speed if speed < super::STANDING => "stands".into(),
                speed => format!("drives {speed:.1} m/s"),
            };
            let moves = match course {
                Course::Region => "may be".into(),
                Course::Stands => "stands".into(),
                Course::SameWay => format!("moves the same way with {other_speed:.1} m/s"),
                Course::Towards => format!("moves the opposite way with {other_speed:.1} m/s"),
                Course::ToTheLeft if is_left(place) => {
                    format!("moves away to the left with {other_speed:.1} m/s")
                }
                Course::ToTheRight if is_right(place) => {
                    format!("moves away to the right with {other_speed:.1} m/s")
                }
                Course::ToTheLeft => {
                    format!("moves across from right to left with {other_speed:.1} m/s")
                }
                Course::ToTheRight => {
                    format!("moves across from left to right with {other_speed:.1} m/s")
                }
            };
            let there = match place {
                Direction::Contact => side(place).into(),
                place => format!("{distance:.1} m away {}", side(place)),
            };
            format!("at {time:.1} s the ego {ego}; {subject}, {there}, {moves}")
        }
        Fact::Turn {
            who,
            degrees,
            from,
            to,
        } => {
            let side = if degrees > 0.0 { "left" } else { "right" };
            let degrees = degrees.abs();
            format!(
                "{}turns {side} by {degrees:.0}° between {from:.1} and {to:.1} s",
                one(who)
            )
        }
        Fact::Brake {
            who,
            from,
            to,
            from_speed,
            to_speed,
            most,
        } => {
            let doubt = if most > GRIP {
                " (more than tyres hold)"
            } else {
                ""
            };
            format!(
                "{}brakes from {from_speed:.1} to {to_speed:.1} m/s between {from:.1} and {to:.1} s, with up to {most:.1} m/s²{doubt}",
                one(who)
            )
        }
        Fact::SpeedUp {
            who,
            from,
            to,
            from_speed,
            to_speed,
        } => {
            let speeds_up = if from_speed < super::STANDING {
                "starts and speeds up".into()
            } else {
                format!("speeds up from {from_speed:.1}")
            };
            format!(
                "{}{speeds_up} to {to_speed:.1} m/s between {from:.1} and {to:.1} s",
                one(who)
            )
        }
        Fact::SlowDown {
            who,
            from,
            to,
            from_speed,
            to_speed,
        } => {
            let slower = if to_speed < super::STANDING {
                "m/s to a stand".into()
            } else {
                format!("to {to_speed:.1} m/s")
            };
            format!(
                "{}slows down from {from_speed:.1} {slower} between {from:.1} and {to:.1} s",
                one(who)
            )
        }
        Fact::NoBrake { who, from, to } => {
            format!("{}does not brake between {from:.1} and {to:.1} s", one(who))
        }
        Fact::Speeds {
            who,
            low,
            high,
            from,
            to,
        } => {
            let moves = if super::is_change(high - low, high) {
                "moves"
            } else {
                "keeps on"
            };
            let (low, high) = (format!("{low:.1}"), format!("{high:.1}"));
            let speeds = if low == high {
                low
            } else {
                format!("{low} to {high}")
            };
            format!(
                "{}{moves} with {speeds} m/s between {from:.1} and {to:.1} s",
                one(who)
            )
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
            is_told,
        } => {
            let (whole, seconds) = (whole(is_told), least(seconds, "s", 2));
            format!("the time to collision is lowest{whole} at {time:.1} s: {seconds}")
        }
        Fact::ShortTtc { time, .. } => match facts {
            [Fact::ShortTtc { .. }, ..] => {
                format!("the time to collision is at most 3 s from {time:.1} s on")
            }
            _ => {
                let late = facts.iter().find_map(|fact| match fact {
                    Fact::Brake { from, .. } => Some(from - time),
                    _ => None,
                });
                format!(
                    "{:.1} s after the time to collision fell to 3 s or less at {time:.1} s",
                    late.unwrap_or_default()
                )
            }
        },
        Fact::NoCourse => "going straight on they would at no time touch within 10 s".into(),
        Fact::Contact {
            time,
            closing_speed,
            is_possible,
        } => {
            let touch = if is_possible { "may touch" } else { "touch" };
            // Who moves as the other does has no speed to tell.
            let speed = match format!("{closing_speed:.1}").as_str() {
                "0.0" => String::new(),
                speed => format!(", with {speed} m/s relative to each other"),
            };
            format!("at {time:.1} s they {touch}{speed}")
        }
        Fact::Nearest {
            time,
            distance,
            place,
            is_told,
        } => {
            // Both are said of the whole recording once.
            let outside = matches!(facts, [Fact::LowestTtc { is_told: false, .. }, ..]);
            let (whole, distance) = (whole(is_told || outside), least(distance, "m", 2));
            let place = side(place);
            format!("they are nearest{whole} at {time:.1} s: {distance}, with {subject} {place}")
        }
    }
}

/// Tyres hold no more, m/s².
const GRIP: f64 = 10.0;

fn whole(is_told: bool) -> &'static str {
    if is_told {
        ""
    } else {
        " in the whole recording"
    }
}

/// A number of which the last digit is not all that is left.
fn least(value: f64, unit: &str, digits: usize) -> String {
    let last = 0.1_f64.powi(digits as i32);
    if value > 0.0 && value < last {
        format!("less than {last:.digits$} {unit}")
    } else {
        format!("{value:.digits$} {unit}")
    }
}

fn is_left(place: Direction) -> bool {
    use Direction::{FrontLeft, Left, RearLeft};
    matches!(place, Left | FrontLeft | RearLeft)
}

fn is_right(place: Direction) -> bool {
    use Direction::{FrontRight, RearRight, Right};
    matches!(place, Right | FrontRight | RearRight)
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
