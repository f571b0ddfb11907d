//! Where a scenario takes place: position, transformation, surroundings.

use super::error::ReadError;
use super::xml::Xml;
use crate::scenario::{Environment, GeoTransformation, Location};

pub(super) fn location(xml: &mut Xml<'_>) -> Result<Location, ReadError> {
    let mut location = Location::default();
    while let Some(child) = xml.next()? {
        match child.name {
            "geoNameId" => location.geo_name_id = xml.optional_number(child)?.map(|v| v as i64),
            "gpsLatitude" => location.latitude = xml.optional_number(child)?,
            "gpsLongitude" => location.longitude = xml.optional_number(child)?,
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
