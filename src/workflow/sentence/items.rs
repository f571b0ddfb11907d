//! The parts of a sentence: phrases that are known, terms as they stand, names, countries and numbers.

use super::lexicon::{Meaning, measure_of, phrase};
use super::words::{Chunk, Token, tokens};
use crate::Filter;
use crate::scenario_filter::country_named;

/// Part of a sentence.
#[derive(Debug, Clone)]
pub struct Item {
    /// Its words: first and behind the last.
    pub words: (usize, usize),
    /// What it is.
    pub what: What,
    /// Whether a comma or the like stands before it.
    pub pause: bool,
}

/// What a part of a sentence is.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// A phrase that is known.
    Means(Meaning),
    /// A value of a key.
    Value(&'static str, String),
    /// A term as it stands, or a word of a name.
    Term(String),
    /// A number.
    Number(f64),
    /// Not known.
    Unknown,
}

/// The parts of a sentence, without fillers.
pub fn items(words: &[Token]) -> Vec<Item> {
    let mut items = Vec::new();
    let mut at = 0;
    let mut pause = false;
    while at < words.len() {
        let (length, what) = part(&words[at..]);
        pause |= words[at].pause;
        if what != What::Means(Meaning::Filler) {
            items.push(Item {
                words: (at, at + length),
                what,
                pause: std::mem::take(&mut pause),
            });
        }
        at += length;
    }
    items
}

fn part(words: &[Token]) -> (usize, What) {
    let word = &words[0];
    let country = |code: &str| What::Value("country", code.to_string());
    let chunk = word
        .chunk
        .as_ref()
        .filter(|chunk| chunk.words <= words.len());
    if let Some(chunk) = chunk.filter(|chunk| is_term(chunk)) {
        return (chunk.words, What::Term(chunk.text.clone()));
    }
    // In small letters it is another word.
    if word.said == "US" {
        return (1, country("USA"));
    }
    match phrase(words) {
        Some((length, Meaning::Key(key))) => {
            return match words.get(length) {
                Some(value) => {
                    let chunk = value.chunk.as_ref();
                    let (text, more) = chunk.map_or((&value.said, 1), |c| (&c.text, c.words));
                    let value = text.trim_end_matches('.').to_lowercase();
                    (length + more, What::Term(format!("{key}:{value}")))
                }
                None => (length, What::Unknown),
            };
        }
        Some((length, meaning)) => return (length, What::Means(meaning)),
        None => {}
    }
    if let Some(measure) = measure_of(&word.small) {
        return (1, What::Means(measure));
    }
    if let Some(meaning) = underscored(word) {
        return (1, What::Means(meaning));
    }
    if let Some(chunk) = chunk.filter(|chunk| chunk.text.contains('_') && is_name(&chunk.text)) {
        let name = chunk.text.trim_end_matches('.');
        return (chunk.words, What::Term(name.to_string()));
    }
    if let Some(next) = words.get(1)
        && let Some(code) = country_named(&format!("{} {}", word.said, next.said))
    {
        return (2, country(code));
    }
    match (word.number, country_named(&word.said)) {
        (Some(number), _) => (1, What::Number(number)),
        (None, Some(code)) => (1, country(code)),
        (None, None) if is_name(&word.said) => (1, What::Term(word.said.clone())),
        _ => (1, What::Unknown),
    }
}

/// Whether a text is a term of the filter language, such as `road:urban` or `!ttc<2`.
fn is_term(chunk: &Chunk) -> bool {
    let text = &chunk.text;
    let key = text.trim_start_matches('!').split_once(':');
    let named = key.is_some_and(|(key, value)| !key.is_empty() && !value.is_empty());
    let compared = text.starts_with('!') && text.contains(['<', '>', '=']);
    if !(named || compared) {
        return false;
    }
    let read = Filter::read_for_windows(text);
    read.wrong.is_empty() && !read.incomplete
}

/// The meaning of a word such as `cut_in`.
fn underscored(word: &Token) -> Option<Meaning> {
    if !word.said.contains('_') {
        return None;
    }
    let words = tokens(&word.said.replace('_', " "));
    let (length, meaning) = phrase(&words)?;
    (length == words.len()).then_some(meaning)
}

/// Whether a word is part of a scenario's name: capitals with digits or `_`.
fn is_name(word: &str) -> bool {
    let has = |test: fn(&char) -> bool| word.chars().any(|c| test(&c));
    has(char::is_ascii_uppercase) && (word.contains('_') || has(char::is_ascii_digit))
}
