//! Timestamps: formats and parses milliseconds since 1970.

use jiff::Timestamp;
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
