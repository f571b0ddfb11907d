//! A response body as text: bytes under deadlines, in arbitrary pieces, joined to whole characters.

use std::io::Write;
use std::pin::Pin;

use encoding_rs::{Encoding, UTF_8};
use futures_util::stream::{self, Stream, StreamExt};
use reqwest::header::{CONTENT_ENCODING, CONTENT_TYPE};

use super::client::deepest;
use super::deadlines::{Deadlines, Elapsed};

/// More than any answer can be; a server that sends this much is broken.
const LONGEST: usize = 64 << 20;

/// Why a body ended early.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum BodyError {
    /// Patience ran out.
    Elapsed(Elapsed),
    /// The connection was cut.
    Cut(String),
    /// The bytes are no UTF-8.
    NotText,
    /// More than [`LONGEST`] bytes.
    TooLong,
}

/// The texts of a body as they arrive. Ends after the first fault; half a character at the end is dropped.
pub(super) fn texts<S, B, E>(
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
pub(super) async fn whole(
    response: reqwest::Response,
    patience: Deadlines,
    longest: usize,
) -> Result<String, (String, BodyError)> {
    joined_whole(response_texts(response, patience), longest).await
}

/// The same of texts.
pub(super) async fn joined_whole(
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
        if self.seen > LONGEST {
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
}
