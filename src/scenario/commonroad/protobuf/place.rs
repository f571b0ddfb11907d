//! Where a scenario takes place, in what surroundings, and when it was written.

use super::messages::{self, TimeStamp};
use super::report::{At, Report};
use super::values::{optional, text};
use super::words::{EnvironmentWords, UNDERGROUNDS, word};
use crate::scenario::commonroad::ReadError;
use crate::scenario::commonroad::location::{UNKNOWN_DEGREES, UNKNOWN_ID};
use crate::scenario::{Environment, GeoTransformation, Location};

/// `words` are those of the environment in it.
pub(super) fn location(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::Location,
    words: &EnvironmentWords,
) -> Result<Location, ReadError> {
    let id = report.need(at, "geo_name_id", message.geo_name_id)?;
    let latitude = report.need(at, "gps_latitude", message.gps_latitude)?;
    let longitude = report.need(at, "gps_longitude", message.gps_longitude)?;
    let known = |degrees: f64| Some(degrees).filter(|d| *d != UNKNOWN_DEGREES);
    let transformation = message.geo_transformation.as_ref();
    let surroundings = message.environment.as_ref();
    Ok(Location {
        geo_name_id: Some(i64::from(id)).filter(|id| *id != UNKNOWN_ID),
        latitude: optional(report, &at.field("gps_latitude"), known(latitude)),
        longitude: optional(report, &at.field("gps_longitude"), known(longitude)),
        transformation: transformation
            .map(|t| self::transformation(report, &at.field("geo_transformation"), t)),
        environment: surroundings
            .and_then(|e| environment(report, &at.field("environment"), e, words)),
    })
}

fn transformation(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::GeoTransformation,
) -> GeoTransformation {
    let reference = message.geo_reference.as_deref();
    let reference = reference.map(|said| text(report, &at.field("geo_reference"), said));
    GeoTransformation {
        reference: reference.filter(|text| !text.is_empty()),
        x: optional(report, &at.field("x_translation"), message.x_translation),
        y: optional(report, &at.field("y_translation"), message.y_translation),
        rotation: optional(report, &at.field("z_rotation"), message.z_rotation),
        scaling: optional(report, &at.field("scaling"), message.scaling),
    }
}

/// The surroundings, in the words of XML; nothing where nothing is said.
pub(super) fn environment(
    report: &mut Report,
    at: &At<'_>,
    message: &messages::Environment,
    words: &EnvironmentWords,
) -> Option<Environment> {
    let mut text = |name, words: &[&'static str], number: Option<i32>| {
        let found = word(report, &at.field(name), words, number?);
        found.map(str::to_string)
    };
    let found = Environment {
        time_of_day: text("time_of_day", words.times_of_day, message.time_of_day),
        weather: text("weather", words.weathers, message.weather),
        underground: text("underground", UNDERGROUNDS, message.underground),
        time: message.time.as_ref().map(|time| {
            let (hour, minute) = (time.hour.unwrap_or(0), time.minute.unwrap_or(0));
            format!("{hour:02}:{minute:02}:00")
        }),
    };
    (found != Environment::default()).then_some(found)
}

/// The day a file was written, as XML has it, which knows no hours.
pub(super) fn day(date: &TimeStamp) -> Option<String> {
    let (year, month, day) = (date.year?, date.month?, date.day?);
    Some(format!("{year:04}-{month:02}-{day:02}"))
}
