//! Where the motion of an ego comes from.

use std::path::Path;

/// Where an ego's motion comes from; shown wherever the ego is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum EgoSource {
    /// A recording, by its file name or bundled name.
    Recording(String),
    /// A log of the planner Frenetix, by its file name.
    Log(String),
    /// A CommonRoad solution.
    Solution {
        /// Its file name.
        file: String,
        /// Model and vehicle, e.g. `KS2`.
        vehicle: String,
        /// The planning problem that it solves.
        planning_problem: i64,
    },
    /// An obstacle of the scenario took the ego's place.
    Obstacle(i64),
    /// Driven by a planner, not recorded.
    Planned {
        /// The planner; `None` for nearmiss' own.
        planner: Option<String>,
        /// The vehicle, e.g. `BMW 320i`.
        vehicle: String,
        /// The forecast given to the planner, e.g. `lane`.
        forecast: String,
        /// The planning problem that it solves.
        planning_problem: i64,
    },
}

/// The obstacle that is the ego, as the store writes an ego; `None` if its motion comes from a file.
#[must_use]
pub fn obstacle_taken(ego: &str) -> Option<i64> {
    let (_, words) = ego.rsplit_once("obstacle ")?;
    words.strip_suffix(" taken as ego")?.parse().ok()
}

impl EgoSource {
    /// In a few words: of a path only the file's name.
    #[must_use]
    pub fn short(&self) -> String {
        let name = |path: &str| {
            let file = Path::new(path).file_name().map(|f| f.to_string_lossy());
            file.unwrap_or_default().into_owned()
        };
        let mut short = self.clone();
        if let Self::Recording(file) | Self::Log(file) | Self::Solution { file, .. } = &mut short {
            *file = name(file);
        }
        short.to_string()
    }
}

impl std::fmt::Display for EgoSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Recording(name) => write!(f, "recorded in {name}"),
            Self::Log(name) => write!(f, "driven by Frenetix in {name}"),
            Self::Solution {
                file,
                vehicle,
                planning_problem,
            } => write!(
                f,
                "solution {vehicle} of planning problem {planning_problem} in {file}"
            ),
            Self::Obstacle(id) => write!(f, "obstacle {id} taken as ego"),
            Self::Planned {
                planner,
                vehicle,
                forecast,
                planning_problem,
            } => write!(
                f,
                "planned by {} for problem {planning_problem} ({vehicle}, forecast {forecast})",
                planner.as_deref().unwrap_or("nearmiss")
            ),
        }
    }
}
