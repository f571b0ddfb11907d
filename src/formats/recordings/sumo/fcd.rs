//! Floating car data, as SUMO writes it with `--fcd-output`: who is where at each time step, in XML or as a table.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};
use std::path::Path;

use nearmiss_base::geometry::{Point, normalize_angle};
use nearmiss_scene::scenario::plausibility::{MOST_PARTS, refused_coordinate};

use super::geo;
use crate::commonroad::builder::SourceLocation;
use crate::commonroad::xml::{Element, Xml, decoded};
use crate::commonroad::{ReadError, beginning};
use crate::recordings::rows::Steps;
use crate::recordings::tracks::{BadCell, ColumnForm, Wanted};
use crate::recordings::{Leftovers, Report, rows};

/// What is in a file.
pub struct Recorded {
    /// The comment at its beginning, which has SUMO's options.
    pub comment: String,
    /// Seconds.
    pub times: Vec<f64>,
    /// The steps of these times.
    pub steps: Steps,
    /// In the order in which they first appear.
    pub vehicles: Vec<Vehicle>,
    /// The edges of the lanes that vehicles are on.
    pub edges: BTreeSet<String>,
    /// Whether places are in degrees, as far as the file tells it.
    pub degrees: Option<bool>,
    /// What stands in the file and is not used.
    pub leftovers: Leftovers,
}

/// A vehicle or a person.
pub struct Vehicle {
    pub name: String,
    /// The name of its type.
    pub kind: String,
    /// In order.
    pub seen: Vec<VehicleAtStep>,
}

/// A vehicle at a step.
#[derive(Debug, Clone, Copy)]
pub struct VehicleAtStep {
    pub step: i64,
    /// The middle of its front: metres, or longitude and latitude in degrees.
    pub front: Point,
    /// Radians, counterclockwise from the x-axis.
    pub heading: f64,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: Option<f64>,
}

impl Recorded {
    /// When the first step is, seconds.
    pub fn start(&self) -> f64 {
        self.steps.start
    }

    /// Seconds between two steps.
    pub fn time_step(&self) -> f64 {
        self.steps.time_step
    }

    /// Bytes, about.
    pub fn size(&self) -> usize {
        let states: usize = self.vehicles.iter().map(|v| v.seen.capacity()).sum();
        let each = size_of::<Vehicle>() + 64;
        self.comment.len()
            + self.times.len() * (size_of::<f64>() + size_of::<i64>())
            + self.vehicles.len() * each
            + self.edges.len() * 64
            + states * size_of::<VehicleAtStep>()
    }
}

impl Vehicle {
    /// Its first and last step.
    pub fn span(&self) -> (i64, i64) {
        let step = |seen: Option<&VehicleAtStep>| seen.map_or(0, |s| s.step);
        (step(self.seen.first()), step(self.seen.last()))
    }
}

/// Most states of a file.
const MOST_STATES: usize = 20 * MOST_PARTS;

/// What a file says of a vehicle at a time.
pub struct Row<'r> {
    pub name: &'r str,
    /// The name of its type; empty where the file has none.
    pub kind: &'r str,
    pub is_person: bool,
    /// The lane that it is on; empty where the file has none.
    pub lane: &'r str,
    /// As in the file.
    pub front: (f64, f64),
    /// Degrees, clockwise from north.
    pub angle: f64,
    /// m/s.
    pub speed: f64,
    /// m/s².
    pub acceleration: Option<f64>,
}

/// Puts the rows of a file together, in the order of the file.
#[derive(Default)]
pub struct Collector {
    times: Vec<f64>,
    places: HashMap<String, usize>,
    vehicles: Vec<Vehicle>,
    edges: BTreeSet<String>,
    count: usize,
    /// What stands in the file and is not used.
    pub leftovers: Leftovers,
}

impl Collector {
    /// The next time, seconds.
    ///
    /// # Errors
    /// It is not after the one before, or they are too many.
    pub fn time(&mut self, time: f64) -> Result<(), String> {
        if self.times.last().is_some_and(|last| *last >= time) {
            return Err(format!("time {time} s does not follow the one before"));
        }
        if self.times.len() == MOST_PARTS {
            return Err(format!("more than {MOST_PARTS} time steps"));
        }
        self.times.push(time);
        Ok(())
    }

    /// The time of the rows that came last; `None` before the first one.
    pub fn last_time(&self) -> Option<f64> {
        self.times.last().copied()
    }

    /// A vehicle at the last time.
    ///
    /// # Errors
    /// Its place is implausible, or there are too many.
    pub fn row(&mut self, row: &Row<'_>) -> Result<(), String> {
        self.count += 1;
        if self.count > MOST_STATES {
            return Err(format!("more than {MOST_STATES} vehicles and steps"));
        }
        let (x, y) = row.front;
        if let Some(why) = refused_coordinate(x).or_else(|| refused_coordinate(y)) {
            return Err(why);
        }
        if let Some((edge, _)) = row.lane.rsplit_once('_')
            && !self.edges.contains(edge)
        {
            self.edges.insert(edge.to_string());
        }
        let place = match self.places.get(row.name) {
            Some(place) => *place,
            None => {
                let default = ["DEFAULT_VEHTYPE", "DEFAULT_PEDTYPE"][usize::from(row.is_person)];
                self.vehicles.push(Vehicle {
                    name: row.name.to_string(),
                    kind: if row.kind.is_empty() {
                        default
                    } else {
                        row.kind
                    }
                    .to_string(),
                    seen: Vec::new(),
                });
                let place = self.vehicles.len() - 1;
                self.places.insert(row.name.to_string(), place);
                place
            }
        };
        self.vehicles[place].seen.push(VehicleAtStep {
            // The place of its time, until steps are known.
            step: i64::try_from(self.times.len()).unwrap_or(i64::MAX) - 1,
            front: Point::new(x, y),
            heading: normalize_angle((90.0 - row.angle).to_radians()),
            speed: row.speed,
            acceleration: row.acceleration,
        });
        Ok(())
    }

    /// Everything, with the comment at the beginning of the file.
    ///
    /// # Errors
    /// Its times are no steps.
    pub fn finish(mut self, comment: String) -> Result<Recorded, String> {
        let steps = Steps::from_times(&self.times)?;
        for vehicle in &mut self.vehicles {
            for seen in &mut vehicle.seen {
                let place = usize::try_from(seen.step).unwrap_or(0);
                seen.step = steps.steps[place];
            }
        }
        Ok(Recorded {
            degrees: geo::degrees(&self.vehicles, steps.time_step, &comment),
            comment,
            times: self.times,
            steps,
            vehicles: self.vehicles,
            edges: self.edges,
            leftovers: self.leftovers,
        })
    }
}

/// A time, seconds: `12.50`, or as `--human-readable-time` writes it, `0:00:12.50` and with days `1:00:00:12.50`.
pub fn seconds(text: &str) -> Option<f64> {
    let (sign, rest) = match text.trim().strip_prefix('-') {
        Some(rest) => (-1.0, rest),
        None => (1.0, text.trim()),
    };
    let pieces: Vec<&str> = rest.split(':').collect();
    let (last, before) = pieces.split_last()?;
    let factors: &[f64] = match before.len() {
        0 => &[],
        2 => &[3600.0, 60.0],
        3 => &[86_400.0, 3600.0, 60.0],
        _ => return None,
    };
    let mut sum = last.parse::<f64>().ok().filter(|s| *s >= 0.0)?;
    for (piece, factor) in before.iter().zip(factors) {
        sum += f64::from(piece.parse::<u32>().ok()?) * factor;
    }
    Some(sign * sum).filter(|s| s.is_finite() && s.abs() <= 1e9)
}

/// The columns that tell such a table.
const TELLING: [&str; 4] = ["timestep_time", "vehicle_id", "vehicle_x", "vehicle_y"];

/// What is used of a vehicle or person.
const USED: [&str; 8] = [
    "id",
    "type",
    "lane",
    "x",
    "y",
    "angle",
    "speed",
    "acceleration",
];

/// Whether a file that begins so has floating car data.
pub fn is_csv(head: &[u8]) -> bool {
    let (_, names) = rows::columns_of(head);
    TELLING.iter().all(|name| names.iter().any(|n| n == name))
}

/// Reads a file; `file` names it in errors.
pub fn read_csv(bytes: &[u8], file: &str) -> Result<Recorded, ReadError> {
    let report = Report::about(file);
    let (separator, names) = rows::columns_of(bytes);
    let mut table = csv::ReaderBuilder::new()
        .delimiter(separator)
        .flexible(true)
        .from_reader(bytes);
    let place = |name: &str| names.iter().position(|n| n == name);
    let mut all = Collector::default();
    let mut rows = 0;
    let mut record = csv::StringRecord::new();
    loop {
        let more = table.read_record(&mut record);
        let line = record.position().map_or(0, csv::Position::line);
        let line = usize::try_from(line).unwrap_or(0);
        if !more.map_err(|error| report.row(line, "").fail(error.to_string()))? {
            break;
        }
        rows += 1;
        let text = |name: &str| {
            let field = place(name).and_then(|place| record.get(place));
            field.unwrap_or_default().trim()
        };
        all.table_row(&text, &report, line)?;
    }
    all.count_unused(&names, rows);
    all.finish(String::new())
        .map_err(|message| report.fail(message))
}

/// Whether a file has floating car data in columns.
pub fn is_parquet(path: &Path, head: &[u8]) -> bool {
    let names = ColumnForm::detect(head).map(|form| form.names(path));
    let Some(Ok(names)) = names else {
        return false;
    };
    TELLING.iter().all(|name| names.iter().any(|n| n == name))
}

/// Reads a file in columns; `file` names it in errors.
pub fn read_parquet(path: &Path, file: &str) -> Result<Recorded, ReadError> {
    let report = Report::about(file);
    let form = ColumnForm::Parquet;
    let names = form.names(path).map_err(|why| report.fail(why))?;
    let wanted: Vec<Wanted> = names
        .iter()
        .map(|name| Wanted {
            name: name.clone(),
            is_text: true,
        })
        .collect();
    let mut all = Collector::default();
    let mut rows = 0;
    let mut failed = None;
    let read = form.read(path, &wanted, &mut |batch| {
        rows += batch.lines.len();
        for (row, line) in batch.lines.iter().enumerate() {
            let text = |name: &str| match names.iter().position(|n| n == name) {
                Some(place) => batch.text(place, row),
                None => "",
            };
            if let Err(error) = all.table_row(&text, &report, *line as usize) {
                failed = Some(error);
                return Err(BadCell::default());
            }
        }
        Ok(())
    });
    match (failed, read) {
        (Some(error), _) => return Err(error),
        (None, Err(bad)) => return Err(report.row(bad.line, bad.column).fail(bad.message)),
        (None, Ok(())) => {}
    }
    all.count_unused(&names, rows);
    all.finish(String::new())
        .map_err(|message| report.fail(message))
}

impl Collector {
    /// A row of a table, which is one vehicle, or a time without any.
    fn table_row<'t>(
        &mut self,
        text: &dyn Fn(&str) -> &'t str,
        report: &Report,
        line: usize,
    ) -> Result<(), ReadError> {
        let row = |column: &str| {
            let element = if column.is_empty() {
                String::new()
            } else {
                format!("column {column}")
            };
            report.row(line, element)
        };
        let wrong = |name: &str, what: &str| {
            let shown: String = text(name).chars().take(40).collect();
            row(name).fail(format!("`{shown}` is not {what}"))
        };
        let optional = |name: &str| match text(name) {
            "" => Ok(None),
            said => match said.parse::<f64>() {
                Ok(value) if value.is_finite() && value.abs() <= 1e9 => Ok(Some(value)),
                _ => Err(wrong(name, "a number")),
            },
        };
        let need = |name: &str| optional(name)?.ok_or_else(|| row(name).fail("missing"));
        let time = seconds(text("timestep_time"))
            .ok_or_else(|| wrong("timestep_time", "a time in seconds"))?;
        let fail = |message: String| row("").fail(message);
        if self.last_time() != Some(time) {
            self.time(time).map_err(fail)?;
        }
        for kind in ["vehicle", "person"] {
            let of = |what: &str| format!("{kind}_{what}");
            let name = text(&of("id"));
            if name.is_empty() {
                continue;
            }
            let row = Row {
                name,
                kind: text(&of("type")),
                is_person: kind == "person",
                lane: text(&of("lane")),
                front: (need(&of("x"))?, need(&of("y"))?),
                angle: need(&of("angle"))?,
                speed: need(&of("speed"))?,
                acceleration: optional(&of("acceleration"))?,
            };
            self.row(&row).map_err(fail)?;
        }
        Ok(())
    }

    /// Counts the columns of a table that are not used.
    fn count_unused(&mut self, names: &[String], rows: usize) {
        let used = |name: &str| {
            let of = |kind| {
                name.strip_prefix(kind)
                    .is_some_and(|what| USED.contains(&what))
            };
            name == TELLING[0] || of("vehicle_") || of("person_")
        };
        for name in names.iter().filter(|name| !used(name)) {
            let kind = format!("column {name}");
            self.leftovers.add_times(&kind, rows, || 1);
        }
    }
}

/// Whether a file that begins so has floating car data.
pub fn is_xml(head: &[u8]) -> bool {
    let head = beginning(head);
    let text = head.trim_start_matches('\u{feff}').trim_start();
    text.starts_with('<') && text.contains("<fcd-export")
}

/// Reads a file; `file` names it in errors.
pub fn read_xml(bytes: &[u8], file: &str) -> Result<Recorded, ReadError> {
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
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn times_are_seconds_or_a_clock() {
        let all = [
            ("12.50", Some(12.5)),
            ("00:00:04.50", Some(4.5)),
            ("23:59:58", Some(86_398.0)),
            ("24:00:00", Some(86_400.0)),
            ("1:00:00:01", Some(86_401.0)),
            ("-0:00:01.00", Some(-1.0)),
            ("1:30", None),
            ("0:x:1", None),
            ("noon", None),
            ("1e300", None),
        ];
        for (text, expected) in all {
            assert_eq!(seconds(text), expected, "{text}");
        }
    }

    #[test]
    fn a_row_is_a_vehicle_or_a_time_without_one() {
        let table = "timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle;vehicle_type;vehicle_speed;vehicle_lane\n\
            0.00;a;1.00;2.00;90.00;car;3.00;e_0\n0.00;b;9.00;2.00;90.00;;3.00;f_1_0\n1.00\n2.00;a;4.00;2.00;90.00;car;3.00;e_0\n";
        assert!(is_csv(table.as_bytes()));
        let read = read_csv(table.as_bytes(), "x.csv").unwrap();
        assert_eq!(read.times, [0.0, 1.0, 2.0]);
        let [a, b] = &read.vehicles[..] else { panic!() };
        assert_eq!((a.span(), b.span()), ((0, 2), (0, 0)));
        assert_eq!((&*a.kind, &*b.kind), ("car", "DEFAULT_VEHTYPE"));
        assert_eq!(read.edges.iter().collect::<Vec<_>>(), ["e", "f_1"]);
        let broken = table.replace("9.00", "9,00");
        let error = super::read_csv(broken.as_bytes(), "x.csv")
            .err()
            .unwrap()
            .to_string();
        assert!(
            error.contains(":3") && error.contains("column vehicle_x: `9,00` is not a number"),
            "{error}"
        );
    }

    #[test]
    fn angles_are_clockwise_from_north() {
        let vehicle = |angle| format!("<vehicle id='a' x='1' y='2' angle='{angle}' speed='3'/>");
        for (angle, degrees) in [(0, 90.0), (90, 0.0), (180, -90.0), (270, 180.0_f64)] {
            let text = format!(
                "<fcd-export><timestep time='5'>{0}</timestep><timestep time='0:00:05.5'>{0}</timestep></fcd-export>",
                vehicle(angle)
            );
            let read = read_xml(text.as_bytes(), "x").unwrap();
            let seen = &read.vehicles[0].seen[1];
            assert_eq!((read.time_step(), seen.step), (0.5, 1));
            assert!((seen.heading.cos() - degrees.to_radians().cos()).abs() < 1e-12);
            assert!((seen.heading.sin() - degrees.to_radians().sin()).abs() < 1e-12);
        }
    }
}
