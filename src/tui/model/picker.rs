//! A fuzzy picker: an input line and the matching items.

use std::collections::HashSet;

use nucleo_matcher::pattern::{AtomKind, CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher, Utf32Str};

use crate::action::{ACTIONS, Action, Entry, synonyms_of};
use crate::model::{Model, Order};
use nearmiss_scene::judge;
use nearmiss_scene::metrics::{Danger, Measure, measures};

/// A line to type into and a selection below it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Picker {
    /// The typed text.
    pub text: String,
    /// The selected line.
    pub selected: usize,
}

/// The rank of an action in whose sentence a typed word stands within another one, and of one in which its letters only
/// stand in order: both match where nothing better does.
const WITHIN: usize = 6;
const LOOSE: usize = 7;

/// The actions that a palette shows, the best match first: names before words that mean the same, these before
/// sentences.
#[must_use]
pub fn palette_shown(model: &Model, picker: &Picker) -> Vec<&'static Entry> {
    // `index FOLDER` is that action alone, whatever the folder is called.
    let folder = picker.text.trim_start().strip_prefix("index ");
    if folder.is_some_and(|folder| !folder.trim().is_empty()) {
        let index = ACTIONS.iter().find(|e| e.action == Action::ChooseIndex);
        return index.into_iter().collect();
    }
    // An action that several places have is listed once.
    let mut seen = HashSet::new();
    let all = ACTIONS.iter().filter(|entry| seen.insert(entry.action));
    let all: Vec<&Entry> = all.collect();
    let texts = all
        .iter()
        .map(|e| format!("{} {} {}", e.id, synonyms_of(e.action), e.doc));
    let shown = matching(&picker.text, texts);
    let mut shown: Vec<&Entry> = shown.into_iter().map(|i| all[i]).collect();
    let typed = picker.text.trim().to_lowercase();
    let rank = |entry: &Entry| {
        let words = || {
            let words = synonyms_of(entry.action).split(' ');
            words.chain(entry.id.split('-'))
        };
        let doc = entry.doc.to_lowercase();
        let in_doc = || doc.split(|c: char| !c.is_alphanumeric());
        let rank = |typed: &str| match typed {
            _ if words().any(|word| word == typed) => 2,
            _ if words().any(|word| word.starts_with(typed)) => 3,
            _ if words().any(|word| word.contains(typed)) => 4,
            _ if in_doc().any(|word| word.starts_with(typed)) => 5,
            _ if doc.contains(typed) => WITHIN,
            _ => LOOSE,
        };
        match typed.as_str() {
            "" => 0,
            typed if entry.id == typed => 0,
            typed if entry.id.starts_with(typed) => 1,
            typed => typed.split_whitespace().map(rank).max().unwrap_or(LOOSE),
        }
    };
    let best = shown.iter().map(|entry| rank(entry)).min();
    let most = best.map_or(LOOSE, |best| best.max(WITHIN - 1));
    shown.retain(|entry| rank(entry) <= most);
    // Of words that only contain it, none is nearer than another: the table's order.
    let place = |entry: &Entry| all.iter().position(|other| other.action == entry.action);
    // What another screen does comes last, unless it is named.
    let here = model.place();
    shown.sort_by_key(|entry| {
        let rank = rank(entry);
        let is_named = !typed.is_empty() && rank < 2;
        let is_elsewhere = !is_named && entry.elsewhere(here).is_some();
        let by_table = if rank == 4 { place(entry) } else { None };
        (is_elsewhere, rank, by_table)
    });
    shown
}

/// The listed models, best match first; typed text can name an unlisted one.
#[must_use]
pub fn models_shown(model: &Model, picker: &Picker) -> Vec<String> {
    let mut ids = vec![judge::MODEL.to_string()];
    // Those that answered already are at hand.
    let answered = model.answers.columns.iter().map(|column| &column.model);
    let offered = model.offers.iter().map(|offer| &offer.id);
    for id in answered.chain(offered) {
        if !ids.contains(id) {
            ids.push(id.clone());
        }
    }
    let order = matching(&picker.text, ids.iter().cloned());
    let mut shown: Vec<String> = order.into_iter().map(|i| ids[i].clone()).collect();
    // What cannot be asked for want of a key comes last.
    let lacks_key = |id: &String| {
        let offer = model.offers.iter().find(|offer| offer.id == *id);
        offer.is_some_and(|offer| matches!(offer.key, Some((_, false))))
    };
    shown.sort_by_key(lacks_key);
    let typed = picker.text.trim();
    let named = typed
        .split_once('/')
        .is_some_and(|(p, m)| !p.is_empty() && !m.is_empty());
    if named && !shown.iter().any(|id| id == typed) {
        shown.push(typed.to_string());
    }
    shown
}

/// The measures that the list shows, the best match first.
#[must_use]
pub fn measures_shown(picker: &Picker) -> Vec<&'static Measure> {
    let texts = measures().map(|m| format!("{} {}", m.id, m.name));
    let order = matching(&picker.text, texts);
    order
        .into_iter()
        .filter_map(|i| measures().nth(i))
        .collect()
}

/// What the list of scenarios can be sorted by, the best match first: measures of which some values are dangerous, and
/// what else is known.
#[must_use]
pub fn orders_shown(picker: &Picker) -> Vec<Order> {
    let dangerous = measures().filter(|m| m.danger != Danger::Neutral);
    let measures = dangerous.map(Order::Measure);
    let all: Vec<Order> = Order::PLAIN.into_iter().chain(measures).collect();
    let texts = all
        .iter()
        .map(|order| format!("{} {}", order.id(), order.doc()));
    let shown = matching(&picker.text, texts);
    shown.into_iter().map(|i| all[i]).collect()
}

/// The templates for the task and frame that the list shows, by file.
#[must_use]
pub fn templates_shown(model: &Model, picker: &Picker) -> Vec<String> {
    let all = model
        .library
        .candidates(model.task.name(), model.frame.name());
    let all: Vec<(String, String)> = all
        .map(|(file, template, _)| (file.to_string(), template.front.summary.clone()))
        .collect();
    let texts = all
        .iter()
        .map(|(file, summary)| format!("{file} {summary}"));
    let order = matching(&picker.text, texts);
    order.into_iter().map(|i| all[i].0.clone()).collect()
}

/// Places of the texts that match, the best first; all of them for an empty pattern. Letters that only stand in order
/// match where no text has the words as parts, as in the filter of the list.
#[must_use]
pub fn matching(pattern: &str, texts: impl Iterator<Item = String>) -> Vec<usize> {
    let texts: Vec<String> = texts.collect();
    let mut matcher = Matcher::new(Config::DEFAULT);
    let mut buffer = Vec::new();
    let mut score = |parsed: Pattern| -> Vec<(u32, usize)> {
        let texts = texts.iter().enumerate();
        texts
            .filter_map(|(i, text)| {
                let text = Utf32Str::new(text, &mut buffer);
                parsed.score(text, &mut matcher).map(|score| (score, i))
            })
            .collect()
    };
    let (case, form) = (CaseMatching::Smart, Normalization::Smart);
    let mut scored = score(Pattern::new(pattern, case, form, AtomKind::Substring));
    if scored.is_empty() {
        scored = score(Pattern::parse(pattern, case, form));
    }
    if !pattern.is_empty() {
        scored.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    }
    scored.into_iter().map(|(_, i)| i).collect()
}

#[cfg(test)]
mod tests {
    use super::{Picker, orders_shown};

    #[test]
    fn scattered_letters_match_only_where_no_word_does() {
        let shown = |text: &str| {
            let picker = Picker {
                text: text.into(),
                selected: 0,
            };
            let orders = orders_shown(&picker).into_iter();
            orders.map(|order| order.id()).collect::<Vec<_>>()
        };
        let orders = shown("ttc");
        assert_eq!(orders[0], "ttc");
        assert!(orders.iter().all(|id| id.contains("ttc")), "{orders:?}");
        assert!(shown("svrt").contains(&"severity"));
    }
}
