//! Ego trajectories as CSV, one row a step: reading and writing.

use std::collections::HashSet;

use super::table::{Table, finite, shown};
use super::{EgoError, Lines, assumed};
use nearmiss_base::geometry::{Footprint, Point, Shape, angle_between};
use nearmiss_scene::scenario::EgoSource;
use nearmiss_scene::scenario::plausibility::LATEST_STEP;
use nearmiss_scene::scenario::track::forget_headings_at_standstill;
use nearmiss_scene::scenario::{Diagnostic, Ego, Sample, Scenario, Severity, Track, VehicleType};

/// The vehicle whose size a recording gets that carries none: the one the paper's were made with.
pub const USUAL: VehicleType = VehicleType::Bmw320i;

/// Reads a recorded ego from CSV `bytes`, with the lines of its rows; `file` names it in errors. Where there are several
/// egos, it reads that of a planning problem.
///
/// Headings that are the directions of the displacements are held at standstill, where they are 0 or noise; before the
/// first movement they are the planning problem's. The size is that of the columns `length` and `width`, else of the vehicle the paper recorded
/// with.
///
/// # Errors
/// Missing columns, rows of another length, values that are not numbers, several egos, no rows: with file and line.
pub(super) fn read_chosen(
    bytes: &[u8],
    file: &str,
    scenario: &Scenario,
    planning_problem: Option<i64>,
) -> Result<(Ego, Lines), EgoError> {
    let mut diagnostics = Vec::new();
    let rows = rows(bytes, file, &mut diagnostics)?;
    let (id, rows) = choose(rows, file, planning_problem, &mut diagnostics)?;
    let mut seen = HashSet::new();
    if let Some(again) = rows.iter().find(|row| !seen.insert(row.sample.step)) {
        return Err(EgoError::Repeated {
            file: file.to_string(),
            line: again.line,
            step: again.sample.step,
        });
    }
    if rows.is_empty() {
        return Err(EgoError::Empty {
            file: file.to_string(),
        });
    }
    let steps: Vec<i64> = rows.iter().map(|row| row.sample.step).collect();
    diagnostics.extend(super::order(&steps, |row| rows[row].line));
    let size = rows[0].size;
    if let Some(other) = rows.iter().find(|row| row.size != size) {
        return Err(EgoError::OtherSize {
            file: file.to_string(),
            line: other.line,
        });
    }
    let lines = Lines::new(rows.iter().map(|row| (row.sample.step, row.line)));
    let mut samples: Vec<Sample> = rows.into_iter().map(|row| row.sample).collect();
    samples.sort_by_key(|s| s.step);
    let problem = scenario
        .planning_problems
        .iter()
        .find(|p| Some(p.id) == id)
        .or(scenario.planning_problems.first());
    let resting = problem
        .and_then(|p| p.initial.orientation)
        .map(|q| q.middle());
    let recorded = samples.clone();
    forget_headings_at_standstill(&mut samples);
    let footprint = match size {
        Some((length, width)) => Footprint::new(Shape::rectangle(length, width)).ok(),
        None => None,
    };
    if footprint.is_none() {
        diagnostics.push(usual_size());
    }
    let track = Track::new(samples, scenario.dt(), resting);
    let replaced = recorded.iter().filter(|sample| {
        let used = track.at(sample.step).map(|motion| motion.pose.heading);
        let (used, written) = (used.unwrap_or_default(), sample.heading);
        written.is_some_and(|written| angle_between(used, written).abs() > OTHER_HEADING)
    });
    if let steps @ 1.. = replaced.count() {
        let message = format!(
            "`orientation` is the direction of movement, which standstill has none of; held there (rows: {steps})"
        );
        diagnostics.push(assumed(Severity::Note, message));
    }
    let ego = Ego {
        id: id.or(problem.map(|p| p.id)).unwrap_or(0),
        source: EgoSource::Recording(file.to_string()),
        footprint: footprint.unwrap_or_else(|| USUAL.footprint()),
        track,
        recorded,
        diagnostics,
    };
    Ok((ego, lines))
}

/// Headings that differ by less are told as the same, radians.
const OTHER_HEADING: f64 = 0.01;

/// A diagnostic that the default vehicle size is assumed.
pub(super) fn usual_size() -> Diagnostic {
    let size = format!("no size given; assuming the default vehicle, {USUAL}");
    assumed(Severity::Note, size)
}

/// One row: its vehicle, if given, and its state.
struct Row {
    line: u64,
    id: Option<i64>,
    /// Length and width of the vehicle, metres.
    size: Option<(f64, f64)>,
    sample: Sample,
}

/// All rows, in the order of the file.
fn rows(bytes: &[u8], file: &str, diagnostics: &mut Vec<Diagnostic>) -> Result<Vec<Row>, EgoError> {
    let named = || file.to_string();
    let mut table = Table::begin(bytes, file, b',')?;
    let separators = |h: &String| h.chars().find(|c| matches!(c, ';' | '\t'));
    if let Some(separator) = table.header().first().and_then(separators) {
        return Err(EgoError::Separator {
            file: named(),
            separator: if separator == ';' { "`;`" } else { "tabs" },
        });
    }
    let mut column = |name| table.column(name, diagnostics);
    let missing = |column| EgoError::Column {
        file: named(),
        column,
    };
    let mut needed = |name| column(name)?.ok_or_else(|| missing(name));
    let (step, x, y) = (
        needed("timestep")?,
        needed("x_position")?,
        needed("y_position")?,
    );
    let (heading, velocity, acceleration) = (
        column("orientation")?,
        column("velocity")?,
        column("acceleration")?,
    );
    let id_column = column("ego_id")?;
    let size_columns = column("length")?.zip(column("width")?);
    let mut rows = Vec::new();
    while let Some(row) = table.next()? {
        table.check_length(&row)?;
        let line = row.line;
        let number = |place: usize, column: &'static str| {
            let value = finite(row.text(place)).ok_or_else(|| EgoError::Value {
                file: named(),
                line,
                column,
                value: shown(row.text(place)),
            })?;
            match column {
                // Time steps have their own diagnostics.
                "timestep" => Ok(value),
                _ => super::plausible_number(value, file, line, column),
            }
        };
        let given = |place: Option<usize>| place.filter(|p| !row.text(*p).is_empty());
        let optional = |place: Option<usize>, column: &'static str| {
            given(place).map(|p| number(p, column)).transpose()
        };
        let id = given(id_column).map(|place| {
            let text = row.text(place);
            // Tables of numbers write `7.0`.
            let id = text
                .parse()
                .ok()
                .or_else(|| finite(text).and_then(as_integer));
            id.ok_or_else(|| EgoError::Id {
                file: named(),
                line,
                value: shown(text),
            })
        });
        let at_step = as_integer(number(step, "timestep")?).ok_or_else(|| EgoError::Step {
            file: named(),
            line,
            column: "timestep",
            value: shown(row.text(step)),
        })?;
        let extent = |place: usize, column: &'static str| match number(place, column)? {
            value if value > 0.0 && value <= MAX_LENGTH => Ok(value),
            _ => Err(EgoError::Size {
                file: named(),
                line,
                column,
                value: shown(row.text(place)),
            }),
        };
        let size = size_columns
            .filter(|(l, w)| given(Some(*l)).is_some() && given(Some(*w)).is_some())
            .map(|(l, w)| Ok::<_, EgoError>((extent(l, "length")?, extent(w, "width")?)));
        rows.push(Row {
            line,
            id: id.transpose()?,
            size: size.transpose()?,
            sample: Sample {
                step: at_step,
                position: Point::new(number(x, "x_position")?, number(y, "y_position")?),
                heading: optional(heading, "orientation")?,
                velocity: optional(velocity, "velocity")?,
                acceleration: optional(acceleration, "acceleration")?,
            },
        });
    }
    diagnostics.extend(table.unused(rows.len()));
    Ok(rows)
}

/// No vehicle is longer or wider, metres.
const MAX_LENGTH: f64 = 100.0;

/// Most egos listed in the message that asks for a choice.
const MAX_LISTED: usize = 12;

/// The rows of one ego, and its id. Rows without an id are those of the only one.
fn choose(
    rows: Vec<Row>,
    file: &str,
    planning_problem: Option<i64>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<(Option<i64>, Vec<Row>), EgoError> {
    let mut seen = HashSet::new();
    let ids = rows.iter().filter_map(|row| row.id);
    let ids: Vec<i64> = ids.filter(|id| seen.insert(*id)).collect();
    if ids.len() < 2 {
        return Ok((ids.first().copied(), rows));
    }
    let known = || {
        let mut known: Vec<String> = ids.iter().take(MAX_LISTED).map(i64::to_string).collect();
        if ids.len() > MAX_LISTED {
            known.push(format!("and {} more", ids.len() - MAX_LISTED));
        }
        known.join(", ")
    };
    let file = file.to_string();
    let Some(problem) = planning_problem else {
        let known = known();
        return Err(EgoError::Several { file, known });
    };
    if !seen.contains(&problem) {
        let known = known();
        return Err(EgoError::NoSuchProblem {
            file,
            problem,
            known,
        });
    }
    let all = rows.len();
    let own: Vec<Row> = rows.into_iter().filter(|r| r.id == Some(problem)).collect();
    let message = format!(
        "{} rows of other egos ({}) were left out",
        all - own.len(),
        known()
    );
    diagnostics.push(assumed(Severity::Note, message));
    Ok((Some(problem), own))
}

/// A time step; `None` for fractions and for what no scenario reaches.
pub(super) fn as_integer(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() <= LATEST_STEP as f64).then_some(value as i64)
}

/// An ego's motion as CSV, a row for every recorded step; [`super::read_ego`] reads it back.
///
/// `id` is that of the planning problem. Positions are the centre of the vehicle, metres; headings radians;
/// velocities m/s and accelerations m/s² along the heading.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write_recording(id: i64, track: &Track) -> Result<Vec<u8>, csv::Error> {
    written(id, track, None)
}

/// The same with the length and width of the vehicle, metres.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write_sized_recording(
    id: i64,
    track: &Track,
    size: (f64, f64),
) -> Result<Vec<u8>, csv::Error> {
    written(id, track, Some(size))
}

fn written(id: i64, track: &Track, size: Option<(f64, f64)>) -> Result<Vec<u8>, csv::Error> {
    let mut out = csv::Writer::from_writer(Vec::new());
    let size_columns: &[&str] = if size.is_some() {
        &["length", "width"]
    } else {
        &[]
    };
    let columns = [
        "ego_id",
        "timestep",
        "x_position",
        "y_position",
        "orientation",
        "velocity",
        "acceleration",
    ];
    out.write_record(columns.iter().chain(size_columns))?;
    for (step, motion) in track.iter() {
        let pose = motion.pose;
        let size = size
            .iter()
            .flat_map(|(l, w)| [l.to_string(), w.to_string()]);
        let values = [
            id.to_string(),
            step.to_string(),
            pose.position.x.to_string(),
            pose.position.y.to_string(),
            pose.heading.to_string(),
            motion.velocity.to_string(),
            motion.acceleration.to_string(),
        ];
        out.write_record(values.into_iter().chain(size))?;
    }
    out.into_inner().map_err(|e| e.into_error().into())
}
