//! Variants of a scenario: wanted, made or found, who wrote them, and what is shown of them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::loaded::planned::Recorder;
use crate::loaded::{CertificateDrive, CycleShown, Opened, PlannedEgo};
use nearmiss_ask::prompts::Library;
use nearmiss_drive::generation::attacker::{self, Candidate};
use nearmiss_drive::generation::{
    Attack, AttackStyle, Avoidability, ClosedLoop, Effect, Effort, EvasionRecord, GateEvidence,
    JointChange, Progress, Refusal, SearchResult, SelectedAttack, Variant, Wish,
};
use nearmiss_drive::planner::{Cancel, Forecast};
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_formats::{EgoSelection, Entry, commonroad};
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_scene::scenario::{ContentHash, Scene, Transform};
use nearmiss_scene::traffic_rules::RuleReport;
use nearmiss_scene::verdict::Motion;
use nearmiss_study::evaluation::Settings as Asked;
use nearmiss_study::evaluation::generating::{self, Authored, Method, Source};
use nearmiss_workflow::{
    AttackSource, GenerateEvent, GenerateRequest, Generation, OpenRequest, PlanRequest,
    PreparedPlan, StandIn, generate, prepare,
};

/// Inputs of a generation.
pub struct GenerationInputs<'a> {
    /// How the ego is planned.
    pub settings: &'a Settings,
    /// The planner that is attacked; the built-in one if `None`.
    pub planner: Option<Arc<ExternalPlanner>>,
    /// Where attacks come from; the seed is that of the request.
    pub source: AttackSource<'a>,
}

/// Events of a generation.
#[derive(Debug)]
pub enum GenerationProgress {
    /// The current stage.
    Working(GenerationStage),
    /// Progress of the authoring model.
    Model(generating::Progress),
}

impl Opened {
    /// Makes a scenario dangerous: plans its ego, finds attacks, takes the most dangerous one that an ideal driver
    /// survives, and opens the scenario with it. Nothing where `cancel` asked for an end.
    ///
    /// # Errors
    /// Nothing can be tried: those of [`Opened::planned`], the planned ego touches something already, or there is no
    /// obstacle that could attack.
    pub fn generated(
        wanted: &VariantRequest,
        ego: &EgoSelection,
        thresholds: &Thresholds,
        how: &GenerationInputs<'_>,
        cancel: &Cancel,
        on_event: &mut dyn FnMut(GenerationProgress),
    ) -> Result<Option<GenerationOutcome>, String> {
        let request = PlanRequest {
            open: OpenRequest {
                entry: &wanted.entry,
                ego,
                transform: wanted.change,
                strict: false,
                stand_in: StandIn::None,
            },
            problem: None,
            settings: how.settings,
        };
        let prepared = prepare(&request)
            .map_err(|error| error.to_string())?
            .driven_by(how.planner.clone());
        let effort = match how.source {
            AttackSource::Search(effort) => Effort {
                seed: wanted.seed,
                together: wanted.attackers,
                ..*effort
            },
            AttackSource::Model(_) => Effort::default(),
        };
        let attacking = GenerateRequest {
            prepared: &prepared,
            attackers: wanted.only.as_slice(),
            wish: wanted.wish.as_ref(),
            delay: effort.delay,
            style: wanted.style,
            source: match how.source {
                AttackSource::Search(_) => AttackSource::Search(&effort),
                model @ AttackSource::Model(_) => model,
            },
        };
        let mut recorder = Recorder::new(&prepared);
        let generation = generate(&attacking, cancel, &mut |event| {
            on_author_progress(event, &mut recorder, on_event);
        });
        let Some(generation) = generation.map_err(|error| error.to_string())? else {
            return Ok(None);
        };
        let Generation {
            workshop,
            made,
            authored,
        } = generation;
        if let Some(collision) = workshop.unsafe_already() {
            return Err(format!(
                "the planned ego touches {collision} without an attack, too"
            ));
        }
        let model = wanted.writer.as_ref().map(|writer| writer.model.clone());
        let authorship = authored.map(|authored| {
            let chosen = made.chosen.as_ref();
            let taken = chosen.and_then(|c| authored.find_source(&c.attack));
            Authorship {
                model: model.clone().unwrap_or_default(),
                only: wanted.only,
                taken: taken.map(|attack| attack.source),
                authored,
            }
        });
        if made.found.candidates == 0 && authorship.is_none() {
            let wish = wanted.wish.as_ref().map(ToString::to_string);
            return Err(workshop.why_untried(wanted.only.as_slice(), wish.as_deref()));
        }
        let effective = |c: &SelectedAttack| c.attack.has_effect();
        let Some(chosen) = made.chosen.filter(effective) else {
            return Ok(Some(match authorship {
                Some(wrote) => GenerationOutcome::Unwritten(wrote.nothing(), Arc::new(wrote)),
                None => GenerationOutcome::Nothing(nothing(&made.found, wanted)),
            }));
        };
        let passed = workshop
            .gate()
            .check_joint(&chosen.attack.change, None)
            .map_err(|refusals| refusals[0].to_string())?;
        let ranked = workshop
            .on(|ground| attacker::rank(ground.stage))
            .map_err(|error| error.to_string())?;
        let original = {
            let drive = workshop.closed.baseline().drive();
            let (scenario, mut planned) =
                PlannedEgo::from_outcome(&prepared, drive, recorder.cycles);
            planned.planner = wanted.planner;
            planned.process.clone_from(&drive.external);
            Self::with_planned(
                &request.open,
                workshop.ego.clone(),
                scenario,
                planned,
                thresholds,
            )
        };
        let shown = VariantDisplay {
            style: workshop.style(),
            file: wanted.entry.display(),
            closed: workshop.closed,
            by: model.unwrap_or_else(|| match &wanted.wish {
                Some(words) => format!("{effort}, wish: {words}"),
                None => effort.to_string(),
            }),
            only: wanted.only,
            passed,
            ranked,
            authorship,
        };
        let variant = shown.made(&made.found, chosen)?;
        let Some(cycles) = variant.cycles(&prepared, cancel, on_event)? else {
            return Ok(None);
        };
        let variant = variant.opened(wanted, cycles, thresholds)?;
        Ok(Some(GenerationOutcome::Found {
            original: Box::new(original),
            variant: Box::new(variant),
        }))
    }
}

/// Hands on what happens, in the terms of the workbench.
fn on_author_progress(
    event: GenerateEvent<'_>,
    recorder: &mut Recorder,
    on_event: &mut dyn FnMut(GenerationProgress),
) {
    let heard = match event {
        GenerateEvent::Planning(event) => {
            recorder.on_event(&event, &mut |done, of| {
                on_event(GenerationProgress::Working(GenerationStage::Driving(
                    done, of,
                )));
            });
            return;
        }
        GenerateEvent::Searching(progress, of) => {
            GenerationProgress::Working(GenerationStage::Searching(progress, of))
        }
        GenerateEvent::Asking => {
            GenerationProgress::Working(GenerationStage::Writing(AuthoringProgress::default()))
        }
        GenerateEvent::Model(progress) => GenerationProgress::Model(progress),
        GenerateEvent::Driving(done, of) => {
            GenerationProgress::Working(GenerationStage::Trying(done, of))
        }
        GenerateEvent::Certifying => GenerationProgress::Working(GenerationStage::Proving),
    };
    on_event(heard);
}

/// A variant's data for display, beside the attack.
struct VariantDisplay {
    file: String,
    closed: ClosedLoop,
    by: String,
    only: Option<i64>,
    passed: Vec<GateEvidence>,
    style: AttackStyle,
    ranked: Vec<Candidate>,
    authorship: Option<Authorship>,
}

impl VariantDisplay {
    fn made(
        self,
        found: &SearchResult,
        chosen: SelectedAttack,
    ) -> Result<GeneratedVariant, String> {
        let author = self
            .authorship
            .as_ref()
            .map(|wrote| serde_json::json!(wrote.authored.record(Some(&chosen.attack))));
        let Attack {
            asked,
            change,
            effect,
            ..
        } = chosen.attack;
        let effect = effect.ok_or("the ego was not driven against the attack")?;
        let latest = chosen.avoidability.latest();
        Ok(GeneratedVariant {
            file: self.file,
            ideal_driver: latest
                .map(|(_, way)| EvasionRecord::new(way, &way.review(&self.closed, &effect), None)),
            closed: self.closed,
            asked,
            change,
            effect,
            avoidability: chosen.avoidability,
            passed: self.passed,
            style: self.style,
            refused: match &self.authorship {
                Some(wrote) => wrote.authored.refusals(),
                None => found.refused.clone(),
            },
            progress: found.progress(),
            only: self.only,
            ranked: self.ranked,
            by: self.by,
            authorship: self.authorship.map(Arc::new),
            author,
        })
    }
}

/// Why there is no variant.
fn nothing(found: &SearchResult, wanted: &VariantRequest) -> String {
    let Progress {
        tried,
        refused,
        driven,
        ..
    } = found.progress();
    let who = match (&wanted.wish, wanted.only) {
        (Some(wish), _) if tried == 0 => return format!("no obstacle fits: {wish}"),
        (Some(wish), _) => wish.to_string(),
        (None, Some(id)) => id.to_string(),
        (None, None) => "any obstacle".into(),
    };
    let errors = found
        .planner_errors()
        .map_or(String::new(), |(count, why)| {
            format!("; {count} drives ended with an error of the planner: {why}")
        });
    format!(
        "no dangerous motion found for {who} with seed {}: {tried} motions tried, {refused} rejected, {driven} simulated; the ego got away or was only hit from behind{}",
        wanted.seed,
        visible(&errors)
    )
}

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
    /// Whether an ideal driver avoids it.
    pub avoidability: Avoidability,
    /// What the driver of the longest reaction time who avoids it does; `None` where there is none.
    pub ideal_driver: Option<EvasionRecord>,
    /// The gate's evidence of each changed motion.
    pub passed: Vec<GateEvidence>,
    /// How its attackers move.
    pub style: AttackStyle,
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
                recorder.on_event(&event, &mut on_step);
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

/// The model that writes attacks, and its request settings.
#[derive(Debug, Clone)]
pub struct Writer {
    /// Its id, `provider/model`.
    pub model: String,
    /// The scenario's name in the store.
    pub name: String,
    /// The templates.
    pub library: Library,
    /// The user's settings for descriptions and techniques.
    pub settings: Asked,
    /// How often it is asked, and what for.
    pub method: Method,
    /// Whether it is asked even where the store has its answers.
    pub fresh: bool,
}

/// Progress of a model's authoring.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct AuthoringProgress {
    /// Votes for the attacker that were asked for.
    pub votes: u32,
    /// Votes in all.
    pub of_votes: u32,
    /// Conversations that have begun; 0 while the attacker is chosen.
    pub begun: u32,
    /// How often the last answer that was asked for had been sent back before.
    pub retry: u32,
    /// Motions that passed the gate.
    pub passed: u32,
    /// Answers that were refused.
    pub refused: u32,
    /// Motions that went back to the model with what came of the drive.
    pub sent_back: u32,
    /// Whether the ego is driven against a motion now.
    pub driving: bool,
    /// Grades that were asked for, and motions in all that are to be graded.
    pub grades: (usize, usize),
    /// Conversations in all.
    pub of: u32,
}

impl AuthoringProgress {
    /// Takes note of what happens.
    pub fn on_event(
        &mut self,
        progress: &nearmiss_study::evaluation::generating::Progress,
        method: &Method,
    ) {
        self.of = method.samples;
        match progress {
            nearmiss_study::evaluation::generating::Progress::Choosing { vote, of } => {
                self.votes = self.votes.max(vote + 1);
                self.of_votes = *of;
            }
            nearmiss_study::evaluation::generating::Progress::Writing { sample, retry } => {
                self.begun = self.begun.max(sample + 1);
                self.retry = *retry;
                self.driving = false;
            }
            nearmiss_study::evaluation::generating::Progress::Made(_) => self.passed += 1,
            nearmiss_study::evaluation::generating::Progress::Refused(_) => self.refused += 1,
            nearmiss_study::evaluation::generating::Progress::Driving(_) => self.driving = true,
            nearmiss_study::evaluation::generating::Progress::ToldOfDrive(_) => self.sent_back += 1,
            nearmiss_study::evaluation::generating::Progress::Grading { motion, of } => {
                self.driving = false;
                self.grades = (self.grades.0.max(motion + 1), *of);
            }
            nearmiss_study::evaluation::generating::Progress::Ended { .. } => self.driving = false,
            nearmiss_study::evaluation::generating::Progress::Chosen(_)
            | nearmiss_study::evaluation::generating::Progress::Heard { .. }
            | nearmiss_study::evaluation::generating::Progress::Answered { .. } => {}
        }
    }
}

/// A model's choice and output.
#[derive(Debug)]
pub struct Authorship {
    /// Its id.
    pub model: String,
    /// The one obstacle that was allowed to attack.
    pub only: Option<i64>,
    /// Everything that it wrote; attacks that were driven against come first, the best of all first.
    pub authored: Authored,
    /// The answer that was taken.
    pub taken: Option<Source>,
}

impl Authorship {
    /// Why there is no variant.
    pub(super) fn nothing(&self) -> String {
        let (authored, model) = (&self.authored, &self.model);
        let (passed, answers) = (authored.attacks.len(), authored.candidates());
        if let (Some(why), 0) = (&authored.stopped, passed) {
            return format!("{model} wrote nothing: {why}");
        }
        if authored.choice.attacker.is_none() {
            return format!("{model} was not asked: no moving obstacle can come near the ego");
        }
        if passed > 0 {
            return format!(
                "{model} found nothing dangerous: {passed} of its {answers} motions passed the gate, but the ego got away or was only hit from behind"
            );
        }
        let last = authored
            .declined
            .last()
            .and_then(|d| d.refusals.first())
            .map_or(String::new(), |why| format!("; the last: {why}"));
        format!("{model} found nothing dangerous: all of its {answers} answers were rejected{last}")
    }

    /// Whether it could not do its work, and not only did it badly.
    #[must_use]
    pub fn failed(&self) -> bool {
        self.authored.stopped.is_some() && self.authored.attacks.is_empty()
    }
}
