//! Generating a dangerous variant: runs the shared workflow and prepares its outcome for display.

use std::sync::Arc;

use super::authorship::{AuthoringProgress, Authorship};
use super::planned::Recorder;
use super::variant::{GeneratedVariant, GenerationOutcome, GenerationStage, VariantRequest};
use super::{Opened, PlannedEgo};
use nearmiss_drive::generation::attacker::{self, Candidate};
use nearmiss_drive::generation::{
    Attack, AttackStyle, ClosedLoop, Effort, GateEvidence, Plausibility, Progress, SearchResult,
    SelectedAttack,
};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_formats::EgoSelection;
use nearmiss_scene::description::visible;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_study::evaluation::generating;
use nearmiss_workflow::{
    AttackSource, GenerateEvent, GenerateRequest, Generation, OpenRequest, PlanRequest, generate,
    prepare,
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
    /// Makes a scenario dangerous: plans its ego, finds attacks, takes the most dangerous one that a good driver
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
            heard(event, &mut recorder, on_event);
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
                "not safe as recorded: the planned ego touches {collision}"
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
        let plausibility = workshop.plausibility(&chosen.attack.change);
        let shown = VariantDisplay {
            style: workshop.style(),
            plausibility: plausibility.map(|(own, _)| own),
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
fn heard(
    event: GenerateEvent<'_>,
    recorder: &mut Recorder,
    on_event: &mut dyn FnMut(GenerationProgress),
) {
    let heard = match event {
        GenerateEvent::Planning(event) => {
            recorder.hear(&event, &mut |done, of| {
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
    plausibility: Option<Plausibility>,
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
            good_driver: latest.map(|(_, way)| way.review(&self.closed, &effect)),
            closed: self.closed,
            asked,
            change,
            effect,
            avoidability: chosen.avoidability,
            passed: self.passed,
            style: self.style,
            plausibility: self.plausibility,
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
