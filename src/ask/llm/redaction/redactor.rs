//! Redacts secrets in all their forms from a text that arrives in arbitrary pieces, by finding patterns byte by byte.
//!
//! Finds a few patterns in a stream of bytes, and reports after every byte which of them may have begun.
//!
//! An Aho-Corasick automaton, written here because how much of a stream is held back depends on the longest started
//! match, which the usual library does not report.

use std::collections::VecDeque;

use super::super::chunk::Chunk;
use super::escapes::{self, Escapes, Unit};
use super::{Search, Secrets};

/// Layers of escapes that are taken back: JSON in JSON in JSON.
pub(super) const LAYERS: usize = 3;

/// Replacement of a secret.
const REPLACEMENT: &str = "[key]";

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
                shown += REPLACEMENT;
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

/// Takes secrets out of the two texts of an answer.
#[derive(Debug, Default)]
pub(in crate::llm) struct Redactors {
    reasoning: Redactor,
    text: Redactor,
}

impl Redactors {
    pub fn new(secrets: &Secrets) -> Self {
        Self {
            reasoning: Redactor::new(secrets),
            text: Redactor::new(secrets),
        }
    }

    /// A piece of one of the texts, without secrets; nothing if all of it is held back. Other chunks are left alone.
    pub fn piece(&mut self, chunk: Chunk) -> Option<Chunk> {
        match chunk {
            Chunk::Reasoning(text) => some(self.reasoning.push(&text)).map(Chunk::Reasoning),
            Chunk::Text(text) => some(self.text.push(&text)).map(Chunk::Text),
            other => Some(other),
        }
    }

    /// Returns text held back at the end of a stream; call until it returns `None`.
    pub fn held(&mut self) -> Option<Chunk> {
        let reasoning = some(self.reasoning.cut()).map(Chunk::Reasoning);
        reasoning.or_else(|| some(self.text.cut()).map(Chunk::Text))
    }
}

fn some(text: String) -> Option<String> {
    (!text.is_empty()).then_some(text)
}

/// How much of a text has been seen. The node itself stands for the bytes on the way to it.
struct Node {
    next: Vec<(u8, u32)>,
    /// The node of the longest end of these bytes that is the beginning of a text, too.
    back: u32,
    /// How many bytes have been seen.
    depth: usize,
    /// Length of the longest text that ends here; 0 if none does.
    found: usize,
    /// From how many bytes on a text that breaks off here has told too much.
    telling: usize,
}

/// The texts that are looked for. They may be secret, so this prints nothing.
pub(super) struct Finder {
    nodes: Vec<Node>,
    /// Case folding of bytes, such as a lower-case letter for a capital one.
    fold: [u8; 256],
}

/// The place in a search; the beginning is 0.
pub(super) type State = u32;

impl Finder {
    /// A search for these texts in which bytes that fold to the same one are equal.
    pub fn new<'a>(texts: impl IntoIterator<Item = &'a [u8]>, fold: fn(u8) -> u8) -> Self {
        let mut finder = Self {
            nodes: vec![Node::new(0)],
            fold: std::array::from_fn(|byte| fold(u8::try_from(byte).unwrap_or_default())),
        };
        for text in texts {
            finder.add(text);
        }
        finder.link();
        finder
    }

    /// Whether a text can begin with this byte.
    pub fn begins(&self, byte: u8) -> bool {
        self.edge(0, self.fold[usize::from(byte)]).is_some()
    }

    /// The place after one more byte.
    pub fn next(&self, mut state: State, byte: u8) -> State {
        let byte = self.fold[usize::from(byte)];
        loop {
            match self.edge(state, byte) {
                Some(next) => return next,
                None if state == 0 => return 0,
                None => state = self.node(state).back,
            }
        }
    }

    /// How many of the last bytes may be the beginning of a text.
    pub fn depth(&self, state: State) -> usize {
        self.node(state).depth
    }

    /// Length of the longest text that the last bytes are; 0 if they are none.
    pub fn found(&self, state: State) -> usize {
        self.node(state).found
    }

    /// How many of the last bytes are so much of a text that they tell too much of it, if nothing follows; or 0.
    pub fn telling(&self, mut state: State) -> usize {
        while state != 0 {
            let node = self.node(state);
            if node.depth >= node.telling {
                return node.depth;
            }
            state = node.back;
        }
        0
    }

    fn node(&self, state: State) -> &Node {
        &self.nodes[state as usize]
    }

    fn edge(&self, state: State, byte: u8) -> Option<State> {
        let edges = self.node(state).next.iter();
        edges.copied().find(|(b, _)| *b == byte).map(|(_, to)| to)
    }

    fn add(&mut self, text: &[u8]) {
        let telling = (text.len() / 2).clamp(4, 8);
        let mut state = 0;
        for (at, byte) in text.iter().enumerate() {
            let byte = self.fold[usize::from(*byte)];
            state = match self.edge(state, byte) {
                Some(next) => next,
                None => {
                    let new = u32::try_from(self.nodes.len()).unwrap_or_default();
                    self.nodes.push(Node::new(at + 1));
                    self.nodes[state as usize].next.push((byte, new));
                    new
                }
            };
            let node = &mut self.nodes[state as usize];
            node.telling = node.telling.min(telling);
        }
        self.nodes[state as usize].found = text.len();
    }

    /// Sets what to go back to, the shorter ones first.
    fn link(&mut self) {
        let mut order: Vec<State> = vec![0];
        let mut at = 0;
        while at < order.len() {
            let state = order[at];
            for (byte, to) in self.node(state).next.clone() {
                order.push(to);
                let back = match state {
                    0 => 0,
                    _ => self.next(self.node(state).back, byte),
                };
                let shorter = self.node(back).found;
                let node = &mut self.nodes[to as usize];
                node.back = back;
                node.found = node.found.max(shorter);
            }
            at += 1;
        }
    }
}

impl Node {
    fn new(depth: usize) -> Self {
        Self {
            next: Vec::new(),
            back: 0,
            depth,
            found: 0,
            telling: usize::MAX,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_has_begun_and_what_is_found() {
        let texts = ["sk-sk-ab", "k-s", "ab"];
        let finder = Finder::new(texts.map(str::as_bytes), |b| b.to_ascii_lowercase());
        let mut state = 0;
        let walked: Vec<_> = "xSk-sK-sk-abk"
            .bytes()
            .map(|byte| {
                state = finder.next(state, byte);
                (finder.depth(state), finder.found(state))
            })
            .collect();
        let depths: Vec<_> = walked.iter().map(|(depth, _)| *depth).collect();
        let found: Vec<_> = walked.iter().map(|(_, found)| *found).collect();
        assert_eq!(depths, [0, 1, 2, 3, 4, 5, 6, 4, 5, 6, 7, 8, 1]);
        assert_eq!(found, [0, 0, 0, 0, 3, 0, 0, 3, 0, 0, 0, 8, 0]);
        assert!(finder.begins(b'S') && !finder.begins(b'x'));
    }

    #[test]
    fn a_beginning_tells_too_much_from_half_of_the_text_on() {
        let finder = Finder::new([&b"0123456789"[..], b"56xxxxxxxx"], |b| b);
        let after = |text: &[u8]| text.iter().fold(0, |s, b| finder.next(s, *b));
        for (text, telling) in [(&b"0123"[..], 0), (b"01234", 5), (b"5", 0), (b"a56xxx", 5)] {
            assert_eq!(finder.telling(after(text)), telling, "{text:?}");
        }
    }
}
