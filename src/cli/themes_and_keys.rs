//! `nearmiss config themes` and `nearmiss config keys`: prints the workbench's themes and keys without opening it.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::{Failure, Outcome, json, output};
use nearmiss_base::system::{KeyBinding, Terminal, unknown};
use nearmiss_render::ScreenPainter;
use nearmiss_settings::{Folders, ThemeFile};

/// Arguments of `config themes`.
#[derive(Debug, clap::Args)]
pub struct Themes {
    /// Theme to show in detail [default: list all].
    name: Option<String>,
    /// Colour depth of the preview [default: that of the terminal, none in a pipe].
    #[arg(long, value_name = "COLOURS", value_parser = ["true", "256", "16", "none"])]
    depth: Option<String>,
    #[command(flatten)]
    format: output::FormatOption,
}

/// Arguments of `config keys`.
#[derive(Debug, clap::Args)]
pub struct Keys {
    /// Use this preset and ignore keymap.toml.
    #[arg(long, value_name = "NAME", value_parser = ["default", "vim"])]
    preset: Option<String>,
    /// Form of the output.
    #[arg(long, value_enum, default_value = "table")]
    format: KeysFormat,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum KeysFormat {
    /// A table.
    Table,
    /// JSON lines: one object an action.
    #[value(alias = "jsonl")]
    Json,
    /// A keymap.toml with all keys to start from.
    Toml,
}

/// See [`Workbench::themes`].
pub type ThemePainter = fn(Option<&str>, &Path, Option<&str>) -> Result<String, String>;

/// See [`Workbench::keys`].
pub type KeyPrinter = fn(&Path, Option<&str>, bool) -> Result<String, Vec<String>>;

/// See [`Workbench::key_bindings`].
pub type KeyReader = fn(&Path, Option<&str>) -> Result<Vec<KeyBinding>, Vec<String>>;

/// See [`Workbench::theme_mistakes`].
pub type ThemeCheck = fn(&str, &Path) -> Vec<String>;

/// Functions of the workbench, injected by the program so that commands and workbench stay independent.
pub struct Workbench {
    /// Previews of the theme of this name, or of all, from the user's folder, at a colour depth.
    pub themes: ThemePainter,
    /// The keys of the user's keymap file, or of the preset of this name; as a file if so wished, else as a table.
    pub keys: KeyPrinter,
    /// The same for programs.
    pub key_bindings: KeyReader,
    /// Errors of the theme of this name, and of all in the user's folder.
    pub theme_mistakes: ThemeCheck,
    /// Detects the terminal's capabilities.
    pub terminal: fn() -> Terminal,
    /// Draws a screen of the workbench.
    pub screen: ScreenPainter,
}

/// Runs `config themes`.
pub fn themes(arguments: &Themes, workbench: &Workbench) -> Outcome {
    use std::io::IsTerminal;
    let folders = Folders::find().map_err(Failure::input)?;
    if arguments.format.is_json() {
        return theme_lines(arguments.name.as_deref(), &folders.themes());
    }
    let piped = (!std::io::stdout().is_terminal()).then_some("plain");
    let depth = arguments.depth.as_deref().or(piped);
    let text = (workbench.themes)(arguments.name.as_deref(), &folders.themes(), depth);
    output::text(&text.map_err(Failure::input)?)
}

/// A theme for programs.
#[derive(Serialize, JsonSchema)]
pub struct ThemeDocument {
    /// Name of the theme.
    theme: String,
    origin: String,
    /// Whether it is made for dark backgrounds.
    dark: Option<bool>,
    problem: Option<String>,
}

impl json::Output for ThemeDocument {
    const NAME: &'static str = "config-themes";
    const TITLE: &'static str = "`config themes --format json`: one theme a line";
}

/// Every theme, or the one of this name, as JSON lines.
fn theme_lines(name: Option<&str>, folder: &Path) -> Outcome {
    let mut all = ThemeFile::all(folder);
    if let Some(name) = name {
        let names: Vec<String> = all.iter().map(|theme| theme.name.clone()).collect();
        all.retain(|theme| theme.name == name);
        if all.is_empty() {
            let unknown = unknown("theme", name, names.iter().map(String::as_str));
            return Err(Failure::input(unknown));
        }
    }
    all.iter().try_for_each(|named| {
        let theme = named.theme.as_ref();
        output::document(&ThemeDocument {
            theme: named.name.clone(),
            origin: named.file.as_deref().unwrap_or("shipped").to_string(),
            dark: theme.ok().map(|theme| theme.dark),
            problem: theme.err().map(|mistakes| mistakes.join("; ")),
        })
    })
}

/// Runs `config keys`.
pub fn keys(arguments: &Keys, workbench: &Workbench) -> Outcome {
    let folders = Folders::find().map_err(Failure::input)?;
    let preset = arguments.preset.as_deref();
    let written = if arguments.format == KeysFormat::Json {
        (workbench.key_bindings)(&folders.keymap(), preset)
            .map(|bindings| bindings.iter().try_for_each(output::document))
    } else {
        (workbench.keys)(
            &folders.keymap(),
            preset,
            arguments.format == KeysFormat::Toml,
        )
        .map(|text| output::text(&text))
    };
    match written {
        Ok(outcome) => outcome,
        Err(mut mistakes) => {
            let last = mistakes.pop().unwrap_or_default();
            for mistake in mistakes {
                output::say(&format!("nearmiss: {mistake}"));
            }
            Err(Failure::input(last))
        }
    }
}
