//! Ctrl-C and SIGTERM during a long job that has something to tidy up.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// The exit status of an interrupted program.
pub const INTERRUPTED: u8 = 130;

/// A flag that the first signal sets; the second one ends the program at once.
///
/// With `tidy` false there is nothing to tidy up, and the first one ends it.
///
/// # Errors
/// The system refuses to listen.
pub fn interrupted(tidy: bool) -> io::Result<Arc<AtomicBool>> {
    let heard = Arc::new(AtomicBool::new(false));
    let ends = if tidy {
        Arc::clone(&heard)
    } else {
        Arc::new(AtomicBool::new(true))
    };
    for signal in [SIGINT, SIGTERM] {
        // The order matters: the first signal must find the flag unset here.
        flag::register_conditional_shutdown(signal, INTERRUPTED.into(), Arc::clone(&ends))?;
        flag::register(signal, Arc::clone(&heard))?;
    }
    Ok(heard)
}
