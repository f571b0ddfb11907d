//! Messages that `update` receives and effects that it returns.

use std::path::PathBuf;
use std::time::Duration;

use ratatui::layout::Position;

use crate::features::Step;
use crate::keymap::{Key, Keymap};
use crate::loaded::PictureJob;
use crate::model::JobId;
use crate::request::{AnyReply, AnyRequest};
use crate::theme::Named;
use nearmiss_settings::Config;

/// A message to `update`.
#[derive(Debug)]
pub enum Msg {
    /// A key was pressed.
    Key(Key),
    /// Text was pasted.
    Paste(String),
    /// The mouse did something.
    Mouse(Mouse),
    /// The terminal has this many columns and rows now.
    Resize(u16, u16),
    /// Time passed; sent only while something moves.
    Passed(Duration),
    /// A frame is about to be drawn: what arrived takes its place.
    Drawing,
    /// A frame was drawn.
    Drawn,
    /// A reply to a request.
    Reply(Box<dyn AnyReply>),
    /// A file that says how the workbench looks was changed.
    Reloaded(Reloaded),
    /// A text was edited in the user's editor: which, and how it is now or why it is as before.
    EditedOutside(ExternalEdit, Result<String, String>),
    /// Something went wrong outside.
    Complaint(String),
    /// The program is asked to end.
    Terminate,
    /// It is asked to stop for a while.
    Stop,
}

/// Contents of a reloaded file.
#[derive(Debug)]
pub enum Reloaded {
    /// The configuration, or why it cannot be used.
    Config(Result<Box<Config>, String>),
    /// The keymap, or what is wrong with its file.
    Keymap(Result<Keymap, String>),
    /// All themes.
    Themes(Vec<Named>),
}

/// Mouse events, with positions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mouse {
    /// The left button went down.
    Press(Position),
    /// It moved with the left button down.
    Drag(Position),
    /// The left button went up.
    Release(Position),
    /// The wheel turned up.
    WheelUp(Position),
    /// The wheel turned down.
    WheelDown(Position),
}

/// A text for the user's own editor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExternalEdit {
    /// Name of its file.
    pub file: String,
    /// The text.
    pub text: String,
    /// Whether it is a read-only copy, whose changes are discarded.
    pub copy: bool,
    /// The user's own file, which is edited where it is; the text is what it held before.
    pub place: Option<PathBuf>,
}

/// What `update` asks to be done outside the model.
#[derive(Debug)]
pub enum Effect {
    /// A round trip.
    Request(Box<dyn AnyRequest>),
    /// What follows of a step of a screen; `update` does it before anything leaves it.
    Step(Step),
    /// Cancel a job. A batch begins nothing more; cancelled once more, it ends what it began.
    Cancel(JobId),
    /// Draw and save a picture.
    Picture(Box<PictureJob>),
    /// Put text into the clipboard.
    Copy(String),
    /// Use the mouse, or not.
    UseMouse(bool),
    /// Let the user edit a text in an editor of theirs.
    EditOutside(ExternalEdit),
    /// Go back to the shell for a while.
    Suspend,
    /// End the program.
    Quit,
}
