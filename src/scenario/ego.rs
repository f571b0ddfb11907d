//! Recorded ego trajectories: where they lie beside a scenario, and how they are read.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::track::forget_headings_at_standstill;
use super::{Ego, Sample, Scenario, Track, commonroad};
use crate::geometry::{Footprint, Point, Shape};

/// Where an ego's motion comes from; shown wherever the ego is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EgoSource {
    /// A recording, by its file name or bundled name.
    Recording(String),
    /// An obstacle of the scenario took the ego's place.
    Obstacle(i64),
}

impl EgoSource {
    /// In a few words: of a path only the file's name.
    #[must_use]
    pub fn short(&self) -> String {
        match self {
            Self::Recording(name) => {
                let file = Path::new(name).file_name().map(|f| f.to_string_lossy());
                format!("recorded in {}", file.unwrap_or_default())
            }
            Self::Obstacle(_) => self.to_string(),
        }
    }
}

impl std::fmt::Display for EgoSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Recording(name) => write!(f, "recorded in {name}"),
            Self::Obstacle(id) => write!(f, "obstacle {id} taken as ego"),
        }
    }
}

/// Why an ego could not be read.
#[derive(Debug, thiserror::Error)]
pub enum EgoError {
    /// The file cannot be opened or read.
    #[error("{file}: {source}")]
    Io {
        /// Which file.
        file: String,
        /// What the system said.
        source: std::io::Error,
    },
    /// A column that is needed is not in the header.
    #[error(
        "{file}: line 1 has no column `{column}`; an ego trajectory has at least timestep, x_position and y_position"
    )]
    Column {
        /// Which file.
        file: String,
        /// Which column.
        column: &'static str,
    },
    /// A value is not a number.
    #[error("{file}: line {line}: column `{column}` is `{value}`, a finite number is needed")]
    Value {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which column.
        column: &'static str,
        /// What stands there.
        value: String,
    },
    /// The file is not CSV.
    #[error("{file}: {message}")]
    Csv {
        /// Which file.
        file: String,
        /// What is wrong, with the line.
        message: String,
    },
    /// A time step stands twice.
    #[error("{file}: line {line}: time step {step} was there before; every step has one row")]
    Repeated {
        /// Which file.
        file: String,
        /// Line from 1.
        line: u64,
        /// Which step.
        step: i64,
    },
    /// The file has a header and nothing else.
    #[error("{file}: no rows, so there is no ego in it")]
    Empty {
        /// Which file.
        file: String,
    },
}

/// Size of the recorded egos (BMW 320i, CommonRoad vehicle 2), metres. Recordings do not carry it.
const EGO_LENGTH: f64 = 4.508;
const EGO_WIDTH: f64 = 1.610;

const RECORDING: &str = "ego_trajectory.csv";

/// The recording that belongs to the scenario at `path`, if there is one.
///
/// Looked for as `NAME.ego_trajectory.csv` beside the scenario, in a folder `NAME` beside it, and where
/// the repository of "From Words to Collisions" keeps them: `Results/output_validation*/NAME` for
/// `Scenarios/*_scenarios`, and `Generation/Metrices/NAME` for `Generation/NAME`. A bare
/// `ego_trajectory.csv` counts where the scenario is the only one in its folder.
#[must_use]
pub fn find_recording(path: &Path) -> Option<PathBuf> {
    let name = &commonroad::scenario_name(path);
    let folder = path.parent()?;
    let mut candidates = vec![
        folder.join(format!("{name}.{RECORDING}")),
        folder.join(name).join(RECORDING),
    ];
    let parent = folder.parent();
    if let (Some(parent), Some(kind)) = (parent, folder.file_name().and_then(|f| f.to_str())) {
        let results = match kind {
            "normal_scenarios" => "output_validation_normal",
            _ => "output_validation",
        };
        if let Some(root) = parent.parent() {
            candidates.push(
                root.join("Results")
                    .join(results)
                    .join(name)
                    .join(RECORDING),
            );
        }
        candidates.push(parent.join("Metrices").join(name).join(RECORDING));
    }
    candidates.into_iter().find(|c| c.is_file()).or_else(|| {
        alone(folder)
            .then(|| folder.join(RECORDING))
            .filter(|c| c.is_file())
    })
}

/// Whether a folder holds exactly one scenario, be it in several files or formats.
fn alone(folder: &Path) -> bool {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries.map(|e| e.path());
    let (protobuf, others): (Vec<_>, Vec<_>) =
        paths.partition(|path| commonroad::is_protobuf_name(path));
    let xml = others
        .iter()
        .filter(|path| path.extension().is_some_and(|x| x == "xml"));
    let protobuf = commonroad::protobuf_scenarios(protobuf);
    let names: HashSet<_> = xml
        .chain(&protobuf)
        .map(|path| commonroad::scenario_name(path))
        .collect();
    names.len() == 1
}

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
        let step = number(step, "timestep")? as i64;
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
    let footprint = Footprint::new(Shape::rectangle(EGO_LENGTH, EGO_WIDTH))
        .expect("the recorded vehicle's size is positive");
    Ok(Ego {
        id: id.or(problem.map(|p| p.id)).unwrap_or(0),
        source: EgoSource::Recording(named()),
        footprint,
        track: Track::new(samples, scenario.dt(), resting),
        recorded,
    })
}
