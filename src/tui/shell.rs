//! What the workbench tells the shell about itself: its themes and its keys, as text.

use std::path::Path;

use super::keymap::{Keymap, Preset, as_file, as_table};
use super::theme::{Depth, preview};

/// A list of all themes, or everything about the one called `name`, in the colours of the terminal or of `depth`:
/// `true`, `256`, `16` or `none`, and plain text for `plain`. The user's themes are in `folder`.
///
/// # Errors
/// There is no such theme, or its file is wrong: with file, line and key.
pub fn themes(name: Option<&str>, folder: &Path, depth: Option<&str>) -> Result<String, String> {
    let depth = match depth {
        None => Some(Depth::of_environment(|name| std::env::var(name).ok())),
        Some(said) => {
            let mut named = Depth::NAMED.iter();
            named
                .find(|(name, _)| *name == said)
                .map(|(_, depth)| *depth)
        }
    };
    preview(name, folder, depth)
}

/// All keys of the user's `file`, or of the preset of this name; as a file to begin with, else as a table.
///
/// # Errors
/// Every mistake in the file, with file, line and key.
pub fn keys(file: &Path, preset: Option<&str>, print: bool) -> Result<String, Vec<String>> {
    let map = match preset.and_then(Preset::parse) {
        Some(preset) => Keymap::of(preset),
        None => Keymap::load(file)?,
    };
    Ok(if print { as_file(&map) } else { as_table(&map) })
}
