//! Input line for the user's tags of a scenario, with the tags of its file and those used elsewhere.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};

use crate::features::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::message::Effect;
use crate::model::Model;
use crate::request::{Replies, Request};
use crate::services::Services;
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::window;
use crate::widgets::words::{fit, fit_end};
use nearmiss_scene::description::visible;
use nearmiss_settings::Tags;

/// The user's tags of a scenario, to be typed.
#[derive(Debug)]
pub struct TagsScreen {
    typed: String,
    /// The scenario's name.
    scenario: String,
}

/// Opens the line for the tags of the selected scenario.
pub fn open(model: &mut Model) {
    let Some(place) = model.list.current().or(model.list.opened) else {
        return model.say("select a scenario first");
    };
    let row = &model.list.rows[place];
    let mut typed = row.own_tags.join(" ");
    if !typed.is_empty() {
        typed.push(' ');
    }
    let scenario = row.entry.name.clone();
    model.screens.open(TagsScreen { typed, scenario });
}

impl Screen for TagsScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        Some(match key.code {
            Code::Esc => Step::close(),
            Code::Enter => Step::Close(self.keep(model).into_iter().collect()),
            _ => {
                edit_line(&mut self.typed, key);
                Step::stay()
            }
        })
    }

    fn paste(&mut self, _model: &mut Model, text: &str) -> Vec<Effect> {
        self.typed.push_str(&first_line(text));
        Vec::new()
    }

    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model) {
        let title = format!("tags of {}", fit(&self.scenario, 48));
        let inner = window::window(frame, screen, model, &title, (76, 12));
        let width = usize::from(inner.width);
        let (accent, dim) = (
            Style::new().fg(model.theme.accent),
            Style::new().fg(model.theme.dim),
        );
        // The end is where one types.
        let line = format!("# {}▏", fit_end(&self.typed, width.saturating_sub(4)));
        let mut lines = vec![Line::styled(line, accent), Line::default()];
        let row = model
            .list
            .rows
            .iter()
            .find(|r| r.entry.name == self.scenario);
        let of_file = row
            .and_then(|row| row.facts())
            .map_or(String::new(), |facts| facts.tags.join(" "));
        let in_use = model.list.tags.all().join(" ");
        for (what, tags) in [("in the file", of_file), ("used elsewhere", in_use)] {
            let tags = if tags.is_empty() { "none" } else { &tags };
            lines.push(Line::styled(
                visible(&format!("{what}: {tags}")).into_owned(),
                dim,
            ));
        }
        lines.push(Line::default());
        let hint = "separate tags with spaces; scenarios of the same name share them; filter with tag:WORD";
        lines.push(Line::styled(hint, dim));
        frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }), inner);
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        fixed(&[("type", "tags"), ("Enter", "save"), ("Esc", "cancel")])
    }
}

impl TagsScreen {
    /// Keeps what was typed, if it differs.
    fn keep(&self, model: &Model) -> Option<Effect> {
        let tags = Tags::typed(&self.typed);
        let differs = tags != model.list.tags.tags_for(&self.scenario);
        differs.then(|| ScenarioTags::Change(self.scenario.clone(), tags).into())
    }
}

/// The user's tags of scenarios.
#[derive(Debug)]
pub enum ScenarioTags {
    /// Read.
    Read,
    /// Given to a scenario, by its name.
    Change(String, Vec<String>),
}

impl Request for ScenarioTags {
    /// All of them, or why they cannot be used.
    type Reply = Result<Tags, String>;

    fn perform(self, services: &mut Services, replies: Replies<Self>) {
        let path = services.folders.tags();
        services.background(replies, move || match self {
            Self::Read => Tags::read(&path),
            Self::Change(scenario, tags) => Tags::change(&path, &scenario, tags),
        });
    }

    /// Where they cannot be used, they stay as they were.
    fn reply(model: &mut Model, tags: Self::Reply) -> Vec<Effect> {
        match tags {
            Ok(tags) => model.list.set_tags(tags),
            Err(error) => model.complain(error),
        }
        Vec::new()
    }
}
