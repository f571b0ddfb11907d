//! Finds a few patterns in a stream of bytes, and reports after every byte which of them may have begun.
//!
//! An Aho-Corasick automaton, written here because how much of a stream is held back depends on the longest started
//! match, which the usual library does not report.

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
