//! What is said about fields in several places, the later before the earlier, and every mistake with its place.

use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::ops::Range;

use toml::Value;
use toml::de::{DeTable, DeValue};

use super::Fields;
use super::values::toml_value;
use nearmiss_base::system::{line_at, toml_mistake, unknown};

/// Values of fields from files and from the command line.
#[derive(Debug)]
pub struct Layers<F> {
    given: BTreeMap<&'static str, Given>,
    /// Each with the line of the file it is in.
    mistakes: Vec<(usize, String)>,
    file: Option<String>,
    /// The file is no TOML: what it lacks is not known.
    is_unread: bool,
    fields: PhantomData<F>,
}

/// A value and where it stands.
#[derive(Debug)]
struct Given {
    value: Value,
    place: Place,
}

#[derive(Debug)]
enum Place {
    /// In the file: its line, and those of its members.
    File { line: usize, members: Vec<usize> },
    /// Elsewhere, as messages name it there: `--set samples`.
    Named(String),
}

impl<F> Default for Layers<F> {
    fn default() -> Self {
        Self {
            given: BTreeMap::new(),
            mistakes: Vec::new(),
            file: None,
            is_unread: false,
            fields: PhantomData,
        }
    }
}

impl<F: Fields> Layers<F> {
    /// Adds what is set in `fields`, which messages name as `place` says.
    pub fn fields(&mut self, place: &str, fields: &F) {
        for (row, value) in fields.given() {
            self.insert(row.key, value, Place::Named(format!("{place}{}", row.key)));
        }
    }

    /// Adds what a TOML file says.
    pub fn file(&mut self, name: &str, text: &str) {
        self.file = Some(name.into());
        let table = match DeTable::parse(text) {
            Ok(table) => table.into_inner(),
            Err(error) => {
                let broken = toml_mistake(text, &error);
                self.mistakes.push((broken.line.unwrap_or(1), broken.words));
                self.is_unread = true;
                return;
            }
        };
        let line = |span: &Range<usize>| line_at(text, span.start);
        for (key, value) in table {
            let Ok(row) = F::row(key.get_ref()) else {
                let known = F::rows().iter().map(|row| row.key);
                let wrong = unknown("key", key.get_ref(), known);
                self.mistakes.push((line(&key.span()), wrong));
                continue;
            };
            let members = value.get_ref().as_array().map(|members| {
                let spans = members.iter().map(|member| line(&member.span()));
                spans.collect()
            });
            let place = Place::File {
                line: line(&value.span()),
                members: members.unwrap_or_default(),
            };
            match plain(value.get_ref()) {
                Some(value) => self.insert(row.key, value, place),
                None => {
                    let wrong = format!("{}: {}", row.key, row.expected());
                    self.mistakes.push((line(&value.span()), wrong));
                }
            }
        }
    }

    /// Adds what the user typed for a key, or for a key of a table below it (`split.test`); messages name it as `name`.
    pub fn word(&mut self, name: &str, key: &str, text: &str) {
        let (top, below) = key.split_once('.').unwrap_or((key, ""));
        let row = match F::row(top) {
            Ok(row) => row,
            Err(wrong) => {
                self.mistakes.push((0, format!("{name}: {wrong}")));
                return;
            }
        };
        let mut value = row.parse(text);
        if !below.is_empty() {
            let table = self.given.remove(row.key).map(|given| given.value);
            let mut table = match table {
                Some(Value::Table(table)) => table,
                _ => toml::Table::new(),
            };
            let typed = toml_value(text).unwrap_or_else(|| text.into());
            table.insert(below.into(), typed);
            value = table.into();
        }
        self.insert(row.key, value, Place::Named(name.into()));
    }

    fn insert(&mut self, key: &'static str, value: Value, place: Place) {
        self.given.insert(key, Given { value, place });
    }

    /// Changes what is said about a field.
    pub fn edit(&mut self, key: &str, edit: impl FnOnce(&mut Value)) {
        if let Some(given) = self.given.get_mut(key) {
            edit(&mut given.value);
        }
    }

    /// Takes away what is said about a field.
    pub fn remove(&mut self, key: &str) {
        self.given.remove(key);
    }

    /// Whether a field is said.
    #[must_use]
    pub fn has(&self, key: &str) -> bool {
        self.given.contains_key(key)
    }

    /// The keys of the fields that are said.
    pub fn keys(&self) -> impl Iterator<Item = &'static str> {
        self.given.keys().copied()
    }

    /// The fields as they are said, those with mistakes as by default.
    pub fn fields_so_far(&mut self) -> F {
        let mut fields = F::default();
        for row in F::rows() {
            let Some(given) = self.given.get(row.key) else {
                continue;
            };
            if let Err(wrong) = fields.set(row.key, &given.value) {
                let expected = row.expected();
                let words = wrong.messages(&given.value, &expected);
                let found = words.map(|(member, words)| given.place.found(row.key, member, &words));
                self.mistakes.extend(found);
            }
        }
        fields
    }

    /// Notes that a field's value is wrong, or that it is missing.
    pub fn mistake(&mut self, key: &str, words: &str) {
        let found = match self.given.get(key) {
            Some(given) => given.place.found(key, None, &format!(": {words}")),
            None => (1, format!("{key}: {words}")),
        };
        if !self.mistakes.contains(&found) {
            self.mistakes.push(found);
        }
    }

    /// Notes which fields are missing.
    pub fn require(&mut self) {
        if self.is_unread {
            return;
        }
        let is_empty = |given: &Given| given.value.as_array().is_some_and(Vec::is_empty);
        let missing = F::rows()
            .iter()
            .filter(|row| row.is("required") && self.given.get(row.key).is_none_or(is_empty));
        let words = missing.map(|row| (1, format!("{} is missing: {}", row.key, row.doc())));
        self.mistakes.extend(words);
    }

    /// Whether nothing is wrong.
    ///
    /// # Errors
    /// Every mistake on a line of its own, those of the file with its name and line.
    pub fn checked(&mut self) -> Result<(), String> {
        if self.mistakes.is_empty() {
            return Ok(());
        }
        let mut mistakes = std::mem::take(&mut self.mistakes);
        mistakes.sort_by_key(|(line, _)| *line);
        let said = mistakes.into_iter().map(|(line, words)| match &self.file {
            Some(file) if line > 0 => format!("{file}:{line}: {words}"),
            _ => words,
        });
        Err(said.collect::<Vec<_>>().join("\n"))
    }

    /// The fields as they are said.
    ///
    /// # Errors
    /// See [`Layers::checked`].
    pub fn read(&mut self) -> Result<F, String> {
        let fields = self.fields_so_far();
        self.checked()?;
        Ok(fields)
    }
}

impl Place {
    /// A mistake behind the key, with the line of the file.
    fn found(&self, key: &str, member: Option<usize>, words: &str) -> (usize, String) {
        match self {
            Self::File { line, members } => {
                let member = member.and_then(|place| members.get(place));
                (*member.unwrap_or(line), format!("{key}{words}"))
            }
            Self::Named(name) => (0, format!("{name}{words}")),
        }
    }
}

/// The value without its places; nothing where a number is too large.
fn plain(value: &DeValue<'_>) -> Option<Value> {
    Some(match value {
        DeValue::String(text) => Value::String(text.to_string()),
        DeValue::Integer(number) => {
            Value::Integer(i64::from_str_radix(number.as_str(), number.radix()).ok()?)
        }
        DeValue::Float(number) => Value::Float(number.as_str().parse().ok()?),
        DeValue::Boolean(on) => Value::Boolean(*on),
        DeValue::Datetime(time) => Value::Datetime(*time),
        DeValue::Array(members) => {
            let members = members.iter().map(|member| plain(member.get_ref()));
            Value::Array(members.collect::<Option<_>>()?)
        }
        DeValue::Table(table) => {
            let entries = table.iter();
            let entries = entries
                .map(|(key, value)| Some((key.get_ref().to_string(), plain(value.get_ref())?)));
            Value::Table(entries.collect::<Option<_>>()?)
        }
    })
}
