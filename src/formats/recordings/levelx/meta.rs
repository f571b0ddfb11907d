//! `XX_recordingMeta.csv` and `XX_tracksMeta.csv`: about the recording, and about each of its tracks.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::path::Path;

use super::rows::Kind;
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::{At, Leftovers, Report};
use crate::recordings::rows;
use nearmiss_base::system;
use nearmiss_scene::scenario::ObstacleType;

/// About a recording.
#[derive(Debug)]
pub struct Recording {
    pub kind: Kind,
    pub id: i64,
    /// Where it was recorded; the data sets number their places.
    pub location: Option<i64>,
    /// Frames a second.
    pub frame_rate: f64,
    /// m/s; `None` where there is none.
    pub speed_limit: Option<f64>,
    /// Lines of the road at the top of the picture, and at the bottom: y downwards, metres.
    pub markings: [Vec<f64>; 2],
    /// East and north of the origin in UTM, metres.
    pub origin: (f64, f64),
}

/// About a track.
#[derive(Debug, Clone)]
pub struct TrackMeta {
    pub kind: ObstacleType,
    /// Length and width, metres.
    pub size: (f64, f64),
    /// First and last frame.
    pub frames: (i64, i64),
    /// Where highD's driving directions lead, radians.
    pub heading: f64,
}

/// No such table is larger, bytes.
const LARGEST: u64 = 64 << 20;

/// Lines of a road in one direction.
const MOST_LINES: usize = 64;

/// A row by the names of its columns.
struct Fields<'r> {
    report: &'r Report,
    /// Names of columns that were asked for.
    used: RefCell<BTreeSet<String>>,
    separator: u8,
    header: Vec<String>,
    record: csv::StringRecord,
}

impl<'r> Fields<'r> {
    fn text(&self, name: &str) -> Option<&str> {
        if !self.used.borrow().contains(name) {
            self.used.borrow_mut().insert(name.to_string());
        }
        let place = self.header.iter().position(|n| n == name)?;
        self.record.get(place).map(str::trim)
    }

    fn at(&self, name: &str) -> At<'r> {
        let line = self.record.position().map_or(0, csv::Position::line);
        self.report
            .row(usize::try_from(line).unwrap_or(0), format!("column {name}"))
    }

    fn optional(&self, name: &str) -> Result<Option<f64>, ReadError> {
        let Some(text) = self.text(name).filter(|t| !t.is_empty()) else {
            return Ok(None);
        };
        let shown = || text.chars().take(40).collect::<String>();
        let value = rows::number(text, self.separator)
            .ok_or_else(|| self.at(name).fail(format!("`{}` is not a number", shown())));
        self.at(name).number(value?.0).map(Some)
    }

    fn number(&self, name: &str) -> Result<f64, ReadError> {
        self.optional(name)?
            .ok_or_else(|| self.at(name).fail("missing"))
    }

    fn integer(&self, name: &str) -> Result<i64, ReadError> {
        let value = self.number(name)?;
        if value.fract() == 0.0 && value.abs() < 1e9 {
            return Ok(value as i64);
        }
        Err(self
            .at(name)
            .fail(format!("`{value}` is not a whole number")))
    }
}

/// Gives the rows of a table to `take`; columns that it does not ask for are counted.
fn rows(
    path: &Path,
    report: &Report,
    leftovers: &mut Leftovers,
    take: &mut dyn FnMut(&Fields<'_>) -> Result<(), ReadError>,
) -> Result<(), ReadError> {
    let bytes = system::read_file(path, LARGEST).map_err(|e| ReadError::io(report.file(), &e))?;
    let decoded = String::from_utf8_lossy(&bytes);
    let text = decoded.trim_start_matches('\u{feff}');
    let (separator, header) = rows::columns_of(text.as_bytes());
    let mut table = csv::ReaderBuilder::new()
        .delimiter(separator)
        .flexible(true)
        .from_reader(text.as_bytes());
    let fail = |error: csv::Error| report.fail(error.to_string());
    let mut fields = Fields {
        report,
        used: RefCell::default(),
        separator,
        header,
        record: csv::StringRecord::new(),
    };
    let mut count = 0;
    while table.read_record(&mut fields.record).map_err(fail)? {
        let all = fields.record.iter().map(str::as_bytes);
        if let Some(why) = rows::too_long(all, fields.header.len()) {
            let line = fields.record.position().map_or(0, csv::Position::line);
            return Err(report.row(usize::try_from(line).unwrap_or(0), "").fail(why));
        }
        take(&fields)?;
        count += 1;
    }
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let end = stem.rsplit('_').next().unwrap_or_default();
    let used = fields.used.borrow();
    for name in fields.header.iter().filter(|name| !used.contains(*name)) {
        leftovers.add_times(&format!("{end}, column {name}"), count, || 1);
    }
    Ok(())
}

/// Reads `XX_recordingMeta.csv`.
pub fn recording(path: &Path, leftovers: &mut Leftovers) -> Result<Recording, ReadError> {
    let report = Report::about(path.display().to_string());
    let mut found = None;
    rows(path, &report, leftovers, &mut |row| {
        let highd = row.text("upperLaneMarkings").is_some();
        let lines = |name: &str| -> Result<Vec<f64>, ReadError> {
            let text = row.text(name).unwrap_or_default();
            let pieces = text.split([';', ' ']).filter(|t| !t.trim().is_empty());
            let count = pieces.clone().count();
            if count > MOST_LINES {
                let message = format!("{count} lines; a road has at most {MOST_LINES}");
                return Err(row.at(name).fail(message));
            }
            let mut numbers = pieces
                .map(|t| {
                    let value = rows::number(t, row.separator).ok_or_else(|| {
                        let shown: String = t.chars().take(40).collect();
                        row.at(name).fail(format!("`{shown}` is not a number"))
                    });
                    row.at(name).number(value?.0)
                })
                .collect::<Result<Vec<_>, _>>()?;
            numbers.sort_by(f64::total_cmp);
            Ok(numbers)
        };
        let frame_rate = row.number("frameRate")?;
        if !(0.1..=1000.0).contains(&frame_rate) {
            return Err(row
                .at("frameRate")
                .fail(format!("{frame_rate} frames a second")));
        }
        let id = match row.text("recordingId") {
            Some(_) => row.integer("recordingId")?,
            None => row.integer("id")?,
        };
        found = Some(Recording {
            kind: if highd { Kind::HighD } else { Kind::InD },
            id,
            location: row.optional("locationId")?.map(|id| id as i64),
            frame_rate,
            speed_limit: row.optional("speedLimit")?.filter(|limit| *limit > 0.0),
            markings: [lines("upperLaneMarkings")?, lines("lowerLaneMarkings")?],
            origin: (
                row.optional("xUtmOrigin")?.unwrap_or(0.0),
                row.optional("yUtmOrigin")?.unwrap_or(0.0),
            ),
        });
        Ok(())
    })?;
    found.ok_or_else(|| report.fail("no row about the recording"))
}

/// Reads `XX_tracksMeta.csv`.
pub fn tracks(
    path: &Path,
    recording: &Recording,
    leftovers: &mut Leftovers,
) -> Result<BTreeMap<i64, TrackMeta>, ReadError> {
    let report = Report::about(path.display().to_string());
    let mut tracks = BTreeMap::new();
    rows(path, &report, leftovers, &mut |row| {
        let highd = recording.kind == Kind::HighD;
        let id = row.integer(if highd { "id" } else { "trackId" })?;
        if id < 0 {
            return Err(row.at("id").fail(format!("track {id}")));
        }
        // highD's boxes lie along the road: their width is the length.
        let (length, width) = if highd {
            ("width", "height")
        } else {
            ("length", "width")
        };
        let at = row.at(length);
        let size = (at.size(row.number(length)?)?, at.size(row.number(width)?)?);
        let heading = match row.optional("drivingDirection")? {
            Some(1.0) => PI,
            _ => 0.0,
        };
        let meta = TrackMeta {
            kind: kind(row.text("class").unwrap_or_default()),
            size,
            frames: (row.integer("initialFrame")?, row.integer("finalFrame")?),
            heading,
        };
        match tracks.insert(id, meta) {
            None => Ok(()),
            Some(_) => Err(row.at("id").fail(format!("track {id} is there twice"))),
        }
    })?;
    Ok(tracks)
}

/// The kind of a class.
fn kind(class: &str) -> ObstacleType {
    match class.to_lowercase().as_str() {
        "car" | "van" => ObstacleType::Car,
        "truck" | "truck_bus" | "trailer" => ObstacleType::Truck,
        "bus" => ObstacleType::Bus,
        "motorcycle" => ObstacleType::Motorcycle,
        "bicycle" | "cyclist" => ObstacleType::Bicycle,
        "pedestrian" => ObstacleType::Pedestrian,
        _ => ObstacleType::Unknown,
    }
}
