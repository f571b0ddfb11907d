//! TOML that users write: which line a key stands in, which name was probably meant, every mistake with its place.

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

/// The one of the known words that a mistyped one probably means.
#[must_use]
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let likeness = |other: &str| strsim::jaro(word, other);
    let best = known
        .into_iter()
        .max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    best.filter(|known| likeness(known) > 0.75)
}

/// The names that a mistyped one may mean, at most three, the most alike first. Case does not count, and a name that
/// contains the word is always alike.
#[must_use]
pub fn similar<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let wanted = word.to_lowercase();
    let likeness = |name: &str| {
        let name = name.to_lowercase();
        let contained = wanted.chars().count() >= SHORTEST && name.contains(&wanted);
        let alike = strsim::jaro_winkler(&wanted, &name);
        if contained {
            alike.max(CONTAINED)
        } else {
            alike
        }
    };
    let mut found: Vec<(f64, &str)> = known
        .into_iter()
        .map(|name| (likeness(name), name))
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let best = found.first().map_or(0.0, |(likeness, _)| *likeness);
    // Far behind the best one, a name is noise.
    found.retain(|(likeness, _)| *likeness >= MIN_SIMILARITY && *likeness > best - MAX_SPREAD);
    let mut names: Vec<&str> = found.into_iter().map(|(_, name)| name).collect();
    names.dedup();
    names.truncate(MAX_SUGGESTIONS);
    names
}

/// ``; did you mean `a`, `b` or `c`?``, or nothing where no name is alike.
#[must_use]
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    match &similar(word, known)[..] {
        [] => String::new(),
        [one] => format!("; did you mean `{one}`?"),
        [first @ .., last] => format!("; did you mean `{}` or `{last}`?", first.join("`, `")),
    }
}

/// ``unknown task `saftey`; did you mean `safety`?``: the error for a word that is none of the known ones.
#[must_use]
pub fn unknown<'a>(
    what: &str,
    word: &str,
    known: impl IntoIterator<Item = &'a str> + Clone,
) -> String {
    format!("unknown {what} `{word}`{}", available(word, known))
}

/// What is known instead of a word: the names that it may mean, or all of them where it is like none and they are few.
#[must_use]
pub fn available<'a>(word: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let meant = did_you_mean(word, known.clone());
    let all: Vec<&str> = known.into_iter().collect();
    match all.len() {
        _ if !meant.is_empty() => meant,
        0 => String::new(),
        1..=MAX_LISTED => format!("; available: {}", all.join(", ")),
        more => {
            let first = all[..MAX_LISTED].join(", ");
            format!("; available: {first} and {} more", more - MAX_LISTED)
        }
    }
}

/// Suggestions, at most.
const MAX_SUGGESTIONS: usize = 3;

/// Names that are listed where no one is alike.
const MAX_LISTED: usize = 8;

/// Words at least this much alike, 0 to 1, may be the same one mistyped.
const MIN_SIMILARITY: f64 = 0.82;

/// A suggestion is at most so much less alike than the best one.
const MAX_SPREAD: f64 = 0.08;

/// How alike a name is that contains the word.
const CONTAINED: f64 = 0.9;

/// Characters of a word that is looked for inside names.
const SHORTEST: usize = 3;

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

    #[test]
    fn a_word_is_near_or_nothing_is() {
        assert_eq!(nearest("modell", ["mouse", "model"]), Some("model"));
        assert_eq!(nearest("qwrtz", ["mouse", "model"]), None);
    }

    #[test]
    fn a_few_names_are_suggested_the_best_first() {
        let commands = ["metrics", "models", "describe", "prompt", "prompts"];
        assert_eq!(similar("metrix", commands), ["metrics"]);
        assert_eq!(similar("promts", commands), ["prompts", "prompt"]);
        assert!(similar("data", commands).is_empty());
        let scenarios = ["ZAM_CutIn-1_1_T-1", "ZAM_Merge-1_1_T-1"];
        assert_eq!(similar("cutin", scenarios), ["ZAM_CutIn-1_1_T-1"]);
        assert_eq!(
            available("saftey", ["collision", "safety"]),
            "; did you mean `safety`?"
        );
        assert_eq!(available("x", ["a", "b"]), "; available: a, b");
        assert_eq!(
            unknown("command", "promts", commands),
            "unknown command `promts`; did you mean `prompts` or `prompt`?"
        );
    }
}
