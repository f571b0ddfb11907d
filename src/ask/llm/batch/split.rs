//! Splits questions into batches within every provider's size limits.

use std::ops::Range;

use super::super::dialect::body;
use super::super::endpoint::Endpoint;
use super::super::request::Request;

/// Most requests in a batch: all providers take more, but a batch is read back in one piece.
const MOST_REQUESTS: usize = 20_000;

/// Most bytes of a batch. OpenAI takes 200 MB, Anthropic 256 MB and Gemini 20 MB, sent in one request that must not
/// outlast the patience with a silent server.
const MOST_BYTES: usize = 16 << 20;

/// How many of these go into one batch, and then into the next: ranges of positions, none of them empty.
#[must_use]
pub fn split(endpoint: &Endpoint, requests: &[Request]) -> Vec<Range<usize>> {
    let size = |request: &Request| body(endpoint, request).to_string().len() + 200;
    parts(requests.iter().map(size))
}

fn parts(sizes: impl Iterator<Item = usize>) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    let mut bytes = 0;
    for (at, size) in sizes.enumerate() {
        match parts.last_mut() {
            Some(part) if part.len() < MOST_REQUESTS && bytes + size <= MOST_BYTES => {
                part.end = at + 1;
                bytes += size;
            }
            _ => {
                parts.push(at..at + 1);
                bytes = size;
            }
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_are_split_at_both_limits() {
        assert!(parts(std::iter::empty()).is_empty());
        assert_eq!(parts([10; 3].into_iter()), vec![0..3; 1]);
        let half = MOST_BYTES / 2;
        assert_eq!(parts([half, half, 1].into_iter()), [0..2, 2..3]);
        assert_eq!(parts([1, MOST_BYTES, 1].into_iter()), [0..1, 1..2, 2..3]);
        // One that is too large alone is the provider's to refuse.
        assert_eq!(parts([2 * MOST_BYTES, 1].into_iter()), [0..1, 1..2]);
        let many = vec![1; MOST_REQUESTS + 1];
        let split = parts(many.into_iter());
        assert_eq!(split, [0..MOST_REQUESTS, MOST_REQUESTS..MOST_REQUESTS + 1]);
    }
}
