//! What a screen or window over the main screen is, and the stack of those that are open.

use std::any::Any;
use std::fmt::Debug;

use nearmiss_store::Run;
use ratatui::Frame;
use ratatui::layout::Rect;

use crate::action::{Action, Scope};
use crate::keymap::Key;
use crate::message::{Effect, Mouse};
use crate::model::{Model, Place};
use crate::widgets::hints::Hint;

/// A screen or window over the main screen, which takes the keys: state, keys, drawing and footer.
pub trait Screen: Any + Debug + Send {
    /// Where its keys are looked up.
    fn scope(&self) -> Scope {
        Scope::Window
    }

    /// A key that is typed or answers a question; `None` for one that is looked up in the keymap.
    fn on_key(&mut self, _model: &mut Model, _key: Key) -> Option<Step> {
        None
    }

    /// An action, by a key of the keymap or by its name in the palette.
    fn on_action(&mut self, _model: &mut Model, _action: Action) -> Step {
        Step::Ignored
    }

    /// The mouse. By default the wheel scrolls.
    fn on_mouse(&mut self, _model: &mut Model, mouse: Mouse) -> Step {
        if let Some(scroll) = self.scroll_mut() {
            match mouse {
                Mouse::WheelUp(_) => *scroll = scroll.saturating_sub(WHEEL),
                Mouse::WheelDown(_) => *scroll += WHEEL,
                Mouse::Press(_) | Mouse::Drag(_) | Mouse::Release(_) => {}
            }
        }
        Step::stay()
    }

    /// Pasted text.
    fn paste(&mut self, _model: &mut Model, _text: &str) -> Vec<Effect> {
        Vec::new()
    }

    /// Keeps the screen true to the model, after every message.
    fn follow(&mut self, _model: &mut Model) -> Vec<Effect> {
        Vec::new()
    }

    /// The first line that is shown, if it is a window of text.
    fn scroll_mut(&mut self) -> Option<&mut usize> {
        None
    }

    /// Whether it changes as time passes.
    fn moves(&self, _model: &Model) -> bool {
        false
    }

    /// Columns at the right that it takes, where what is left of them stays in sight.
    fn columns_at_right(&self, _screen: Rect) -> Option<u16> {
        None
    }

    /// Draws it.
    fn draw(&self, frame: &mut Frame<'_>, screen: Rect, model: &Model);

    /// The keys that work on it, for the footer.
    fn hints(&self, model: &Model) -> Vec<Hint>;
}

/// Lines that a turn of the wheel scrolls.
pub(crate) const WHEEL: usize = 3;

/// Consequences of a key, an action or the mouse on a screen.
#[derive(Debug)]
pub enum Step {
    /// It stays open.
    Stay(Vec<Effect>),
    /// It closes.
    Close(Vec<Effect>),
    /// It stays open, and the workbench performs an action.
    Perform(Action),
    /// It closes, and the workbench performs an action.
    CloseAndPerform(Action),
    /// The workbench opens the scenario of an earlier run, as it was asked.
    Reopen(Box<Run>),
    /// It closes, and the workbench goes to a place of a scenario.
    Visit(Place),
    /// It has no use for the action.
    Ignored,
}

impl Step {
    /// It stays open, and nothing has to be done.
    #[must_use]
    pub fn stay() -> Self {
        Self::Stay(Vec::new())
    }

    /// It closes, and nothing has to be done.
    #[must_use]
    pub fn close() -> Self {
        Self::Close(Vec::new())
    }
}

/// The screens that are open, the top last.
#[derive(Debug, Default)]
pub struct Screens(Vec<Box<dyn Screen>>);

impl Screens {
    /// Opens a screen on top; one of its kind that is open already goes.
    pub fn open<S: Screen>(&mut self, screen: S) {
        self.close::<S>();
        self.0.push(Box::new(screen));
    }

    /// Puts a screen that was taken away back on top.
    pub fn put_back(&mut self, screen: Box<dyn Screen>) {
        self.0.push(screen);
    }

    /// Takes the top screen away.
    pub fn pop(&mut self) -> Option<Box<dyn Screen>> {
        self.0.pop()
    }

    /// Closes the screen of this kind.
    pub fn close<S: Screen>(&mut self) {
        self.0.retain(|open| !as_any(open.as_ref()).is::<S>());
    }

    /// Whether none is open.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The screen on top.
    #[must_use]
    pub fn top(&self) -> Option<&dyn Screen> {
        self.0.last().map(AsRef::as_ref)
    }

    /// Whether a screen of this kind is on top.
    #[must_use]
    pub fn is_top<S: Screen>(&self) -> bool {
        self.top().is_some_and(|top| as_any(top).is::<S>())
    }

    /// The screen of this kind, if it is open.
    #[must_use]
    pub fn find<S: Screen>(&self) -> Option<&S> {
        let mut open = self.iter().map(as_any);
        open.find_map(<dyn Any>::downcast_ref)
    }

    /// Every open screen, the top last.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Screen> {
        self.0.iter().map(AsRef::as_ref)
    }

    /// Keeps every screen true to the model.
    pub fn follow(model: &mut Model) -> Vec<Effect> {
        let mut open = std::mem::take(&mut model.screens);
        let screens = open.0.iter_mut();
        let effects = screens.flat_map(|screen| screen.follow(model)).collect();
        model.screens = open;
        effects
    }
}

fn as_any(screen: &dyn Screen) -> &dyn Any {
    screen
}

/// An action on a screen; windows of text scroll by themselves.
pub fn act(screen: &mut dyn Screen, model: &mut Model, action: Action) -> Step {
    let step = screen.on_action(model, action);
    match (step, screen.scroll_mut()) {
        (Step::Ignored, Some(scroll)) if scrolls(action) => {
            *scroll = scrolled(*scroll, action, model);
            Step::stay()
        }
        (step, _) => step,
    }
}

fn scrolls(action: Action) -> bool {
    use Action::*;
    matches!(action, Up | Down | PageUp | PageDown | Top | Bottom)
}

fn scrolled(scroll: usize, action: Action, model: &Model) -> usize {
    let last = model.drawn.window_end();
    if let Some(line) = model.look.line(action) {
        return line.min(last);
    }
    match action {
        Action::Top => 0,
        Action::Bottom => last,
        _ => scroll.saturating_add_signed(model.look.lines(action, PAGE.cast_signed())),
    }
}

/// Lines of a page in a window of text.
pub(crate) const PAGE: usize = 10;

/// Whether an action moves to another step or picks another obstacle: what beside a window follows it.
pub fn moves_scene(action: Action) -> bool {
    use Action::*;
    matches!(
        action,
        StepForward
            | StepBack
            | JumpForward
            | JumpBack
            | FirstStep
            | LastStep
            | MinimumStep
            | CollisionStep
            | ContactStep
            | NextObstacle
            | PreviousObstacle
    )
}
