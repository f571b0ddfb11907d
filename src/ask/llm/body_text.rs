//! A response body as text: bytes under two deadlines, joined to whole characters; and whether its JSON is of bounded size.

use std::io::Write;
use std::pin::Pin;
use std::time::Duration;

use encoding_rs::{Encoding, UTF_8};
use futures_util::stream::{self, Stream, StreamExt};
use reqwest::header::{CONTENT_ENCODING, CONTENT_TYPE};
use tokio::task::yield_now;
use tokio::time::{Instant, timeout};

use super::client::deepest;
use super::endpoint::Timeouts;
use super::error::TimeoutKind;

/// More than any answer can be; a server that sends this much is broken.
const MAX_BODY_BYTES: usize = 64 << 20;

/// Why a body ended early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum BodyError {
    /// Patience ran out.
    Elapsed(Elapsed),
    /// The connection was cut.
    Cut(String),
    /// The bytes are no UTF-8.
    NotText,
    /// More than [`MAX_BODY_BYTES`] bytes.
    TooLong,
}

/// The texts of a body as they arrive. Ends after the first fault; half a character at the end is dropped.
fn texts<S, B, E>(
    bytes: S,
    patience: Deadlines,
) -> impl Stream<Item = Result<String, BodyError>> + Send
where
    S: Stream<Item = Result<B, E>> + Send + 'static,
    B: AsRef<[u8]> + Send,
    E: std::error::Error + Send + 'static,
{
    let state = Some((Box::pin(bytes), Joiner::default()));
    stream::unfold(state, move |state| async move {
        let (mut bytes, mut joiner) = state?;
        let text = match patience.wait(bytes.next()).await {
            Ok(None) => return None,
            Ok(Some(Ok(piece))) => joiner.join(piece.as_ref()),
            Ok(Some(Err(error))) => Err(BodyError::Cut(deepest(&error))),
            Err(elapsed) => Err(BodyError::Elapsed(elapsed)),
        };
        let state = text.is_ok().then_some((bytes, joiner));
        Some((text, state))
    })
}

/// The same for pieces that are all there.
pub(super) fn joined<S>(pieces: S) -> impl Stream<Item = Result<String, BodyError>> + Send
where
    S: Stream<Item = Vec<u8>> + Send + 'static,
{
    let state = Some((Box::pin(pieces), Joiner::default()));
    stream::unfold(state, |state| async move {
        let (mut pieces, mut joiner) = state?;
        let text = joiner.join(&pieces.next().await?);
        let state = text.is_ok().then_some((pieces, joiner));
        Some((text, state))
    })
}

/// The texts of a body, which may be asked for more after its end.
pub(super) type Texts = Pin<Box<dyn Stream<Item = Result<String, BodyError>> + Send>>;

/// The texts of an answer over the network: unpacked where the server packed it with gzip unasked, and in the encoding
/// that its Content-Type names.
pub(super) fn response_texts(response: reqwest::Response, patience: Deadlines) -> Texts {
    let header = |name| {
        response
            .headers()
            .get(name)
            .and_then(|value| value.to_str().ok())
    };
    let is_gzip = header(CONTENT_ENCODING).is_some_and(|value| value.eq_ignore_ascii_case("gzip"));
    let charset = header(CONTENT_TYPE).and_then(charset);
    let bytes = response.bytes_stream();
    let mut gzip = is_gzip.then(|| flate2::write::GzDecoder::new(Vec::new()));
    let mut decoder = charset.map(Encoding::new_decoder_without_bom_handling);
    if gzip.is_none() && decoder.is_none() {
        return Box::pin(texts(bytes, patience).fuse());
    }
    let unpacked = bytes.map(move |piece| {
        let mut piece = piece.map_err(std::io::Error::other)?.to_vec();
        if let Some(gzip) = &mut gzip {
            gzip.write_all(&piece)?;
            gzip.flush()?;
            piece = std::mem::take(gzip.get_mut());
        }
        if let Some(decoder) = &mut decoder {
            let most = decoder.max_utf8_buffer_length(piece.len()).unwrap_or(0);
            let mut text = String::with_capacity(most);
            let _ = decoder.decode_to_string(&piece, &mut text, false);
            piece = text.into_bytes();
        }
        Ok::<Vec<u8>, std::io::Error>(piece)
    });
    Box::pin(texts(unpacked, patience).fuse())
}

/// The encoding that a Content-Type names, if it is another one than UTF-8.
fn charset(content_type: &str) -> Option<&'static Encoding> {
    let mut parameters = content_type
        .split(';')
        .skip(1)
        .map(|p| p.trim().split_once('='));
    let named = parameters.find_map(|p| p.filter(|(key, _)| key.eq_ignore_ascii_case("charset")));
    let encoding = Encoding::for_label(named?.1.trim_matches('"').as_bytes())?;
    (encoding != UTF_8).then_some(encoding)
}

/// The texts of a body up to the first that is more than white space, joined; empty where there is none.
pub(super) async fn beginning(pieces: &mut Texts) -> Result<String, BodyError> {
    let mut begun = String::new();
    while begun.trim().is_empty() {
        match pieces.next().await {
            Some(piece) => begun.push_str(&piece?),
            None => break,
        }
    }
    Ok(begun)
}

/// The text of a body up to a length in bytes; after a fault, what had arrived until then.
pub(super) async fn read_to_end(
    response: reqwest::Response,
    patience: Deadlines,
    longest: usize,
) -> Result<String, (String, BodyError)> {
    join_to_end(response_texts(response, patience), longest).await
}

/// The same of texts.
pub(super) async fn join_to_end(
    pieces: impl Stream<Item = Result<String, BodyError>> + Send,
    longest: usize,
) -> Result<String, (String, BodyError)> {
    let mut pieces = Box::pin(pieces);
    let mut body = String::new();
    while let Some(piece) = pieces.next().await {
        match piece {
            Ok(piece) => body.push_str(&piece),
            Err(fault) => return Err((body, fault)),
        }
        if body.len() > longest {
            return Err((body, BodyError::TooLong));
        }
    }
    Ok(body)
}

#[derive(Default)]
struct Joiner {
    held: Vec<u8>,
    begun: bool,
    seen: usize,
}

impl Joiner {
    fn join(&mut self, piece: &[u8]) -> Result<String, BodyError> {
        self.seen += piece.len();
        if self.seen > MAX_BODY_BYTES {
            return Err(BodyError::TooLong);
        }
        self.held.extend_from_slice(piece);
        let whole = match std::str::from_utf8(&self.held) {
            Ok(text) => text.len(),
            Err(error) if error.error_len().is_none() => error.valid_up_to(),
            Err(_) => return Err(BodyError::NotText),
        };
        let rest = self.held.split_off(whole);
        let bytes = std::mem::replace(&mut self.held, rest);
        let mut text = String::from_utf8(bytes).map_err(|_| BodyError::NotText)?;
        if !self.begun {
            // However many there are: a second mark would be the beginning of a field's name.
            text = text.trim_start_matches('\u{feff}').to_owned();
            self.begun = !text.is_empty();
        }
        Ok(text)
    }
}

/// Remaining time of one exchange.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deadlines {
    idle: Duration,
    total: Duration,
    started: Instant,
}

/// The limit that was hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Elapsed {
    pub which: TimeoutKind,
    pub after: Duration,
}

impl Deadlines {
    /// Both clocks start now.
    pub fn starting_now(timeouts: Timeouts) -> Self {
        Self {
            idle: timeouts.idle,
            total: timeouts.total,
            started: Instant::now(),
        }
    }

    /// Remaining total time.
    pub fn left(&self) -> Duration {
        self.total.saturating_sub(self.started.elapsed())
    }

    /// Waits for one sign of life.
    pub async fn wait<F: Future>(&self, future: F) -> Result<F::Output, Elapsed> {
        let left = self.left();
        let elapsed = if left < self.idle {
            Elapsed {
                which: TimeoutKind::Total,
                after: self.total,
            }
        } else {
            Elapsed {
                which: TimeoutKind::Idle,
                after: self.idle,
            }
        };
        // A timeout looks at the clock only where the future has to wait: what is always ready would never be late.
        if left.is_zero() {
            return Err(elapsed);
        }
        // For the same reason everything else gets its turn, Ctrl-C among it. Not by tokio's budget: who uses it up
        // leaves none to those beside it in a `select`.
        yield_now().await;
        timeout(left.min(self.idle), future)
            .await
            .map_err(|_| elapsed)
    }

    /// The same patience, but from now on for no longer than this in all.
    pub fn at_most(self, longest: Duration) -> Self {
        let total = self.started.elapsed().saturating_add(longest);
        Self {
            total: total.min(self.total),
            ..self
        }
    }
}

/// Most values in the document of one answer.
pub(super) const MAX_VALUES: usize = 1_000_000;

/// Whether a document has at most `most` values; each follows a comma or the start of a list or object.
pub(super) fn is_bounded(document: &[u8], most: usize) -> bool {
    if document.len() <= most {
        return true;
    }
    let (mut values, mut quoted, mut escaped) = (1_usize, false, false);
    for byte in document {
        match byte {
            _ if escaped => escaped = false,
            b'\\' => escaped = quoted,
            b'"' => quoted = !quoted,
            b',' | b'[' | b'{' if !quoted => values += 1,
            _ => {}
        }
    }
    values <= most
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn join(bytes: &[u8], size: usize) -> Result<String, BodyError> {
        let mut joiner = Joiner::default();
        bytes.chunks(size).map(|c| joiner.join(c)).collect()
    }

    #[test]
    fn characters_survive_any_cut() {
        let text = "\u{feff}\u{feff}data: é 車 🚗\n\n\u{feff}";
        for size in 1..text.len() {
            assert_eq!(
                join(text.as_bytes(), size).unwrap(),
                text.trim_start_matches('\u{feff}')
            );
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_reported_at_once() {
        for size in 1..4 {
            assert_eq!(join(b"ab\xffcd", size), Err(BodyError::NotText));
        }
        assert_eq!(join("é".as_bytes().split_last().unwrap().1, 4).unwrap(), "");
    }

    const MS: Duration = Duration::from_millis(1);

    fn patience(total: Duration) -> Deadlines {
        Deadlines::starting_now(Timeouts {
            connect: MS,
            idle: 60_000 * MS,
            total,
        })
    }

    #[tokio::test]
    async fn what_is_always_ready_runs_out_of_time_too() {
        let patience = patience(50 * MS);
        let begun = Instant::now();
        let elapsed = loop {
            if let Err(elapsed) = patience.wait(std::future::ready(())).await {
                break elapsed;
            }
            assert!(begun.elapsed() < 10_000 * MS, "the total time is not kept");
        };
        assert_eq!(
            (elapsed.which, elapsed.after),
            (TimeoutKind::Total, 50 * MS)
        );
    }

    #[tokio::test]
    async fn what_is_always_ready_lets_others_have_their_turn() {
        let patience = patience(60_000 * MS);
        let endless = async {
            loop {
                let _ = patience.wait(std::future::ready(())).await;
            }
        };
        tokio::select! {
            biased;
            () = endless => {}
            () = tokio::time::sleep(20 * MS) => {}
        }
    }

    #[tokio::test]
    async fn patience_for_a_part_ends_before_the_whole() {
        let whole = patience(60_000 * MS);
        let part = whole.at_most(30 * MS);
        let late = part.wait(std::future::pending::<()>()).await;
        assert_eq!(
            late.map_err(|elapsed| elapsed.which),
            Err(TimeoutKind::Total)
        );
        assert!(whole.left() > 30_000 * MS);
        assert!(patience(10 * MS).at_most(60_000 * MS).left() <= 10 * MS);
    }

    #[test]
    fn values_are_counted_and_texts_are_not_looked_into() {
        assert!(is_bounded(b"[1,2,{\"a\":3}]", 5));
        assert!(!is_bounded(b"[1,2,{\"a\":3}]", 4));
        assert!(is_bounded(br#"{"a":"[,,\"[,,,,"}"#, 2));
        assert!(!is_bounded(&b"[],".repeat(100), 99));
    }
}
