//! The location of a scenario: position, transformation, environment.

use super::error::ReadError;
use super::xml::{Element, Xml};
use nearmiss_scene::scenario::{Environment, GeoTransformation, Location};

/// The value that files write for an unknown place id.
pub(super) const UNKNOWN_ID: i64 = -999;
/// The value that files write for an unknown latitude or longitude.
pub(super) const UNKNOWN_DEGREES: f64 = 999.0;

fn degrees<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Option<f64>, ReadError> {
    let said = xml.optional_number(element)?;
    Ok(said.filter(|degrees| *degrees != UNKNOWN_DEGREES))
}

pub(super) fn location(xml: &mut Xml<'_>) -> Result<Location, ReadError> {
    let mut location = Location::default();
    while let Some(child) = xml.next()? {
        match child.name {
            "geoNameId" => {
                let id = xml.optional_number(child)?.map(|v| v as i64);
                location.geo_name_id = id.filter(|id| *id != UNKNOWN_ID);
            }
            "gpsLatitude" => location.latitude = degrees(xml, child)?,
            "gpsLongitude" => location.longitude = degrees(xml, child)?,
            "geoTransformation" => location.transformation = Some(transformation(xml)?),
            "environment" => location.environment = Some(environment(xml)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(location)
}

fn transformation(xml: &mut Xml<'_>) -> Result<GeoTransformation, ReadError> {
    let mut found = GeoTransformation::default();
    while let Some(child) = xml.next()? {
        match child.name {
            "geoReference" => {
                found.reference = Some(xml.text()?.into_owned()).filter(|text| !text.is_empty());
            }
            "additionalTransformation" => {
                while let Some(part) = xml.next()? {
                    match part.name {
                        "xTranslation" => found.x = xml.optional_number(part)?,
                        "yTranslation" => found.y = xml.optional_number(part)?,
                        "zRotation" => found.rotation = xml.optional_number(part)?,
                        "scaling" => found.scaling = xml.optional_number(part)?,
                        _ => xml.skip_unknown(part)?,
                    }
                }
            }
            _ => xml.skip_unknown(child)?,
        }
    }
    Ok(found)
}

fn environment(xml: &mut Xml<'_>) -> Result<Environment, ReadError> {
    let mut found = Environment::default();
    while let Some(child) = xml.next()? {
        let word = match child.name {
            "time" => &mut found.time,
            "timeOfDay" => &mut found.time_of_day,
            "weather" => &mut found.weather,
            "underground" => &mut found.underground,
            _ => {
                xml.skip_unknown(child)?;
                continue;
            }
        };
        *word = Some(xml.text()?.into_owned()).filter(|text| !text.is_empty());
    }
    Ok(found)
}
