//! File metadata, the location of a scenario, and its environment.

use std::collections::BTreeMap;

use nearmiss_scene::scenario::plausibility::refused_time_step;
use nearmiss_scene::scenario::{Environment, GeoTransformation, Header, Location, Severity};

use super::messages::{
    self, FileInformation, MapId, ScenarioInformation, ScenarioMetaInformation, TimeStamp,
};
use super::report::FieldPath;
use super::values::{EnvironmentWords, UNDERGROUNDS};
use super::wire::{benchmark_id, map_name};
use crate::commonroad::ReadError;
use crate::commonroad::builder::{SourceLocation, check_benchmark_id};
use crate::commonroad::elements::{UNKNOWN_DEGREES, UNKNOWN_ID};
use crate::commonroad::xml::short;

/// The header of a file of 2020a.
pub(super) fn of_2020a(
    at: &FieldPath<'_>,
    message: &ScenarioInformation,
) -> Result<Header, ReadError> {
    let version = message.common_road_version.as_ref();
    let version = at.needed_text("common_road_version", version)?;
    if !matches!(version.as_str(), "2020a" | "2018b") {
        let message = format!("version `{}` is not 2020a; read as 2020a", short(&version));
        at.field("common_road_version").warn(message);
    }
    let id = at.needed_text("benchmark_id", message.benchmark_id.as_ref())?;
    check_benchmark_id(&at.field("benchmark_id"), &id);
    let texts = [&message.author, &message.affiliation, &message.source];
    Ok(Header {
        other_format: None,
        benchmark_id: id,
        version,
        time_step_size: step_size(at, message.time_step_size)?,
        attributes: attributes(at, message.date.as_ref(), texts)?,
    })
}

/// The header of a dynamic or scenario file of 2024, and the id of the map that it is about.
pub(super) fn of_2024(
    at: &FieldPath<'_>,
    message: &ScenarioMetaInformation,
) -> Result<(Header, Map), ReadError> {
    let id = at.need("benchmark_id", message.benchmark_id.as_ref())?;
    let file = at.need("file_information", message.file_information.as_ref())?;
    let time_step_size = step_size(at, message.time_step_size)?;
    let attributes = of_file(&at.field("file_information"), file)?;
    let at = at.field("benchmark_id");
    let map = map(&at.field("map_id"), at.need("map_id", id.map_id.as_ref())?)?;
    let version = at.needed_text("scenario_version", id.scenario_version.as_ref())?;
    let behavior = id
        .obstacle_behavior
        .as_deref()
        .map(|text| at.field("obstacle_behavior").text(text));
    let benchmark_id = benchmark_id(
        at.need("cooperative", id.cooperative)?,
        &map.id,
        Some(at.need("configuration_id", id.configuration_id)?),
        behavior.as_deref(),
        id.prediction_id,
    );
    check_benchmark_id(&at, &benchmark_id);
    let header = Header {
        other_format: None,
        benchmark_id,
        version,
        time_step_size,
        attributes,
    };
    Ok((header, map))
}

/// The id of a map.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Map {
    /// `DEU_Bremen-1`.
    pub id: String,
    /// `DEU`.
    pub country: String,
}

pub(super) fn map(at: &FieldPath<'_>, message: &MapId) -> Result<Map, ReadError> {
    let country = at.needed_text("country_id", message.country_id.as_ref())?;
    let name = at.needed_text("map_name", message.map_name.as_ref())?;
    let number = at.need("map_id", message.map_id)?;
    Ok(Map {
        id: map_name(&country, &name, number),
        country,
    })
}

/// Author, affiliation, source and date of a file of 2024.
pub(super) fn of_file(
    at: &FieldPath<'_>,
    message: &FileInformation,
) -> Result<BTreeMap<String, String>, ReadError> {
    let name = at.need("license_name", message.license_name.as_deref())?;
    let text = message.license_text.as_deref().unwrap_or_default();
    if !(name.is_empty() && text.is_empty()) {
        let name = short(name);
        let message = format!("the licence `{name}` is not supported and was left out");
        at.note(Severity::Note, message);
    }
    let texts = [&message.author, &message.affiliation, &message.source];
    attributes(at, message.date.as_ref(), texts)
}

fn attributes(
    at: &FieldPath<'_>,
    date: Option<&TimeStamp>,
    texts: [&Option<String>; 3],
) -> Result<BTreeMap<String, String>, ReadError> {
    let mut found = BTreeMap::new();
    for (name, text) in ["author", "affiliation", "source"].into_iter().zip(texts) {
        found.insert(name.to_string(), at.needed_text(name, text.as_ref())?);
    }
    let date = day(at.need("date", date)?);
    found.extend(date.map(|day| ("date".to_string(), day)));
    Ok(found)
}

/// The day a file was written, as XML has it, which knows no hours.
fn day(date: &TimeStamp) -> Option<String> {
    let (year, month, day) = (date.year?, date.month?, date.day?);
    Some(format!("{year:04}-{month:02}-{day:02}"))
}

fn step_size(at: &FieldPath<'_>, value: Option<f64>) -> Result<f64, ReadError> {
    let value = at.need("time_step_size", value)?;
    match refused_time_step(value) {
        None => Ok(value),
        Some(why) => Err(at.field("time_step_size").fail(format!("{value} {why}"))),
    }
}

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
