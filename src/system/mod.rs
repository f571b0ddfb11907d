//! The operating system: what it says, in plain words, and files that users name or that are theirs alone.

pub mod activity;
mod activity_locks;
mod atomic_write;
pub mod crash;
mod file_cache;
pub mod job_control;
mod key_binding;
mod opened_files;
mod private;
mod process_groups;
mod read_file;
mod shown_path;
mod similar;
mod temporary_file;
mod terminal;
mod text;
mod toml_text;
mod unfinished;
mod without_folders;
mod words;

pub use atomic_write::{NewFile, SaveError, save, save_private};
pub use file_cache::FileCache;
pub use key_binding::KeyBinding;
pub use opened_files::files_opened_by;
pub use private::{close_file, close_folder, make_file, make_folder};
pub use process_groups::{ProcessGroup, end_process_groups};
pub use read_file::{LARGEST, LARGEST_TEXT, check_file, open_file, read_file, read_text};
pub use shown_path::shown_path;
pub use similar::{available, did_you_mean, mistyped, nearest, similar, unknown};
pub use terminal::Terminal;
pub use text::text_of;
pub use toml_text::{KeyLines, Mistake, TomlText, line_at, shown_value, toml_mistake};
pub use unfinished::{Unfinished, remove_unfinished};
pub use without_folders::without_folders;
pub use words::words;
