//! The operating system: what it says, in plain words, and files that users name or that are theirs alone.

pub mod activity;
pub mod crash;
mod file;
pub mod job_control;
mod marks;
mod new_file;
mod part;
mod private;
mod terminal;
mod text;
mod toml_text;
mod unfinished;
mod words;

pub use file::{LARGEST, LARGEST_TEXT, check_file, open_file, read_file, read_text};
pub use new_file::{NewFile, SaveError, save, save_private};
pub use private::{close_file, close_folder, make_file, make_folder};
pub use terminal::Terminal;
pub use text::text_of;
pub use toml_text::{KeyLines, Mistake, TomlText, line_at, nearest, shown_value, toml_mistake};
pub use unfinished::{Unfinished, remove_unfinished};
pub use words::words;
