//! Floating car data in XML.

use super::fcd::{Collector, Recorded, Row, seconds};
use crate::formats::commonroad::ReadError;
use crate::formats::commonroad::xml::{Element, Xml};

/// Whether a file that begins so has floating car data.
pub fn begins(head: &[u8]) -> bool {
    let head = String::from_utf8_lossy(head);
    let text = head.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<') && text.contains("<fcd-export")
}

/// Reads a file; `file` names it in errors.
pub fn read(bytes: &[u8], file: &str) -> Result<Recorded, ReadError> {
    let mut xml = Xml::new(bytes, file)?;
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 16)]);
    let comment = head.split("<fcd-export").next().unwrap_or_default();
    let Some(root) = xml.next()?.filter(|root| root.name == "fcd-export") else {
        let message = "not floating car data: its root is not <fcd-export>";
        return Err(xml.fail(0, message.into()));
    };
    let mut all = Collector::default();
    while let Some(element) = xml.next()? {
        if element.name != "timestep" {
            xml.skip_unknown(element)?;
            continue;
        }
        let at = |message: String| xml.fail(element.at, message);
        let text = xml.attribute(element, "time");
        let text = text.ok_or_else(|| at("<timestep> has no attribute `time`".into()))?;
        let time = seconds(&text).ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            at(format!("time=\"{shown}\" is not a time in seconds"))
        })?;
        all.time(time).map_err(at)?;
        while let Some(child) = xml.next()? {
            if !matches!(child.name, "vehicle" | "person") {
                xml.skip_unknown(child)?;
                continue;
            }
            vehicle(&xml, child, &mut all)?;
            xml.skip()?;
        }
    }
    all.finish(comment.to_string())
        .map_err(|message| xml.fail_in(root, message))
}

fn vehicle<'a>(xml: &Xml<'a>, element: Element<'a>, all: &mut Collector) -> Result<(), ReadError> {
    let fail = |message| xml.fail(element.at, message);
    let missing = |name: &str| fail(format!("<{}> has no attribute `{name}`", element.name));
    let need = |name: &str| number(xml, element, name)?.ok_or_else(|| missing(name));
    let name = xml.attribute(element, "id").ok_or_else(|| missing("id"))?;
    let kind = xml.attribute(element, "type").unwrap_or_default();
    let lane = xml.attribute(element, "lane").unwrap_or_default();
    let row = Row {
        name: &name,
        kind: &kind,
        is_person: element.name == "person",
        lane: &lane,
        front: (need("x")?, need("y")?),
        angle: need("angle")?,
        speed: need("speed")?,
        acceleration: number(xml, element, "acceleration")?,
    };
    all.row(&row).map_err(fail)
}

fn number(xml: &Xml<'_>, element: Element<'_>, name: &str) -> Result<Option<f64>, ReadError> {
    let Some(text) = xml.attribute(element, name) else {
        return Ok(None);
    };
    let value = text.parse::<f64>().ok();
    let value = value.filter(|v| v.is_finite() && v.abs() <= 1e9);
    value.map(Some).ok_or_else(|| {
        let shown: String = text.chars().take(40).collect();
        xml.fail(element.at, format!("{name}=\"{shown}\" is not a number"))
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_clockwise_from_north() {
        let vehicle = |angle| format!("<vehicle id='a' x='1' y='2' angle='{angle}' speed='3'/>");
        for (angle, degrees) in [(0, 90.0), (90, 0.0), (180, -90.0), (270, 180.0_f64)] {
            let text = format!(
                "<fcd-export><timestep time='5'>{0}</timestep><timestep time='0:00:05.5'>{0}</timestep></fcd-export>",
                vehicle(angle)
            );
            let read = read(text.as_bytes(), "x").unwrap();
            let seen = &read.vehicles[0].seen[1];
            assert_eq!((read.time_step(), seen.step), (0.5, 1));
            assert!((seen.heading.cos() - degrees.to_radians().cos()).abs() < 1e-12);
            assert!((seen.heading.sin() - degrees.to_radians().sin()).abs() < 1e-12);
        }
    }
}
