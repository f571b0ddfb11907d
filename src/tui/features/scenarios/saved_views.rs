//! Saved views of the list: filter, order and grouping under a name; chosen, saved and deleted here.

use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::Action;
use crate::features::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::{Model, Picker, matching};
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::words::pad;
use crate::widgets::{picker, window};
use nearmiss_scene::description::visible;
use nearmiss_settings::{SavedView, SavedViews};

/// The list of views.
#[derive(Debug, Default)]
pub struct SavedViewsScreen {
    picker: Picker,
    /// The view that the same key deletes now.
    deleting: Option<String>,
}

/// A line of the list.
#[derive(Debug, Clone, PartialEq)]
enum Row {
    /// A saved view.
    View(String),
    /// The list as it is, to be saved under the typed name.
    Save(String),
}

/// Columns of a name.
const NAME: usize = 24;

impl Screen for SavedViewsScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        let deleting = self.deleting.take();
        let selected = self.rows(model).into_iter().nth(self.picker.selected);
        match key.code {
            Code::Esc => return Some(Step::close()),
            Code::Enter => {
                return Some(match selected {
                    Some(Row::View(name)) => {
                        model.list.chosen_view = Some(name);
                        Step::CloseAndPerform(Action::SavedViews)
                    }
                    Some(Row::Save(name)) => {
                        let view = model.list.view();
                        model.say(format!("view `{name}` saved"));
                        Step::Close(vec![ListViews::Change(name, Some(view)).into()])
                    }
                    None => Step::stay(),
                });
            }
            Code::Up => self.picker.selected = self.picker.selected.saturating_sub(1),
            Code::Down | Code::Tab => self.picker.selected += 1,
            Code::Delete => return Some(self.delete(model, selected, deleting)),
            Code::Char('d') if key.ctrl => return Some(self.delete(model, selected, deleting)),
            _ if edit_line(&mut self.picker.text, key) => self.picker.selected = 0,
            _ => {}
        }
        Some(Step::stay())
    }

    fn paste(&mut self, _model: &mut Model, text: &str) -> Vec<Effect> {
        self.picker.text.push_str(&first_line(text));
        self.picker.selected = 0;
        Vec::new()
    }

    fn follow(&mut self, model: &mut Model) -> Vec<Effect> {
        let last = self.rows(model).len().saturating_sub(1);
        self.picker.selected = self.picker.selected.min(last);
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let inner = window::window(frame, screen, model, "saved views of the list", (92, 18));
        let now = model.list.view();
        let rows = self.rows(model).into_iter().map(|row| match row {
            Row::View(name) => {
                let words = model.list.views.get(&name).map(summary).unwrap_or_default();
                (format!("{} {words}", pad(&name, NAME)), String::new())
            }
            Row::Save(name) => {
                let there = model.list.views.get(&name).is_some();
                let verb = if there { "replace" } else { "save as" };
                (format!("{verb} `{name}`"), summary(&now))
            }
        });
        picker::draw(frame, inner, model, &self.picker, &rows.collect::<Vec<_>>());
        let hint = match &self.deleting {
            Some(name) => format!("Ctrl-D again deletes `{name}`"),
            None if self.picker.text.trim().is_empty() => {
                format!("type a name to save the list as it is: {}", summary(&now))
            }
            None => return,
        };
        picker::hint(frame, inner, model, &visible(&hint));
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        fixed(&[
            ("type", "a name"),
            ("↑↓", "select"),
            ("Enter", "choose"),
            ("Ctrl-D", "delete"),
            ("Esc", "close"),
        ])
    }
}

impl SavedViewsScreen {
    /// The views that match, and what is typed as a name.
    fn rows(&self, model: &Model) -> Vec<Row> {
        let all: Vec<(&str, &SavedView)> = model.list.views.iter().collect();
        let texts = all
            .iter()
            .map(|(name, view)| format!("{name} {}", view.filter));
        let found = matching(&self.picker.text, texts);
        let mut rows: Vec<Row> = found
            .into_iter()
            .map(|place| Row::View(all[place].0.to_string()))
            .collect();
        let typed = self.picker.text.trim();
        if !typed.is_empty() {
            rows.push(Row::Save(typed.to_string()));
        }
        rows
    }

    /// Deletes the selected view when the key is pressed twice.
    fn delete(&mut self, model: &mut Model, selected: Option<Row>, before: Option<String>) -> Step {
        let Some(Row::View(name)) = selected else {
            return Step::stay();
        };
        if before.as_ref() != Some(&name) {
            self.deleting = Some(name);
            return Step::stay();
        }
        model.say(format!("view `{name}` deleted"));
        Step::Stay(vec![ListViews::Change(name, None).into()])
    }
}

/// A view in words.
fn summary(view: &SavedView) -> String {
    let filter = match view.filter.trim() {
        "" => "no filter".to_string(),
        filter => filter.to_string(),
    };
    let sort = match view.sort.as_str() {
        "" => "found",
        sort => sort,
    };
    let reversed = if view.reversed { " reversed" } else { "" };
    let group = match view.group.as_str() {
        "" | "nothing" => String::new(),
        group => format!(" · by {group}"),
    };
    format!("{filter} · sorted by {sort}{reversed}{group}")
}

/// The saved views of the list.
#[derive(Debug)]
pub enum ListViews {
    /// Read.
    Read,
    /// One is saved under a name, or deleted.
    Change(String, Option<SavedView>),
}

impl Request for ListViews {
    /// All of them, or why they cannot be used.
    type Reply = Result<SavedViews, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let path = services.folders.views();
        services.background(replies, move || match self {
            Self::Read => SavedViews::read(&path),
            Self::Change(name, view) => SavedViews::change(&path, &name, view),
        });
    }

    /// Where they cannot be used, they stay as they were.
    fn reply(model: &mut Model, views: Self::Reply) -> Vec<Effect> {
        match views {
            Ok(views) => model.list.views = views,
            Err(error) => model.complain(error),
        }
        Vec::new()
    }
}
