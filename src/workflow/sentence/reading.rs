//! From the words of a sentence to the terms of a filter.

use super::lexicon::{Meaning, phrase};
use super::words::{Token, tokens};
use super::{Sentence, quantity};
use crate::workflow::scenario_filter::country_named;

/// Part of a sentence.
#[derive(Debug, Clone)]
pub struct Item {
    /// Its words: first and behind the last.
    pub words: (usize, usize),
    /// What it is.
    pub what: What,
}

/// What a part of a sentence is.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// A phrase that is known.
    Means(Meaning),
    /// A term as it stands, or a word of a name.
    Term(String),
    /// A number.
    Number(f64),
    /// Not known.
    Unknown,
}

/// Left and right, which no term tells apart.
const SIDES: [&str; 4] = ["left", "right", "leftwards", "rightwards"];

/// Reads a sentence.
pub fn read(sentence: &str) -> Sentence {
    let (sides, words): (Vec<_>, Vec<_>) = { tokens(sentence).into_iter().enumerate() }
        .partition(|(_, token)| SIDES.contains(&token.small.as_str()));
    let (places, words): (Vec<usize>, Vec<Token>) = words.into_iter().unzip();
    let mut reading = Reading {
        unknown: vec![false; words.len()],
        terms: Vec::new(),
    };
    let items = items(&words);
    let mut at = 0;
    while at < items.len() {
        at += reading.take(&items[at..]);
    }
    let unknown = reading.unknown.iter().zip(places.iter().zip(&words));
    let unknown = unknown.filter(|(unknown, _)| **unknown);
    let unknown = unknown.map(|(_, (place, token))| (*place, token.said.clone()));
    let sides = sides.into_iter().map(|(place, token)| (place, token.said));
    let mut unknown: Vec<(usize, String)> = unknown.chain(sides).collect();
    unknown.sort();
    Sentence {
        filter: reading.filter(),
        not_understood: joined(unknown),
    }
}

/// Words that follow each other are one part.
fn joined(words: Vec<(usize, String)>) -> Vec<String> {
    let mut parts: Vec<(usize, String)> = Vec::new();
    for (place, word) in words {
        match parts.last_mut() {
            Some((last, part)) if *last + 1 == place => {
                *last = place;
                part.push(' ');
                part.push_str(&word);
            }
            _ => parts.push((place, word)),
        }
    }
    parts.into_iter().map(|(_, part)| part).collect()
}

/// The parts of a sentence, without fillers.
fn items(words: &[Token]) -> Vec<Item> {
    let mut items = Vec::new();
    let mut at = 0;
    while at < words.len() {
        let (length, what) = part(&words[at..]);
        let filler = what == What::Means(Meaning::Filler);
        if !filler {
            items.push(Item {
                words: (at, at + length),
                what,
            });
        }
        at += length;
    }
    items
}

fn part(words: &[Token]) -> (usize, What) {
    let word = &words[0];
    match phrase(words) {
        Some((length, Meaning::Key(key))) => match words.get(length) {
            Some(value) => (length + 1, What::Term(format!("{key}:{}", value.small))),
            None => (length, What::Unknown),
        },
        Some((length, meaning)) => (length, What::Means(meaning)),
        None => {
            let two = words
                .get(1)
                .map(|next| format!("{} {}", word.said, next.said));
            if let Some(code) = two.and_then(|two| country_named(&two)) {
                return (2, What::Term(format!("country:{code}")));
            }
            match (word.number, country_named(&word.said)) {
                (Some(number), _) => (1, What::Number(number)),
                (None, Some(code)) => (1, What::Term(format!("country:{code}"))),
                (None, None) if is_name(&word.said) => (1, What::Term(word.said.clone())),
                _ => (1, What::Unknown),
            }
        }
    }
}

/// Whether a word is part of a scenario's name: capitals with digits or `_`.
fn is_name(word: &str) -> bool {
    let has = |test: fn(&char) -> bool| word.chars().any(|c| test(&c));
    has(char::is_ascii_uppercase) && (word.contains('_') || has(char::is_ascii_digit))
}

/// A term while the sentence is read.
enum Term {
    /// A key with the values of all its words.
    Values {
        key: &'static str,
        values: Vec<String>,
        negated: bool,
    },
    /// One that is complete.
    Whole(String),
}

struct Reading {
    /// By word.
    unknown: Vec<bool>,
    terms: Vec<Term>,
}

impl Reading {
    /// Takes what stands first: how many items.
    fn take(&mut self, items: &[Item]) -> usize {
        if let Some(taken) = self.levels(items) {
            return taken;
        }
        if let Some(quantity) = quantity::read(items) {
            let taken = &items[..quantity.length];
            if quantity.terms.is_empty() {
                taken.iter().for_each(|item| self.miss(item));
            }
            for term in quantity.terms {
                self.whole(term);
            }
            return quantity.length;
        }
        let item = &items[0];
        match &item.what {
            What::Means(Meaning::Term(key, value)) => self.add(key, value, false),
            What::Means(Meaning::Terms(all)) => {
                for (key, value) in *all {
                    self.add(key, value, false);
                }
            }
            What::Means(Meaning::Whole(term)) => self.whole((*term).to_string()),
            What::Means(Meaning::Not) => return self.negated(items),
            What::Term(term) => self.whole(term.clone()),
            // Joins, and obstacles that nothing is said of.
            What::Means(Meaning::And | Meaning::Measure("obstacles", _)) => {}
            _ => self.miss(item),
        }
        1
    }

    /// Not what follows, as far as it is joined and of one key.
    fn negated(&mut self, items: &[Item]) -> usize {
        let value = |item: Option<&Item>| match item.map(|item| &item.what) {
            Some(What::Means(Meaning::Term(key, value))) => Some((*key, (*value).to_string())),
            Some(What::Term(term)) => Some(("", term.clone())),
            _ => None,
        };
        let Some((key, first)) = value(items.get(1)) else {
            self.miss(&items[0]);
            return 1;
        };
        if key.is_empty() {
            self.whole(format!("!{first}"));
            return 2;
        }
        self.add(key, &first, true);
        let mut at = 2;
        let joins = |at: usize| {
            let meaning = items.get(at).map(|item| &item.what);
            meaning == Some(&What::Means(Meaning::And))
        };
        while joins(at) {
            match value(items.get(at + 1)) {
                Some((same, value)) if same == key => self.add(key, &value, true),
                _ => break,
            }
            at += 2;
        }
        at
    }

    /// Names of severities beside a word such as risk: `high risk or worse`, `worse than medium risk`.
    fn levels(&mut self, items: &[Item]) -> Option<usize> {
        let what = |at: usize| items.get(at).map(|item| &item.what);
        let level = |at: usize| match what(at) {
            Some(What::Means(Meaning::Level(score))) => Some(*score),
            _ => None,
        };
        let means = |at: usize, meaning: Meaning| what(at) == Some(&What::Means(meaning));
        let mut at = 0;
        let mut named = means(at, Meaning::Risk);
        at += usize::from(named);
        let sign = match what(at) {
            Some(What::Means(Meaning::Worse)) => Some("<"),
            // More risk is a lower score.
            Some(What::Means(Meaning::Compare(">=", _))) => Some("<="),
            Some(What::Means(Meaning::Compare(">", _))) => Some("<"),
            Some(What::Means(Meaning::Compare("<=", _))) => Some(">="),
            Some(What::Means(Meaning::Compare("<", _))) => Some(">"),
            _ => None,
        };
        at += usize::from(sign.is_some());
        let mut scores = vec![level(at)?];
        at += 1;
        while let (true, Some(score)) = (means(at, Meaning::And), level(at + 1)) {
            scores.push(score);
            at += 2;
        }
        if means(at, Meaning::Risk) {
            named = true;
            at += 1;
        }
        let worse = means(at, Meaning::OrWorse) || means(at, Meaning::OrMore);
        let better = means(at, Meaning::OrLess);
        at += usize::from(worse || better);
        // `high speed` says nothing of risk; `extreme` can be nothing else.
        if !named && sign.is_none() && scores != [1] {
            return None;
        }
        let sign = match (sign, worse, better) {
            (None, true, _) => Some("<="),
            (None, _, true) => Some(">="),
            (sign, ..) => sign,
        };
        match (sign, &scores[..]) {
            (Some(sign), [score]) => self.whole(format!("severity{sign}{score}")),
            (None, scores) => {
                let levels = &crate::metrics::RISK_LEVELS;
                for level in scores.iter().filter_map(|score| levels.level(*score)) {
                    self.add("severity", &level.name, false);
                }
            }
            _ => items[..at].iter().for_each(|item| self.miss(item)),
        }
        Some(at)
    }

    fn miss(&mut self, item: &Item) {
        self.unknown[item.words.0..item.words.1].fill(true);
    }

    fn whole(&mut self, term: String) {
        let known = |t: &Term| matches!(t, Term::Whole(other) if *other == term);
        if !self.terms.iter().any(known) {
            self.terms.push(Term::Whole(term));
        }
    }

    fn add(&mut self, key: &'static str, value: &str, negated: bool) {
        let same = self.terms.iter_mut().find_map(|term| match term {
            Term::Values {
                key: k,
                values,
                negated: n,
            } if *k == key && *n == negated => Some(values),
            _ => None,
        });
        match same {
            Some(values) if values.iter().any(|known| known == value) => {}
            Some(values) => values.push(value.to_string()),
            None => self.terms.push(Term::Values {
                key,
                values: vec![value.to_string()],
                negated,
            }),
        }
    }

    fn filter(&self) -> String {
        let terms = self.terms.iter().map(|term| match term {
            Term::Whole(term) => term.clone(),
            Term::Values {
                key,
                values,
                negated,
            } => {
                let not = if *negated { "!" } else { "" };
                let mut values: Vec<&str> = values.iter().map(String::as_str).collect();
                // Who turns across the ego's way came towards it.
                if values.contains(&"turning_across") {
                    values.retain(|value| *value != "oncoming");
                }
                format!("{not}{key}:{}", values.join(","))
            }
        });
        terms.collect::<Vec<_>>().join(" ")
    }
}
