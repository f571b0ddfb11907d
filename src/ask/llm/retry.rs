//! Retries: which failures may pass, and how long to wait.

use std::time::Duration;

use backon::{BackoffBuilder, ExponentialBackoff, ExponentialBuilder};
use jiff::Timestamp;
use jiff::fmt::rfc2822::DateTimeParser;
use reqwest::header::{HeaderMap, RETRY_AFTER};

use super::endpoint::Retry;
use super::error_body::ErrorBody;

/// The waits between tries; ends when the tries are used up. Random parts keep a batch from asking in step.
pub(super) fn waits(retry: Retry) -> ExponentialBackoff {
    ExponentialBuilder::new()
        .with_min_delay(retry.first_wait)
        .with_factor(2.0)
        .with_max_delay(retry.longest_wait)
        .with_max_times(retry.attempts.max(1) as usize - 1)
        .with_jitter()
        .build()
}

/// Whether an answer of this status may be followed by a better one. 409 is a lock timeout, 529 "overloaded".
pub(super) fn may_pass(status: u16, headers: &HeaderMap, body: &ErrorBody) -> bool {
    let says = headers.get("x-should-retry");
    let says = |word: &[u8]| says.is_some_and(|v| v.as_bytes().eq_ignore_ascii_case(word));
    let passing = matches!(status, 408 | 409 | 429 | 500 | 502 | 503 | 504 | 529);
    (passing || says(b"true")) && !says(b"false") && !body.is_exhausted()
}

/// The wait the server asks for: `retry-after-ms`, `retry-after` in seconds or as a date, or a word in the body.
pub(super) fn asked_wait(
    headers: &HeaderMap,
    body: &ErrorBody,
    now: Timestamp,
) -> Option<Duration> {
    let header = |name: &str| headers.get(name)?.to_str().ok().map(str::trim);
    let milliseconds = header("retry-after-ms")
        .and_then(|v| v.parse().ok())
        .map(|ms: f64| ms / 1000.0);
    let seconds =
        || header(RETRY_AFTER.as_str()).and_then(|v| v.parse().ok().or_else(|| until(v, now)));
    milliseconds
        .or_else(seconds)
        .and_then(|s: f64| Duration::try_from_secs_f64(s.max(0.0)).ok())
        .or(body.retry_delay)
}

fn until(date: &str, now: Timestamp) -> Option<f64> {
    // Servers get the weekday wrong more often than the day.
    let parser = DateTimeParser::new().relaxed_weekday(true);
    let then = parser.parse_timestamp(date).ok()?;
    Some(then.duration_since(now).as_secs_f64())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn asked(name: &'static str, value: &'static str) -> Option<Duration> {
        let now = "2015-10-21T07:28:00Z".parse().unwrap();
        let headers = HeaderMap::from_iter([(name.parse().unwrap(), value.parse().unwrap())]);
        asked_wait(&headers, &ErrorBody::default(), now)
    }

    #[test]
    fn the_server_may_say_how_long() {
        assert_eq!(
            asked("retry-after-ms", "1500"),
            Some(Duration::from_millis(1500))
        );
        assert_eq!(asked("retry-after", " 7 "), Some(Duration::from_secs(7)));
        assert_eq!(
            asked("retry-after", "0.25"),
            Some(Duration::from_millis(250))
        );
        assert_eq!(
            asked("retry-after", "Wed, 21 Oct 2015 07:28:30 GMT"),
            Some(Duration::from_secs(30))
        );
        assert_eq!(
            asked("retry-after", "Wed, 21 Oct 2015 07:00:00 GMT"),
            Some(Duration::ZERO)
        );
        assert_eq!(asked("retry-after", "-3"), Some(Duration::ZERO));
        for nonsense in ["soon", "", "NaN", "inf", "1e300"] {
            let wait = asked("retry-after", nonsense);
            assert!(wait.is_none_or(|w| w.is_zero()), "{nonsense}: {wait:?}");
        }
    }

    #[test]
    fn tries_are_counted_and_waits_grow() {
        let retry = Retry {
            attempts: 4,
            first_wait: Duration::from_secs(1),
            longest_wait: Duration::from_secs(3),
        };
        let waits: Vec<f64> = waits(retry).map(|w| w.as_secs_f64()).collect();
        assert_eq!(waits.len(), 3);
        assert!(
            (1.0..=2.0).contains(&waits[0])
                && (2.0..=4.0).contains(&waits[1])
                && (3.0..=6.0).contains(&waits[2]),
            "{waits:?}"
        );
        assert_eq!(
            super::waits(Retry {
                attempts: 0,
                ..retry
            })
            .count(),
            0
        );
    }

    #[test]
    fn what_may_pass() {
        let none = HeaderMap::new();
        let ok = ErrorBody::default();
        for status in [408, 409, 429, 500, 502, 503, 504, 529] {
            assert!(may_pass(status, &none, &ok));
        }
        for status in [400, 401, 402, 403, 404, 413, 422, 501] {
            assert!(!may_pass(status, &none, &ok));
        }
        let no =
            HeaderMap::from_iter([("x-should-retry".parse().unwrap(), "false".parse().unwrap())]);
        assert!(!may_pass(500, &no, &ok));
        let yes =
            HeaderMap::from_iter([("x-should-retry".parse().unwrap(), "true".parse().unwrap())]);
        assert!(may_pass(501, &yes, &ok));
        let empty = ErrorBody {
            kind: Some("insufficient_quota".into()),
            ..ErrorBody::default()
        };
        assert!(!may_pass(429, &none, &empty));
    }
}
