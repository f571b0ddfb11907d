//! Redacts secrets in all their forms from a text that arrives in arbitrary pieces.

use std::collections::VecDeque;

use super::escapes::{self, Escapes, Unit};
use super::finder::State;
use super::{Search, Secrets};

/// Layers of escapes that are taken back: JSON in JSON in JSON.
pub(super) const LAYERS: usize = 3;

/// Replacement of a secret.
const INSTEAD: &str = "[key]";

/// Takes secrets out of one text. The end of what has arrived is held back while it may be the beginning of a secret,
/// which is bounded by the length of the secrets.
#[derive(Default)]
pub(in crate::llm) struct Redactor {
    secrets: Secrets,
    pub(super) held: String,
    /// Where in the whole text `held` begins, and up to where nothing of it is shown.
    at: usize,
    hidden: usize,
    /// The text as it is written, and with one layer of escapes after the other taken back.
    layers: [Layer; LAYERS + 1],
    escapes: [Escapes; LAYERS],
    /// An escape may have begun since nothing had; until then all layers are like the first, which alone is looked at.
    escaped: bool,
    /// Secrets that were found in what is held: where they begin and end.
    found: Vec<(usize, usize)>,
}

/// The search in a text with some of its escapes taken back.
#[derive(Clone, Default)]
struct Layer {
    plain: State,
    coded: State,
    /// Where the last bytes are written that may be the beginning of a secret.
    starts: VecDeque<usize>,
}

impl Layer {
    /// One more byte: where a secret stands that ends with it.
    fn take(&mut self, search: &Search, unit: Unit) -> Option<(usize, usize)> {
        self.starts.push_back(unit.start);
        self.plain = search.plain.next(self.plain, unit.byte);
        self.coded = search.coded.next(self.coded, unit.byte);
        let found = search.plain.found(self.plain);
        let start = self.start_of_last(found.max(search.coded.found(self.coded)));
        let depth = search
            .plain
            .depth(self.plain)
            .max(search.coded.depth(self.coded));
        while self.starts.len() > depth {
            self.starts.pop_front();
        }
        Some((start?, unit.end))
    }

    /// Where so many of the last bytes begin; `None` for none.
    fn start_of_last(&self, count: usize) -> Option<usize> {
        let at = self.starts.len().checked_sub(count.max(1))?;
        self.starts.get(at).copied().filter(|_| count > 0)
    }

    /// Where the beginning of a secret stands that tells too much of it.
    fn telling(&self, search: &Search) -> Option<usize> {
        let telling = search.plain.telling(self.plain);
        self.start_of_last(telling.max(search.coded.telling(self.coded)))
    }
}

impl Redactor {
    pub fn new(secrets: &Secrets) -> Self {
        Self {
            secrets: secrets.clone(),
            ..Self::default()
        }
    }

    /// The next piece, without secrets, up to where one may have begun.
    pub fn push(&mut self, piece: &str) -> String {
        let Some(search) = self.secrets.search.clone() else {
            return piece.to_owned();
        };
        let base = self.at + self.held.len();
        self.held.push_str(piece);
        let bytes = piece.as_bytes();
        let mut at = 0;
        while let Some(byte) = bytes.get(at).copied() {
            // Nearly all text is passed over here.
            if !search.begins[usize::from(byte)] && self.is_idle() {
                at += 1;
                continue;
            }
            let (start, end) = (base + at, base + at + 1);
            let unit = Unit { byte, start, end };
            at += 1;
            if !self.escaped && !escapes::begins(byte) {
                self.found.extend(self.layers[0].take(&search, unit));
                continue;
            }
            if !self.escaped {
                let [first, others @ ..] = &mut self.layers;
                others.fill(first.clone());
            }
            self.step(&search, 0, unit);
            self.escaped = !self.is_idle();
        }
        let begun = self
            .layers
            .iter()
            .filter_map(|l| l.starts.front().copied())
            .chain(self.escapes.iter().filter_map(Escapes::begun));
        self.release(begun.min().unwrap_or(base + bytes.len()))
    }

    /// Returns the held text at the end of a complete text.
    pub fn end(&mut self) -> String {
        let rest = self.release(self.at + self.held.len());
        *self = Self::new(&self.secrets);
        rest
    }

    /// Returns the held text at the end of a possibly truncated text; the larger part of a secret is redacted, too.
    pub fn cut(&mut self) -> String {
        let end = self.at + self.held.len();
        if let Some(search) = self.secrets.search.clone() {
            let begun = self.layers.iter().filter_map(|l| l.telling(&search));
            self.found.extend(begun.map(|start| (start, end)));
        }
        self.end()
    }

    /// Whether nothing has begun, in no layer.
    fn is_idle(&self) -> bool {
        self.layers.iter().all(|layer| layer.starts.is_empty())
            && self.escapes.iter().all(|e| e.begun().is_none())
    }

    fn step(&mut self, search: &Search, layer: usize, unit: Unit) {
        self.found.extend(self.layers[layer].take(search, unit));
        let Some(escapes) = self.escapes.get_mut(layer) else {
            return;
        };
        if escapes.passes(unit.byte) {
            return self.step(search, layer + 1, unit);
        }
        let mut units = Vec::new();
        escapes.push(unit, |unit| units.push(unit));
        for unit in units {
            self.step(search, layer + 1, unit);
        }
    }

    /// Lets go of what is held up to a place before which nothing has begun.
    fn release(&mut self, mut until: usize) -> String {
        while !self.held.is_char_boundary(until - self.at) {
            until -= 1;
        }
        let mut shown = String::new();
        self.found.sort_unstable();
        let mut from = self.at.max(self.hidden);
        for &(start, end) in self.found.iter().filter(|(start, _)| *start < until) {
            if start >= self.hidden {
                shown += self.between(from, start);
                shown += INSTEAD;
            }
            self.hidden = self.hidden.max(end);
            from = self.hidden;
        }
        shown += self.between(from, until);
        self.found.retain(|(start, _)| *start >= until);
        self.held.drain(..until - self.at);
        self.at = until;
        shown
    }

    fn between(&self, from: usize, to: usize) -> &str {
        let place = |at: usize| at.saturating_sub(self.at);
        self.held.get(place(from)..place(to)).unwrap_or_default()
    }
}

// The held text may be half a secret.
impl std::fmt::Debug for Redactor {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Redactor")
    }
}
