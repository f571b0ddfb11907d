//! All details of one stored run, as text.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use serde_json::Value;

use crate::model::Model;
use crate::widgets::words::{date, duration, thousands};
use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use nearmiss_store::{Origin, Run};
use nearmiss_study::evaluation::TemplateVersion;
use nearmiss_study::evaluation::tool_rounds;

/// Columns of the names.
const NAME: usize = 12;

/// The run; `truth` is what the built-in judge says to the same question, where that is known.
pub fn text(model: &Model, run: &Run, truth: Option<bool>) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let title = Style::new().fg(theme.picked).add_modifier(Modifier::BOLD);
    let mut text = Text::default();
    for (name, value, style) in rows(model, run, truth) {
        let value = visible(&value).replace(['\n', '\t'], " ");
        text.push_line(Line::from(vec![
            Span::styled(format!("{name:<NAME$} "), dim),
            Span::styled(value, style),
        ]));
    }
    let mut part = |name: &str, words: &str| {
        if words.trim().is_empty() {
            return;
        }
        text.push_line("");
        text.push_line(Line::styled(format!("── {name} ──"), title));
        for line in visible(words.trim_end()).lines() {
            text.push_line(line.replace('\t', "    "));
        }
    };
    let rounds = tool_rounds::stored(run.tool_rounds.as_deref());
    let calls: Vec<String> = rounds.iter().flat_map(tool_rounds::lines).collect();
    part("tool calls", &calls.join("\n"));
    part("reasoning", &run.reasoning);
    part("answer", &run.answer);
    for (role, content) in messages(&run.question.messages) {
        part(&format!("message: {role}"), &content);
    }
    text
}

/// Names and values, in the order of what people look for.
fn rows(model: &Model, run: &Run, truth: Option<bool>) -> Vec<(&'static str, String, Style)> {
    let theme = &model.theme;
    let plain = Style::new();
    let bold = |color| Style::new().fg(color).add_modifier(Modifier::BOLD);
    let (question, ending, consumed) = (&run.question, &run.ending, &run.ending.consumed);
    let mut rows = Vec::new();
    let verdict = ending.verdict.as_ref().and_then(|said| said.verdict());
    let said = verdict.map(|verdict| verdict.dangerous);
    if let Some(verdict) = verdict {
        let color = if verdict.dangerous {
            theme.danger
        } else {
            theme.danger_low
        };
        rows.push(("verdict", verdict.word().to_string(), bold(color)));
    }
    if question.model != judge::MODEL {
        let words = |dangerous| if dangerous { "yes" } else { "no" };
        let (value, style) = match (truth, said) {
            (Some(truth), Some(said)) if truth == said => {
                (format!("= {}", words(truth)), bold(theme.agree))
            }
            (Some(truth), Some(_)) => (format!("≠ {}", words(truth)), bold(theme.disagree)),
            (Some(truth), None) => (words(truth).to_string(), plain),
            (None, _) => ("unknown".to_string(), Style::new().fg(theme.dim)),
        };
        rows.push(("built-in", value, style));
    }
    let mut row = |name, value: Option<String>| {
        if let Some(value) = value.filter(|v| !v.is_empty()) {
            rows.push((name, value, plain));
        }
    };
    row("state", Some(ending.state.name().into()));
    row("problem", ending.error.clone());
    row("reading", ending.reading.clone());
    row("model", Some(question.model.clone()));
    let other = ending.model_returned.clone();
    let name = question.model.split_once('/').map(|(_, name)| name);
    row(
        "answered by",
        other.filter(|other| Some(other.as_str()) != name),
    );
    row("scenario", Some(question.scenario.clone()));
    row("ego", Some(question.ego.clone()));
    let asked = || format!("{} · {}", question.frame, question.techniques);
    let how = judge::how(&question.model).map_or_else(asked, String::from);
    row("asked", Some(format!("{} · {how}", question.task.name())));
    let window = question
        .window
        .map(|(first, last)| format!("{first} to {last}"));
    let all = judge::looks_at(&question.model, question.task).map(String::from);
    row("steps", all.or(window));
    let (when, at) = match run.origin {
        // The time of a recorded answer is unknown.
        Origin::Recorded => ("imported", date(run.created_ms)),
        Origin::Asked | Origin::Replayed => ("when", date(run.created_ms)),
    };
    row(when, Some(at));
    row("took", times(run));
    row("tokens", tokens(run));
    let source = ending.price_source.as_deref().unwrap_or("source unknown");
    row(
        "cost",
        consumed.cost_usd.map(|usd| format!("${usd:.6} ({source})")),
    );
    row("notes", Some(run.notes.clone()));
    row("pinned", run.pinned.then(|| "yes".into()));
    row("deleted", run.deleted_ms.map(date));
    row("batch", question.batch.clone());
    let sample = Some(question.sample).filter(|n| *n > 0);
    row("sample", sample.map(|n| n.to_string()));
    row("origin", Some(run.origin.name().into()));
    row("read from", run.source.clone());
    row("server", Some(question.endpoint.clone()));
    row("template", TemplateVersion::described(&question.template()));
    row(
        "parameters",
        Some(question.parameters.clone()).filter(|p| p != "{}"),
    );
    rows
}

fn times(run: &Run) -> Option<String> {
    let consumed = &run.ending.consumed;
    let whole = consumed.duration_ms.map(duration)?;
    Some(match consumed.first_chunk_ms {
        Some(first) => format!("{whole}, {} to first token", duration(first)),
        None => whole,
    })
}

fn tokens(run: &Run) -> Option<String> {
    let consumed = &run.ending.consumed;
    let count = |tokens: Option<u64>| tokens.map_or("unknown".into(), thousands);
    consumed.input_tokens.or(consumed.output_tokens)?;
    let mut words = format!(
        "{} in, {} out",
        count(consumed.input_tokens),
        count(consumed.output_tokens)
    );
    if let Some(reasoning) = consumed.reasoning_tokens {
        words.push_str(&format!(", {} of them reasoning", thousands(reasoning)));
    }
    Some(words)
}

/// Roles and contents of the messages; of what is no list of messages, the text as it is.
fn messages(json: &str) -> Vec<(String, String)> {
    let Ok(Value::Array(all)) = serde_json::from_str(json) else {
        return vec![("as stored".into(), json.to_string())];
    };
    let text = |message: &Value, name: &str| match &message[name] {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    };
    let pictures = |message: &Value| -> String {
        let images = message["images"].as_array().into_iter().flatten();
        let words = |image: &Value| {
            let hash = text(image, "sha256");
            format!("\n\n[picture {hash}: nearmiss runs show writes it]")
        };
        images.map(words).collect()
    };
    all.iter()
        .map(|m| (text(m, "role"), text(m, "content") + &pictures(m)))
        .collect()
}
