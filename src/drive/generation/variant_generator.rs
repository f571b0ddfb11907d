//! Generates a scenario's dangerous variant without a language model.

use std::sync::Arc;

use super::attack::AttackSetup;
use super::attacker;
use super::closed_loop_screening::NEAR_MISS;
use super::staging;
use super::{
    AllowedAttacks, Attack, AttackContext, AttackStyle, Change, ClosedLoop, Effort, Gate,
    JointChange, Plausibility, Progress, RecordedMotions, SearchResult, SelectedAttack,
    StagedDrive,
};
use crate::simulation::{Collision, Outcome};
use nearmiss_scene::scenario::{Ego, Scenario};

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
        self.stage_with(self.closed.scenario(), &self.ego, None)
    }

    /// The stage for attacks on an ego in the scenario, in which others may attack already.
    pub(super) fn stage_with<'a>(
        &self,
        scenario: &'a Scenario,
        ego: &'a Ego,
        others: Option<(&'a Attack, &'a StagedDrive)>,
    ) -> Option<AttackContext<'a>> {
        let stage = AttackContext::new(scenario, &ego.footprint, &ego.track)?;
        Some(AttackContext {
            others,
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

    /// Why no motion was tried, with the obstacles that alone might attack, where some are named, and the wish for them.
    #[must_use]
    pub fn why_untried(&self, among: &[i64], wish: Option<&str>) -> String {
        let why = self.on(|ground| attacker::why_none(ground.stage, among));
        match (why, wish) {
            (Err(error), _) => error.to_string(),
            (Ok(Some(why)), _) if among.is_empty() => format!("no obstacle can attack: {why}"),
            (Ok(Some(why)), _) => {
                let ids: Vec<String> = among.iter().map(i64::to_string).collect();
                format!("{} cannot attack: {why}", ids.join(" and "))
            }
            (Ok(None), Some(wish)) => format!("no obstacle fits the wish: {wish}"),
            (Ok(None), None) => "no manoeuvre brings an obstacle to the ego".into(),
        }
    }

    /// How plausible a change is beside the recorded motions of the scenario; `None` where no obstacle moves in those.
    #[must_use]
    pub fn plausibility(&self, change: &JointChange) -> Option<(Plausibility, &RecordedMotions)> {
        self.plausibility_of(change.changes())
    }

    /// The same of one of several changes.
    #[must_use]
    pub fn plausibility_of(&self, changes: &[Change]) -> Option<(Plausibility, &RecordedMotions)> {
        let scenario = self.closed.scenario();
        let recorded = self.recorded.as_deref()?;
        let motions = changes.iter().map(|change| change.motions.as_slice());
        let plausibility = recorded.plausibility(motions, &scenario.network);
        Some((plausibility, recorded))
    }

    /// What every changed motion has to pass.
    #[must_use]
    pub fn gate(&self) -> Gate<'_> {
        self.gate_with(self.closed.scenario(), &self.ego)
    }

    /// The gate of the scenario, in which others may attack already, beside an ego.
    pub(super) fn gate_with<'a>(&self, scenario: &'a Scenario, ego: &'a Ego) -> Gate<'a> {
        Gate::new(scenario).with_ego(ego).of_style(self.style)
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

    /// Searches, and takes the most dangerous attack that a good driver survives, with as many attackers as it needs and
    /// the effort allows; only with what is allowed. `watch` hears how far that
    /// is, and says whether to go on. Nothing is tried where the original is not safe.
    ///
    /// # Errors
    /// The ego stands.
    pub fn search(
        &self,
        effort: &Effort,
        allowed: AllowedAttacks<'_>,
        watch: &mut dyn FnMut(SearchEvent) -> bool,
    ) -> Result<Selection, GeneratorError> {
        if self.unsafe_already().is_some() {
            return Ok(Selection::default());
        }
        self.stage().ok_or(GeneratorError::Stands)?;
        Ok(staging::search(self, effort, allowed, watch))
    }
}
