//! Ego trajectories as CSV: a row a step, read and written.

use super::{EgoError, EgoSource, assumed};
use crate::geometry::Point;
use crate::scenario::track::forget_headings_at_standstill;
use crate::scenario::{Ego, Sample, Scenario, Severity, Track, VehicleType};

/// The vehicle whose size a recording gets that carries none: the one the paper's were made with.
pub(super) const USUAL: VehicleType = VehicleType::Bmw320i;

/// Reads a recorded ego from CSV `bytes`; `file` names it in errors.
///
/// The heading is held at standstill, where recorders write 0 or noise; before the first movement it is
/// the planning problem's. The size is that of the vehicle the paper recorded with.
///
/// # Errors
/// Missing columns, values that are not numbers, no rows: with file and line.
pub fn read_recording(bytes: &[u8], file: &str, scenario: &Scenario) -> Result<Ego, EgoError> {
    let named = || file.to_string();
    let csv_error = |e: csv::Error| EgoError::Csv {
        file: named(),
        message: e.to_string(),
    };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let header = reader.headers().map_err(csv_error)?.clone();
    if let Some(separator) = header
        .get(0)
        .and_then(|h| h.chars().find(|c| matches!(c, ';' | '\t')))
    {
        return Err(EgoError::Separator {
            file: named(),
            separator: if separator == ';' { "`;`" } else { "tabs" },
        });
    }
    let column = |name: &'static str| header.iter().position(|h| h == name);
    let needed = |name| {
        column(name).ok_or(EgoError::Column {
            file: named(),
            column: name,
        })
    };
    let (step, x, y) = (
        needed("timestep")?,
        needed("x_position")?,
        needed("y_position")?,
    );
    let (heading, velocity, acceleration) = (
        column("orientation"),
        column("velocity"),
        column("acceleration"),
    );
    let id_column = column("ego_id");

    let (mut samples, mut seen) = (Vec::new(), std::collections::HashSet::new());
    let mut id = None;
    for row in reader.records() {
        let row = row.map_err(csv_error)?;
        let line = row.position().map_or(0, csv::Position::line);
        let number = |place: usize, column: &'static str| {
            let text = row.get(place).unwrap_or("");
            text.parse::<f64>()
                .ok()
                .filter(|v| v.is_finite())
                .ok_or_else(|| EgoError::Value {
                    file: named(),
                    line,
                    column,
                    value: text.chars().take(40).collect(),
                })
        };
        let optional = |place: Option<usize>, column: &'static str| {
            let given = place.filter(|&p| row.get(p).is_some_and(|t| !t.is_empty()));
            given.map(|p| number(p, column)).transpose()
        };
        id = id.or(optional(id_column, "ego_id")?.map(|v| v as i64));
        let step = whole(number(step, "timestep")?).ok_or_else(|| EgoError::Step {
            file: named(),
            line,
            column: "timestep",
            value: row.get(step).unwrap_or("").chars().take(40).collect(),
        })?;
        if !seen.insert(step) {
            return Err(EgoError::Repeated {
                file: named(),
                line,
                step,
            });
        }
        samples.push(Sample {
            step,
            position: Point::new(number(x, "x_position")?, number(y, "y_position")?),
            heading: optional(heading, "orientation")?,
            velocity: optional(velocity, "velocity")?,
            acceleration: optional(acceleration, "acceleration")?,
        });
    }
    if samples.is_empty() {
        return Err(EgoError::Empty { file: named() });
    }
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
    let size = format!("no size in it: taken to be that of the usual vehicle, {USUAL}");
    Ok(Ego {
        id: id.or(problem.map(|p| p.id)).unwrap_or(0),
        source: EgoSource::Recording(named()),
        footprint: USUAL.footprint(),
        track: Track::new(samples, scenario.dt(), resting),
        recorded,
        diagnostics: vec![assumed(Severity::Note, size)],
    })
}

/// A time step; nothing for fractions and for what no scenario reaches.
pub(super) fn whole(value: f64) -> Option<i64> {
    (value.fract() == 0.0 && value.abs() <= 1e9).then_some(value as i64)
}

/// An ego's motion as CSV, a row for every recorded step; [`read_recording`] reads it back.
///
/// `id` is that of the planning problem. Positions are the centre of the vehicle, metres; headings radians;
/// velocities m/s and accelerations m/s² along the heading.
///
/// # Errors
/// None in practice: writing goes to memory.
pub fn write_recording(id: i64, track: &Track) -> Result<Vec<u8>, csv::Error> {
    let mut out = csv::Writer::from_writer(Vec::new());
    out.write_record([
        "ego_id",
        "timestep",
        "x_position",
        "y_position",
        "orientation",
        "velocity",
        "acceleration",
    ])?;
    for (step, motion) in track.iter() {
        let pose = motion.pose;
        out.write_record([
            id.to_string(),
            step.to_string(),
            pose.position.x.to_string(),
            pose.position.y.to_string(),
            pose.heading.to_string(),
            motion.velocity.to_string(),
            motion.acceleration.to_string(),
        ])?;
    }
    out.into_inner().map_err(|e| e.into_error().into())
}
