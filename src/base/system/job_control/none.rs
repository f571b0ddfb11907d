//! Systems without job control: nothing stops the program, nothing continues it.

use std::io;

use super::JobSignal;

/// Does nothing.
///
/// # Errors
/// None.
pub fn take_over() -> io::Result<()> {
    Ok(())
}

/// Starts another program, by `start`.
pub fn with_default<T>(start: impl FnOnce() -> T) -> T {
    start()
}

/// Does nothing.
pub fn ask_to_stop() {}

/// Does nothing.
///
/// # Errors
/// None.
pub fn stop() -> io::Result<()> {
    Ok(())
}

/// Never.
#[must_use]
pub fn was_continued() -> bool {
    false
}

/// Waits for ever.
pub struct Signals;

impl Signals {
    /// Begins to wait.
    ///
    /// # Errors
    /// None.
    pub fn listen() -> io::Result<Self> {
        Ok(Self)
    }

    /// Never returns.
    pub async fn wait(&mut self) -> JobSignal {
        std::future::pending().await
    }
}
