//! A scenario with its ego, which every measure, description and judge looks at, and windows of its steps.

use std::ops::{Range, RangeInclusive};
use std::path::Path;
use std::sync::Arc;

use nearmiss_base::geometry::{Footprint, Placed};

use super::{
    Diagnostic, Motion, Obstacle, ObstacleParts, ObstacleRole, ObstacleType, Position, Prediction,
    Quantity, Sample, Scenario, State, Steps, Track, VehicleType,
};

/// The vehicle whose safety is in question.
#[derive(Debug, Clone, PartialEq)]
pub struct Ego {
    /// Id of its planning problem, or of the obstacle it was.
    pub id: i64,
    /// Where its motion comes from.
    pub source: EgoSource,
    /// The region it covers.
    pub footprint: Footprint,
    /// Its motion.
    pub track: Track,
    /// The rows of the recording as they were read, before any gap was filled.
    pub recorded: Vec<Sample>,
    /// What was assumed while reading it: its size, and what is doubtful about it.
    pub diagnostics: Vec<Diagnostic>,
}

impl std::fmt::Display for Ego {
    /// Its id and where its motion comes from, the same wherever the files lie.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}, {}", self.id, self.source.short())
    }
}

/// A scenario and an ego in it. Cheap to share, never changed.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The road network and the obstacles.
    pub scenario: Arc<Scenario>,
    /// The ego.
    pub ego: Ego,
}

/// Why there is no scene.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// No obstacle has this id.
    #[error("no obstacle {id} in the scenario; it has {known}")]
    NoSuchObstacle {
        /// The id asked for.
        id: i64,
        /// Some that exist.
        known: String,
    },
    /// The obstacle cannot be an ego.
    #[error("obstacle {id} cannot be the ego: {why}")]
    NotAnEgo {
        /// Which one.
        id: i64,
        /// What it lacks.
        why: &'static str,
    },
}

/// One other participant with a body, seen from a scene.
#[derive(Debug, Clone, Copy)]
pub struct Participant<'a> {
    /// Who.
    pub obstacle: &'a Obstacle,
    /// The region it covers.
    pub footprint: &'a Footprint,
}

impl<'a> Participant<'a> {
    /// Its motion at a step; static obstacles stand at all times.
    #[must_use]
    pub fn at(&self, step: i64) -> Option<&'a Motion> {
        self.obstacle.motion_at(step)
    }

    /// Its body at a step.
    #[must_use]
    pub fn placed_at(&self, step: i64) -> Option<Placed<'a>> {
        Some(self.footprint_at(step).at(self.at(step)?.pose))
    }

    /// The region it covers at a step, in its own frame.
    #[must_use]
    pub fn footprint_at(&self, step: i64) -> &'a Footprint {
        self.obstacle.footprint_at(step).unwrap_or(self.footprint)
    }
}

impl Scene {
    /// `scenario` with an ego that was recorded or made.
    ///
    /// ```
    /// use nearmiss_formats::bundled;
    /// use nearmiss_scene::scenario::Scene;
    ///
    /// let entry = &bundled()[0];
    /// let scenario = entry.read()?;
    /// let ego = entry.recorded_ego(&scenario)?.expect("recorded beside it");
    /// let scene = Scene::new(scenario, ego);
    /// assert!(scene.ego_at(0).is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn new(scenario: Arc<Scenario>, ego: Ego) -> Self {
        let scenario = match ego.source {
            EgoSource::Obstacle(_) => scenario.for_taken_ego(),
            _ => scenario,
        };
        Self { scenario, ego }
    }

    /// `scenario` with one of its obstacles as the ego.
    ///
    /// # Errors
    /// There is no such obstacle, or it has no body or does not move.
    pub fn with_obstacle_as_ego(scenario: Arc<Scenario>, id: i64) -> Result<Self, SceneError> {
        let Some(obstacle) = scenario.obstacle(id) else {
            return Err(scenario.no_such_obstacle(id));
        };
        let refuse = |why| SceneError::NotAnEgo { id, why };
        if obstacle.is_set_based() {
            return Err(refuse("its motion is an occupancy set"));
        }
        let footprint = obstacle.footprint.clone().ok_or(refuse("no shape"))?;
        if obstacle.role != ObstacleRole::Dynamic || obstacle.track().iter().count() < 2 {
            return Err(refuse("no trajectory"));
        }
        let ego = Ego {
            id,
            source: EgoSource::Obstacle(id),
            footprint,
            track: obstacle.track().clone(),
            recorded: Vec::new(),
            diagnostics: Vec::new(),
        };
        Ok(Self::new(scenario, ego))
    }

    /// The steps of the ego, first to last.
    #[must_use]
    pub fn steps(&self) -> std::ops::Range<i64> {
        self.ego.track.steps()
    }

    /// The last step of the ego.
    #[must_use]
    pub fn last_step(&self) -> i64 {
        self.steps().end - 1
    }

    /// Seconds since time step 0.
    #[must_use]
    pub fn time_of(&self, step: i64) -> f64 {
        step as f64 * self.scenario.dt()
    }

    /// The obstacles with a body other than the ego, in the file's order.
    pub fn participants(&self) -> impl Iterator<Item = Participant<'_>> {
        let taken = match self.ego.source {
            EgoSource::Obstacle(id) => Some(id),
            _ => None,
        };
        self.scenario.obstacles.iter().filter_map(move |obstacle| {
            let bodily = matches!(obstacle.role, ObstacleRole::Static | ObstacleRole::Dynamic);
            let footprint = obstacle.any_footprint()?;
            (bodily && Some(obstacle.id) != taken).then_some(Participant {
                obstacle,
                footprint,
            })
        })
    }

    /// The ego's body at a step.
    #[must_use]
    pub fn ego_at(&self, step: i64) -> Option<Placed<'_>> {
        Some(
            self.ego_footprint_at(step)
                .at(self.ego.track.at(step)?.pose),
        )
    }

    /// What the ego is; a car where nothing says otherwise.
    #[must_use]
    pub fn ego_kind(&self) -> ObstacleType {
        let recorded = self.scenario.recorded_ego.as_ref().map(|own| &own.obstacle);
        let known = match &self.ego.source {
            EgoSource::Obstacle(id) => self.scenario.obstacle(*id),
            EgoSource::Recording(_) => recorded.filter(|own| own.id == self.ego.id),
            EgoSource::Solution { vehicle, .. } | EgoSource::Planned { vehicle, .. } => {
                let truck = VehicleType::Truck;
                let is_truck = vehicle.ends_with(&truck.number().to_string())
                    || vehicle.as_str() == truck.name();
                return if is_truck {
                    ObstacleType::Truck
                } else {
                    ObstacleType::Car
                };
            }
            EgoSource::Log(_) => None,
        };
        known.map_or(ObstacleType::Car, |obstacle| obstacle.kind)
    }

    /// The region the ego covers at a step, in its own frame.
    #[must_use]
    pub fn ego_footprint_at(&self, step: i64) -> &Footprint {
        let obstacle = match self.ego.source {
            EgoSource::Obstacle(id) => self.scenario.obstacle(id),
            _ => None,
        };
        obstacle
            .and_then(|o| o.footprint_at(step))
            .unwrap_or(&self.ego.footprint)
    }
}

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

/// The track that is the ego of a recording, as long as no other is chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedEgo {
    /// The track, with its size; its id is that of its planning problem too.
    pub obstacle: Obstacle,
    /// The file, as messages name it.
    pub file: String,
}

impl RecordedEgo {
    /// It as the ego; `None` if it has no body.
    #[must_use]
    pub fn ego(&self) -> Option<Ego> {
        Some(Ego {
            id: self.obstacle.id,
            source: EgoSource::Recording(self.file.clone()),
            footprint: self.obstacle.footprint.clone()?,
            track: self.obstacle.track().clone(),
            recorded: Vec::new(),
            diagnostics: Vec::new(),
        })
    }
}

impl Scenario {
    /// That no obstacle has this id, with some that there are.
    pub(super) fn no_such_obstacle(&self, id: i64) -> SceneError {
        let obstacles = self.obstacles.iter().take(12);
        let mut known: Vec<String> = obstacles.map(|o| o.id.to_string()).collect();
        if self.obstacles.len() > known.len() {
            known.push("…".into());
        }
        if known.is_empty() {
            known.push("none".into());
        }
        SceneError::NoSuchObstacle {
            id,
            known: known.join(", "),
        }
    }

    /// The scenario for an ego that is one of its obstacles: the recording's own ego is an obstacle then, as any other.
    pub(super) fn for_taken_ego(self: Arc<Self>) -> Arc<Self> {
        if self.recorded_ego.is_none() {
            return self;
        }
        let mut scenario = Arc::unwrap_or_clone(self);
        let own = scenario.recorded_ego.take().map(|own| own.obstacle);
        scenario.obstacles.extend(own);
        Arc::new(scenario)
    }
}

impl Obstacle {
    /// The same obstacle with another motion from the first of `motions` on, time steps in order: that one is the
    /// recorded state it departs from, what was recorded before stays, what was recorded after is gone. Nothing for
    /// obstacles that do not move, or are absent at that step.
    ///
    /// Changed states say position, orientation, velocity and acceleration; what else the recorded ones said (yaw
    /// rates, steering angles, signals) would not be true of them and is left out.
    #[must_use]
    pub fn departing(&self, motions: &[(i64, Motion)], dt: f64) -> Option<Self> {
        let (from, _) = *motions.first()?;
        let initial = self.initial.clone()?;
        if self.role != ObstacleRole::Dynamic || self.track().at(from).is_none() {
            return None;
        }
        let kept = self.states().skip(1).filter(|s| s.time.from <= from);
        let new = motions.iter().skip(1).map(|(step, m)| state(*step, m));
        let states = kept.cloned().chain(new).collect();
        Some(self.with_states(initial, states, from, dt))
    }

    /// The same obstacle with another motion from beginning to end, time steps in order. Nothing for obstacles that do not
    /// move, and of no motion.
    #[must_use]
    pub fn moving(&self, motions: &[(i64, Motion)], dt: f64) -> Option<Self> {
        let ((first, begin), rest) = motions.split_first()?;
        let states = rest.iter().map(|(step, m)| state(*step, m)).collect();
        let moves = self.role == ObstacleRole::Dynamic;
        moves.then(|| self.with_states(state(*first, begin), states, *first - 1, dt))
    }

    /// With other states, and its signals until a step.
    fn with_states(&self, initial: State, states: Vec<State>, until: i64, dt: f64) -> Self {
        let signals = self.signals.iter().filter(|s| s.time.to <= until);
        Self::new(
            ObstacleParts {
                id: self.id,
                role: self.role,
                kind: self.kind,
                footprint: self.footprint.clone(),
                initial: Some(initial),
                prediction: Prediction::Trajectory(states),
                signals: signals.cloned().collect(),
            },
            dt,
        )
    }
}

fn state(step: i64, motion: &Motion) -> State {
    State {
        position: Some(Position::Point(motion.pose.position)),
        orientation: Some(Quantity::Exact(motion.pose.heading)),
        velocity: Some(Quantity::Exact(motion.velocity)),
        acceleration: Some(Quantity::Exact(motion.acceleration)),
        ..State::at(Steps::exact(step))
    }
}

/// Where the window of a question ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowEnd {
    /// With the recording.
    Recording,
    /// At the present step.
    Present,
    /// With the recording, and it begins with it.
    Whole,
}

/// How the window of a question is chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WindowRule {
    /// Where it ends.
    pub end: WindowEnd,
    /// How many steps it has, where the recording has as many.
    pub history: usize,
}

impl WindowRule {
    /// The window of a question that is asked at the present step.
    #[must_use]
    pub fn at(&self, scene: &Scene, present: i64) -> Window {
        let last = match self.end {
            WindowEnd::Whole => return Window::full(scene),
            WindowEnd::Recording => scene.last_step(),
            WindowEnd::Present => present,
        };
        Window::ending_at(scene, last, self.history)
    }
}

/// Consecutive time steps, ends included; never empty, always inside the ego's recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Window {
    first: i64,
    last: i64,
}

impl Window {
    /// Steps that a recording goes on after the window of the safety task, as in "From Words to Collisions".
    pub const AFTER_SAFETY: i64 = 2;

    /// `history` steps (at least one) that end at `last`, cut to the ego's recording.
    #[must_use]
    pub fn ending_at(scene: &Scene, last: i64, history: usize) -> Self {
        Self::within(&scene.steps(), last, history)
    }

    /// Every step of the ego's recording.
    #[must_use]
    pub fn full(scene: &Scene) -> Self {
        Self::ending_at(scene, scene.last_step(), usize::MAX)
    }

    /// The same, cut to these steps.
    #[must_use]
    pub fn within(steps: &Range<i64>, last: i64, history: usize) -> Self {
        let last = last.clamp(steps.start, (steps.end - 1).max(steps.start));
        let before = i64::try_from(history.max(1) - 1).unwrap_or(i64::MAX);
        Self {
            first: last.saturating_sub(before).max(steps.start),
            last,
        }
    }

    /// The first step.
    #[must_use]
    pub fn first(&self) -> i64 {
        self.first
    }

    /// The last step: the present of a judgement.
    #[must_use]
    pub fn last(&self) -> i64 {
        self.last
    }

    /// Every step.
    #[must_use]
    pub fn steps(&self) -> RangeInclusive<i64> {
        self.first..=self.last
    }
}
