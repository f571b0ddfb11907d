//! Floating car data in XML.

use std::borrow::Cow;

use super::fcd::{Collector, Recorded, Row, seconds};
use crate::commonroad::xml::{Element, Xml, decoded};
use crate::commonroad::{ReadError, beginning};

/// Whether a file that begins so has floating car data.
pub fn begins(head: &[u8]) -> bool {
    let head = beginning(head);
    let text = head.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<') && text.contains("<fcd-export")
}

/// Reads a file; `file` names it in errors.
pub fn read(bytes: &[u8], file: &str) -> Result<Recorded, ReadError> {
    let text = decoded(bytes, file)?;
    let mut xml = Xml::new(&text, file);
    let head = beginning(&bytes[..bytes.len().min(1 << 16)]);
    let comment = head.split("<fcd-export").next().unwrap_or_default();
    let Some(root) = xml.next()?.filter(|root| root.name == "fcd-export") else {
        let message = "not floating car data: its root is not <fcd-export>";
        return Err(xml.fail(0, message.into()));
    };
    let mut all = Collector::default();
    while let Some(element) = xml.next()? {
        if element.name != "timestep" {
            all.leftovers.element(&mut xml, "fcd-export", element)?;
            continue;
        }
        all.leftovers.attributes(&xml, element, &["time"]);
        let at = |message: String| xml.fail(element.at, message);
        let text = xml
            .attribute(element, "time")
            .ok_or_else(|| at("<timestep> has no attribute `time`".into()))?;
        let time = seconds(&text).ok_or_else(|| {
            let shown: String = text.chars().take(40).collect();
            at(format!("time=\"{shown}\" is not a time in seconds"))
        })?;
        all.time(time).map_err(at)?;
        while let Some(child) = xml.next()? {
            if !matches!(child.name, "vehicle" | "person") {
                all.leftovers.element(&mut xml, "timestep", child)?;
                continue;
            }
            vehicle(&xml, child, &mut all)?;
            all.leftovers.rest(&mut xml, child.name)?;
        }
    }
    all.finish(comment.to_string())
        .map_err(|message| xml.fail_in(root, message))
}

fn vehicle<'a>(xml: &Xml<'a>, element: Element<'a>, all: &mut Collector) -> Result<(), ReadError> {
    let fail = |message| xml.fail(element.at, message);
    let missing = |name: &str| fail(format!("<{}> has no attribute `{name}`", element.name));
    let mut texts: [Option<Cow<'a, str>>; 3] = Default::default();
    let mut numbers: [Option<f64>; 5] = Default::default();
    // Once through all of them, as there are millions.
    for (key, value) in xml.attributes(element) {
        if let Some(place) = TEXTS.iter().position(|name| *name == key) {
            texts[place].get_or_insert(value);
        } else if let Some(place) = NUMBERS.iter().position(|name| *name == key) {
            let number = value
                .parse::<f64>()
                .ok()
                .filter(|v| v.is_finite() && v.abs() <= 1e9);
            numbers[place] = Some(number.ok_or_else(|| {
                let shown: String = value.chars().take(40).collect();
                fail(format!("{key}=\"{shown}\" is not a number"))
            })?);
        } else {
            let line = || xml.line(element);
            all.leftovers.attribute(element.name, key, line);
        }
    }
    let need = |place: usize| numbers[place].ok_or_else(|| missing(NUMBERS[place]));
    let [name, kind, lane] = texts;
    let row = Row {
        name: &name.ok_or_else(|| missing("id"))?,
        kind: &kind.unwrap_or_default(),
        is_person: element.name == "person",
        lane: &lane.unwrap_or_default(),
        front: (need(0)?, need(1)?),
        angle: need(2)?,
        speed: need(3)?,
        acceleration: numbers[4],
    };
    all.row(&row).map_err(fail)
}

/// The attributes of a vehicle that are used.
const TEXTS: [&str; 3] = ["id", "type", "lane"];
const NUMBERS: [&str; 5] = ["x", "y", "angle", "speed", "acceleration"];

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
