//! Answers to tasks beyond yes or no, formatted for people.

use super::line;
use nearmiss_scene::verdict::{Motion, ObstacleRisk, ParsedAnswer};
use nearmiss_study::evaluation::{MissingVerdict, motion_lines};

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

/// Who could attack, or how an attacker moves.
pub(super) fn said(said: &ParsedAnswer, model: &str) -> Vec<String> {
    let mut lines = match said {
        ParsedAnswer::Verdict(verdict) => {
            vec![line("verdict", format!("{} ({model})", verdict.word()))]
        }
        ParsedAnswer::Attacker(choice) => {
            let who = choice.attacker.map_or("none".into(), |id| id.to_string());
            let first = line("attacker", format!("{who} ({model})"));
            let risks = choice.obstacles.iter().map(risk);
            std::iter::once(first).chain(risks).collect()
        }
        ParsedAnswer::Trajectory(new) => {
            let first = line("obstacle", format!("{} ({model})", new.obstacle));
            let name = match new.motion {
                Motion::Manoeuvre(_) => "manoeuvre",
                Motion::Waypoints(_) => "waypoint",
            };
            let parts = motion_lines(&new.motion);
            let motion = parts.iter().map(|words| line(name, words));
            std::iter::once(first).chain(motion).collect()
        }
    };
    lines.push(line("justification", said.justification()));
    lines
}

/// The score of an obstacle, and why.
pub(super) fn risk(one: &ObstacleRisk) -> String {
    format!("  risk {}      {}  {}", one.risk_score, one.id, one.reason)
}
