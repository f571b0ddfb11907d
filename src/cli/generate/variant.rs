//! One scenario's variant: newly generated, or taken over from an earlier run.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::line::Line;
use super::model::Writer;
use super::resume::{EarlierRun, with_identity};
use crate::output;
use nearmiss_drive::generation::{AttackStyle, Effort, Refusal, Selection, VariantGenerator, Wish};
use nearmiss_drive::planner::Cancel;
use nearmiss_drive::simulation::{ExternalPlanner, Settings};
use nearmiss_formats::{EgoSelection, Entry};
use nearmiss_settings::PlannerKey;
use nearmiss_study::evaluation::generating::Authored;
use nearmiss_workflow::{
    AttackSource, GenerateRequest, ModelWriter, OpenRequest, PlanError, PlanRequest, generate,
    prepare,
};

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
    pub identity: Value,
}

impl GenerateJob {
    /// All that decides what is made of a scenario but for its content: two runs with the same one make the same.
    pub fn said(&self, problem: i64) -> Value {
        let effort = &self.effort;
        // Attacks are always judged in recorded traffic.
        let planning = PlannerKey::ALL
            .iter()
            .filter(|key| key.id != "traffic")
            .map(|key| (key.id, key.value(&self.settings)));
        let search = json!({
            "candidates": effort.candidates,
            "rounds": effort.rounds,
            "drives": effort.drives,
            "attackers": effort.attackers,
            "seed": effort.seed,
        });
        let mut said = json!({
            "problem": problem,
            "planning": planning.collect::<BTreeMap<_, _>>(),
            "attacker": self.only,
            "attackers": effort.together,
            "survive": effort.delay,
            "style": self.style.name(),
            "search": self.writer.is_none().then_some(search),
            "model": self.writer.as_ref().map(Writer::settings),
        });
        if let Some(wish) = &self.wish {
            said["wish"] = wish.to_string().into();
        }
        if let Some(planner) = &self.planner {
            let options = planner.options();
            said["planner"] = json!({
                "command": options.command,
                "seconds": [options.start.as_secs_f64(), options.cycle.as_secs_f64()],
                "predictions": options.predictions,
                "history": options.history,
                "clock": options.clock.name(),
            });
        }
        said
    }
}

/// The result for one scenario.
pub enum Product {
    /// Newly generated.
    New(Box<Generated>),
    /// Taken over from an earlier run.
    TakenOver(Box<Line>),
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
    /// The settings it was generated with, see [`Wanted::said`].
    pub settings: Value,
}

impl Generated {
    /// A model's choice, output and consumption.
    pub fn author(&self) -> Option<Value> {
        let taken = self.made.chosen.as_ref().map(|chosen| &chosen.attack);
        let authored = self.authored.as_ref()?;
        Some(authored.document(taken))
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
    let prepared = prepare(&PlanRequest {
        open: OpenRequest {
            entry,
            ego: &EgoSelection::Beside,
            transform: None,
            strict: false,
        },
        problem: wanted.problem,
        settings: &wanted.settings,
    })?
    .driven_by(wanted.planner.clone());
    let settings = wanted.said(prepared.problem().id);
    let past = wanted.past.as_ref();
    let said = with_identity(settings.clone(), &wanted.identity);
    if let Some(line) = past.and_then(|past| past.line_for(entry, &prepared.scenario.hash, &said)) {
        return Ok(Some(Product::TakenOver(Box::new(line))));
    }
    if let Some(why) = past.and_then(|past| past.why_not(&prepared.scenario.hash, &said)) {
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
