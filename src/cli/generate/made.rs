//! One scenario's variant: made, or taken over from an earlier run.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::line::Line;
use super::model::{Writer, WriterError};
use super::resume::Past;
use crate::cli::output;
use crate::cli::plan::{Missed, chosen, within_horizon};
use crate::config::PlannerKey;
use crate::evaluation::generating::Authored;
use crate::evaluation::planning_value;
use crate::generation::{Capability, Effort, Made, Refusal, Workshop};
use crate::scenario::{Entry, ObstacleRole};
use crate::simulation::Settings;

/// What is asked for.
pub struct Wanted {
    /// The model; nothing for the search.
    pub writer: Option<Writer>,
    pub settings: Settings,
    pub problem: Option<i64>,
    pub effort: Effort,
    pub only: Option<i64>,
    /// What an earlier run has left, where that is to be gone on with.
    pub past: Option<Past>,
}

impl Wanted {
    /// All that decides what is made of a scenario but for its content: two runs with the same one make the same.
    pub fn said(&self, problem: i64) -> Value {
        let effort = &self.effort;
        let planning = PlannerKey::ALL.iter();
        let planning = planning.map(|key| (key.id, planning_value(&self.settings, key.id)));
        let search = json!({
            "candidates": effort.candidates,
            "rounds": effort.rounds,
            "drives": effort.drives,
            "attackers": effort.attackers,
            "seed": effort.seed,
        });
        json!({
            "problem": problem,
            "planning": planning.collect::<BTreeMap<_, _>>(),
            "attacker": self.only,
            "survive": effort.delay,
            "search": self.writer.is_none().then_some(search),
            "model": self.writer.as_ref().map(Writer::settings),
        })
    }
}

/// What there is of one scenario.
pub enum Product {
    /// It was made now.
    New(Box<Generated>),
    /// It was there already.
    TakenOver(Box<Line>),
}

/// What was made of one scenario.
pub struct Generated {
    pub name: String,
    pub file: String,
    pub workshop: Workshop,
    pub made: Made,
    /// What a model wrote, and what it took.
    pub authored: Option<Authored>,
    pub took: Duration,
    /// What it was made with, see [`Wanted::said`].
    pub settings: Value,
}

impl Generated {
    /// Why nothing was tried, where nothing was, and that the original is not safe, where it is not.
    pub fn note(&self) -> Option<String> {
        if let Some(collision) = self.workshop.unsafe_already() {
            return Some(format!("not safe as it is: the ego touches {collision}"));
        }
        let mut notes = Vec::new();
        let made = &self.made;
        if made.found.candidates == 0 && made.chosen.is_none() {
            notes.push("nobody is there who could attack".into());
        }
        let lowest = self.workshop.closed.baseline().lowest();
        if let Some(lowest) = lowest.filter(|_| !self.workshop.is_safe()) {
            notes.push(format!(
                "not safe as it is: the lowest risk score of anybody is {lowest} already"
            ));
        }
        let effect = made.chosen.as_ref().and_then(|c| c.attack.effect.as_ref());
        if let Some(step) = effect.and_then(|effect| effect.between) {
            notes.push(between(step));
        }
        (!notes.is_empty()).then(|| notes.join("; "))
    }

    /// What a model chose and wrote, and what that took.
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

/// That the steps do not see all.
fn between(step: i64) -> String {
    format!(
        "between steps {step} and {} the ego is touched, at neither of them",
        step + 1
    )
}

/// Drives the ego of a scenario, searches, and chooses; nothing where `stop` ended that before it was done.
pub fn make(entry: &Entry, wanted: &Wanted, stop: &AtomicBool) -> Option<Result<Product, Missed>> {
    let cut = AtomicBool::new(false);
    let made = make_watched(entry, wanted, stop, &cut);
    (!cut.load(Ordering::Relaxed)).then_some(made)
}

/// The same; `cut` becomes true where `stop` ends it.
fn make_watched(
    entry: &Entry,
    wanted: &Wanted,
    stop: &AtomicBool,
    cut: &AtomicBool,
) -> Result<Product, Missed> {
    let began = Instant::now();
    let scenario = entry.read().map_err(|e| Missed::Unread(e.to_string()))?;
    let problem = chosen(entry, &scenario, wanted.problem)?;
    within_horizon(entry, &scenario, &wanted.settings)?;
    let nothing = |e: &dyn std::fmt::Display| Missed::Nothing(format!("{}: {e}", entry.display()));
    if let Some(id) = wanted.only {
        let unfit = |why: &str| Missed::Unfit(format!("{}: {why}", entry.display()));
        let obstacle = scenario.obstacle(id);
        let obstacle =
            obstacle.ok_or_else(|| unfit(&format!("there is no obstacle {id} in it")))?;
        if obstacle.role != ObstacleRole::Dynamic || Capability::of(obstacle).is_none() {
            return Err(unfit(&format!("obstacle {id} does not move by itself")));
        }
    }
    let settings = wanted.said(problem.id);
    let past = wanted.past.as_ref();
    if let Some(line) = past.and_then(|past| past.of(entry, &scenario.hash, &settings)) {
        return Ok(Product::TakenOver(Box::new(line)));
    }
    let workshop = Workshop::new(Arc::clone(&scenario), problem, &wanted.settings);
    let workshop = workshop.map_err(|e| nothing(&e))?;
    // No model is paid for what cannot be made dangerous.
    let writer = wanted
        .writer
        .as_ref()
        .filter(|_| workshop.unsafe_already().is_none());
    let (made, authored) = match writer {
        None => {
            let made = workshop.search(&wanted.effort, wanted.only, &|| {
                cut.fetch_or(stop.load(Ordering::Relaxed), Ordering::Relaxed);
                !cut.load(Ordering::Relaxed)
            });
            (made.map_err(|e| nothing(&e))?, None)
        }
        Some(writer) => {
            let written = writer.write(&entry.name, &workshop, wanted.effort.delay, stop);
            let (made, authored) = written.map_err(|error| match error {
                WriterError::Interrupted => {
                    cut.store(true, Ordering::Relaxed);
                    nothing(&error)
                }
                // Whatever the scenario, the question would fail.
                WriterError::Author(_) => Missed::Unfit(format!("{}: {error}", entry.display())),
                WriterError::Workshop(_) => nothing(&error),
            })?;
            (made, Some(authored))
        }
    };
    Ok(Product::New(Box::new(Generated {
        name: output::visible(&entry.name),
        file: entry.display(),
        workshop,
        made,
        authored,
        took: began.elapsed(),
        settings,
    })))
}
