//! Splits a stream into events: server-sent events, or one JSON document a line. Time is linear in the input; at most
//! one event is held in memory.

use super::body_text::BodyError;
use super::dialect::Framing;
use super::frames::Frame;

/// More than any line or event of a stream is long, in bytes: some hold a whole answer.
const LONGEST: usize = 8 << 20;

/// Reads text that is cut anywhere.
#[derive(Debug)]
pub(super) struct Parser {
    framing: Framing,
    /// The line so far.
    line: String,
    /// The line before ended with a carriage return, so that a line feed belongs to its end.
    returned: bool,
    event: Frame,
    /// Whether the event has data, be it empty.
    has_data: bool,
}

impl Parser {
    /// A parser at the beginning of a stream.
    pub fn new(framing: Framing) -> Self {
        Self {
            framing,
            line: String::new(),
            returned: false,
            event: empty(),
            has_data: false,
        }
    }

    /// Reads on and gives the events that end here.
    ///
    /// # Errors
    /// [`BodyError::TooLong`]: a line or an event is longer than any that servers send.
    pub fn push(&mut self, text: &str, mut found: impl FnMut(Frame)) -> Result<(), BodyError> {
        let mut at = 0;
        // Each kind of end is looked for once: together it would take far longer, and anew in each line for ever.
        let (mut feed, mut carriage) = (Next::default(), Next::default());
        while at < text.len() {
            if std::mem::take(&mut self.returned) && text[at..].starts_with('\n') {
                at += 1;
                continue;
            }
            let feed = feed.of('\n', text, at);
            let end = match self.framing {
                Framing::Events => feed.min(carriage.of('\r', text, at)),
                Framing::Lines => feed,
            };
            let piece = &text[at..end];
            if self.line.len() + piece.len() > LONGEST {
                return Err(BodyError::TooLong);
            }
            if end == text.len() {
                self.line.push_str(piece);
                return Ok(());
            }
            self.returned = text[end..].starts_with('\r');
            at = end + 1;
            if self.line.is_empty() {
                self.end_line(piece, &mut found)?;
            } else {
                let mut line = std::mem::take(&mut self.line);
                line.push_str(piece);
                self.end_line(&line, &mut found)?;
            }
        }
        Ok(())
    }

    /// The stream is over. A last line without its end counts if it is whole JSON; an event that was not ended is
    /// dropped, as the standard wants.
    pub fn end(self) -> Option<Frame> {
        let whole = serde_json::from_str::<serde::de::IgnoredAny>(&self.line).is_ok();
        (self.framing == Framing::Lines && whole).then_some(Frame {
            is_error: false,
            data: self.line,
        })
    }

    fn end_line(&mut self, line: &str, found: &mut impl FnMut(Frame)) -> Result<(), BodyError> {
        if self.framing == Framing::Lines {
            found(Frame {
                is_error: false,
                data: line.to_owned(),
            });
            return Ok(());
        }
        if line.is_empty() {
            let event = std::mem::replace(&mut self.event, empty());
            if std::mem::take(&mut self.has_data) {
                found(event);
            }
            return Ok(());
        }
        // A comment is a line whose field has no name.
        let (field, value) = line.split_once(':').unwrap_or((line, ""));
        let value = value.strip_prefix(' ').unwrap_or(value);
        match field {
            "event" => self.event.is_error = value == "error",
            "data" => {
                if self.event.data.len() + value.len() >= LONGEST {
                    return Err(BodyError::TooLong);
                }
                // Some servers end events with one line feed instead of two: an event that is whole ends where the next
                // one begins.
                let begins = value.starts_with('{') || value.starts_with("[DONE]");
                if self.has_data && begins && is_whole(&self.event.data) {
                    found(std::mem::replace(&mut self.event, empty()));
                    self.has_data = false;
                }
                if std::mem::replace(&mut self.has_data, true) {
                    self.event.data.push('\n');
                }
                self.event.data.push_str(value);
            }
            _ => {}
        }
        Ok(())
    }
}

/// Whether data of one line is a whole JSON document. Of several lines it is not asked, which would take long.
fn is_whole(data: &str) -> bool {
    !data.contains('\n') && serde_json::from_str::<serde::de::IgnoredAny>(data).is_ok()
}

/// Where a character comes next, remembered until that place is passed.
#[derive(Default)]
struct Next(Option<usize>);

impl Next {
    /// The next place from `at` on, or the text's end.
    fn of(&mut self, wanted: char, text: &str, at: usize) -> usize {
        match self.0 {
            Some(place) if place >= at => place,
            _ => {
                let place = text[at..].find(wanted).map_or(text.len(), |n| at + n);
                *self.0.insert(place)
            }
        }
    }
}

fn empty() -> Frame {
    Frame {
        is_error: false,
        data: String::new(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::time::{Duration, Instant};

    use super::*;

    fn read(framing: Framing, text: &str, size: usize) -> Vec<(bool, String)> {
        let mut parser = Parser::new(framing);
        let mut found = Vec::new();
        let letters: Vec<char> = text.chars().collect();
        for piece in letters.chunks(size) {
            let piece: String = piece.iter().collect();
            parser.push(&piece, |f| found.push(f)).unwrap();
        }
        found.extend(parser.end());
        found.into_iter().map(|f| (f.is_error, f.data)).collect()
    }

    #[test]
    fn events_as_the_standard_has_them_however_they_are_cut() {
        let text = "\n: a comment\ndata: one\r\n\r\ndata:two\rdata:  three\r\revent: error\nid: 7\ndata: {é}\n\n\
            event: error\n\ndata\n\nretry: 5\ndata: again\n\ndata: not ended\n";
        let expected = [
            (false, "one"),
            (false, "two\n three"),
            (true, "{é}"),
            (false, ""),
            (false, "again"),
        ];
        for size in 1..40 {
            let found = read(Framing::Events, text, size);
            let found: Vec<_> = found.iter().map(|(e, d)| (*e, d.as_str())).collect();
            assert_eq!(found, expected, "in pieces of {size}");
        }
    }

    #[test]
    fn whole_events_may_end_with_one_line_feed() {
        let text = "data: {\"a\":1}\ndata: {\"b\":\ndata: {}}\n\ndata: {}\ndata: [DONE]\n\n";
        let found = read(Framing::Events, text, 7);
        let found: Vec<_> = found.iter().map(|(_, data)| data.as_str()).collect();
        assert_eq!(found, ["{\"a\":1}", "{\"b\":\n{}}", "{}", "[DONE]"]);
    }

    #[test]
    fn lines_and_a_last_one_that_is_whole() {
        for size in 1..20 {
            let data = |text| {
                let found = read(Framing::Lines, text, size);
                found.into_iter().map(|(_, d)| d).collect::<Vec<_>>()
            };
            assert_eq!(data("{\"a\":1}\n\n{}"), ["{\"a\":1}", "", "{}"]);
            assert_eq!(data("{}\n{\"a\":"), ["{}"]);
        }
    }

    /// Empty lines once took time that grew with the square of their number.
    #[test]
    fn nothing_grows_without_an_end() {
        let begun = Instant::now();
        for filler in ["\n", "\r", ": x\n", "id: 1\n", "event: error\n", "\r\n"] {
            let mut parser = Parser::new(Framing::Events);
            let text = filler.repeat((1 << 20) / filler.len());
            parser.push(&text, |_| panic!("no event")).unwrap();
            assert!(parser.line.is_empty() && parser.event.data.is_empty());
        }
        for filler in [
            "x".repeat(1 << 10),
            format!("data: {}\n", "x".repeat(1 << 10)),
        ] {
            let mut parser = Parser::new(Framing::Events);
            let text = filler.repeat((1 << 20) / filler.len());
            let refused = (0..100).find_map(|_| parser.push(&text, |_| panic!("no event")).err());
            assert_eq!(refused, Some(BodyError::TooLong), "{filler:?}");
        }
        assert!(
            begun.elapsed() < Duration::from_secs(20),
            "{:?}",
            begun.elapsed()
        );
    }
}
