//! A generated variant: its attack, its evidence, and the original to compare it with.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::authorship::{AuthoringProgress, Authorship, Writer};
use super::generated::GenerationProgress;
use super::planned::Recorder;
use super::{CertificateDrive, CycleShown, Opened, PlannedEgo};
use nearmiss_drive::generation::attacker::Candidate;
use nearmiss_drive::generation::{
    AttackStyle, Avoidability, ClosedLoop, Effect, EvasiveReview, GateEvidence, JointChange,
    Plausibility, Progress, Refusal, Variant, Wish,
};
use nearmiss_drive::planner::{Cancel, Forecast};
use nearmiss_formats::Entry;
use nearmiss_formats::commonroad;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{ContentHash, Scene, Transform};
use nearmiss_scene::traffic_rules::RuleReport;
use nearmiss_scene::verdict::Motion;
use nearmiss_workflow::PreparedPlan;

/// A request for a variant.
#[derive(Debug, Clone)]
pub struct VariantRequest {
    /// Of which scenario.
    pub entry: Entry,
    /// The change applied to the scenario first.
    pub change: Option<Transform>,
    /// The forecast given to the planner.
    pub forecast: Forecast,
    /// The planner that is attacked: 0 is the built-in one, then those of the configuration.
    pub planner: usize,
    /// The only obstacle that may attack; any if `None`.
    pub only: Option<i64>,
    /// What an attack of a search is wished to be.
    pub wish: Option<Wish>,
    /// At most so many obstacles attack together in a search.
    pub attackers: usize,
    /// Of the random numbers of a search.
    pub seed: u64,
    /// The model that thinks of the attack, in place of a search.
    pub writer: Option<Box<Writer>>,
    /// How attackers move.
    pub style: AttackStyle,
    /// Where it would be saved, which decides its name; the current folder if none.
    pub folder: Option<PathBuf>,
}

/// The current stage of a generation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GenerationStage {
    /// The ego is planned in the original: steps done, and the most there can be.
    Driving(usize, usize),
    /// Attacks are searched for: how far that is, and how many motions there are to try.
    Searching(Progress, usize),
    /// A model chooses the attacker and writes motions.
    Writing(AuthoringProgress),
    /// The ego is driven against motions written by a model: done, and in total.
    Trying(usize, usize),
    /// Ways out of the best attacks are searched for.
    Proving,
    /// The ego is planned in the variant: steps done, and the most there can be.
    Showing(usize, usize),
}

/// A generated variant, with its evidence.
#[derive(Debug)]
pub struct GeneratedVariant {
    /// The original's file.
    pub file: String,
    /// The original scenario and the ego's drive in it.
    pub closed: ClosedLoop,
    /// The motions requested of the attackers, in the order of the change.
    pub asked: Vec<Motion>,
    /// The changed motions.
    pub change: JointChange,
    /// Its effect.
    pub effect: Effect,
    /// Whether a good driver avoids it.
    pub avoidability: Avoidability,
    /// What the driver of the longest reaction time who avoids it does; `None` where there is none.
    pub good_driver: Option<EvasiveReview>,
    /// The gate's evidence of each changed motion.
    pub passed: Vec<GateEvidence>,
    /// How its attackers move.
    pub style: AttackStyle,
    /// How plausible the motions are; `None` where no obstacle moves in the recording.
    pub plausibility: Option<Plausibility>,
    /// Refusals on the way.
    pub refused: Vec<Refusal>,
    /// How far the search had come.
    pub progress: Progress,
    /// The one obstacle that was allowed to attack.
    pub only: Option<i64>,
    /// Possible attackers by the reference, the least change first.
    pub ranked: Vec<Candidate>,
    /// The author of the attack.
    pub by: String,
    /// The model's choice and output, if a model is the author.
    pub authorship: Option<Arc<Authorship>>,
    /// The same as its papers have it.
    pub author: Option<serde_json::Value>,
}

/// A variant that is shown, or the original beside it.
#[derive(Debug, Clone)]
pub struct VariantShown {
    /// The variant.
    pub made: Arc<GeneratedVariant>,
    /// Whether the variant is shown, and not the original.
    pub changed: bool,
}

/// Result of a search.
#[derive(Debug, Clone)]
pub enum GenerationOutcome {
    /// A variant.
    Found {
        /// The original with its planned ego.
        original: Box<Opened>,
        /// The variant.
        variant: Box<Opened>,
    },
    /// No dangerous attack was found, and why.
    Nothing(String),
    /// A model produced nothing dangerous: why, and its output.
    Unwritten(String, Arc<Authorship>),
}

impl GeneratedVariant {
    /// The variant as it is exported.
    #[must_use]
    pub fn variant(&self) -> Variant<'_> {
        Variant {
            file: &self.file,
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
        let mut recorder = Recorder::new(prepared);
        let mut on_step = |done, of| {
            on_event(GenerationProgress::Working(GenerationStage::Showing(
                done, of,
            )))
        };
        let scenario = &self.effect.scenario;
        let again = prepared
            .drive_in(scenario, cancel, &mut |event| {
                recorder.hear(&event, &mut on_step);
            })
            .map_err(|error| error.to_string())?;
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
        let bytes = commonroad::write(&scenario)
            .map_err(|error| format!("the variant has no file: {error}"))?;
        scenario.hash = ContentHash::digest(&bytes);
        let scenario = Arc::new(scenario);
        let driver = self.closed.driver();
        let ego = self.effect.drive.ego(driver.problem(), driver.settings());
        let scene = Arc::new(Scene::new(scenario.clone(), ego));
        let planned = PlannedEgo {
            rules: RuleReport::from_scene(&scene),
            forecast: driver.settings().forecast,
            planner: wish.planner,
            process: self.effect.drive.external.clone(),
            vehicle: driver.settings().planner.vehicle,
            problem: driver.problem().id,
            outcome: self.effect.drive.outcome,
            beyond: self.effect.drive.beyond_vehicle(),
            cycles,
            recorded: None,
        };
        let mut opened = Opened::with(&wish.entry, wish.change, scenario, Ok(scene), thresholds);
        let drive = CertificateDrive::made(&self, &wish.entry, &opened.scenario, thresholds);
        opened.certificate = drive.map(Arc::new);
        opened.name = id;
        opened.planned = Some(Arc::new(planned));
        opened.variant = Some(VariantShown {
            made: Arc::new(self),
            changed: true,
        });
        Ok(opened)
    }
}
