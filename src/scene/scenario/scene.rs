//! A scenario with its ego: what every measure, description and judge looks at.

use std::sync::Arc;

use super::{Diagnostic, EgoSource, Motion, Obstacle, ObstacleRole, Sample, Scenario, Track};
use nearmiss_base::geometry::{Footprint, Placed};

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
            let mut known: Vec<String> = scenario
                .obstacles
                .iter()
                .take(12)
                .map(|o| o.id.to_string())
                .collect();
            if scenario.obstacles.len() > known.len() {
                known.push("…".into());
            }
            let known = if known.is_empty() {
                "none".into()
            } else {
                known.join(", ")
            };
            return Err(SceneError::NoSuchObstacle { id, known });
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
