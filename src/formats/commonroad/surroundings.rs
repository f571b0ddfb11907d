//! Writes the location: position, transformation and environment.

use super::location::{UNKNOWN_DEGREES, UNKNOWN_ID};
use super::writer::WriteError;
use super::xml_writer::{XmlWriter, number};
use nearmiss_scene::scenario::Location;

/// The children of a location.
pub(super) fn write(out: &mut XmlWriter, location: &Location) -> Result<(), WriteError> {
    let id = location.geo_name_id.unwrap_or(UNKNOWN_ID);
    let degrees = |known: Option<f64>| number(known.unwrap_or(UNKNOWN_DEGREES));
    out.leaf("geoNameId", &id.to_string())?;
    out.leaf("gpsLatitude", &degrees(location.latitude))?;
    out.leaf("gpsLongitude", &degrees(location.longitude))?;
    if let Some(transformation) = &location.transformation {
        out.element("geoTransformation", &[], |out| {
            if let Some(reference) = &transformation.reference {
                out.leaf("geoReference", reference)?;
            }
            let parts = [
                ("xTranslation", transformation.x),
                ("yTranslation", transformation.y),
                ("zRotation", transformation.rotation),
                ("scaling", transformation.scaling),
            ];
            if parts.iter().all(|(_, value)| value.is_none()) {
                return Ok(());
            }
            out.element("additionalTransformation", &[], |out| {
                let mut said = parts
                    .iter()
                    .filter_map(|(name, value)| Some((name, (*value)?)));
                said.try_for_each(|(name, value)| out.leaf(name, &number(value)))
            })
        })?;
    }
    let Some(environment) = &location.environment else {
        return Ok(());
    };
    out.element("environment", &[], |out| {
        let words = [
            ("time", &environment.time),
            ("timeOfDay", &environment.time_of_day),
            ("weather", &environment.weather),
            ("underground", &environment.underground),
        ];
        let mut said = words
            .iter()
            .filter_map(|(name, word)| Some((name, word.as_ref()?)));
        said.try_for_each(|(name, word)| out.leaf(name, word))
    })
}
