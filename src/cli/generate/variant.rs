//! One scenario's variant: newly generated or taken over from an earlier run, then saved, counted and reported.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use nearmiss_drive::generation::{
    AttackStyle, Effort, Refusal, Selection, Variant, VariantFiles, VariantGenerator, Wish,
};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_formats::Entry;
use nearmiss_settings::Planning;
use nearmiss_study::evaluation::generating::{Authored, AuthoredRecord};
use nearmiss_workflow::{AttackSource, GenerateRequest, ModelWriter, PlanError, generate};
use serde_json::json;

use super::line::{VariantLine, authoring_notes};
use super::model::Writer;
use super::resume::EarlierRun;
use super::settings::{GenerationSettings, PlannerProcess, SearchSettings};
use super::summary::Summary;
use super::table::Table;
use crate::many_files::{NEXT, Taken};
use crate::plan::request;
use crate::{Failure, output};

/// The request.
pub struct GenerateJob {
    /// The model; nothing for the search.
    pub writer: Option<Writer>,
    pub settings: Settings,
    /// The planner that is attacked; the built-in one where none is named.
    pub planner: Option<Arc<ExternalPlanner>>,
    pub problem: Option<i64>,
    pub effort: Effort,
    pub style: AttackStyle,
    /// The obstacles that may attack; any where none is named.
    pub only: Vec<i64>,
    /// What attacks are wished to be.
    pub wish: Option<Wish>,
    /// The results of an earlier run, if it is resumed.
    pub past: Option<EarlierRun>,
    /// What the planner's process says of itself, where an earlier run is resumed: name and version.
    pub identity: Option<(String, String)>,
}

impl GenerateJob {
    /// All that decides what is made of a scenario but for its content: two runs with the same make the same.
    pub fn settings(&self, problem: i64) -> GenerationSettings {
        let effort = &self.effort;
        // Attacks are always judged in recorded traffic.
        let planning = Planning::values(&self.settings)
            .into_iter()
            .filter(|(key, _)| key != "traffic")
            .map(|(key, value)| (key, json!(value)));
        GenerationSettings {
            problem,
            planning: planning.collect(),
            attacker: self.only.clone(),
            attackers: effort.together,
            survive: effort.delay,
            style: self.style.name().into(),
            search: self.writer.is_none().then_some(SearchSettings {
                candidates: effort.candidates,
                rounds: effort.rounds,
                drives: effort.drives,
                attackers: effort.attackers,
                seed: effort.seed,
            }),
            model: self.writer.as_ref().map(Writer::settings),
            wish: self.wish.as_ref().map(ToString::to_string),
            planner: self
                .planner
                .as_ref()
                .map(|planner| PlannerProcess::new(planner)),
        }
    }
}

/// The result for one scenario.
pub enum Product {
    /// Newly generated.
    New(Box<Generated>),
    /// Taken over from an earlier run.
    TakenOver(Box<VariantLine>),
}

/// The generated variant of one scenario.
pub struct Generated {
    pub name: String,
    pub file: String,
    pub workshop: VariantGenerator,
    pub made: Selection,
    /// A model's output and consumption.
    pub authored: Option<Authored>,
    pub took: Duration,
    /// The settings it was generated with.
    pub settings: GenerationSettings,
}

impl Generated {
    /// A model's choice, output and consumption.
    pub fn author(&self) -> Option<AuthoredRecord> {
        let taken = self.made.chosen.as_ref().map(|chosen| &chosen.attack);
        let authored = self.authored.as_ref()?;
        Some(authored.record(taken))
    }

    /// Why motions were refused: of a model's answers all reasons, of a search's motions the first.
    pub fn refusals(&self) -> Vec<Refusal> {
        match &self.authored {
            Some(authored) => authored.refusals(),
            None => self.made.found.refused.clone(),
        }
    }
}

/// Makes a variant of a scenario; nothing where `cancel` asked for an end before it was done.
pub fn make(
    entry: &Entry,
    wanted: &GenerateJob,
    cancel: &Cancel,
) -> Option<Result<Product, PlanError>> {
    make_or_error(entry, wanted, cancel).transpose()
}

fn make_or_error(
    entry: &Entry,
    wanted: &GenerateJob,
    cancel: &Cancel,
) -> Result<Option<Product>, PlanError> {
    let began = Instant::now();
    let prepared =
        request(entry, wanted.problem, &wanted.settings)?.driven_by(wanted.planner.clone());
    let settings = wanted.settings(prepared.problem().id);
    let past = wanted.past.as_ref();
    let identified = settings.clone().with_identity(wanted.identity.clone());
    if let Some(line) =
        past.and_then(|past| past.line_for(entry, &prepared.scenario.hash, &identified))
    {
        return Ok(Some(Product::TakenOver(Box::new(line))));
    }
    if let Some(why) = past.and_then(|past| past.why_not(&prepared.scenario.hash, &identified)) {
        output::say(&format!(
            "nearmiss: {}: {why}",
            output::visible(&entry.name)
        ));
    }
    let writer = wanted.writer.as_ref();
    let author = writer.map(|writer| (writer.author(&entry.name), writer.runtime()));
    let model = author
        .as_ref()
        .map(|(author, runtime)| ModelWriter { author, runtime });
    let request = GenerateRequest {
        prepared: &prepared,
        attackers: &wanted.only,
        wish: wanted.wish.as_ref(),
        delay: wanted.effort.delay,
        style: wanted.style,
        source: match &model {
            Some(model) => AttackSource::Model(model),
            None => AttackSource::Search(&wanted.effort),
        },
    };
    let generation = generate(&request, cancel, &mut |_| {})?;
    Ok(generation.map(|generation| {
        Product::New(Box::new(Generated {
            name: output::visible(&entry.name),
            file: entry.display(),
            workshop: generation.workshop,
            made: generation.made,
            authored: generation.authored,
            took: began.elapsed(),
            settings,
        }))
    }))
}

/// The work so far.
pub struct Variants<'a> {
    pub folder: Option<&'a Path>,
    pub json: bool,
    pub by: &'a str,
    /// Whether it is of use after standard output is closed: files are written.
    pub unheard: bool,
    pub summary: Summary,
    pub table: Table,
}

impl Variants<'_> {
    /// Saves and reports the outcome of a scenario.
    pub fn take(&mut self, entry: &Entry, product: Result<Product, PlanError>) -> Taken {
        match product {
            Ok(Product::New(generated)) => self.made(&generated),
            Ok(Product::TakenOver(line)) => self.report(&line),
            Err(error) => {
                self.summary.missed(&error);
                output::say(&format!("nearmiss: {error}"));
                if self.json {
                    self.show(&output::json_line(&crate::plan::NotDrivenRecord::new(
                        entry, &error,
                    ))?)
                } else {
                    NEXT
                }
            }
        }
    }

    fn made(&mut self, generated: &Generated) -> Taken {
        // Files first: who reads a line finds them.
        let line = VariantLine::new(generated, self.by);
        let saved = self.save(generated, &line)?;
        if let Some(authored) = &generated.authored {
            for words in authoring_notes(authored) {
                output::say(&format!("nearmiss: {}: {words}", generated.file));
            }
        }
        let line = VariantLine {
            rejected: Some(generated.refusals().iter().map(Into::into).collect()),
            ..line
        };
        self.report(&match saved {
            Some(saved) => line.saved_as(&saved),
            None => line,
        })
    }

    /// Counts a line and writes it.
    fn report(&mut self, line: &VariantLine) -> Taken {
        self.summary.count(line);
        let text = if self.json {
            output::json_line(line)?
        } else {
            self.table.row(line)
        };
        self.show(&text)
    }

    /// After standard output is closed, only files are worth going on for.
    fn show(&self, text: &str) -> Taken {
        if output::try_text(text)? || self.unheard {
            NEXT
        } else {
            Ok(ControlFlow::Break(()))
        }
    }

    fn save(
        &self,
        generated: &Generated,
        line: &VariantLine,
    ) -> Result<Option<VariantFiles>, Failure> {
        let (Some(folder), Some(chosen)) = (self.folder, &generated.made.chosen) else {
            return Ok(None);
        };
        let Some(effect) = &chosen.attack.effect else {
            return Ok(None);
        };
        // The search has asked the gate; nothing is written that it does not let through here, too.
        let change = &chosen.attack.change;
        if let Err(refusals) = generated.workshop.gate().check_joint(change, None) {
            return Err(Failure::input(format!(
                "{}: internal error: the chosen motion does not pass the gate ({}); not written",
                generated.file, refusals[0]
            )));
        }
        let made = json!({
            "settings": generated.settings,
            "line": line,
        });
        let author = generated.author().map(|author| json!(author));
        let variant = Variant {
            file: &generated.file,
            closed: &generated.workshop.closed,
            change,
            asked: &chosen.attack.asked,
            effect,
            avoidability: &chosen.avoidability,
            refusals: &generated.refusals(),
            by: self.by,
            author: author.as_ref(),
            made: Some(&made),
        };
        let id = variant.free_id(folder);
        let saved = variant.save(folder, &id, false);
        saved.map(Some).map_err(Failure::input)
    }
}
