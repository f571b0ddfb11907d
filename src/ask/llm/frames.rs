//! The events of a stream, in any framing, and the outcome of each read.

use std::pin::Pin;

use futures_util::future::FutureExt;
use futures_util::stream::{self, Stream, StreamExt};

use super::body_text::{BodyError, joined};
use super::chunk::Chunk;
use super::deadlines::Elapsed;
use super::decoder::Decoder;
use super::dialect::{Dialect, Framing};
use super::endpoint::Endpoint;
use super::error::Error;
use super::events::Parser;

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
            Some(some) => {
                items.extend(some.into_iter().map(|i| i.map_err(|e| e.cleared_of(&none))))
            }
            None => break,
        }
    }
    items
}
