//! Splits a stream into events, whose JSON is put right: server-sent events, or one JSON document a line. Time is linear
//! in the input; at most one event is held in memory.

use std::fmt::Write;
use std::pin::Pin;

use futures_util::future::FutureExt;
use futures_util::stream::{self, Stream, StreamExt};

use super::body_text::{BodyError, Elapsed, joined};
use super::chunk::Chunk;
use super::decoder::Decoder;
use super::dialect::{Dialect, Framing};
use super::endpoint::Endpoint;
use super::error::Error;

/// More than any line or event of a stream is long, in bytes: some hold a whole answer.
const MAX_EVENT_BYTES: usize = 8 << 20;

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
            let feed = feed.position('\n', text, at);
            let end = match self.framing {
                Framing::Events => feed.min(carriage.position('\r', text, at)),
                Framing::Lines => feed,
            };
            let piece = &text[at..end];
            if self.line.len() + piece.len() > MAX_EVENT_BYTES {
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
                if self.event.data.len() + value.len() >= MAX_EVENT_BYTES {
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
    fn position(&mut self, wanted: char, text: &str, at: usize) -> usize {
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

/// One event.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Frame {
    /// The server calls it an error.
    pub is_error: bool,
    pub data: String,
}

/// The events of a stream of text.
pub(super) type Frames = Pin<Box<dyn Stream<Item = Result<Frame, BodyError>> + Send>>;

/// The events in texts that are cut anywhere.
pub(super) fn frames<S>(texts: S, framing: Framing) -> Frames
where
    S: Stream<Item = Result<String, BodyError>> + Send + 'static,
{
    let state = Some((Box::pin(texts), Parser::new(framing)));
    let pieces = stream::unfold(state, |state| async move {
        let (mut texts, mut parser) = state?;
        let mut found = Vec::new();
        let fault = match texts.next().await {
            None => {
                found.extend(parser.end().map(Ok));
                return Some((found, None));
            }
            Some(Ok(text)) => parser.push(&text, |frame| found.push(Ok(frame))).err(),
            Some(Err(fault)) => Some(fault),
        };
        let rest = fault.is_none().then_some((texts, parser));
        found.extend(fault.map(Err));
        Some((found, rest))
    });
    Box::pin(pieces.flat_map(stream::iter))
}

/// Reads the next event of a stream and returns its chunks; after an answer's end the decoder is done.
pub(super) async fn step(frames: &mut Frames, decoder: &mut Decoder) -> Vec<Result<Chunk, Error>> {
    match frames.next().await {
        Some(Ok(frame)) if frame.is_error => {
            let error = decoder.error_event(&frame.data);
            decoder.failed(error)
        }
        Some(Ok(frame)) => match decoder.event(&frame.data) {
            Ok(chunks) => chunks.into_iter().map(Ok).collect(),
            Err(error) => decoder.failed(error),
        },
        Some(Err(fault)) => ended(decoder, fault),
        // An event begun but not ended has been dropped, as the standard wants.
        None => ended(decoder, BodyError::Cut("the stream ended early".to_owned())),
    }
}

/// The chunks at the end of a body that ended with a fault.
pub(super) fn ended(decoder: &mut Decoder, fault: BodyError) -> Vec<Result<Chunk, Error>> {
    if fault == BodyError::TooLong {
        let what = "too large for an answer".to_owned();
        return decoder.too_long(|place| Error::Malformed { place, what });
    }
    let items = decoder.ended(|place, received| match fault {
        BodyError::Elapsed(Elapsed { which, after }) => Error::Timeout {
            place,
            which,
            after,
        },
        BodyError::Cut(why) => Error::Truncated {
            place,
            received,
            why,
        },
        BodyError::NotText | BodyError::TooLong => Error::Malformed {
            place,
            what: "not UTF-8 text".to_owned(),
        },
    });
    debug_assert!(decoder.is_done(), "an ended body leaves nothing to read");
    items
}

/// What the body of a streamed answer says, given as the pieces in which it arrives; no network is used. Whatever the
/// bytes and wherever they are cut, the last item is [`Chunk::Finished`] or an error, and there is one such item.
#[must_use]
pub fn decode<'a>(
    dialect: Dialect,
    pieces: impl IntoIterator<Item = &'a [u8]>,
) -> Vec<Result<Chunk, Error>> {
    let pieces: Vec<_> = pieces.into_iter().map(<[u8]>::to_vec).collect();
    let mut frames = frames(joined(stream::iter(pieces)), dialect.protocol().framing());
    let endpoint = Endpoint::new("decoder", "http://localhost");
    let (place, none) = (endpoint.place(), endpoint.secrets());
    let mut decoder = Decoder::new(dialect, place);
    let mut items = Vec::new();
    while !decoder.is_done() {
        // All pieces are present, so this never waits.
        match step(&mut frames, &mut decoder).now_or_never() {
            Some(some) => items.extend(some.into_iter().map(|i| i.map_err(|e| e.redacted(&none)))),
            None => break,
        }
    }
    items
}

/// Half of a character beyond the first 65,536, which the next event has the other half of.
#[derive(Debug, Default)]
pub(super) struct HalfCharacter(Option<u16>);

impl HalfCharacter {
    /// The text of an event with `null` for numbers that JSON does not have, and with whole characters: the first half of
    /// one is kept for the next event, and a second half without a first is U+FFFD.
    pub fn mend(&mut self, data: &str) -> String {
        let mut mended = String::with_capacity(data.len());
        let mut rest = data;
        let mut inside = false;
        while let Some(next) = rest.chars().next() {
            if !inside
                && let Some((word, after)) = foreign(rest)
                && !mended.ends_with(|c: char| c.is_ascii_alphanumeric())
            {
                mended.push_str(word);
                rest = after;
                continue;
            }
            let unit = rest
                .strip_prefix("\\u")
                .and_then(|hex| hex.get(..4))
                .and_then(|hex| u16::from_str_radix(hex, 16).ok());
            match (next, unit) {
                (_, Some(unit)) if inside => {
                    self.take(unit, &mut mended);
                    rest = &rest[6..];
                }
                ('\\', _) if inside => {
                    self.alone(&mut mended);
                    let length = 1 + rest[1..].chars().next().map_or(0, char::len_utf8);
                    mended.push_str(&rest[..length]);
                    rest = &rest[length..];
                }
                (next, _) => {
                    inside ^= next == '"';
                    if inside && next != '"' {
                        self.alone(&mut mended);
                    }
                    mended.push(next);
                    rest = &rest[next.len_utf8()..];
                }
            }
        }
        mended
    }

    /// An escaped unit of UTF-16.
    fn take(&mut self, unit: u16, into: &mut String) {
        match (unit, self.0.take()) {
            (0xdc00..=0xdfff, Some(first)) => {
                let both = char::decode_utf16([first, unit]).next();
                into.push(both.and_then(Result::ok).unwrap_or('\u{fffd}'));
            }
            (0xdc00..=0xdfff, None) => into.push('\u{fffd}'),
            (unit, before) => {
                if before.is_some() {
                    into.push('\u{fffd}');
                }
                match unit {
                    0xd800..=0xdbff => self.0 = Some(unit),
                    unit => drop(write!(into, "\\u{unit:04x}")),
                }
            }
        }
    }

    /// Something else follows a first half.
    fn alone(&mut self, into: &mut String) {
        if self.0.take().is_some() {
            into.push('\u{fffd}');
        }
    }
}

/// A number that JSON does not have at the beginning, as JSON, and what follows it.
fn foreign(text: &str) -> Option<(&'static str, &str)> {
    let words = ["NaN", "-Infinity", "Infinity"].into_iter();
    words
        .filter_map(|word| text.strip_prefix(word))
        .map(|after| ("null", after))
        .next()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::time::{Duration, Instant};

    use super::*;
    use serde_json::Value;

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

    fn text(half: &mut HalfCharacter, data: &str) -> String {
        let value: Value = serde_json::from_str(&half.mend(data)).unwrap();
        value.as_str().unwrap().to_string()
    }

    #[test]
    fn characters_cut_between_events_are_joined() {
        let mut half = HalfCharacter::default();
        assert_eq!(text(&mut half, r#""a\ud83d""#), "a");
        assert_eq!(text(&mut half, r#""\ude97b""#), "🚗b");
        assert_eq!(
            text(&mut half, r#""\ud83d\ude97 \\u00e9 \u00e9 \" é""#),
            "🚗 \\u00e9 é \" é"
        );
        assert_eq!(text(&mut half, r#""\ude97x\ud83dy""#), "\u{fffd}x\u{fffd}y");
        assert_eq!(text(&mut half, r#""\ud83d\ud83d""#), "\u{fffd}");
        assert_eq!(text(&mut half, r#""z""#), "\u{fffd}z");
    }

    #[test]
    fn numbers_that_json_does_not_have_are_null() {
        let mended = HalfCharacter::default()
            .mend(r#"{"a": NaN, "NaN": -Infinity, "b": [Infinity, "Infinity"]}"#);
        assert_eq!(
            mended,
            r#"{"a": null, "NaN": null, "b": [null, "Infinity"]}"#
        );
    }
}
