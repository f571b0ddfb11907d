//! Timestamps: formats and parses milliseconds since 1970.

use jiff::Timestamp;

pub use nearmiss_study::evaluation::local_time as local;

/// For programs, in UTC.
pub fn rfc3339(ms: i64) -> String {
    // Only an edited store holds a moment that no calendar has.
    let moment = Timestamp::from_millisecond(ms);
    moment.map_or_else(|_| format!("{ms} ms"), |moment| moment.to_string())
}
