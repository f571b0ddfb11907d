//! The operating system: what it says, in plain words, and files that somebody names.

mod file;
mod terminal;
mod words;

pub use file::{LARGEST, LARGEST_TEXT, open_file, read_file, read_text};
pub use terminal::Terminal;
pub use words::words;
