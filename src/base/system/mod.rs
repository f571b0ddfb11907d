//! The operating system: what it says, in plain words, and files that users name or that are theirs alone.

pub mod crash;
mod new_file;
mod private;
pub mod processes;
mod read_file;
mod text;
mod toml_text;

pub use new_file::{NewFile, SaveError, Unfinished, remove_unfinished, save, save_private};
pub use private::{OthersMay, close_file, close_folder, make_file, make_folder, others_may};
pub use processes::{ProcessGroup, end_process_groups, is_program};
pub use read_file::{
    FileCache, LARGEST, LARGEST_TEXT, check_file, files_opened_by, is_of_kernel, open_file,
    read_file, read_text, text_of,
};
pub use text::{
    KeyBinding, Terminal, columns, counted, disguises, error_text, escaped_json, escaped_xml,
    pad_end, pad_start, shown_path, visible, without_folders,
};
pub use toml_text::{
    KeyLines, Mistake, TomlText, available, did_you_mean, line_at, nearest, shown_value, similar,
    toml_mistake, unknown,
};
