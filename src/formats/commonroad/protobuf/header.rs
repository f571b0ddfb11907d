//! File metadata.

use std::collections::BTreeMap;

use super::kind::{benchmark_id, map_name};
use super::messages::{
    FileInformation, MapId, ScenarioInformation, ScenarioMetaInformation, TimeStamp,
};
use super::report::FieldPath;
use crate::commonroad::ReadError;
use crate::commonroad::builder::{SourceLocation, check_benchmark_id};
use crate::commonroad::xml::short;
use nearmiss_scene::scenario::plausibility::limits::refused_time_step;
use nearmiss_scene::scenario::{Header, Severity};

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
