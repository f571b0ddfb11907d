//! TOML that users write: which line a key stands in, which key was probably meant, and every mistake with its place.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue, Error};

/// An unknown or invalid entry in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mistake {
    /// Line from 1, where it has one.
    pub line: Option<usize>,
    /// What is wrong; begins with the key.
    pub words: String,
}

/// A TOML text and what is wrong with it.
#[derive(Debug)]
pub struct TomlText<'a> {
    text: &'a str,
    mistakes: Vec<(usize, String)>,
}

impl<'a> TomlText<'a> {
    /// A text of which nothing is known to be wrong.
    #[must_use]
    pub fn new(text: &'a str) -> Self {
        Self {
            text,
            mistakes: Vec::new(),
        }
    }

    /// The keys and values of the text; `None` if it is no TOML, which is noted as a mistake.
    pub fn table(&mut self) -> Option<DeTable<'a>> {
        match DeTable::parse(self.text) {
            Ok(table) => Some(table.into_inner()),
            Err(error) => {
                let words = toml_mistake(self.text, &error).words;
                self.mistake(&error.span().unwrap_or_default(), words);
                None
            }
        }
    }

    /// The table below a key; anything else there is noted as a mistake.
    pub fn below<'t, 'v>(
        &mut self,
        key: &str,
        value: &'t Spanned<DeValue<'v>>,
    ) -> Option<&'t DeTable<'v>> {
        let table = value.get_ref().as_table();
        if table.is_none() {
            self.mistake(&value.span(), format!("{key} must be a table: [{key}]"));
        }
        table
    }

    /// The line of a place in the text, from 1.
    #[must_use]
    pub fn line(&self, span: &Range<usize>) -> usize {
        line_at(self.text, span.start)
    }

    /// Notes a mistake; its words begin with the key.
    pub fn mistake(&mut self, span: &Range<usize>, words: String) {
        self.mistakes.push((self.line(span), words));
    }

    /// Whether the text is free of mistakes.
    ///
    /// # Errors
    /// All mistakes in the order of the text, each as `file:line: words`; what they quote is as the file has it.
    pub fn checked(mut self, file: &str) -> Result<(), Vec<String>> {
        if self.mistakes.is_empty() {
            return Ok(());
        }
        self.mistakes.sort_by_key(|(line, _)| *line);
        let all = self.mistakes.into_iter();
        Err(all
            .map(|(line, words)| format!("{file}:{line}: {words}"))
            .collect())
    }
}

/// The line of a byte of a text, from 1; that of the last byte where the text is shorter.
#[must_use]
pub fn line_at(text: &str, byte: usize) -> usize {
    let before = &text.as_bytes()[..byte.min(text.len())];
    1 + before.iter().filter(|byte| **byte == b'\n').count()
}

/// The words of an error on one line, and the line it is in.
#[must_use]
pub fn toml_mistake(text: &str, error: &Error) -> Mistake {
    Mistake {
        line: error.span().map(|span| line_at(text, span.start)),
        words: error.message().trim().replace('\n', " "),
    }
}

/// A value as the file has it.
#[must_use]
pub fn shown_value(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(number) => number.as_str().to_string(),
        DeValue::Float(number) => number.as_str().to_string(),
        DeValue::Boolean(yes) => yes.to_string(),
        DeValue::Array(_) => "a list".into(),
        other => format!("a {}", other.type_str()),
    }
}

/// Positions of the keys in a text.
#[derive(Debug)]
pub struct KeyLines<'a> {
    text: &'a str,
    table: DeTable<'a>,
}

impl<'a> KeyLines<'a> {
    /// The keys of a text; none where it is no TOML.
    #[must_use]
    pub fn new(text: &'a str) -> Self {
        let table = DeTable::parse(text).map(Spanned::into_inner);
        Self {
            text,
            table: table.unwrap_or_default(),
        }
    }

    /// The line, from 1, of a key that is reached by these names; `None` if the text does not have it.
    #[must_use]
    pub fn line(&self, names: &[&str]) -> Option<usize> {
        let (last, tables) = names.split_last()?;
        let mut table = &self.table;
        for name in tables {
            table = table.get(*name)?.get_ref().as_table()?;
        }
        let (key, _) = table.iter().find(|(key, _)| key.get_ref() == last)?;
        Some(line_at(self.text, key.span().start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_keys() {
        let text = "# a\nmouse = true\n\n[provider.lab]\nbase_url = \"http://x\"\n[provider]\nb.key_env = \"B\"\n";
        let lines = KeyLines::new(text);
        assert_eq!(lines.line(&["mouse"]), Some(2));
        assert_eq!(lines.line(&["provider", "lab", "base_url"]), Some(5));
        assert_eq!(lines.line(&["provider", "b", "key_env"]), Some(7));
        assert_eq!(lines.line(&["provider", "c", "key_env"]), None);
        assert_eq!(lines.line(&["theme"]), None);
        assert_eq!(KeyLines::new("= =").line(&["theme"]), None);
    }
}
