//! The operating system: what it says, in plain words, and files that somebody names.

mod file;
mod words;

pub use file::{LARGEST, open_file, read_file};
pub use words::words;
