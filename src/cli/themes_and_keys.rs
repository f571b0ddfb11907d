//! `nearmiss themes` and `nearmiss keys`: prints the workbench's themes and keys without opening it.

use std::path::Path;

use super::{Failure, Outcome, output};
use crate::render::ScreenPainter;
use crate::settings::Folders;
use crate::system::Terminal;

/// Arguments of `themes`.
#[derive(Debug, clap::Args)]
pub struct Themes {
    /// Theme to show in detail [default: list all].
    name: Option<String>,
    /// Colour depth of the preview [default: that of the terminal, none in a pipe].
    #[arg(long, value_name = "COLOURS", value_parser = ["true", "256", "16", "none"])]
    depth: Option<String>,
}

/// Arguments of `keys`.
#[derive(Debug, clap::Args)]
pub struct Keys {
    /// Print a keymap.toml with all keys to start from.
    #[arg(long)]
    print: bool,
    /// Use this preset and ignore keymap.toml.
    #[arg(long, value_name = "NAME", value_parser = ["default", "vim"])]
    preset: Option<String>,
}

/// See [`Workbench::themes`].
pub type ThemePainter = fn(Option<&str>, &Path, Option<&str>) -> Result<String, String>;

/// See [`Workbench::keys`].
pub type KeyPrinter = fn(&Path, Option<&str>, bool) -> Result<String, Vec<String>>;

/// See [`Workbench::theme_mistakes`].
pub type ThemeCheck = fn(&str, &Path) -> Vec<String>;

/// Functions of the workbench, injected by the program so that commands and workbench stay independent.
pub struct Workbench {
    /// Previews of the theme of this name, or of all, from the user's folder, at a colour depth.
    pub themes: ThemePainter,
    /// The keys of the user's keymap file, or of the preset of this name; as a file if so wished, else as a table.
    pub keys: KeyPrinter,
    /// Errors of the theme of this name, and of all in the user's folder.
    pub theme_mistakes: ThemeCheck,
    /// Detects the terminal's capabilities.
    pub terminal: fn() -> Terminal,
    /// Draws a screen of the workbench.
    pub screen: ScreenPainter,
}

/// Runs `themes`.
pub fn themes(arguments: &Themes, workbench: &Workbench) -> Outcome {
    use std::io::IsTerminal;
    let folders = Folders::find().map_err(Failure::input)?;
    let piped = (!std::io::stdout().is_terminal()).then_some("plain");
    let depth = arguments.depth.as_deref().or(piped);
    let text = (workbench.themes)(arguments.name.as_deref(), &folders.themes(), depth);
    output::text(&text.map_err(Failure::input)?)
}

/// Runs `keys`.
pub fn keys(arguments: &Keys, workbench: &Workbench) -> Outcome {
    let folders = Folders::find().map_err(Failure::input)?;
    let preset = arguments.preset.as_deref();
    match (workbench.keys)(&folders.keymap(), preset, arguments.print) {
        Ok(text) => output::text(&text),
        Err(mut mistakes) => {
            let last = mistakes.pop().unwrap_or_default();
            for mistake in mistakes {
                output::say(&format!("nearmiss: {mistake}"));
            }
            Err(Failure::input(last))
        }
    }
}
