//! The signals of the system that the workbench answers in good order, with the terminal given back.

use super::super::message::Msg;

/// The signals that ask the program to end or to stop for a while.
///
/// Ctrl-C and Ctrl-Z are keys here: an interrupt or a stop comes from somewhere else.
pub struct Ending {
    #[cfg(unix)]
    ends: [tokio::signal::unix::Signal; 4],
    #[cfg(unix)]
    stop: tokio::signal::unix::Signal,
}

impl Ending {
    /// Begins to listen; what came before is not heard.
    #[cfg(unix)]
    pub fn listen() -> std::io::Result<Self> {
        use tokio::signal::unix::{SignalKind, signal};
        let stop = SignalKind::from_raw(signal_hook::consts::SIGTSTP);
        Ok(Self {
            ends: [
                signal(SignalKind::terminate())?,
                signal(SignalKind::hangup())?,
                signal(SignalKind::interrupt())?,
                signal(SignalKind::quit())?,
            ],
            stop: signal(stop)?,
        })
    }

    /// Waits for the next one.
    #[cfg(unix)]
    pub async fn wait(&mut self) -> Msg {
        let [terminate, hang_up, interrupt, quit] = &mut self.ends;
        tokio::select! {
            _ = terminate.recv() => Msg::Terminate,
            _ = hang_up.recv() => Msg::Terminate,
            _ = interrupt.recv() => Msg::Terminate,
            _ = quit.recv() => Msg::Terminate,
            _ = self.stop.recv() => Msg::Stop,
        }
    }

    #[cfg(not(unix))]
    pub fn listen() -> std::io::Result<Self> {
        Ok(Self {})
    }

    #[cfg(not(unix))]
    pub async fn wait(&mut self) -> Msg {
        std::future::pending().await
    }
}
