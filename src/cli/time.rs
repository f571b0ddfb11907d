//! Moments: milliseconds since 1970 in words, and words as milliseconds.

use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;

/// Day and minute in the clock of this place.
pub fn local(ms: i64) -> String {
    written(ms, |moment| {
        let there = moment.to_zoned(TimeZone::system());
        there.strftime("%Y-%m-%d %H:%M").to_string()
    })
}

/// For programs, in UTC.
pub fn rfc3339(ms: i64) -> String {
    written(ms, |moment| moment.to_string())
}

fn written(ms: i64, write: impl FnOnce(Timestamp) -> String) -> String {
    // Only an edited store holds a moment that no calendar has.
    Timestamp::from_millisecond(ms).map_or_else(|_| format!("{ms} ms"), write)
}

/// A day of this place (its beginning), or a moment with its zone.
///
/// # Errors
/// It is neither; says what is wanted.
pub fn parse(text: &str) -> Result<i64, String> {
    let day = text.parse::<Date>().ok().filter(|_| text.len() == 10);
    let day = day.and_then(|day| day.to_zoned(TimeZone::system()).ok());
    match day {
        Some(day) => Ok(day.timestamp().as_millisecond()),
        None => text
            .parse::<Timestamp>()
            .map(Timestamp::as_millisecond)
            .map_err(|_| "write 2026-01-31, or 2026-01-31T12:00:00Z".to_string()),
    }
}
