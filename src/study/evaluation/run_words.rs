//! Runs and answers in words, for every face: everything that people want to know of a run beside its verdict and its
//! texts, and motions that answers ask for.

use super::consumption::{local_time, tokens, took, unknown};
use super::prompt_summary::TemplateVersion;
use nearmiss_scene::judge;
use nearmiss_scene::verdict::{Moment, Motion, Waypoint};
use nearmiss_store::{Origin, Run};

/// Names and values, what people look for first; `most` is what it can have cost, US dollars.
#[must_use]
pub fn run_words(run: &Run, most: Option<f64>) -> Vec<(&'static str, String)> {
    let (question, ending) = (&run.question, &run.ending);
    let name = question.model.split_once('/').map(|(_, name)| name);
    let other = ending.model_returned.clone();
    let asked = || format!("{} · {}", question.frame, question.techniques);
    let how = judge::how(&question.model);
    // The built-in judge reads no prompt.
    let template = || TemplateVersion::described(&question.template());
    let window = question.window;
    let window = || window.map(|(first, last)| format!("{first} to {last}"));
    let steps = judge::looks_at(&question.model, question.task).map(String::from);
    // The time of a recorded answer is unknown.
    let when = match run.origin {
        Origin::Recorded => "imported",
        Origin::Asked | Origin::Replayed => "asked",
    };
    let rows = [
        ("state", Some(ending.state.name().into())),
        ("problem", ending.error.clone()),
        ("reading", ending.reading.clone()),
        ("model", Some(question.model.clone())),
        ("answered by", other.filter(|other| Some(&**other) != name)),
        ("scenario", Some(question.scenario.clone())),
        ("ego", Some(question.ego.clone())),
        ("task", Some(question.task.name().into())),
        ("asked with", Some(how.map_or_else(asked, String::from))),
        ("steps", steps.or_else(window)),
        (when, Some(local_time(run.created_ms))),
        ("took", took(&ending.consumed)),
        ("tokens", tokens(&ending.consumed)),
        ("cost", cost(run, most)),
        ("notes", Some(run.notes.clone())),
        ("pinned", run.pinned.then(|| "yes".into())),
        ("deleted", run.deleted_ms.map(local_time)),
        ("batch", question.batch.clone()),
        (
            "sample",
            (question.sample > 0).then(|| question.sample.to_string()),
        ),
        ("origin", Some(run.origin.name().into())),
        ("read from", run.source.clone()),
        ("server", Some(question.endpoint.clone())),
        ("template", how.map_or_else(template, |_| None)),
        (
            "parameters",
            Some(question.parameters.clone()).filter(|p| p != "{}"),
        ),
    ];
    rows.into_iter()
        .filter_map(|(name, value)| Some((name, value.filter(|v| !v.is_empty())?)))
        .collect()
}

/// What a run cost, and whose figure that is; nothing of what costs nothing here.
fn cost(run: &Run, most: Option<f64>) -> Option<String> {
    let (question, ending) = (&run.question, &run.ending);
    Some(match (ending.consumed.cost_usd, most) {
        (Some(usd), _) => {
            let source = ending.price_source.as_deref().unwrap_or("source unknown");
            format!("{usd} US dollars ({source})")
        }
        (None, _) if run.origin == Origin::Recorded || question.model == judge::MODEL => {
            return None;
        }
        (None, Some(0.0)) => "0 US dollars (nothing was sent, or the server is free)".into(),
        (None, Some(most)) => format!(
            "at most {most:.6} US dollars (no token counts from the server; computed from estimated tokens, the token limit and prices)"
        ),
        (None, None) => {
            let returned = ending.model_returned.as_deref();
            format!(
                "unknown ({})",
                unknown(&ending.consumed, &question.model, returned)
            )
        }
    })
}

/// A motion that an answer asks for, a line for each of its parts.
#[must_use]
pub fn motion_words(motion: &Motion) -> Vec<String> {
    let number = |name: &str, value: Option<f64>, unit: &str| {
        value.map_or(String::new(), |v| format!(", {name} {v:.2} {unit}"))
    };
    match motion {
        Motion::Manoeuvre(m) => vec![format!(
            "{} from {:.2} s for {:.2} s{}{}",
            m.kind.name(),
            m.start,
            m.duration,
            number("gap", m.gap, "m"),
            number("speed", m.speed, "m/s"),
        )],
        Motion::Waypoints(points) => {
            let words = |p: &Waypoint| {
                let at = match p.at {
                    Moment::Step(step) => format!("step {step}"),
                    Moment::Seconds(seconds) => format!("{seconds:.2} s"),
                };
                format!(
                    "{at}: ({:.2}, {:.2}) m{}{}",
                    p.x,
                    p.y,
                    number("heading", p.heading, "rad"),
                    number("velocity", p.velocity, "m/s"),
                )
            };
            points.iter().map(words).collect()
        }
    }
}
