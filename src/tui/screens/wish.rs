//! Input line for what an attack is wished to be, in words, with what is understood of them.

use ratatui::Frame;
use ratatui::layout::Rect;
use ratatui::style::Style;
use ratatui::text::Line;
use ratatui::widgets::{Paragraph, Wrap};

use super::{Screen, Step};
use crate::keymap::{Code, Key, edit_line, first_line};
use crate::loaded::VariantRequest;
use crate::message::{Effect, JobId};
use crate::model::Model;
use crate::widgets::hints::{Hint, fixed};
use crate::widgets::window;
use crate::widgets::words::fit_end;
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::ContentHash;
use nearmiss_workflow::read_wish;

/// The words, and the search that waits for them.
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
        let title = "search for an attack that you describe";
        let inner = window::window(frame, screen, model, title, (76, 10));
        let width = usize::from(inner.width);
        let (accent, dim) = (
            Style::new().fg(model.theme.accent),
            Style::new().fg(model.theme.dim),
        );
        // The end is where one types.
        let line = format!("> {}▏", fit_end(&self.typed, width.saturating_sub(4)));
        let mut lines = vec![Line::styled(line, accent), Line::default()];
        let read = read_wish(&self.typed);
        if !read.wish.is_empty() {
            lines.push(Line::raw(format!("understood: {}", read.wish)));
        }
        if !read.not_understood.is_empty() {
            let words = read.not_understood.join(", ");
            let style = Style::new().fg(model.theme.warning);
            let words = format!("not understood: {words}");
            lines.push(Line::styled(visible(&words).into_owned(), style));
        }
        lines.push(Line::default());
        let hint = "who, which manoeuvre, from where: a car cuts in from the left lane; a cyclist comes from behind the parked van";
        lines.push(Line::styled(hint, dim));
        frame.render_widget(Paragraph::new(lines).wrap(Wrap { trim: true }), inner);
    }

    fn hints(&self, _model: &Model) -> Vec<Hint> {
        fixed(&[("type", "words"), ("Enter", "search"), ("Esc", "cancel")])
    }
}

impl WishScreen {
    fn begin(&mut self, model: &mut Model) -> Step {
        let read = read_wish(&self.typed);
        if !read.not_understood.is_empty() {
            model.say("use other words for what is not understood, or leave it out");
            return Step::stay();
        }
        let wish = read.wish;
        if wish.is_empty() {
            model.say("none of the words says who attacks, how, or from where");
            return Step::stay();
        }
        let Some(mut request) = self.request.take() else {
            return Step::close();
        };
        let id = JobId(model.new_id());
        model.say(format!("searching for an attack: {wish}…"));
        request.wish = Some(wish);
        request.seed = model.maker.next_seed(self.hash, None);
        Step::Close(vec![model.maker.begin(id, self.place, request)])
    }
}
