//! The operating system: what it says, in plain words, and files that users name or that are theirs alone.

pub mod activity;
pub mod crash;
mod error_text;
mod file_cache;
pub mod job_control;
mod new_file;
mod paths;
mod private;
mod processes;
mod read_file;
mod terminal;
mod toml_text;
mod visible;

pub use error_text::error_text;
pub use file_cache::FileCache;
pub use new_file::{NewFile, SaveError, Unfinished, remove_unfinished, save, save_private};
pub use paths::{shown_path, without_folders};
pub use private::{OthersMay, close_file, close_folder, make_file, make_folder, others_may};
pub use processes::{ProcessGroup, end_process_groups, is_program};
pub use read_file::{
    LARGEST, LARGEST_TEXT, check_file, files_opened_by, is_of_kernel, open_file, read_file,
    read_text, text_of,
};
pub use terminal::{KeyBinding, Terminal, columns, pad_end, pad_start};
pub use toml_text::{
    KeyLines, Mistake, TomlText, available, did_you_mean, line_at, nearest, shown_value, similar,
    toml_mistake, unknown,
};
pub use visible::{disguises, escaped_json, escaped_xml, visible};
