//! The tour: nine keys with what they do, one after the other in a line above everything else, on example answers.

use ratatui::Frame;
use ratatui::layout::{Constraint, Layout, Rect};
use ratatui::style::{Modifier, Style};
use ratatui::text::{Line, Span};

use crate::action::Action;
use crate::model::Model;
use crate::widgets::words::pad;

/// How far it is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tour(usize);

/// What is done, and what it shows.
const STEPS: [(Action, &str); 9] = [
    (Action::Play, "plays from 3 s before the contact"),
    (
        Action::NextDifference,
        "goes to an answer that differs from the geometry",
    ),
    (
        Action::NextClaim,
        "goes to the next claim of that answer, checked",
    ),
    (Action::CompareScreen, "shows answers side by side"),
    (
        Action::BlindMode,
        "hides who answered, so that 1, 2 or t rates them",
    ),
    (Action::Results, "counts all answers against the truth"),
    (
        Action::Generate,
        "finds an attack that an ideal driver survives",
    ),
    (
        Action::VariantPanel,
        "shows the attack, once found, and how to survive it",
    ),
    (Action::Edit, "edits the prompt; Alt-r asks with it"),
];

/// An action was performed: if it was the next one, the tour goes on.
pub fn follow(model: &mut Model, action: Action) {
    // The panel stays closed until the search has found something.
    if action == Action::VariantPanel && model.variant().is_none() {
        return;
    }
    if let Some(Tour(step)) = &mut model.tour
        && STEPS.get(*step).is_some_and(|(next, _)| *next == action)
    {
        *step += 1;
    }
}

/// The keys of an action from where the user is; what hides the main screen and its menus is closed first.
fn key(model: &Model, action: Action) -> String {
    let own = model.look.keymap.key_in(action, model.scope());
    if !own.is_empty() {
        return own;
    }
    let key = model.look.key(action);
    if model.screens.is_empty() && !model.compare.hides() && !model.prompt.editing {
        return key;
    }
    format!("{}, then {key}", model.look.key(Action::Cancel))
}

/// Draws its line, and gives what of the screen is below it.
pub fn draw(frame: &mut Frame<'_>, screen: Rect, model: &Model) -> Rect {
    let shown = model.tour.filter(|_| !model.drawn.is_for_picture());
    let Some(Tour(step)) = shown else {
        return screen;
    };
    let [first, below] =
        Layout::vertical([Constraint::Length(1), Constraint::Min(0)]).areas(screen);
    let theme = &model.theme;
    let style = Style::new()
        .fg(theme.accent)
        .add_modifier(Modifier::REVERSED);
    let words = match STEPS.get(step) {
        Some((action, words)) => {
            let key = key(model, *action);
            format!(" tour {}/{} · {key} {words} ", step + 1, STEPS.len())
        }
        None => {
            let quit = model.look.key(Action::Quit);
            format!(" tour · that was all: {quit} quits, `nearmiss FOLDER` opens your scenarios ")
        }
    };
    let width = usize::from(screen.width);
    let line = Line::from(Span::styled(
        pad(&words, width),
        style.add_modifier(Modifier::BOLD),
    ));
    frame.render_widget(line, first);
    below
}
