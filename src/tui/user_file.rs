//! A TOML file of the user's, and its mistakes: by file, line and key.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::text::visible;

/// A file that is read, and what was found to be wrong with it.
pub struct UserFile<'a> {
    name: &'a str,
    text: &'a str,
    mistakes: Vec<(usize, String)>,
}

impl<'a> UserFile<'a> {
    /// A text with the name of its file, for people.
    pub fn new(name: &'a str, text: &'a str) -> Self {
        Self {
            name,
            text,
            mistakes: Vec::new(),
        }
    }

    /// What the file says; nothing where it is no TOML, which is noted.
    pub fn table(&mut self) -> Option<DeTable<'a>> {
        match DeTable::parse(self.text) {
            Ok(table) => Some(table.into_inner()),
            Err(error) => {
                let words = error.message().trim().replace('\n', " ");
                self.mistake(&error.span().unwrap_or_default(), &words);
                None
            }
        }
    }

    /// The table below a key; anything else there is noted.
    pub fn below<'t>(
        &mut self,
        key: &str,
        value: &'t Spanned<DeValue<'a>>,
    ) -> Option<&'t DeTable<'a>> {
        let table = value.get_ref().as_table();
        if table.is_none() {
            self.mistake(&value.span(), &format!("{key} must be a table: [{key}]"));
        }
        table
    }

    /// The line of a place in the file, from 1.
    pub fn line(&self, span: &Range<usize>) -> usize {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        1 + before.matches('\n').count()
    }

    /// Notes a mistake; its words begin with the key.
    pub fn mistake(&mut self, span: &Range<usize>, words: &str) {
        self.mistakes.push((self.line(span), words.to_string()));
    }

    /// All mistakes in the order of the file, a line each.
    ///
    /// # Errors
    /// There are some.
    pub fn checked(mut self) -> Result<(), Vec<String>> {
        if self.mistakes.is_empty() {
            return Ok(());
        }
        self.mistakes.sort_by_key(|(line, _)| *line);
        let all = self.mistakes.into_iter();
        let name = self.name;
        Err(all
            .map(|(line, words)| visible(&format!("{name}:{line}: {words}")).into_owned())
            .collect())
    }
}

/// A value as the file has it.
pub fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(number) => number.as_str().to_string(),
        DeValue::Boolean(yes) => yes.to_string(),
        other => format!("a {}", other.type_str()),
    }
}

/// The first mistake, and how many more there are.
pub fn first(mistakes: &[String]) -> String {
    match mistakes {
        [] => String::new(),
        [one] => one.clone(),
        [one, more @ ..] => format!("{one} (and {} more)", more.len()),
    }
}
