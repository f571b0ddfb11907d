//! Answers to tasks beyond yes or no, formatted for people.

use std::fmt::Write;

use nearmiss_scene::verdict::{Moment, Motion, ParsedAnswer};
use nearmiss_study::evaluation::MissingVerdict;

/// Why there is no verdict. An address that cannot be reached was tried, other than what is refused beforehand.
pub(super) fn missing(missing: &MissingVerdict) -> String {
    match missing {
        MissingVerdict::NotSent(why) => format!("no answer: {why}"),
        MissingVerdict::NoAnswer(why) if is_too_long(why) => format!(
            "{missing}; a shorter question may fit: --set form=compact, a smaller --history or radius, --techniques base"
        ),
        missing => missing.to_string(),
    }
}

/// Whether a server means that the question is longer than what its model can take.
fn is_too_long(why: &str) -> bool {
    let why = why.to_ascii_lowercase();
    let context = ["length", "window", "size", "maximum", "exceed", "limit"];
    (why.contains("(400") || why.contains("(413"))
        && ((why.contains("context") && context.iter().any(|word| why.contains(word)))
            || why.contains("too long")
            || why.contains("too many tokens"))
}

/// Who could attack, or how an attacker moves; the verdicts of the other tasks are in `ask` itself.
pub(super) fn said(said: &ParsedAnswer, model: &str) -> String {
    let mut text = String::new();
    let mut line = |words: String| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{words}");
    };
    match said {
        ParsedAnswer::Verdict(verdict) => {
            line(format!("\nverdict       {} ({model})", verdict.word()))
        }
        ParsedAnswer::Attacker(choice) => {
            let who = choice.attacker.map_or("none".into(), |id| id.to_string());
            line(format!("\nattacker      {who} ({model})"));
            for o in &choice.obstacles {
                line(format!(
                    "  risk {}      {}  {}",
                    o.risk_score, o.id, o.reason
                ));
            }
        }
        ParsedAnswer::Trajectory(new) => {
            line(format!("\nobstacle      {} ({model})", new.obstacle));
            match &new.motion {
                Motion::Manoeuvre(m) => {
                    let number = |name: &str, value: Option<f64>, unit: &str| {
                        value.map_or(String::new(), |v| format!(", {name} {v:.2} {unit}"))
                    };
                    line(format!(
                        "manoeuvre     {} from {:.2} s for {:.2} s{}{}",
                        m.kind.name(),
                        m.start,
                        m.duration,
                        number("gap", m.gap, "m"),
                        number("speed", m.speed, "m/s"),
                    ));
                }
                Motion::Waypoints(points) => {
                    for p in points {
                        let at = match p.at {
                            Moment::Step(step) => format!("step {step}"),
                            Moment::Seconds(time) => format!("{time:.2} s"),
                        };
                        let number = |name: &str, value: Option<f64>, unit: &str| {
                            value.map_or(String::new(), |v| format!("  {name} {v:.3} {unit}"))
                        };
                        line(format!(
                            "  {at:<11} ({:.3}, {:.3}) m{}{}",
                            p.x,
                            p.y,
                            number("heading", p.heading, "rad"),
                            number("velocity", p.velocity, "m/s"),
                        ));
                    }
                }
            }
        }
    }
    line(format!("justification {}", said.justification()));
    text
}
