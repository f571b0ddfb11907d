//! `nearmiss config`: prints the effective configuration, the workbench's themes and its keys.

use std::collections::BTreeSet;
use std::path::Path;

use nearmiss_ask::llm::{Address, Environment, Registry};
use nearmiss_base::system::{KeyBinding, KeyLines, Terminal, unknown};
use nearmiss_drive::simulation::ExternalOptions;
use nearmiss_record::fields::{Fields as _, Row};
use nearmiss_render::ScreenPainter;
use nearmiss_settings::{Config, Folders, Planning, TextFile, ThemeFile};
use schemars::JsonSchema;
use serde::Serialize;
use toml::Value;

use super::doctor::open_to_others;
use super::open::unusable;
use super::{Failure, Outcome, output};

/// Subcommands of `config`.
#[derive(Debug, clap::Subcommand)]
pub enum ConfigCommand {
    /// Print the configuration in force and the source of each value.
    Print,
    /// List and preview the themes of the workbench.
    Themes(Themes),
    /// List the keys of the workbench, or print a keymap file.
    Keys(Keys),
}

/// Runs `config`.
pub fn run(command: &ConfigCommand, workbench: &Workbench) -> Outcome {
    match command {
        ConfigCommand::Print => print_config(),
        ConfigCommand::Themes(arguments) => themes(arguments, workbench),
        ConfigCommand::Keys(arguments) => keys(arguments, workbench),
    }
}

/// Prints the configuration. Keys are never in it, only the variables they are looked for in.
///
/// # Errors
/// A file of the user's cannot be used.
fn print_config() -> Outcome {
    let folders = Folders::find().map_err(Failure::input)?;
    let path = folders.config_file();
    let file = TextFile::read_if_there(&path).map_err(Failure::input)?;
    let config = Config::read(&path).map_err(unusable)?;
    let registry = Registry::new(&config.provider).map_err(Failure::input)?;
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    let text = file.as_ref().map_or("", |file| &file.text);
    let page = Page {
        lines: KeyLines::new(text),
        file: path.display().to_string(),
    };
    for (what, todo) in open_to_others(&folders) {
        output::say(&format!("nearmiss: {what}; {todo}"));
    }
    let mut out = String::new();
    for (what, folder, variable) in [
        ("configuration", &folders.config, "NEARMISS_CONFIG"),
        ("data", &folders.data, "NEARMISS_DATA"),
    ] {
        let set = std::env::var_os(variable).is_some_and(|value| !value.is_empty());
        let from = if set { variable } else { "default" };
        out += &format!("# {what}: {}  # {from}\n", folder.display());
    }
    out += "\n";
    out += &page.settings(&config);
    out += &page.planner(&config.planning());
    out += &page.planners(&config);
    out += &page.providers(&config, &registry.addresses(&environment));
    output::text(&output::visible(&out))
}

struct Page<'a> {
    lines: KeyLines<'a>,
    file: String,
}

impl Page<'_> {
    /// Where a key is said: in the file, or nowhere.
    fn source(&self, names: &[&str]) -> String {
        match self.lines.line(names) {
            Some(line) => format!("{}:{line}", self.file),
            None => "default".into(),
        }
    }

    fn settings(&self, config: &Config) -> String {
        let line = |row: &Row| {
            let (key, source) = (row.key, self.source(&[row.key]));
            match (config.value(key), user_variable()) {
                (Some(value), _) => format!("{key} = {value}  # {source}\n"),
                (None, Some(variable)) if key == "person" => {
                    format!("{key} = {}  # {variable}\n", Value::String(config.person()))
                }
                (None, _) => format!("# {key} is not set. {}  # {source}\n", row.doc()),
            }
        };
        let rows = Config::rows().iter();
        rows.filter(|row| row.section != "tables")
            .map(line)
            .collect()
    }

    fn planner(&self, planning: &Planning) -> String {
        let (mut out, mut table) = (String::from("\n[planner]\n"), String::new());
        for (key, value) in Planning::values(&planning.into()) {
            let path: Vec<&str> = ["planner"].into_iter().chain(key.split('.')).collect();
            if let [_, inner, _] = path[..]
                && table != inner
            {
                table = inner.into();
                out += &format!("\n[planner.{inner}]\n");
            }
            let name = path.last().copied().unwrap_or_default();
            out += &format!("{name} = {value}  # {}\n", self.source(&path));
        }
        out
    }

    /// The planners that are processes. Arguments of commands may be secrets.
    fn planners(&self, config: &Config) -> String {
        let one = |(name, options): (String, ExternalOptions)| {
            let program = Value::String(options.command.first().cloned().unwrap_or_default());
            let table = ["planner", name.as_str()];
            let line = |key: &str, value: String| {
                let source = self.source(&[table[0], table[1], key]);
                format!("{key} = {value}  # {source}\n")
            };
            let command = match options.command.len() {
                1 => program.to_string(),
                count => format!("{program}  # and {} arguments", count - 1),
            };
            format!("\n[planner.{}]\n", quoted(&name))
                + &line("command", command)
                + &line("start_timeout", options.start.as_secs_f64().to_string())
                + &line("timeout", options.cycle.as_secs_f64().to_string())
                + &line("predictions", options.predictions.to_string())
                + &line("history", options.history.to_string())
        };
        config.external_planners().into_iter().map(one).collect()
    }

    fn providers(&self, config: &Config, addresses: &[Address]) -> String {
        let with_address = addresses.iter().map(|address| address.provider.as_str());
        let names: BTreeSet<&str> = with_address
            .chain(config.provider.keys().map(String::as_str))
            .collect();
        let of = |name: &str| addresses.iter().find(|address| address.provider == name);
        let one = |name: &str| {
            let table = config.provider.get(name).and_then(Value::as_table);
            self.provider(name, of(name), table.unwrap_or(&toml::Table::new()))
        };
        names.into_iter().map(one).collect()
    }

    fn provider(&self, name: &str, address: Option<&Address>, table: &toml::Table) -> String {
        let mut out = format!("\n[provider.{}]\n", quoted(name));
        if let Some(address) = address {
            let url = Value::String(address.url.clone());
            let source = address.variable.clone();
            let source = source.unwrap_or_else(|| self.source(&["provider", name, "base_url"]));
            out += &format!("base_url = {url}  # {source}\n");
            let keys = address.keys.iter().cloned().map(Value::String).collect();
            let source = self.source(&["provider", name, "key_env"]);
            out += &format!("key_env = {}  # {source}\n", Value::Array(keys));
        }
        for (key, value) in table {
            let source = self.source(&["provider", name, key]);
            match key.as_str() {
                "base_url" | "key_env" if address.is_some() => {}
                // Its arguments may be secrets.
                "key_command" => out += &format!("# key_command is set  # {source}\n"),
                // An address may hold a password.
                "base_url" => out += &format!("# base_url cannot be used  # {source}\n"),
                key => out += &format!("{key} = {}  # {source}\n", inline(value)),
            }
        }
        out
    }
}

/// A name as a key of the file.
fn quoted(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.chars().all(bare) {
        name.into()
    } else {
        Value::String(name.into()).to_string()
    }
}

/// A value on one line, tables too.
fn inline(value: &Value) -> String {
    match value {
        Value::Table(table) => {
            let pairs = table.iter().map(|(key, value)| {
                let key = Value::String(key.clone());
                format!("{key} = {}", inline(value))
            });
            format!("{{ {} }}", pairs.collect::<Vec<_>>().join(", "))
        }
        Value::Array(values) => {
            let values: Vec<String> = values.iter().map(inline).collect();
            format!("[{}]", values.join(", "))
        }
        other => other.to_string(),
    }
}

/// The variable that the user's name is from.
fn user_variable() -> Option<&'static str> {
    let mut names = ["USER", "LOGNAME", "USERNAME"]
        .into_iter()
        .filter(|name| std::env::var(name).is_ok_and(|n| !n.trim().is_empty()));
    names.next()
}

/// Arguments of `config themes`.
#[derive(Debug, clap::Args)]
pub struct Themes {
    /// Theme to show in detail [default: list all themes].
    name: Option<String>,
    /// Colour depth of the preview [default: that of the terminal; none in a pipe].
    #[arg(long, value_name = "COLOURS", value_parser = ["true", "256", "16", "none"])]
    depth: Option<String>,
    #[command(flatten)]
    format: output::FormatOption,
}

/// Arguments of `config keys`.
#[derive(Debug, clap::Args)]
pub struct Keys {
    /// Show this preset and ignore keymap.toml.
    #[arg(long, value_name = "NAME", value_parser = ["default", "vim"])]
    preset: Option<String>,
    /// Output format.
    #[arg(long, value_enum, default_value = "table")]
    format: KeysFormat,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum KeysFormat {
    /// Human-readable text.
    Table,
    /// JSON lines: one object per action.
    #[value(alias = "jsonl")]
    Json,
    /// A keymap.toml with all keys, to edit.
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
fn themes(arguments: &Themes, workbench: &Workbench) -> Outcome {
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
fn keys(arguments: &Keys, workbench: &Workbench) -> Outcome {
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
