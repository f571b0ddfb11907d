//! Generates a scenario's dangerous variant without a language model.

use std::sync::Arc;

use super::attack::AttackSetup;
use super::closed_loop_screening::NEAR_MISS;
use super::{
    AttackContext, AttackStyle, Change, ClosedLoop, Effort, Gate, Plausibility, Progress,
    RecordedMotions, SearchResult, SelectedAttack, choose, search_until,
};
use crate::scenario::Ego;
use crate::simulation::{Collision, Outcome};

/// A scenario whose ego has been driven once, ready to be attacked.
#[derive(Debug)]
pub struct VariantGenerator {
    /// What drives the ego, and its drive in the scenario as it was recorded.
    pub closed: ClosedLoop,
    /// The ego of that drive.
    pub ego: Ego,
    style: AttackStyle,
    /// Recorded motions of its scenario; `None` where no obstacle moves in it.
    recorded: Option<Arc<RecordedMotions>>,
}

/// The generated attacks and the chosen one.
#[derive(Debug, Default)]
pub struct Selection {
    /// Everything that was tried.
    pub found: SearchResult,
    /// What was taken.
    pub chosen: Option<SelectedAttack>,
}

/// Progress events of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SearchEvent {
    /// A round has ended.
    Round(Progress),
    /// Ways out of the best attacks are searched for.
    Certifying,
}

/// Why no variant can be generated.
#[derive(Debug, thiserror::Error)]
pub enum GeneratorError {
    /// An ego that stands cannot be attacked.
    #[error("the planned ego never moves, so there is nothing to attack")]
    Stands,
}

impl VariantGenerator {
    /// Attacks the ego that was driven in a closed loop.
    ///
    /// # Errors
    /// [`GeneratorError::Stands`].
    pub fn from_closed_loop(closed: ClosedLoop) -> Result<Self, GeneratorError> {
        let driver = closed.driver();
        let baseline = closed.baseline().drive();
        let ego = baseline.ego(driver.problem(), driver.settings());
        let recorded = RecordedMotions::of_scenario(closed.scenario()).map(Arc::new);
        let workshop = Self {
            recorded,
            closed,
            ego,
            style: AttackStyle::default(),
        };
        workshop.stage().ok_or(GeneratorError::Stands)?;
        Ok(workshop)
    }

    /// The same with attackers of a style.
    #[must_use]
    pub fn of_style(self, style: AttackStyle) -> Self {
        Self { style, ..self }
    }

    /// How attackers move.
    #[must_use]
    pub fn style(&self) -> AttackStyle {
        self.style
    }

    fn stage(&self) -> Option<AttackContext<'_>> {
        let scenario = self.closed.scenario();
        let stage = AttackContext::new(scenario, &self.ego.footprint, &self.ego.track)?;
        Some(AttackContext {
            // Who goes to the limits of a vehicle is not meant to drive like others.
            recorded: match self.style {
                AttackStyle::Human => self.recorded.clone(),
                AttackStyle::Limit => None,
            },
            ..stage.of_style(self.style)
        })
    }

    /// Gives the ground for attacks to `work`.
    ///
    /// # Errors
    /// The ego stands.
    pub fn on<T>(&self, work: impl FnOnce(&AttackSetup<'_>) -> T) -> Result<T, GeneratorError> {
        let stage = self.stage().ok_or(GeneratorError::Stands)?;
        let gate = self.gate();
        Ok(work(&AttackSetup {
            stage: &stage,
            gate: &gate,
            closed_loop: &self.closed,
        }))
    }

    /// How plausible a change is beside the recorded motions of the scenario; `None` where no obstacle moves in those.
    #[must_use]
    pub fn plausibility(&self, change: &Change) -> Option<(Plausibility, &RecordedMotions)> {
        let scenario = self.closed.scenario();
        let recorded = self.recorded.as_deref()?;
        let plausibility = recorded.plausibility(&change.motions, &scenario.network);
        Some((plausibility, recorded))
    }

    /// What every changed motion has to pass.
    #[must_use]
    pub fn gate(&self) -> Gate<'_> {
        Gate::new(self.closed.scenario())
            .with_ego(&self.ego)
            .of_style(self.style)
    }

    /// The contact that the ego has in the original scenario: then that is not safe, and nothing is to be made
    /// dangerous.
    #[must_use]
    pub fn unsafe_already(&self) -> Option<Collision> {
        match self.closed.baseline().drive().outcome {
            Outcome::Collision(collision) => Some(collision),
            _ => None,
        }
    }

    /// Whether no obstacle comes near to the ego in the original: it touches none, and no risk score in it is that of
    /// a near miss or lower. Otherwise that is no safe scenario, and what is made of it proves less.
    #[must_use]
    pub fn is_safe(&self) -> bool {
        let lowest = self.closed.baseline().lowest();
        self.unsafe_already().is_none() && lowest.is_none_or(|score| score > NEAR_MISS)
    }

    /// Searches, and takes the most dangerous attack that a good driver survives; `only` names the one obstacle that
    /// may attack. `watch` hears how far that is, and says whether to go on. Nothing is tried where the original is not
    /// safe.
    ///
    /// # Errors
    /// The ego stands.
    pub fn search(
        &self,
        effort: &Effort,
        only: Option<i64>,
        watch: &mut dyn FnMut(SearchEvent) -> bool,
    ) -> Result<Selection, GeneratorError> {
        if self.unsafe_already().is_some() {
            return Ok(Selection::default());
        }
        self.on(|ground| {
            let stop = || self.closed.driver().is_cancelled();
            let mut round = |progress| watch(SearchEvent::Round(progress));
            let found = search_until(ground, effort, only, &mut round, &stop);
            let chosen = match watch(SearchEvent::Certifying) {
                true => choose(&self.closed, &found.attacks, effort.delay),
                false => None,
            };
            Selection { found, chosen }
        })
    }
}
