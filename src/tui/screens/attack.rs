//! Confirmation of attacks that a model writes: how many requests that is, and what they cost at most.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};

use super::{Screen, Step};
use crate::action::Action;
use crate::keymap::Key;
use crate::loaded::VariantRequest;

use crate::model::JobId;
use crate::model::Model;
use crate::tasks::making::Generate;
use crate::widgets::hints::Hint;
use crate::widgets::window;
use crate::widgets::words::thousands;
use nearmiss_scene::description::visible;

/// The confirmation, with what is asked on a yes.
#[derive(Debug)]
pub struct AttackScreen {
    /// The work; taken on a yes.
    pub request: Option<Box<VariantRequest>>,
    /// The scenario's place in the list.
    pub place: usize,
    /// The model.
    pub asked: String,
    /// What it is asked.
    pub task: String,
    /// Requests at most.
    pub requests: usize,
    /// Of these, votes for the attacker, answers about motions, and grades of motions.
    pub counts: (u32, u32, u32),
    /// Tokens of the questions at most, estimated.
    pub tokens: usize,
    /// Their cost at most, in words.
    pub price: String,
    /// Said on a yes.
    pub reply: String,
}

/// Columns of the window.
const COLUMNS: u16 = 76;

impl Screen for AttackScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        match key.writes()? {
            'y' => Some(self.begin(model)),
            'n' => Some(Step::close()),
            _ => None,
        }
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            Action::Accept => self.begin(model),
            Action::Cancel | Action::Quit => Step::close(),
            _ => Step::stay(),
        }
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let [yes, no] = [Action::Accept, Action::Cancel].map(|action| model.look.key(action));
        let title = format!("let a model attack · {yes} ask · {no} cancel");
        let text = Paragraph::new(self.text(model)).wrap(Wrap { trim: false });
        let width = window::width_in(screen, COLUMNS);
        let lines = text.line_count(u16::try_from(width).unwrap_or(u16::MAX));
        let height = u16::try_from(lines + 2).unwrap_or(u16::MAX);
        let inner = window::window(frame, screen, model, &title, (COLUMNS, height));
        frame.render_widget(text, inner);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let key = |action, words: &str| (model.look.key(action), words.to_string());
        vec![key(Action::Accept, "ask"), key(Action::Cancel, "cancel")]
    }
}

impl AttackScreen {
    fn begin(&mut self, model: &mut Model) -> Step {
        let Some(request) = self.request.take() else {
            return Step::close();
        };
        let id = JobId(model.new_id());
        model.say(self.reply.clone());
        model.maker.begin(id, self.place);
        Step::Close(vec![Generate { id, request }.into()])
    }

    fn text(&self, model: &Model) -> Text<'static> {
        let dim = Style::new().fg(model.theme.dim);
        let bold = Style::new().add_modifier(Modifier::BOLD);
        let (votes, motions, grades) = self.counts;
        let votes = match votes {
            0 => String::new(),
            1 => "1 vote for the attacker, ".into(),
            n => format!("{n} votes for the attacker, "),
        };
        let requests = format!(
            "up to {}: {votes}{motions} about motions, which go back with reasons or with what came of the drive, {grades} to grade them",
            self.requests
        );
        let tokens = thousands(self.tokens as u64);
        let rows = [
            ("model", self.asked.clone(), bold),
            ("task", self.task.clone(), Style::new()),
            ("requests", requests, bold),
            (
                "tokens",
                format!("about {tokens} in the questions at most"),
                Style::new(),
            ),
            ("price", self.price.clone(), bold),
        ];
        let bound = model
            .prompt
            .prices
            .bound(&self.asked)
            .map(|bound| ("counted", bound, Style::new()));
        let rows = rows.into_iter().chain(bound);
        let line = |(name, value, style): (&str, String, Style)| {
            let value = visible(&value).into_owned();
            Line::from(vec![
                Span::styled(format!(" {name:<9} "), dim),
                Span::styled(value, style),
            ])
        };
        let mut text: Text<'static> = rows.map(line).collect();
        if self.price.contains("+ answers") {
            text.push_line(Line::styled(
                " max_tokens in config.toml bounds the length of answers, and so the price",
                Style::new().fg(model.theme.warning),
            ));
        }
        text
    }
}
