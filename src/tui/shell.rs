//! Text about the workbench for the shell: themes and keys.

use std::path::Path;

use crate::keymap::{Keymap, Preset, as_bindings, as_file, as_table};
use crate::layout::SMALLEST;
use crate::model::Glyphs;
use crate::theme::{ColorDepth, Theme, preview};
use crate::{background, terminal};
use nearmiss_base::system::{KeyBinding, Terminal};

/// A list of all themes, or everything about the one called `name`, in the colours of the terminal or of `depth`:
/// `true`, `256`, `16` or `none`, and plain text for `plain`. The user's themes are in `folder`.
///
/// # Errors
/// The theme does not exist, or its file is invalid: with file, line and key.
pub fn themes(name: Option<&str>, folder: &Path, depth: Option<&str>) -> Result<String, String> {
    let depth = match depth {
        None => Some(ColorDepth::of_environment(|name| std::env::var(name).ok())),
        Some(said) => {
            let mut named = ColorDepth::NAMED.iter();
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
        Some(preset) => Keymap::from_preset(preset),
        None => Keymap::load(file)?,
    };
    Ok(if print { as_file(&map) } else { as_table(&map) })
}

/// The same as data, one action each.
///
/// # Errors
/// As [`keys`].
pub fn key_bindings(file: &Path, preset: Option<&str>) -> Result<Vec<KeyBinding>, Vec<String>> {
    let map = match preset.and_then(Preset::parse) {
        Some(preset) => Keymap::from_preset(preset),
        None => Keymap::load(file)?,
    };
    Ok(as_bindings(&map))
}

/// Errors of the theme `chosen` and of every theme in the user's `folder`, with file, line and key.
#[must_use]
pub fn theme_mistakes(chosen: &str, folder: &Path) -> Vec<String> {
    let all = Theme::all(folder).into_iter();
    let mut mistakes: Vec<String> = all
        .filter_map(|named| named.theme.err())
        .flatten()
        .collect();
    if let Err(mistake) = Theme::load(chosen, folder, true)
        && mistakes.is_empty()
    {
        mistakes.push(mistake);
    }
    mistakes
}

/// Detects the capabilities of the terminal. An interactive one is queried for its background, for at most a tenth of a
/// second.
#[must_use]
pub fn terminal_here() -> Terminal {
    let env = |name: &str| std::env::var(name).ok();
    let depth = ColorDepth::of_environment(env);
    let named = ColorDepth::NAMED.iter().find(|(_, d)| *d == depth);
    let size = terminal::size_here();
    let dark = size.and_then(|_| {
        let asked = background::ask(terminal::answers, env);
        (!asked.late).then_some(asked.dark)
    });
    Terminal {
        size,
        least: SMALLEST,
        colours: named.map_or("none", |(name, _)| name),
        unicode: Glyphs::of_environment(env) == Glyphs::Unicode,
        dark,
    }
}
