//! The list of scenarios: filtered as one types, with the facts that are known so far.

use std::cmp::Ordering;

use nucleo_matcher::pattern::{CaseMatching, Normalization, Pattern};
use nucleo_matcher::{Config, Matcher, Utf32Str};

use crate::metrics::Measure;
use crate::scenario::{Entry, Found, PassedOver};
use crate::tui::loaded::Facts;

/// The scenarios.
#[derive(Debug, Default)]
pub struct List {
    /// All of them.
    pub rows: Vec<Row>,
    /// Whether they have been looked for.
    pub found: bool,
    /// What looked like scenarios from outside and was left out, and folders that could not be searched.
    pub passed_over: Vec<PassedOver>,
    /// Places of those that the filter lets through, the best match first.
    pub visible: Vec<usize>,
    /// The selected one, as a place in `visible`.
    pub selected: usize,
    /// The filter.
    pub filter: String,
    /// The opened one, as a place in `rows`.
    pub opened: Option<usize>,
    /// Whether the filter is being typed.
    pub filtering: bool,
    /// The measure by which it is sorted; by name without one.
    pub order: Option<&'static Measure>,
}

/// A scenario in the list.
#[derive(Debug)]
pub struct Row {
    /// The scenario.
    pub entry: Entry,
    /// What is known of it, once it is.
    pub facts: Option<Result<Facts, String>>,
    /// The most dangerous value of the measure by which the list is sorted; the outer one is whether it is known.
    pub value: Option<Option<f64>>,
}

impl List {
    /// The list of these scenarios.
    pub fn fill(&mut self, found: Found) {
        self.passed_over = found.passed_over;
        self.rows = found
            .entries
            .into_iter()
            .map(|entry| Row {
                entry,
                facts: None,
                value: None,
            })
            .collect();
        self.found = true;
        self.apply_filter();
    }

    /// The selected scenario's place in `rows`.
    #[must_use]
    pub fn current(&self) -> Option<usize> {
        self.visible.get(self.selected).copied()
    }

    /// Adds a scenario at the end; gives its place.
    pub fn append(&mut self, entry: Entry) -> usize {
        self.rows.push(Row {
            entry,
            facts: None,
            value: None,
        });
        self.apply_filter();
        self.rows.len() - 1
    }

    /// Selects the scenario at a place; a filter that hides it goes.
    pub fn show(&mut self, place: usize) {
        if !self.visible.contains(&place) {
            self.filtering = false;
            self.set_filter(String::new());
        }
        let shown = self.visible.iter().position(|&other| other == place);
        self.selected = shown.unwrap_or(self.selected);
    }

    /// Moves the selection; it stops at the ends.
    pub fn move_by(&mut self, lines: isize) {
        let last = self.visible.len().saturating_sub(1);
        self.selected = self.selected.saturating_add_signed(lines).min(last);
    }

    /// Changes the filter; the selected scenario stays selected if it passes.
    pub fn set_filter(&mut self, filter: String) {
        self.filter = filter;
        self.apply_filter();
    }

    /// Sorts by a measure, as its values become known; by name without one.
    pub fn sort_by(&mut self, measure: Option<&'static Measure>) {
        self.order = measure;
        for row in &mut self.rows {
            row.value = None;
        }
        self.apply_filter();
    }

    /// The most dangerous value of a scenario is known; values of another measure are too late.
    pub fn rank(&mut self, measure: &str, place: usize, value: Option<f64>) {
        if self.order.is_some_and(|m| m.id == measure)
            && let Some(row) = self.rows.get_mut(place)
        {
            row.value = Some(value);
            self.apply_filter();
        }
    }

    /// The order of two places, the more dangerous one first; scenarios without a value come last.
    fn compare(&self, measure: &Measure, a: usize, b: usize) -> Ordering {
        let value = |place: usize| self.rows[place].value.flatten();
        match (value(a), value(b)) {
            (Some(x), Some(y)) => measure.danger.compare(x, y),
            (Some(_), None) => Ordering::Less,
            (None, Some(_)) => Ordering::Greater,
            (None, None) => Ordering::Equal,
        }
        .then(a.cmp(&b))
    }

    fn apply_filter(&mut self) {
        let selected = self.current();
        let mut matcher = Matcher::new(Config::DEFAULT.match_paths());
        let pattern = Pattern::parse(&self.filter, CaseMatching::Smart, Normalization::Smart);
        let mut buffer = Vec::new();
        let mut scored: Vec<(u32, usize)> = Vec::new();
        for (place, row) in self.rows.iter().enumerate() {
            let text = format!("{} {}", row.entry.name, row.entry.group);
            if let Some(score) = pattern.score(Utf32Str::new(&text, &mut buffer), &mut matcher) {
                scored.push((score, place));
            }
        }
        if let Some(measure) = self.order {
            scored.sort_by(|a, b| self.compare(measure, a.1, b.1));
        } else if !self.filter.is_empty() {
            scored.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        }
        self.visible = scored.into_iter().map(|(_, place)| place).collect();
        let kept = selected
            .or(self.opened)
            .and_then(|s| self.visible.iter().position(|&v| v == s));
        // The best match is what one looks for while typing; a new order moves what is selected.
        self.selected = kept
            .filter(|_| self.filter.is_empty() || self.order.is_some())
            .unwrap_or(0);
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn filters_fuzzily_and_keeps_the_selection() {
        let mut list = List::default();
        let names = [
            "a/DEU_Bremen-1_10_T-1.xml",
            "a/USA_Peach-4_8_T-1.xml",
            "b/DEU_Bonn-1_1_T-1.xml",
        ];
        let entries = names.iter().map(|n| Entry::of_file(Path::new(n)));
        list.fill(entries.collect::<Vec<_>>().into());
        list.move_by(2);
        assert_eq!(list.current(), Some(2));
        list.set_filter("brem".into());
        assert_eq!(list.visible, [0]);
        list.set_filter(String::new());
        assert_eq!(list.visible.len(), 3);
        list.set_filter("nothing like it".into());
        assert_eq!(list.current(), None);
    }
}
