//! From the words of a sentence to the terms of a filter.

use super::items::{Item, What, items};
use super::levels;
use super::lexicon::{Meaning, alike};
use super::quantity::{self, Before, Named};
use super::words::{Token, tokens};
use super::{NotUnderstood, Sentence};

/// Reads a sentence.
pub fn read(sentence: &str) -> Sentence {
    let all = tokens(sentence).into_iter().enumerate();
    let (sides, words): (Vec<_>, Vec<_>) = all.partition(|(_, token)| token.is_side());
    let (places, words): (Vec<usize>, Vec<Token>) = words.into_iter().unzip();
    let mut reading = Reading {
        unknown: vec![false; words.len()],
        ..Reading::default()
    };
    let items = items(&words);
    let mut at = 0;
    while at < items.len() {
        at += reading.take(&items[at..]);
    }
    reading.end();
    let unknown = reading.unknown.iter().zip(places.iter().zip(&words));
    let unknown = unknown
        .filter(|(unknown, _)| **unknown)
        .map(|(_, (place, token))| (*place, token.said.clone()));
    let sides = sides.into_iter().map(|(place, token)| (place, token.said));
    let mut unknown: Vec<(usize, String)> = unknown.chain(sides).collect();
    unknown.sort();
    Sentence {
        filter: reading.filter(),
        not_understood: joined(unknown),
    }
}

/// Words that follow each other are one part.
fn joined(words: Vec<(usize, String)>) -> Vec<NotUnderstood> {
    let mut parts: Vec<(usize, Vec<String>)> = Vec::new();
    for (place, word) in words {
        match parts.last_mut() {
            Some((last, part)) if *last + 1 == place => {
                *last = place;
                part.push(word);
            }
            _ => parts.push((place, vec![word])),
        }
    }
    let parts = parts.into_iter().map(|(_, words)| NotUnderstood {
        alike: words.iter().find_map(|word| alike(word)),
        words: words.join(" "),
    });
    parts.collect()
}

/// Part of a filter.
#[derive(Debug, Clone)]
pub enum Part {
    /// A value of a key: those of one key are alternatives.
    Value(&'static str, String),
    /// A term that is complete.
    Whole(String),
}

/// What was said last, to which `or` may join alternatives.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Said {
    /// Values of a key.
    Values(&'static str),
    /// Anything else, which no filter has alternatives of.
    Other,
}

/// A term while the sentence is read.
enum Term {
    Values {
        key: &'static str,
        values: Vec<String>,
        negated: bool,
    },
    Whole(String),
}

/// Words, by their places: first and behind the last.
type Words = (usize, usize);

#[derive(Default)]
struct Reading {
    /// By word.
    unknown: Vec<bool>,
    terms: Vec<Term>,
    /// The measure of the quantity that was read last.
    joined: Option<Named>,
    /// The last measure without a number.
    waiting: Option<(Named, Words)>,
    said: Option<Said>,
    /// `or`, behind what was said.
    or: Option<(Said, Words)>,
    /// Words that say that the other is ahead.
    ahead: Option<Words>,
}

impl Reading {
    /// Takes what stands first: how many items.
    fn take(&mut self, items: &[Item]) -> usize {
        let item = &items[0];
        match item.what {
            What::Means(Meaning::Or) => {
                self.or = self.said.map(|said| (said, item.words));
                return 1;
            }
            // Joins, and obstacles that nothing is said of.
            What::Means(Meaning::And | Meaning::Between | Meaning::Measure("obstacles", _))
                if quantity::read(items, Before::default()).is_none() =>
            {
                return 1;
            }
            What::Means(Meaning::Not) => return self.negated(items),
            What::Means(Meaning::Ahead) => {
                self.ahead = Some(item.words);
                return 1;
            }
            What::Means(Meaning::NoTermOf) => {
                let length = items.len().min(2);
                self.miss(&items[..length]);
                return length;
            }
            _ => {}
        }
        let Some((length, parts)) = self.parts(items) else {
            self.miss(&items[..1]);
            if let What::Means(Meaning::Measure(id, unit)) = item.what {
                self.waiting = Some(((id, unit), item.words));
            }
            return 1;
        };
        match parts {
            Some(parts) => self.put(&parts, false),
            None => self.miss(&items[..length]),
        }
        length
    }

    /// The parts of a filter that an item or several mean, and how many; no parts where the filter language has none.
    fn parts(&mut self, items: &[Item]) -> Option<(usize, Option<Vec<Part>>)> {
        let joined = self.joined.take();
        if let Some(levels) = levels::read(items) {
            return Some(levels);
        }
        let before = Before {
            joined,
            waiting: self.waiting.map(|(named, _)| named),
        };
        if let Some(read) = quantity::read(items, before) {
            self.joined = read.named.filter(|_| read.terms.is_some());
            if let Some((named, words)) = self.waiting
                && self.joined == Some(named)
            {
                self.unknown[words.0..words.1].fill(false);
                self.waiting = None;
            }
            let parts = |terms: Vec<String>| terms.into_iter().map(Part::Whole).collect();
            return Some((read.length, read.terms.map(parts)));
        }
        let value = |(key, value): &(&'static str, &'static str)| Part::Value(key, (*value).into());
        let parts = match &items[0].what {
            What::Means(Meaning::Term(key, one)) => vec![value(&(*key, *one))],
            What::Means(Meaning::Terms(all)) => all.iter().map(value).collect(),
            What::Means(Meaning::Whole(term)) => vec![Part::Whole((*term).to_string())],
            What::Value(key, value) => vec![Part::Value(key, value.clone())],
            What::Term(term) => vec![Part::Whole(term.clone())],
            _ => return None,
        };
        Some((1, Some(parts)))
    }

    /// Not what follows, as far as it is joined and of one key.
    fn negated(&mut self, items: &[Item]) -> usize {
        let joins = |at: usize| {
            let what = items.get(at).map(|item| &item.what);
            matches!(what, Some(What::Means(Meaning::And | Meaning::Or)))
        };
        let mut at = 1;
        let mut key = None;
        loop {
            let rest = items.get(at..).unwrap_or_default();
            let next = match rest.first().map(|item| &item.what) {
                // `without any other vehicle`
                Some(What::Means(Meaning::Measure("obstacles", _))) => Some((1, None)),
                Some(_) => self.parts(rest),
                None => None,
            };
            let parts = next.as_ref().and_then(|(_, parts)| parts.clone());
            let parts = parts.filter(|parts| negatable(parts));
            let said = parts.as_deref().map(said_of);
            match (parts, next) {
                (Some(parts), Some((length, _))) if key.is_none() || key == said => {
                    self.put(&parts, true);
                    at += length;
                }
                // What cannot be negated is not meant as it stands.
                (None, Some((length, _))) if key.is_none() => {
                    self.miss(&items[..at + length]);
                    return at + length;
                }
                _ if key.is_none() => {
                    self.miss(&items[..1]);
                    return 1;
                }
                // It was joined to something else.
                _ => return at - 1,
            }
            key = said;
            if !(joins(at) && matches!(key, Some(Said::Values(_)))) {
                return at;
            }
            at += 1;
        }
    }

    fn put(&mut self, parts: &[Part], negated: bool) {
        let mut said = said_of(parts);
        if let Some((before, words)) = self.or.take()
            && (negated || said == Said::Other || said != before)
        {
            self.unknown[words.0..words.1].fill(true);
        }
        if negated {
            said = Said::Other;
        }
        self.said = Some(said);
        for part in parts {
            match (part, negated) {
                (Part::Value(key, value), _) => self.add(key, value, negated),
                (Part::Whole(term), false) => self.whole(term.clone()),
                (Part::Whole(term), true) => self.whole(match term.strip_prefix('!') {
                    Some(term) => term.to_string(),
                    None => format!("!{term}"),
                }),
            }
        }
    }

    fn miss(&mut self, items: &[Item]) {
        for item in items {
            self.unknown[item.words.0..item.words.1].fill(true);
        }
        (self.said, self.or, self.joined) = (None, None, None);
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

    /// What is ahead and does nothing else is followed, unless it walks.
    fn end(&mut self) {
        let Some(words) = self.ahead else { return };
        let values = |wanted: &str| {
            let mut terms = self.terms.iter();
            terms.find_map(|term| match term {
                Term::Values {
                    key,
                    values,
                    negated: false,
                } if *key == wanted => Some(values),
                _ => None,
            })
        };
        let walks = values("actor").is_some_and(|all| all.iter().any(|one| one == "pedestrian"));
        match (values("manoeuvre"), walks) {
            (Some(_), _) => {}
            (None, true) => self.unknown[words.0..words.1].fill(true),
            (None, false) => self.add("manoeuvre", "following", false),
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
                // What turns across the ego's way came towards it.
                if values.contains(&"turning_across") {
                    values.retain(|value| *value != "oncoming");
                }
                format!("{not}{key}:{}", values.join(","))
            }
        });
        terms.collect::<Vec<_>>().join(" ")
    }
}

fn said_of(parts: &[Part]) -> Said {
    let key = |part: &Part| match part {
        Part::Value(key, _) => Some(*key),
        Part::Whole(_) => None,
    };
    let first = parts.first().and_then(key);
    match first {
        Some(first) if parts.iter().all(|part| key(part) == Some(first)) => Said::Values(first),
        _ => Said::Other,
    }
}

/// Whether the filter language can say that these do not hold: values of one key, or a single term.
fn negatable(parts: &[Part]) -> bool {
    parts.len() == 1 || matches!(said_of(parts), Said::Values(_))
}
