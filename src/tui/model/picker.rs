//! A line to type into, and what of a list matches it.

use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher};

use super::Model;
use crate::judge;
use crate::metrics::{Danger, MEASURES, Measure};
use crate::tui::action::{ACTIONS, Entry};

/// A line to type into and a selection below it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Picker {
    /// What is typed.
    pub text: String,
    /// The selected line.
    pub selected: usize,
}

/// The actions that a palette shows, the best match first.
#[must_use]
pub fn palette_shown(picker: &Picker) -> Vec<&'static Entry> {
    let texts = ACTIONS.iter().map(|e| format!("{} {}", e.id, e.doc));
    matching(&picker.text, texts)
        .into_iter()
        .map(|i| &ACTIONS[i])
        .collect()
}

/// The models that the list shows, the best match first; what is typed can be one of its own.
#[must_use]
pub fn models_shown(model: &Model, picker: &Picker) -> Vec<String> {
    let mut ids = vec![judge::MODEL.to_string()];
    ids.extend(model.offers.iter().map(|o| o.id.clone()));
    let order = matching(&picker.text, ids.iter().cloned());
    let mut shown: Vec<String> = order.into_iter().map(|i| ids[i].clone()).collect();
    let typed = picker.text.trim();
    let named = typed
        .split_once('/')
        .is_some_and(|(p, m)| !p.is_empty() && !m.is_empty());
    if named && !shown.iter().any(|id| id == typed) {
        shown.push(typed.to_string());
    }
    shown
}

/// The measures that the list shows, the best match first; to sort by, also none at all, which is by name.
#[must_use]
pub fn measures_shown(picker: &Picker, sort: bool) -> Vec<Option<&'static Measure>> {
    let by_name = sort.then_some(None);
    let can_sort = |m: &&'static Measure| !sort || m.danger != Danger::Neutral;
    let measures = MEASURES.iter().filter(can_sort).map(Some);
    let all: Vec<_> = by_name.into_iter().chain(measures).collect();
    let texts = all.iter().map(|m| match m {
        Some(m) => format!("{} {}", m.id, m.name),
        None => "by name".into(),
    });
    let order = matching(&picker.text, texts);
    order.into_iter().map(|i| all[i]).collect()
}

/// Places of the texts that match, the best first; all of them for an empty pattern.
pub(super) fn matching(pattern: &str, texts: impl Iterator<Item = String>) -> Vec<usize> {
    let mut matcher = Matcher::new(Config::DEFAULT);
    let parsed = Pattern::parse(pattern, CaseMatching::Smart, Normalization::Smart);
    let mut buffer = Vec::new();
    let mut scored: Vec<(u32, usize)> = texts
        .enumerate()
        .filter_map(|(i, text)| {
            let text = nucleo_matcher::Utf32Str::new(&text, &mut buffer);
            parsed.score(text, &mut matcher).map(|score| (score, i))
        })
        .collect();
    if !pattern.is_empty() {
        scored.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
    }
    scored.into_iter().map(|(_, i)| i).collect()
}
