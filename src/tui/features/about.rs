//! Contents of the opened scenario, and what reading it assumed or skipped.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Color, Modifier, Style};
use ratatui::text::{Line, Span, Text};

use crate::action::Action;
use crate::features::Screen;
use crate::loaded::Opened;
use crate::model::Model;
use crate::widgets::hints::{self, Hint};
use crate::widgets::window;
use crate::widgets::words::{pad, two_lines};
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::{Severity, in_short};

/// The contents of the opened scenario.
#[derive(Debug, Default)]
pub struct AboutScreen {
    scroll: usize,
}

impl Screen for AboutScreen {
    fn scroll_mut(&mut self) -> Option<&mut usize> {
        Some(&mut self.scroll)
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let width = window::text_width(screen);
        let contents = match &model.opened {
            Some(opened) => about(model, opened, width),
            None => Text::raw(match &model.open_error {
                Some(error) => visible(error).into_owned(),
                None => "no scenario is open".into(),
            }),
        };
        let mut text = Text::default();
        if two_lines(
            &model.last_message,
            usize::from(screen.width.saturating_sub(2)),
        )
        .1
        {
            text.push_line(Line::styled("last message", title(model)));
            push_wrapped(&mut text, &model.last_message, width, model.theme.text);
            text.push_line("");
        }
        text.extend(contents);
        passed_over(model, &mut text, width);
        window::scrolled(frame, screen, model, "scenario", text, self.scroll);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        vec![
            hints::scroll(model),
            hints::page(model),
            hints::close(model),
        ]
    }
}

/// Most files to name; more would add no information.
const MAX_NAMED: usize = 100;

/// Files that the list leaves out.
fn passed_over(model: &Model, text: &mut Text<'static>, width: usize) {
    let all = &model.list.passed_over;
    if all.is_empty() {
        return;
    }
    text.push_line("");
    text.push_line(Line::styled("skipped files", title(model)));
    for one in all.iter().take(MAX_NAMED) {
        push_wrapped(text, &one.to_string(), width, model.theme.warning);
    }
    if all.len() > MAX_NAMED {
        text.push_line(format!("  and {} more", all.len() - MAX_NAMED));
    }
}

fn title(model: &Model) -> Style {
    Style::new()
        .fg(model.theme.picked)
        .add_modifier(Modifier::BOLD)
}

/// A paragraph with a hanging indent.
fn push_wrapped(text: &mut Text<'static>, words: &str, width: usize, color: Color) {
    let hanging = textwrap::Options::new(width.max(10))
        .initial_indent("  ")
        .subsequent_indent("    ");
    for line in textwrap::wrap(&visible(words), hanging) {
        text.push_line(Line::styled(line.into_owned(), Style::new().fg(color)));
    }
}

/// Columns before a value.
const INDENT: usize = 14;

fn about(model: &Model, opened: &Opened, width: usize) -> Text<'static> {
    let theme = &model.theme;
    let title = title(model);
    let word = Style::new().fg(theme.accent);
    let scenario = &opened.scenario;
    let mut text = Text::from(Line::styled(visible(&opened.name).into_owned(), title));
    let mut line = |name: &str, said: &str| {
        let said = visible(said);
        let mut wrapped = textwrap::wrap(&said, width.saturating_sub(INDENT).max(10)).into_iter();
        text.push_line(Line::from(vec![
            Span::styled(format!("  {}", pad(name, INDENT - 2)), word),
            Span::raw(wrapped.next().unwrap_or_default().into_owned()),
        ]));
        for more in wrapped {
            text.push_line(format!("{:INDENT$}{more}", ""));
        }
    };
    line("file", &opened.file);
    line("hash", &scenario.hash.to_string());
    for (name, said) in scenario.summary() {
        line(name, &said);
    }
    match (&opened.scene, &opened.no_ego) {
        (Some(scene), _) => {
            let (first, last) = (scene.steps().start, scene.last_step());
            let (id, source) = (scene.ego.id, &scene.ego.source);
            line("ego", &format!("{id}, {source}, steps {first} to {last}"));
        }
        (None, Some(why)) => line("ego", &why.to_string()),
        (None, None) => line("ego", "none"),
    }
    let possible = scenario.possible_egos();
    if !possible.is_empty() {
        let ids: Vec<String> = possible.iter().map(i64::to_string).collect();
        let (pick, take) = (Action::NextObstacle, Action::TakeAsEgo);
        let (pick, take) = (model.look.key(pick), model.look.key(take));
        let words = format!("{} ({pick} select, {take} use)", ids.join(", "));
        line("as ego", &words);
    }
    text.push_line("");
    text.push_line(Line::styled("parser notes", title));
    let ego = opened
        .scene
        .iter()
        .flat_map(|s| in_short(&s.ego.diagnostics))
        .map(|(severity, words)| (severity, format!("ego {words}")));
    let all: Vec<_> = ego.chain(in_short(&scenario.diagnostics)).collect();
    if all.is_empty() {
        text.push_line("  nothing");
    }
    for (severity, words) in all {
        let color = match severity {
            Severity::Warning => theme.warning,
            Severity::Note | Severity::Unused => theme.dim,
        };
        push_wrapped(&mut text, &words, width, color);
    }
    text
}
