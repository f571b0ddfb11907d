//! Job control: a shell stops and continues the program, and no continuation is lost on the way to a stop.

#[cfg(unix)]
#[cfg_attr(target_os = "linux", path = "pending.rs")]
#[cfg_attr(not(target_os = "linux"), path = "handled.rs")]
mod signals;

#[cfg(not(unix))]
#[path = "none.rs"]
mod signals;

pub use self::signals::{Signals, ask_to_stop, stop, take_over, was_continued, with_default};

/// Job-control signals from a shell or another program.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JobSignal {
    /// It is to stop: call [`stop`] once the terminal is given back.
    Stop,
    /// It was stopped and goes on, or was told to go on before it had stopped; [`was_continued`] tells once.
    Continue,
}
