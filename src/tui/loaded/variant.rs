//! A scenario that was made dangerous, with all that is known about it, and the original to compare it with.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::authorship::{Authorship, Writer, Writing};
use super::generated::GenerationProgress;
use super::planned::Recorder;
use super::{CycleShown, Opened, Planned};
use crate::formats::Entry;
use crate::formats::commonroad;
use crate::generation::attacker::Candidate;
use crate::generation::{
    Avoidability, Change, ClosedLoop, Effect, Passed, Progress, Refusal, Variant,
};
use crate::metrics::Thresholds;
use crate::planner::{Cancel, Forecast};
use crate::scenario::{ContentHash, Scene, Transform};
use crate::verdict::Motion;
use crate::workflow::PreparedPlan;

/// What is to be made.
#[derive(Debug, Clone)]
pub struct VariantRequest {
    /// Of which scenario.
    pub entry: Entry,
    /// What of it is changed before.
    pub change: Option<Transform>,
    /// What the planner is told.
    pub forecast: Forecast,
    /// The one obstacle that may attack; anybody where none is named.
    pub only: Option<i64>,
    /// Of the random numbers of a search.
    pub seed: u64,
    /// The model that thinks of the attack, in place of a search.
    pub writer: Option<Box<Writer>>,
    /// Where it would be saved, which decides its name; the current folder if none.
    pub folder: Option<PathBuf>,
}

/// What is being done about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Working {
    /// The ego is planned in the original: so many steps, of so many at most.
    Driving(usize, usize),
    /// Attacks are searched for: how far that is, and how many motions there are to try.
    Searching(Progress, usize),
    /// A model chooses the attacker and writes motions.
    Writing(Writing),
    /// The ego is driven against motions that a model wrote: so many are done, of so many.
    Trying(usize, usize),
    /// Ways out of the best attacks are searched for.
    Proving,
    /// The ego is planned in the variant: so many steps, of so many at most.
    Showing(usize, usize),
}

/// Everything that is known about a variant.
#[derive(Debug)]
pub struct Made {
    /// The original scenario and the ego's drive in it.
    pub closed: ClosedLoop,
    /// What was asked of the attacker.
    pub asked: Motion,
    /// What it does.
    pub change: Change,
    /// What that leads to.
    pub effect: Effect,
    /// Whether a good driver avoids it.
    pub avoidability: Avoidability,
    /// What the gate held it against.
    pub passed: Passed,
    /// What was refused on the way.
    pub refused: Vec<Refusal>,
    /// How far the search had come.
    pub progress: Progress,
    /// The one obstacle that was allowed to attack.
    pub only: Option<i64>,
    /// Who could attack, by the reference, the least change first.
    pub ranked: Vec<Candidate>,
    /// Who thought of it.
    pub by: String,
    /// What the model chose and wrote, where one did.
    pub authorship: Option<Arc<Authorship>>,
    /// The same as its papers have it.
    pub author: Option<serde_json::Value>,
}

/// A variant that is shown, or the original beside it.
#[derive(Debug, Clone)]
pub struct VariantShown {
    /// The variant.
    pub made: Arc<Made>,
    /// Whether the variant is shown, and not the original.
    pub changed: bool,
}

/// What a search came to.
#[derive(Debug, Clone)]
pub enum Generated {
    /// A variant.
    Found {
        /// The original with its planned ego.
        original: Box<Opened>,
        /// The variant.
        variant: Box<Opened>,
    },
    /// Nothing dangerous: in words.
    Nothing(String),
    /// A model made nothing dangerous: in words, and what it wrote.
    Unwritten(String, Arc<Authorship>),
}

impl Made {
    /// The variant as it is exported.
    #[must_use]
    pub fn variant(&self) -> Variant<'_> {
        Variant {
            closed: &self.closed,
            change: &self.change,
            asked: &self.asked,
            effect: &self.effect,
            avoidability: &self.avoidability,
            refusals: &self.refused,
            by: &self.by,
            author: self.author.as_ref(),
            made: None,
        }
    }

    /// The hash of the original.
    #[must_use]
    pub fn original(&self) -> ContentHash {
        self.closed.scenario().hash
    }

    /// What the planner saw and chose in the variant: the search does not keep that, and the same drive has the same
    /// cycles.
    pub(super) fn cycles(
        &self,
        prepared: &PreparedPlan,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(GenerationProgress),
    ) -> Result<Option<Vec<CycleShown>>, String> {
        let mut recorder = Recorder::of(prepared);
        let mut on_step =
            |done, of| on_event(GenerationProgress::Working(Working::Showing(done, of)));
        let scenario = &self.effect.scenario;
        let again = prepared.drive_in(scenario, cancel, &mut |event| {
            recorder.hear(&event, &mut on_step);
        });
        let again = again.map_err(|error| error.to_string())?;
        Ok(again.map(|_| recorder.cycles))
    }

    /// The variant opened: under the name and with the hash of the file that would be saved, so that an answer about it
    /// is never taken for one about the original.
    pub(super) fn opened(
        self,
        wish: &VariantRequest,
        cycles: Vec<CycleShown>,
        thresholds: &Thresholds,
    ) -> Result<Opened, String> {
        let id = {
            let folder = wish.folder.as_deref().unwrap_or(Path::new("."));
            self.variant().free_id(folder)
        };
        let mut scenario = self.variant().scenario(&id);
        let bytes = commonroad::write(&scenario);
        let bytes = bytes.map_err(|error| format!("the variant has no file: {error}"))?;
        scenario.hash = ContentHash::of(&bytes);
        let scenario = Arc::new(scenario);
        let driver = self.closed.driver();
        let ego = self.effect.drive.ego(driver.problem(), driver.settings());
        let scene = Arc::new(Scene::new(scenario.clone(), ego));
        let planned = Planned {
            forecast: driver.settings().forecast,
            vehicle: driver.settings().planner.vehicle,
            problem: driver.problem().id,
            outcome: self.effect.drive.outcome,
            cycles,
            recorded: None,
        };
        let mut opened = Opened::with(&wish.entry, wish.change, scenario, Ok(scene), thresholds);
        opened.name = id;
        opened.planned = Some(Arc::new(planned));
        opened.variant = Some(VariantShown {
            made: Arc::new(self),
            changed: true,
        });
        Ok(opened)
    }
}
