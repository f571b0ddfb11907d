//! Confirmation of a batch: its questions, those already answered, and its cost.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span, Text};
use ratatui::widgets::{Paragraph, Wrap};

use super::{Screen, Step};
use crate::description::visible;
use crate::judge;
use crate::tui::action::Action;
use crate::tui::keymap::Key;
use crate::tui::message::{Effect, JobRequest};
use crate::tui::model::{Card, Model};
use crate::tui::widgets::hints::Hint;
use crate::tui::widgets::window;
use crate::tui::widgets::words::{fit, thousands};
use crate::verdict::Task;

/// The confirmation of a batch, with its estimated consumption.
#[derive(Debug)]
pub struct BatchScreen;

impl Screen for BatchScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        match key.writes()? {
            'y' => Some(begin(model)),
            'n' => Some(decline(model)),
            _ => None,
        }
    }

    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            Action::Accept => begin(model),
            Action::Cancel | Action::Quit => decline(model),
            _ => Step::stay(),
        }
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let Some(card) = &model.card else { return };
        let title = match card.is_counted() {
            true => {
                let (yes, no) = (Action::Accept, Action::Cancel);
                let (yes, no) = (model.look.key(yes), model.look.key(no));
                format!("ask many · {yes} ask · {no} cancel")
            }
            false => "ask many · counting…".to_string(),
        };
        let text = Paragraph::new(text(model, card)).wrap(Wrap { trim: false });
        let lines =
            text.line_count(u16::try_from(window::width_in(screen, 84)).unwrap_or(u16::MAX));
        let height = u16::try_from(lines + 2).unwrap_or(u16::MAX);
        let inner = window::window(frame, screen, model, &title, (84, height));
        frame.render_widget(text, inner);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let key = |action, words: &str| (model.look.key(action), words.to_string());
        vec![key(Action::Accept, "ask"), key(Action::Cancel, "cancel")]
    }
}

/// Closes without asking.
fn decline(model: &mut Model) -> Step {
    let card = model.card.take();
    Step::Close(
        card.map(|card| Effect::Cancel(card.id))
            .into_iter()
            .collect(),
    )
}

/// Asks, or says why it cannot be asked.
fn begin(model: &mut Model) -> Step {
    let Some(card) = model.card.take_if(|card| card.is_counted()) else {
        let key = model.look.key(Action::Accept);
        model.say(format!("still counting; {key} asks when done"));
        return Step::stay();
    };
    let estimate = &card.counts.estimate;
    let nothing_to_ask = estimate.requests + estimate.free + estimate.stored == 0;
    if let Some(why) = &card.counts.refused {
        let why = why.clone();
        model.card = Some(card);
        model.say(why);
        return Step::stay();
    }
    if nothing_to_ask {
        model.say("there is nothing to ask about");
        return Step::close();
    }
    let key = model.look.key(Action::TaskList);
    model.say(format!(
        "asking {} about {} scenarios; {key} shows progress",
        card.batch.model,
        card.batch.entries.len()
    ));
    Step::Close(vec![Effect::Start(card.id, JobRequest::Batch(card.batch))])
}

fn text(model: &Model, card: &Card) -> Text<'static> {
    let theme = &model.theme;
    let dim = Style::new().fg(theme.dim);
    let bold = Style::new().add_modifier(Modifier::BOLD);
    let (batch, counts) = (&card.batch, &card.counts);
    let mut text = Text::default();
    let mut row = |name: &str, value: String, style: Style| {
        let value = visible(&value).into_owned();
        text.push_line(Line::from(vec![
            Span::styled(format!(" {name:<11} "), dim),
            Span::styled(value, style),
        ]));
    };
    let estimate = &counts.estimate;
    row("model", batch.model.clone(), bold);
    let how = format!(
        "{} · {} · {}",
        batch.task.name(),
        batch.frame.name(),
        batch.techniques
    );
    row("how", how, Style::new());
    if batch.draft.is_some() {
        row(
            "prompt",
            "draft, not saved".into(),
            Style::new().fg(theme.warning),
        );
    }
    let window = match batch.task {
        Task::Collision => "the end of each scenario".to_string(),
        _ => format!(
            "of each scenario the {} steps that end two before the last",
            batch.history
        ),
    };
    row("window", window, Style::new());
    let which = if card.marked { "marked" } else { "listed" };
    row(
        "scenarios",
        format!("{} {which}", batch.entries.len()),
        Style::new(),
    );
    if !card.is_counted() {
        let done = format!("{} of {} so far", counts.looked, batch.entries.len());
        row("counted", done, Style::new().fg(theme.warning));
    }
    if counts.unlabelled > 0 {
        let words = format!("{} without a ground truth", counts.unlabelled);
        row("left out", words, Style::new().fg(theme.warning));
    }
    if estimate.unaskable > 0 {
        let why = estimate.why.first().map_or("", |(why, _)| why.as_str());
        let words = format!(
            "{} cannot be asked about: {}",
            estimate.unaskable,
            fit(why, 300)
        );
        row("left out", words, Style::new().fg(theme.warning));
    }
    let there = format!("{}, free", estimate.stored);
    row("in store", there, Style::new());
    let own = batch.model == judge::MODEL;
    let name = if own { "answers" } else { "requests" };
    let asks = match own {
        true => format!("{}, on this machine", estimate.free),
        false => format!("{}, {} at once", estimate.requests, counts.at_once),
    };
    row(name, asks, bold);
    if !own {
        let tokens = format!("about {} in the questions", thousands(estimate.tokens));
        row("tokens", tokens, Style::new());
        row("price", counts.price(), bold);
    }
    if let Some(left) = counts.budget {
        row(
            "budget",
            format!("${left:.4} left in this session"),
            Style::new(),
        );
    }
    if let Some(why) = &counts.refused {
        row("but", fit(why, 400), Style::new().fg(theme.danger));
    }
    text
}
