//! What a file says about itself.

use std::collections::BTreeMap;

use super::kind::{benchmark_id, map_name};
use super::messages::{
    FileInformation, MapId, ScenarioInformation, ScenarioMetaInformation, TimeStamp,
};
use super::place::day;
use super::report::{At, Report};
use super::values::text;
use crate::scenario::commonroad::ReadError;
use crate::scenario::commonroad::xml::short;
use crate::scenario::plausibility::limits::refused_time_step;
use crate::scenario::{self, Header, Severity};

/// The header of a file of 2020a.
pub(super) fn of_2020a(
    report: &mut Report,
    at: &At<'_>,
    message: &ScenarioInformation,
) -> Result<Header, ReadError> {
    let version = message.common_road_version.as_ref();
    let version = needed_text(report, at, "common_road_version", version)?;
    if !matches!(version.as_str(), "2020a" | "2018b") {
        let message = format!("version `{}` is not 2020a; read as 2020a", short(&version));
        report.warn(&at.field("common_road_version"), message);
    }
    let id = needed_text(report, at, "benchmark_id", message.benchmark_id.as_ref())?;
    check_id(report, &at.field("benchmark_id"), &id);
    Ok(Header {
        benchmark_id: id,
        version,
        time_step_size: step_size(report, at, message.time_step_size)?,
        attributes: attributes(
            report,
            at,
            message.date.as_ref(),
            [&message.author, &message.affiliation, &message.source],
        )?,
    })
}

/// The header of a dynamic or scenario file of 2024, and the id of the map that it is about.
pub(super) fn of_2024(
    report: &mut Report,
    at: &At<'_>,
    message: &ScenarioMetaInformation,
) -> Result<(Header, Map), ReadError> {
    let id = report.need(at, "benchmark_id", message.benchmark_id.as_ref())?;
    let file = report.need(at, "file_information", message.file_information.as_ref())?;
    let step = step_size(report, at, message.time_step_size)?;
    let attributes = of_file(report, &at.field("file_information"), file)?;
    let at = at.field("benchmark_id");
    let map_id = report.need(&at, "map_id", id.map_id.as_ref())?;
    let map = map(report, &at.field("map_id"), map_id)?;
    let version = id.scenario_version.as_ref();
    let version = needed_text(report, &at, "scenario_version", version)?;
    let behavior = id.obstacle_behavior.as_deref();
    let behavior = behavior.map(|said| text(report, &at.field("obstacle_behavior"), said));
    let benchmark_id = benchmark_id(
        report.need(&at, "cooperative", id.cooperative)?,
        &map.id,
        Some(report.need(&at, "configuration_id", id.configuration_id)?),
        behavior.as_deref(),
        id.prediction_id,
    );
    check_id(report, &at, &benchmark_id);
    let header = Header {
        benchmark_id,
        version,
        time_step_size: step,
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

pub(super) fn map(report: &mut Report, at: &At<'_>, message: &MapId) -> Result<Map, ReadError> {
    let country = needed_text(report, at, "country_id", message.country_id.as_ref())?;
    let name = needed_text(report, at, "map_name", message.map_name.as_ref())?;
    let number = report.need(at, "map_id", message.map_id)?;
    Ok(Map {
        id: map_name(&country, &name, number),
        country,
    })
}

/// Author, affiliation, source and date of a file of 2024.
pub(super) fn of_file(
    report: &mut Report,
    at: &At<'_>,
    message: &FileInformation,
) -> Result<BTreeMap<String, String>, ReadError> {
    let name = report.need(at, "license_name", message.license_name.as_deref())?;
    let text = message.license_text.as_deref().unwrap_or_default();
    if !(name.is_empty() && text.is_empty()) {
        let message = format!(
            "the licence `{}` has no place here and was left out",
            short(name)
        );
        report.note(Severity::Note, at, message);
    }
    attributes(
        report,
        at,
        message.date.as_ref(),
        [&message.author, &message.affiliation, &message.source],
    )
}

fn attributes(
    report: &mut Report,
    at: &At<'_>,
    date: Option<&TimeStamp>,
    texts: [&Option<String>; 3],
) -> Result<BTreeMap<String, String>, ReadError> {
    let mut found = BTreeMap::new();
    for (name, said) in ["author", "affiliation", "source"].into_iter().zip(texts) {
        let said = needed_text(report, at, name, said.as_ref())?;
        found.insert(name.to_string(), said);
    }
    let date = day(report.need(at, "date", date)?);
    found.extend(date.map(|day| ("date".to_string(), day)));
    Ok(found)
}

/// A text that the schema requires.
fn needed_text(
    report: &mut Report,
    at: &At<'_>,
    name: &str,
    value: Option<&String>,
) -> Result<String, ReadError> {
    let value = report.need(at, name, value)?;
    Ok(text(report, &at.field(name), value))
}

fn step_size(report: &Report, at: &At<'_>, value: Option<f64>) -> Result<f64, ReadError> {
    let value = report.need(at, "time_step_size", value)?;
    match refused_time_step(value) {
        None => Ok(value),
        Some(why) => Err(report.fail(&at.field("time_step_size"), format!("{value} {why}"))),
    }
}

fn check_id(report: &mut Report, at: &At<'_>, id: &str) {
    if !scenario::benchmark_id::is_valid(id) {
        let message = format!("`{}` does not follow the rule for benchmark ids", short(id));
        report.note(Severity::Note, at, message);
    }
}
