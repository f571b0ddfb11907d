//! Transient notices.

use super::Model;

/// A message that stays readable for a while.
#[derive(Debug, Clone, PartialEq)]
pub struct Toast {
    /// Its text.
    pub text: String,
    /// Its kind.
    pub kind: Notice,
    /// Seconds it still stays; errors stay until a key is pressed.
    pub left: f64,
    /// Seconds it was shown.
    pub shown: f64,
}

/// Seconds after which a key takes news away, too: they were read.
const READ: f64 = 3.0;

/// Kind of a notice, which determines how long it is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Notice {
    /// The reply to a key: the next key makes it old.
    Reply,
    /// Something that came about by itself: keys meant for something else do not take it away at once.
    News,
    /// Something is wrong.
    Error,
}

impl Model {
    /// Shows a reply to a key.
    pub fn say(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::Reply, 4.0);
    }

    /// Says that something came about by itself.
    pub fn tell(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::News, 4.0);
    }

    /// Says how something long ended: the user may look elsewhere meanwhile.
    pub fn announce(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::News, 60.0);
    }

    /// Says that something is wrong.
    pub fn complain(&mut self, text: impl Into<String>) {
        self.notify(text.into(), Notice::Error, f64::INFINITY);
    }

    /// The newest takes the place of an older one that is no error; errors are all there until they were read.
    fn notify(&mut self, text: String, kind: Notice, left: f64) {
        self.toasts
            .retain(|t| (kind == Notice::Error || t.kind == Notice::Error) && t.text != text);
        self.toasts.push(Toast {
            text,
            kind,
            left,
            shown: 0.0,
        });
    }

    /// A key was pressed: replies and errors were read, and news that were shown for a while.
    pub fn read_notices(&mut self) {
        let unread = |toast: &Toast| toast.kind == Notice::News && toast.shown < READ;
        self.toasts.retain(unread);
    }
}
