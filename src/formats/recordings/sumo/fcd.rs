//! The file that SUMO writes with `--fcd-output`: who is where at each time step.

use std::collections::HashMap;

use crate::formats::commonroad::xml::{Element, Xml, decoded};
use crate::formats::commonroad::{ReadError, beginning};
use crate::formats::recordings::assembly::median;
use crate::geometry::Point;
use crate::scenario::plausibility::limits::{LATEST_STEP, MOST_PARTS, refused_coordinate};

/// What is in a file.
pub struct Recorded {
    /// The comment at its beginning, which has SUMO's options.
    pub comment: String,
    /// Seconds.
    pub times: Vec<f64>,
    /// The first of them, seconds.
    pub start: f64,
    /// Seconds between two.
    pub time_step: f64,
    /// In the order in which they first appear.
    pub vehicles: Vec<Vehicle>,
}

/// A vehicle or a person.
pub struct Vehicle {
    pub name: String,
    /// The name of its type.
    pub kind: String,
    /// In order.
    pub seen: Vec<Seen>,
}

/// A vehicle at a step.
pub struct Seen {
    pub step: i64,
    /// The middle of its front.
    pub front: Point,
    /// Radians, counterclockwise from the x-axis.
    pub heading: f64,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: Option<f64>,
}

impl Recorded {
    /// Bytes, about.
    pub fn size(&self) -> usize {
        let states: usize = self.vehicles.iter().map(|v| v.seen.capacity()).sum();
        let each = size_of::<Vehicle>() + 64;
        self.comment.len()
            + self.times.len() * size_of::<f64>()
            + self.vehicles.len() * each
            + states * size_of::<Seen>()
    }
}

impl Vehicle {
    /// Its first and last step.
    pub fn span(&self) -> (i64, i64) {
        let step = |seen: Option<&Seen>| seen.map_or(0, |s| s.step);
        (step(self.seen.first()), step(self.seen.last()))
    }
}

/// Whether a file that begins so has floating car data.
pub fn begins(head: &[u8]) -> bool {
    let head = beginning(head);
    let text = head.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<') && text.contains("<fcd-export")
}

/// Most states of a file.
const MOST_STATES: usize = 20 * MOST_PARTS;

/// Reads a file; `file` names it in errors.
pub fn read(bytes: &[u8], file: &str) -> Result<Recorded, ReadError> {
    let text = decoded(bytes, file)?;
    let mut xml = Xml::new(&text, file);
    let head = beginning(&bytes[..bytes.len().min(1 << 16)]);
    let comment = head
        .split("<fcd-export")
        .next()
        .unwrap_or_default()
        .to_string();
    let Some(root) = xml.next()?.filter(|root| root.name == "fcd-export") else {
        return Err(xml.fail(
            0,
            "not floating car data: its root is not <fcd-export>".into(),
        ));
    };
    let mut times = Vec::new();
    let mut places: HashMap<String, usize> = HashMap::new();
    let mut vehicles: Vec<Vehicle> = Vec::new();
    let mut count = 0;
    while let Some(element) = xml.next()? {
        if element.name != "timestep" {
            xml.skip_unknown(element)?;
            continue;
        }
        let time = number(&xml, element, "time")?;
        let time =
            time.ok_or_else(|| xml.fail(element.at, "<timestep> has no attribute `time`".into()))?;
        if times.last().is_some_and(|last| *last >= time) {
            return Err(xml.fail(
                element.at,
                format!("time {time} s does not follow the one before"),
            ));
        }
        let step = i64::try_from(times.len()).unwrap_or(i64::MAX);
        times.push(time);
        xml.check_count(element, times.len(), "time steps")?;
        while let Some(child) = xml.next()? {
            if !matches!(child.name, "vehicle" | "person") {
                xml.skip_unknown(child)?;
                continue;
            }
            count += 1;
            if count > MOST_STATES {
                return Err(xml.fail(
                    child.at,
                    format!("more than {MOST_STATES} vehicles and steps"),
                ));
            }
            let Some(name) = xml.attribute(child, "id") else {
                return Err(xml.fail(child.at, format!("<{}> has no attribute `id`", child.name)));
            };
            let place = match places.get(name.as_ref()) {
                Some(place) => *place,
                None => {
                    let default =
                        ["DEFAULT_VEHTYPE", "DEFAULT_PEDTYPE"][usize::from(child.name == "person")];
                    let kind = xml.attribute(child, "type").filter(|k| !k.is_empty());
                    vehicles.push(Vehicle {
                        name: name.to_string(),
                        kind: kind.map_or_else(|| default.into(), |k| k.to_string()),
                        seen: Vec::new(),
                    });
                    places.insert(name.to_string(), vehicles.len() - 1);
                    vehicles.len() - 1
                }
            };
            let seen = seen(&xml, child, step)?;
            let all = &mut vehicles[place].seen;
            if all.last().is_none_or(|last| last.step < step) {
                all.push(seen);
            }
            xml.skip()?;
        }
    }
    if times.len() < 2 {
        let message = format!("{} time steps; at least 2 are needed", times.len());
        return Err(xml.fail_in(root, message));
    }
    let start = times[0];
    let between = times.windows(2).map(|pair| pair[1] - pair[0]);
    let time_step = (median(between.collect()) * 1e4).round() / 1e4;
    if time_step <= 0.0 {
        return Err(xml.fail_in(root, "time steps of less than 0.1 ms".into()));
    }
    // Steps are counted by time, so that times that are not written are gaps.
    let mut by_time = Vec::with_capacity(times.len());
    for time in &times {
        let step = ((time - start) / time_step).round();
        if step.abs() > LATEST_STEP as f64 {
            return Err(xml.fail_in(root, format!("time {time} s is implausible")));
        }
        by_time.push(step as i64);
    }
    for vehicle in &mut vehicles {
        for seen in &mut vehicle.seen {
            seen.step = by_time[usize::try_from(seen.step).unwrap_or(0)];
        }
        vehicle.seen.dedup_by_key(|s| s.step);
    }
    Ok(Recorded {
        comment,
        times,
        start,
        time_step,
        vehicles,
    })
}

fn number(xml: &Xml<'_>, element: Element<'_>, name: &str) -> Result<Option<f64>, ReadError> {
    let Some(text) = xml.attribute(element, name) else {
        return Ok(None);
    };
    let value = text
        .parse::<f64>()
        .ok()
        .filter(|v| v.is_finite() && v.abs() <= 1e9);
    value.map(Some).ok_or_else(|| {
        let shown: String = text.chars().take(40).collect();
        xml.fail(element.at, format!("{name}=\"{shown}\" is not a number"))
    })
}

fn seen(xml: &Xml<'_>, element: Element<'_>, step: i64) -> Result<Seen, ReadError> {
    let need = |name: &str| {
        number(xml, element, name)?.ok_or_else(|| {
            xml.fail(
                element.at,
                format!("<{}> has no attribute `{name}`", element.name),
            )
        })
    };
    let (x, y) = (need("x")?, need("y")?);
    if let Some(why) = refused_coordinate(x).or_else(|| refused_coordinate(y)) {
        return Err(xml.fail(element.at, why));
    }
    Ok(Seen {
        step,
        front: Point::new(x, y),
        // Degrees clockwise from north.
        heading: crate::geometry::normalize_angle((90.0 - need("angle")?).to_radians()),
        speed: need("speed")?,
        acceleration: number(xml, element, "acceleration")?,
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
                "<fcd-export><timestep time='5'>{0}</timestep><timestep time='5.5'>{0}</timestep></fcd-export>",
                vehicle(angle)
            );
            let read = read(text.as_bytes(), "x").unwrap();
            let seen = &read.vehicles[0].seen[1];
            assert_eq!((read.time_step, seen.step), (0.5, 1));
            assert!((seen.heading.cos() - degrees.to_radians().cos()).abs() < 1e-12);
            assert!((seen.heading.sin() - degrees.to_radians().sin()).abs() < 1e-12);
        }
    }
}
