//! Splits a leading `<think>…</think>` from a text that arrives in arbitrary pieces.

const OPEN: &str = "<think>";
const CLOSE: &str = "</think>";

/// White space before a tag, in bytes; who sends more is not about to think.
const MOST_SPACE: usize = 1024;

/// Kind of a piece of content.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ContentPart {
    /// Between the tags.
    Thought(String),
    /// Everything else.
    Said(String),
}

/// The splitter's state; one per answer.
#[derive(Debug, Default)]
pub(super) struct Splitter {
    place: Place,
    /// Text that cannot be attributed yet: perhaps the beginning of a tag, or white space around one.
    held: String,
}

#[derive(Debug, Default, Clone, Copy)]
enum Place {
    #[default]
    Before,
    Inside,
    /// After the closing tag, where white space is only a separator.
    Gap,
    Open,
}

impl Splitter {
    /// Takes the next piece and gives what is certain.
    pub fn push(&mut self, piece: &str) -> Vec<ContentPart> {
        let mut parts = Vec::new();
        self.held.push_str(piece);
        loop {
            let text = std::mem::take(&mut self.held);
            match self.place {
                Place::Before => {
                    let trimmed = text.trim_start();
                    if let Some(rest) = trimmed.strip_prefix(OPEN) {
                        self.place = Place::Inside;
                        self.held = rest.to_owned();
                    } else if OPEN.starts_with(trimmed) && text.len() <= MOST_SPACE {
                        self.held = text;
                        return parts;
                    } else {
                        self.place = Place::Open;
                        self.held = text;
                    }
                }
                Place::Inside => {
                    let Some((thought, rest)) = text.split_once(CLOSE) else {
                        let certain = text.len() - tag_begun(&text);
                        self.held = text[certain..].to_owned();
                        add(&mut parts, ContentPart::Thought, &text[..certain]);
                        return parts;
                    };
                    add(&mut parts, ContentPart::Thought, thought);
                    self.place = Place::Gap;
                    self.held = rest.to_owned();
                }
                Place::Gap => {
                    let rest = text.trim_start();
                    if rest.is_empty() {
                        return parts;
                    }
                    self.place = Place::Open;
                    self.held = rest.to_owned();
                }
                Place::Open => {
                    add(&mut parts, ContentPart::Said, &text);
                    return parts;
                }
            }
        }
    }

    /// The text is over: gives what was held back.
    pub fn end(&mut self) -> Vec<ContentPart> {
        let mut parts = Vec::new();
        let kind = if matches!(self.place, Place::Inside) {
            ContentPart::Thought
        } else {
            ContentPart::Said
        };
        add(&mut parts, kind, &std::mem::take(&mut self.held));
        parts
    }
}

fn add(parts: &mut Vec<ContentPart>, kind: fn(String) -> ContentPart, text: &str) {
    if !text.is_empty() {
        parts.push(kind(text.to_owned()));
    }
}

/// Length of the longest end of the text that could be the beginning of the closing tag.
fn tag_begun(text: &str) -> usize {
    (1..CLOSE.len())
        .rev()
        .find(|&n| text.ends_with(&CLOSE[..n]))
        .unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Thought and said text, joined, of a text given in pieces of `size` characters.
    fn split(text: &str, size: usize) -> (String, String) {
        let (mut thought, mut said) = (String::new(), String::new());
        let mut splitter = Splitter::default();
        let letters: Vec<char> = text.chars().collect();
        let mut parts: Vec<ContentPart> = letters
            .chunks(size)
            .flat_map(|c| splitter.push(&c.iter().collect::<String>()))
            .collect();
        parts.extend(splitter.end());
        for part in parts {
            match part {
                ContentPart::Thought(t) => thought.push_str(&t),
                ContentPart::Said(t) => said.push_str(&t),
            }
        }
        (thought, said)
    }

    #[test]
    fn whatever_the_pieces_the_split_is_the_same() {
        for (text, thought, said) in [
            ("<think>a < b</think>\n\n{\"x\":1}", "a < b", "{\"x\":1}"),
            ("\n <think>\nö</thin</think>yes", "\nö</thin", "yes"),
            ("<think></think>yes", "", "yes"),
            ("<think>never closed </th", "never closed </th", ""),
            ("<thin air", "", "<thin air"),
            ("  <thi", "", "  <thi"),
            (
                "  plain <think>not leading</think>",
                "",
                "  plain <think>not leading</think>",
            ),
            ("   ", "", "   "),
            ("<think>a</think>b</think> c", "a", "b</think> c"),
            ("", "", ""),
        ] {
            for size in 1..=12 {
                assert_eq!(
                    split(text, size),
                    (thought.to_owned(), said.to_owned()),
                    "{text:?} in pieces of {size}"
                );
            }
        }
    }

    #[test]
    fn plain_text_is_not_held_back() {
        let mut splitter = Splitter::default();
        assert_eq!(splitter.push("Hello"), [ContentPart::Said("Hello".into())]);
        assert_eq!(splitter.push(" <"), [ContentPart::Said(" <".into())]);
    }
}
