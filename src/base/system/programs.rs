//! Programs of this machine.

use std::path::Path;

/// Whether a word is the path of a file, or the name of one in the folders of `PATH`.
#[must_use]
pub fn is_program(word: &str) -> bool {
    let path = Path::new(word);
    if path.components().count() > 1 {
        return path.is_file();
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let mut folders = std::env::split_paths(&folders);
    folders.any(|folder| {
        let file = folder.join(word);
        file.is_file()
            || file
                .with_extension(std::env::consts::EXE_EXTENSION)
                .is_file()
    })
}
