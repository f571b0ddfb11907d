//! `nearmiss config print`: the effective configuration as TOML, with the source of each value.

use std::collections::BTreeSet;
use std::path::Path;

use toml::Value;

use super::doctor::open_to_others;
use super::open::unusable;
use super::{Failure, Outcome, output};
use nearmiss_ask::llm::{Address, Environment, Registry};
use nearmiss_base::system::KeyLines;
use nearmiss_drive::simulation::ExternalOptions;
use nearmiss_record::fields::{Fields as _, Row};
use nearmiss_settings::{Config, Folders, Planning, TextFile};

/// Prints the configuration. Keys are never in it, only the variables they are looked for in.
///
/// # Errors
/// A file of the user's cannot be used.
pub fn print_config() -> Outcome {
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
                (Some(value), _) => format!(
                    "{key} = {value}  # {source}
"
                ),
                (None, Some(variable)) if key == "person" => {
                    format!(
                        "{key} = {}  # {variable}
",
                        Value::String(config.person())
                    )
                }
                (None, _) => format!(
                    "# {key} is not set. {}  # {source}
",
                    row.doc()
                ),
            }
        };
        let rows = Config::rows().iter();
        rows.filter(|row| row.section != "tables")
            .map(line)
            .collect()
    }

    fn planner(&self, planning: &Planning) -> String {
        let (mut out, mut table) = (
            String::from(
                "
[planner]
",
            ),
            String::new(),
        );
        for (key, value) in Planning::values(&planning.into()) {
            let path: Vec<&str> = ["planner"].into_iter().chain(key.split('.')).collect();
            if let [_, inner, _] = path[..]
                && table != inner
            {
                table = inner.into();
                out += &format!(
                    "
[planner.{inner}]
"
                );
            }
            let name = path.last().copied().unwrap_or_default();
            out += &format!(
                "{name} = {value}  # {}
",
                self.source(&path)
            );
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
