//! All details of one stored run, as text.

use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};

use crate::model::Model;
use nearmiss_ask::llm::{Image, Message};
use nearmiss_scene::description::visible;
use nearmiss_scene::judge;
use nearmiss_store::Run;
use nearmiss_study::evaluation::{run_summary, tool_rounds};

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
    let (question, ending) = (&run.question, &run.ending);
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
    let words = run_summary(run, run.most_usd).into_iter();
    rows.extend(words.map(|(name, value)| (name, value, plain)));
    rows
}

/// Roles and contents of the messages; of what is no list of messages, the text as it is.
fn messages(json: &str) -> Vec<(String, String)> {
    let Ok(all) = serde_json::from_str::<Vec<Message>>(json) else {
        return vec![("as stored".into(), json.to_string())];
    };
    let pictures = |message: &Message| -> String {
        let images = message.images.iter();
        let words = |image: &Image| {
            format!(
                "\n\n[picture {}: nearmiss runs show writes it]",
                image.sha256
            )
        };
        images.map(words).collect()
    };
    let text = |m: &Message| (m.role.name().into(), m.content.clone() + &pictures(m));
    all.iter().map(text).collect()
}
