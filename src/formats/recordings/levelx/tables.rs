//! The tables of a levelXdata recording: about it and its tracks (`XX_recordingMeta.csv`, `XX_tracksMeta.csv`), and `XX_tracks.csv`.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use std::io::{BufRead, BufReader};
use std::path::Path;

use csv::ByteRecord;
use nearmiss_base::geometry::{Point, Vector};
use nearmiss_base::system;
use nearmiss_scene::scenario::ObstacleType;

use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::assembly::{TrackState, signed_speed};
use crate::recordings::{At, Leftovers, Report, rows};

/// Which of the data sets: they differ in axes, points of reference and columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Upper left corners, y downwards, boxes along the road.
    HighD,
    /// Middles, y upwards, headings in degrees: inD, rounD, uniD and exiD.
    InD,
}

/// Columns of highD and of the others, in the order of [`Row`]'s fields.
const HIGHD: [&str; 10] = [
    "id",
    "frame",
    "x",
    "y",
    "",
    "width",
    "height",
    "xVelocity",
    "yVelocity",
    "laneId",
];

const IND: [&str; 9] = [
    "trackId",
    "frame",
    "xCenter",
    "yCenter",
    "heading",
    "length",
    "width",
    "xVelocity",
    "yVelocity",
];

/// What a table lacks that has the columns by which one knows a form of levelXdata: the form, and its other columns.
pub fn missing_columns(names: &[String]) -> Option<(&'static str, Vec<&'static str>)> {
    let has = |name: &&str| names.iter().any(|known| known == name);
    let forms = [
        ("highD", &["frame", "id", "x", "y", "xVelocity"], &HIGHD[..]),
        (
            "inD",
            &["frame", "trackId", "xCenter", "yCenter", "heading"],
            &IND[..],
        ),
    ];
    forms.into_iter().find_map(|(form, telling, all)| {
        let lacks = all
            .iter()
            .copied()
            .filter(|name| !name.is_empty() && !has(name));
        let lacks: Vec<&str> = lacks.collect();
        (telling.iter().all(has) && !lacks.is_empty()).then_some((form, lacks))
    })
}

impl Kind {
    /// That of a file that begins with `head`.
    pub fn detect(head: &[u8]) -> Option<Self> {
        Self::among(&rows::columns_of(head).1)
    }

    /// That of a table with these columns.
    fn among(names: &[String]) -> Option<Self> {
        let has = |all: &[&str]| {
            all.iter()
                .all(|n| n.is_empty() || names.iter().any(|name| name == n))
        };
        match () {
            () if has(&HIGHD) => Some(Self::HighD),
            () if has(&IND) => Some(Self::InD),
            () => None,
        }
    }

    /// The data set, as scenarios name their source.
    pub fn source(self) -> &'static str {
        match self {
            Self::HighD => "highD (levelXdata)",
            Self::InD => "inD, rounD, uniD or exiD (levelXdata)",
        }
    }

    /// The beginning of benchmark ids.
    pub fn prefix(self) -> &'static str {
        match self {
            Self::HighD => "DEU_HighD",
            Self::InD => "DEU_LevelX",
        }
    }
}

/// A track at a frame. The middle of its body, y upwards, whatever the file has.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    // Millions of rows are kept, and both numbers are below 10⁹.
    track: u32,
    frame: u32,
    pub x: f64,
    pub y: f64,
    /// Radians; of highD not a number, as it is the track's driving direction.
    heading: f64,
    velocity: Vector,
}

impl Row {
    /// Which track.
    pub fn track(&self) -> i64 {
        i64::from(self.track)
    }

    /// At which frame.
    pub fn frame(&self) -> i64 {
        i64::from(self.frame)
    }

    fn heading(&self, track: &TrackMeta) -> f64 {
        if self.heading.is_nan() {
            track.heading
        } else {
            self.heading
        }
    }

    /// As a state; the first step is at the frame `first`, and one is so many frames.
    pub fn state(&self, track: &TrackMeta, (first, frames): (i64, i64)) -> TrackState {
        let heading = self.heading(track);
        TrackState {
            step: (self.frame() - first) / frames,
            position: Point::new(self.x, self.y),
            heading,
            velocity: Some(signed_speed(heading, self.velocity.x, self.velocity.y)),
            acceleration: None,
        }
    }

    /// Everything that it says.
    pub fn bytes(&self) -> impl Iterator<Item = u8> {
        let heading = if self.heading.is_nan() {
            0.0
        } else {
            self.heading
        };
        let whole = [self.track(), self.frame()];
        let numbers = [self.x, self.y, self.velocity.x, self.velocity.y, heading];
        let whole = whole.into_iter().flat_map(i64::to_le_bytes);
        whole.chain(numbers.into_iter().flat_map(f64::to_le_bytes))
    }
}

/// Gives every row of a file to `take`, in the order of the file, and says how many numbers have a decimal comma. Columns
/// that are not used are counted.
///
/// # Errors
/// A column is missing, a value is no number, or `take` refuses a row: with the line.
pub fn each(
    path: &Path,
    report: &Report,
    leftovers: &mut Leftovers,
    take: &mut dyn FnMut(&Row) -> Result<(), ReadError>,
) -> Result<usize, ReadError> {
    let io = |error| ReadError::io(report.file(), &error);
    let mut file = BufReader::new(system::open_file(path).map_err(io)?);
    let (separator, names) = rows::columns_of(file.fill_buf().map_err(io)?);
    let kind = Kind::among(&names)
        .ok_or_else(|| report.row(1, "").fail("not the columns of levelXdata"))?;
    let place = |name: &&str| names.iter().position(|n| n == name).unwrap_or(usize::MAX);
    let places: Vec<usize> = kind_columns(kind).iter().map(place).collect();
    let mut table = csv::ReaderBuilder::new()
        .delimiter(separator)
        .flexible(true)
        .from_reader(file);
    let mut record = ByteRecord::new();
    let commas = Cell::new(0);
    let mut rows = 0;
    loop {
        let more = table.read_byte_record(&mut record);
        let line = || {
            record
                .position()
                .map_or(0, |p| usize::try_from(p.line()).unwrap_or(0))
        };
        match more {
            Ok(true) => rows += 1,
            Ok(false) => {
                let used = |name: &&String| kind_columns(kind).contains(&name.as_str());
                // That of the recording is known from its other table.
                for name in names.iter().filter(|n| !used(n) && *n != "recordingId") {
                    leftovers.add_times(&format!("column {name}"), rows, || 1);
                }
                return Ok(commas.get());
            }
            Err(error) => return Err(report.row(line(), "").fail(error.to_string())),
        }
        if record.len() > names.len()
            && let Some(why) = rows::too_long(record.iter(), names.len())
        {
            return Err(report.row(line(), "").fail(why));
        }
        let number = |i: usize| -> Result<f64, ReadError> {
            let at = |name: &str| report.row(line(), format!("column {name}"));
            let name = kind_columns(kind)[i];
            let Some(field) = record.get(places[i]) else {
                return Err(at(name).fail("the row ends before it; is the file truncated?"));
            };
            let text = std::str::from_utf8(field).unwrap_or("");
            match rows::number(text, separator) {
                Some((value, comma)) => {
                    commas.set(commas.get() + usize::from(comma));
                    if value.abs() < 1e6 {
                        Ok(value)
                    } else {
                        at(name).number(value)
                    }
                }
                None => Err(at(name).fail(format!(
                    "`{}` is not a number",
                    String::from_utf8_lossy(field)
                        .chars()
                        .take(40)
                        .collect::<String>()
                ))),
            }
        };
        let whole = |i: usize| -> Result<u32, ReadError> {
            let value = number(i)?;
            if value.fract() == 0.0 && (0.0..1e9).contains(&value) {
                return Ok(value as u32);
            }
            let at = report.row(line(), format!("column {}", kind_columns(kind)[i]));
            Err(at.fail(format!("`{value}` is not a whole number from 0")))
        };
        let (x, y) = (number(2)?, number(3)?);
        let velocity = Vector::new(number(7)?, number(8)?);
        let row = match kind {
            Kind::HighD => Row {
                track: whole(0)?,
                frame: whole(1)?,
                x: x + number(5)? / 2.0,
                y: -(y + number(6)? / 2.0),
                heading: f64::NAN,
                velocity: Vector::new(velocity.x, -velocity.y),
            },
            Kind::InD => Row {
                track: whole(0)?,
                frame: whole(1)?,
                x,
                y,
                heading: number(4)?.to_radians(),
                velocity,
            },
        };
        report.row(line(), "").point(row.x, row.y)?;
        take(&row)?;
    }
}

fn kind_columns(kind: Kind) -> &'static [&'static str] {
    match kind {
        Kind::HighD => &HIGHD,
        Kind::InD => &IND,
    }
}

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
fn each_line(
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
    each_line(path, &report, leftovers, &mut |row| {
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
    each_line(path, &report, leftovers, &mut |row| {
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
