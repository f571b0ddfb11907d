//! Input line for the terms that an attack is wished to fit.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};

use super::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::loaded::VariantRequest;
use crate::message::Effect;
use crate::model::JobId;
use crate::model::Model;
use crate::tasks::making::Generate;
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::window;
use crate::widgets::words::fit_end;
use nearmiss_drive::generation::Wish;
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::ContentHash;

/// The terms, and the search that waits for them.
#[derive(Debug)]
pub struct WishScreen {
    typed: String,
    /// The search; taken when it begins.
    request: Option<Box<VariantRequest>>,
    /// The scenario's place in the list.
    place: usize,
    /// The scenario's hash.
    hash: ContentHash,
}

/// Opens the line for a search in the scenario at a place of the list.
pub fn open(model: &mut Model, place: usize, hash: ContentHash, request: Box<VariantRequest>) {
    model.screens.open(WishScreen {
        typed: String::new(),
        request: Some(request),
        place,
        hash,
    });
}

impl Screen for WishScreen {
    fn on_key(&mut self, model: &mut Model, key: Key) -> Option<Step> {
        Some(match key.code {
            Code::Esc => Step::close(),
            Code::Enter => self.begin(model),
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
        let title = "search for an attack that terms describe";
        let inner = window::window(frame, screen, model, title, (76, 10));
        let width = usize::from(inner.width);
        let (accent, dim) = (
            Style::new().fg(model.theme.accent),
            Style::new().fg(model.theme.dim),
        );
        // The end is where one types.
        let line = format!("> {}▏", fit_end(&self.typed, width.saturating_sub(4)));
        let mut lines = vec![Line::styled(line, accent), Line::default()];
        if let Some(why) = self
            .typed
            .parse::<Wish>()
            .err()
            .filter(|_| !self.typed.is_empty())
        {
            let style = Style::new().fg(model.theme.warning);
            lines.push(Line::styled(visible(&why).into_owned(), style));
            lines.push(Line::default());
        }
        let hint = "who, which manoeuvre, from where: actor:car,truck manoeuvre:cut-in place:left-lane; actor:bicycle place:hidden";
        lines.push(Line::styled(hint, dim));
        frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }), inner);
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        fixed(&[("type", "terms"), ("Enter", "search"), ("Esc", "cancel")])
    }
}

impl WishScreen {
    fn begin(&mut self, model: &mut Model) -> Step {
        let wish = match self.typed.parse::<Wish>() {
            Ok(wish) => wish,
            Err(why) => {
                model.say(visible(&why).into_owned());
                return Step::stay();
            }
        };
        let Some(mut request) = self.request.take() else {
            return Step::close();
        };
        let id = JobId(model.new_id());
        model.say(format!("searching for an attack: {wish}…"));
        request.wish = Some(wish);
        request.seed = model.maker.next_seed(self.hash, None);
        model.maker.begin(id, self.place);
        Step::Close(vec![Generate { id, request }.into()])
    }
}
