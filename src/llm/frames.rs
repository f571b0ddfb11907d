//! The events of a stream, however the API marks them off, and how each step of reading them ends.

use std::pin::Pin;

use eventsource_stream::{EventStreamError, Eventsource};
use futures_util::future::FutureExt;
use futures_util::stream::{self, Stream, StreamExt};

use super::chunk::Chunk;
use super::decoder::Decoder;
use super::dialect::{Dialect, Framing};
use super::endpoint::Endpoint;
use super::error::Error;
use super::patience::Elapsed;
use super::text::{Fault, joined};

/// More than any line of a stream is long, in bytes: some hold a whole answer.
const LONGEST_LINE: usize = 2 << 20;

/// One event.
#[derive(Debug)]
pub(super) struct Frame {
    /// The server calls it an error.
    is_error: bool,
    data: String,
}

/// The events of a stream of text.
pub(super) type Frames = Pin<Box<dyn Stream<Item = Result<Frame, Fault>> + Send>>;

/// The events in texts that are cut anywhere.
pub(super) fn frames<S>(texts: S, framing: Framing) -> Frames
where
    S: Stream<Item = Result<String, Fault>> + Send + 'static,
{
    let texts = bounded(texts);
    match framing {
        Framing::Events => Box::pin(texts.eventsource().map(|event| match event {
            Ok(event) => Ok(Frame {
                is_error: event.event == "error",
                data: event.data,
            }),
            Err(EventStreamError::Transport(fault)) => Err(fault),
            Err(EventStreamError::Utf8(_) | EventStreamError::Parser(_)) => Err(Fault::NotText),
        })),
        Framing::Lines => Box::pin(lines(texts)),
    }
}

/// Stops at a line that no server sends: the parsers look at a whole line again with every piece of it.
fn bounded<S>(texts: S) -> impl Stream<Item = Result<String, Fault>> + Send
where
    S: Stream<Item = Result<String, Fault>> + Send + 'static,
{
    let mut line = 0;
    texts.map(move |text| {
        let text = text?;
        line = match text.rfind(['\n', '\r']) {
            Some(end) => text.len() - end,
            None => line + text.len(),
        };
        (line <= LONGEST_LINE).then_some(text).ok_or(Fault::TooLong)
    })
}

/// The lines of texts that are cut anywhere. A last line without its end counts if it is whole JSON.
fn lines<S>(texts: S) -> impl Stream<Item = Result<Frame, Fault>> + Send
where
    S: Stream<Item = Result<String, Fault>> + Send + 'static,
{
    let frame = |line: &str| Frame {
        is_error: false,
        data: line.to_owned(),
    };
    let state = Some((Box::pin(texts), String::new()));
    let pieces = stream::unfold(state, move |state| async move {
        let (mut texts, mut held) = state?;
        match texts.next().await {
            None => {
                let whole = serde_json::from_str::<serde::de::IgnoredAny>(&held).is_ok();
                let last = whole.then(|| Ok(frame(&held)));
                Some((last.into_iter().collect::<Vec<_>>(), None))
            }
            Some(Err(fault)) => Some((vec![Err(fault)], None)),
            Some(Ok(text)) => {
                let Some((before, after)) = text.rsplit_once('\n') else {
                    held.push_str(&text);
                    return Some((Vec::new(), Some((texts, held))));
                };
                held.push_str(before);
                let found = held.lines().map(|line| Ok(frame(line))).collect();
                Some((found, Some((texts, after.to_owned()))))
            }
        }
    });
    pieces.flat_map(stream::iter)
}

/// Takes the next event of a stream and gives what comes of it; after an answer's end the decoder is done.
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
        None => ended(decoder, Fault::Cut("the stream ended early".to_owned())),
    }
}

/// What comes of a body that ended with a fault.
pub(super) fn ended(decoder: &mut Decoder, fault: Fault) -> Vec<Result<Chunk, Error>> {
    let items = decoder.ended(|place, received| match fault {
        Fault::Elapsed(Elapsed { which, after }) => Error::Timeout {
            place,
            which,
            after,
        },
        Fault::Cut(why) => Error::Truncated {
            place,
            received,
            why,
        },
        Fault::NotText => Error::Malformed {
            place,
            what: "bytes that are no UTF-8 text".to_owned(),
        },
        Fault::TooLong => Error::Malformed {
            place,
            what: "more than any answer can be".to_owned(),
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
    let mut frames = frames(joined(stream::iter(pieces)), dialect.framing());
    let place = Endpoint::new("decoder", "http://localhost").place();
    let mut decoder = Decoder::new(dialect, place);
    let mut items = Vec::new();
    while !decoder.is_done() {
        // All pieces are there, so nothing is ever waited for.
        match step(&mut frames, &mut decoder).now_or_never() {
            Some(some) => items.extend(some.into_iter().map(|i| i.map_err(|e| e.cleared_of(None)))),
            None => break,
        }
    }
    items
}
