//! The location of a scenario, and its environment.

use super::messages;
use super::report::FieldPath;
use super::words::{EnvironmentWords, UNDERGROUNDS};
use crate::commonroad::ReadError;
use crate::commonroad::location::{UNKNOWN_DEGREES, UNKNOWN_ID};
use nearmiss_scene::scenario::{Environment, GeoTransformation, Location};

/// `words` are those of the environment in it.
pub(super) fn location(
    at: &FieldPath<'_>,
    message: &messages::Location,
    words: &EnvironmentWords,
) -> Result<Location, ReadError> {
    let id = i64::from(at.need("geo_name_id", message.geo_name_id)?);
    let degrees = |name, value| {
        let value = Some(at.need(name, value)?).filter(|d| *d != UNKNOWN_DEGREES);
        Ok(at.optional(name, value))
    };
    let transformation = message.geo_transformation.as_ref();
    let surroundings = message.environment.as_ref();
    Ok(Location {
        geo_name_id: Some(id).filter(|id| *id != UNKNOWN_ID),
        latitude: degrees("gps_latitude", message.gps_latitude)?,
        longitude: degrees("gps_longitude", message.gps_longitude)?,
        transformation: transformation
            .map(|t| self::transformation(&at.field("geo_transformation"), t)),
        environment: surroundings.and_then(|e| environment(&at.field("environment"), e, words)),
    })
}

fn transformation(at: &FieldPath<'_>, message: &messages::GeoTransformation) -> GeoTransformation {
    let reference = message
        .geo_reference
        .as_deref()
        .map(|text| at.field("geo_reference").text(text));
    GeoTransformation {
        reference: reference.filter(|text| !text.is_empty()),
        x: at.optional("x_translation", message.x_translation),
        y: at.optional("y_translation", message.y_translation),
        rotation: at.optional("z_rotation", message.z_rotation),
        scaling: at.optional("scaling", message.scaling),
    }
}

/// The surroundings, in the words of XML; nothing where nothing is said.
pub(super) fn environment(
    at: &FieldPath<'_>,
    message: &messages::Environment,
    words: &EnvironmentWords,
) -> Option<Environment> {
    let text = |name, words: &[&'static str], number: Option<i32>| {
        let word = at.field(name).word(words, number?);
        word.map(str::to_string)
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
