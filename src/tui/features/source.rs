//! The scenario's source, read-only: only the visible lines are highlighted.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};
use ratatui::widgets::Paragraph;
use unicode_width::UnicodeWidthStr;

use crate::action::{Action, Scope};
use crate::features::{Screen, Step, WHEEL};
use crate::loaded::Source;
use crate::message::{Effect, Mouse};
use crate::model::Model;
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::widgets::highlight::{Language, lines};
use crate::widgets::hints::{self, Hint};
use crate::widgets::window;
use crate::widgets::words::{fit_end, thousands};
use nearmiss_formats::Entry;
use nearmiss_scene::description::visible;

/// Rows before the first one that are highlighted too, for what begins there.
const BEFORE: usize = 20;

/// The source of the scenario.
#[derive(Debug)]
pub struct SourceScreen {
    /// The first row that is shown.
    scroll: usize,
    /// Whether another obstacle is being picked, to which it goes.
    seeks: bool,
}

impl SourceScreen {
    fn scroll(&mut self, model: &Model, action: Action) -> bool {
        let Some((_, source)) = &model.source else {
            return false;
        };
        let last = source.row_count().saturating_sub(1);
        let page = usize::from(model.size.1.saturating_sub(6)).max(1);
        let to = match action {
            Action::Up => self.scroll.saturating_sub(1),
            Action::Down => self.scroll + 1,
            Action::PageUp => self.scroll.saturating_sub(page),
            // Playback is hidden here, so its key turns the page.
            Action::PageDown | Action::Play => self.scroll + page,
            Action::Top | Action::FirstStep => 0,
            Action::Bottom | Action::LastStep => last,
            _ => return false,
        };
        self.scroll = to.min(last);
        true
    }
}

impl Screen for SourceScreen {
    fn on_action(&mut self, model: &mut Model, action: Action) -> Step {
        match action {
            _ if self.scroll(model, action) => Step::stay(),
            Action::NextObstacle | Action::PreviousObstacle => {
                self.seeks = true;
                Step::Perform(action)
            }
            _ => Step::Ignored,
        }
    }

    fn on_mouse(&mut self, model: &mut Model, mouse: Mouse) -> Step {
        let action = match mouse {
            Mouse::WheelUp(_) => Action::Up,
            Mouse::WheelDown(_) => Action::Down,
            Mouse::Press(_) | Mouse::Drag(_) | Mouse::Release(_) => return Step::stay(),
        };
        for _ in 0..WHEEL {
            self.scroll(model, action);
        }
        Step::stay()
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        if std::mem::take(&mut self.seeks) {
            self.scroll = at_picked(model).unwrap_or(self.scroll);
        }
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let Some((_, source)) = &model.source else {
            return;
        };
        let count = format!("{} rows", thousands(source.row_count() as u64));
        // The borders and spaces of a window that is nearly as wide as the screen.
        let room = usize::from(screen.width).saturating_sub(count.width() + 11);
        let file = fit_end(&visible(&source.file), room);
        let title = format!("{file} · {count}");
        let inner = window::window(frame, screen, model, &title, (screen.width, screen.height));
        let rows = usize::from(inner.height);
        let top = self.scroll.min(source.row_count().saturating_sub(rows));
        let from = top.saturating_sub(BEFORE);
        let picked = model.picked.and_then(|id| source.row_of(id));
        let seen: Vec<(usize, &str)> = source.rows(from..top + rows).collect();
        let texts = seen.iter().map(|(_, text)| *text);
        let styled = lines(Language::Xml, texts, &model.theme);
        let digits = source.row_count().to_string().len();
        let dim = Style::new().fg(model.theme.dim);
        let numbered = seen.iter().zip(styled).enumerate().skip(top - from);
        let shown = numbered.map(|(row, ((number, _), line))| {
            let here = picked == Some(from + row);
            let sign = if here { "▸" } else { " " };
            let style = if here {
                Style::new()
                    .fg(model.theme.picked)
                    .add_modifier(Modifier::BOLD)
            } else {
                dim
            };
            let mut whole = Line::from(Span::styled(format!("{sign}{number:>digits$} "), style));
            whole.spans.extend(line.spans);
            whole
        });
        frame.render_widget(Paragraph::new(shown.collect::<Vec<_>>()), inner);
    }

    fn hints(&self, model: &Model) -> Vec<Hint> {
        let ends = [Action::Top, Action::Bottom]
            .map(|action| model.look.keymap.key_in(action, Scope::Window));
        let ends = (ends.join(" "), "begin, end".to_string());
        let mut hints = vec![hints::scroll(model), hints::page(model), ends];
        hints.extend(hints::hint_of(model, Action::NextObstacle));
        hints.push(hints::close(model));
        hints
    }
}

/// Opens the source of what is open.
pub fn open(model: &mut Model) -> Vec<Effect> {
    let place = model.list.opened.filter(|_| model.opened.is_some());
    let Some(place) = place else {
        model.say("no scenario is open");
        return Vec::new();
    };
    if model.source.as_ref().is_some_and(|(of, _)| *of == place) {
        show(model);
        return Vec::new();
    }
    let entry = model.list.rows[place].entry.clone();
    vec![ReadSource(place, entry).into()]
}

fn show(model: &mut Model) {
    let scroll = at_picked(model).unwrap_or(0);
    let seeks = false;
    model.screens.open(SourceScreen { scroll, seeks });
}

/// The row of the picked obstacle, with what comes just before it.
fn at_picked(model: &Model) -> Option<usize> {
    let (_, source) = model.source.as_ref()?;
    let row = source.row_of(model.picked?)?;
    Some(row.saturating_sub(2))
}

/// Reads the source of a scenario, by its place in the list.
#[derive(Debug)]
pub struct ReadSource(pub usize, pub Entry);

impl Request for ReadSource {
    type Reply = (usize, Result<Box<Source>, String>);

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let Self(place, entry) = self;
        services.background(replies, move || (place, Source::read(&entry).map(Box::new)));
    }

    /// It is shown if it is still that of what is open.
    fn reply(model: &mut Model, (place, read): Self::Reply) -> Vec<Effect> {
        if model.list.opened == Some(place) {
            match read {
                Ok(source) => {
                    model.source = Some((place, source));
                    show(model);
                }
                Err(error) => model.complain(error),
            }
        }
        Vec::new()
    }
}
