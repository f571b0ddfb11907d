//! Takes the key out of what a server sends, also where it comes in pieces: some servers quote what they were sent.

use super::chunk::Chunk;
use super::error::without_key;

/// Takes the key out of the two texts of an answer.
#[derive(Debug, Default)]
pub(super) struct Redactors {
    reasoning: Redactor,
    text: Redactor,
}

impl Redactors {
    /// A piece of one of the texts, without the key; nothing if all of it is held back. Other chunks are left alone.
    pub fn piece(&mut self, chunk: Chunk, key: Option<&str>) -> Option<Chunk> {
        let some = |text: String| (!text.is_empty()).then_some(text);
        match chunk {
            Chunk::Reasoning(text) => some(self.reasoning.push(&text, key)).map(Chunk::Reasoning),
            Chunk::Text(text) => some(self.text.push(&text, key)).map(Chunk::Text),
            other => Some(other),
        }
    }

    /// What is held back of one of the texts, which are over; to be asked until there is nothing.
    pub fn held(&mut self) -> Option<Chunk> {
        let some = |text: String| (!text.is_empty()).then_some(text);
        let reasoning = some(self.reasoning.end()).map(Chunk::Reasoning);
        reasoning.or_else(|| some(self.text.end()).map(Chunk::Text))
    }
}

/// Takes the key out of one text that arrives in pieces.
#[derive(Debug, Default)]
struct Redactor {
    held: String,
}

impl Redactor {
    /// The next piece, without the key; an end that may be the beginning of the key is held back.
    pub fn push(&mut self, piece: &str, key: Option<&str>) -> String {
        let Some(key) = key.filter(|key| key.len() >= 4) else {
            return piece.to_owned();
        };
        self.held.push_str(piece);
        let text = without_key(&self.held, Some(key));
        let ends = key.char_indices().map(|(at, _)| at).rev();
        let begun = ends
            .filter(|&at| at > 0)
            .find(|&at| text.ends_with(&key[..at]));
        let certain = text.len() - begun.unwrap_or(0);
        self.held = text[certain..].to_owned();
        text[..certain].to_owned()
    }

    /// What was held back: the text is over.
    pub fn end(&mut self) -> String {
        std::mem::take(&mut self.held)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KEY: &str = "sk-sk-abé";

    fn redact(text: &str, size: usize) -> String {
        let mut redactor = Redactor::default();
        let letters: Vec<char> = text.chars().collect();
        let pieces = letters.chunks(size).map(|c| c.iter().collect::<String>());
        let mut shown: String = pieces.map(|p| redactor.push(&p, Some(KEY))).collect();
        shown += &redactor.end();
        shown
    }

    #[test]
    fn the_key_is_found_across_pieces() {
        for (text, shown) in [
            ("a sk-sk-abé b", "a [key] b"),
            ("sk-sk-sk-abé", "sk-[key]"),
            ("sk-sk-abésk-sk-abé", "[key][key]"),
            ("ask sk-s", "ask sk-s"),
            ("sk-sk-abe", "sk-sk-abe"),
            ("", ""),
        ] {
            for size in 1..=text.len().max(1) {
                assert_eq!(redact(text, size), shown, "{text} in pieces of {size}");
            }
        }
    }

    #[test]
    fn usual_text_is_not_held_back() {
        let mut redactor = Redactor::default();
        assert_eq!(redactor.push("Hello", Some(KEY)), "Hello");
        assert_eq!(
            redactor.push("sk", Some("abc")),
            "sk",
            "no key is that short"
        );
        assert_eq!(redactor.push("is", Some(KEY)), "i");
        assert_eq!(redactor.push("o", Some(KEY)), "so");
    }
}
