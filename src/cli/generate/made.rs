//! One scenario's variant: made, saved, told.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use super::document;
use super::line::Line;
use super::model::{Writer, WriterError};
use super::summary::Summary;
use super::table::Table;
use crate::cli::plan::{Missed, chosen, within_horizon};
use crate::cli::{Failure, output};
use crate::evaluation::generating::Authored;
use crate::generation::{Capability, Effort, Made, Refusal, Saved, Variant, Workshop};
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
}

impl Generated {
    /// Why nothing was tried, where nothing was.
    pub fn note(&self) -> Option<String> {
        if let Some(collision) = self.workshop.unsafe_already() {
            return Some(format!("not safe as it is: the ego touches {collision}"));
        }
        if !self.workshop.is_safe() {
            let lowest = self.workshop.closed.baseline().lowest();
            let lowest = lowest.map_or(String::new(), |score| format!(" {score}"));
            return Some(format!(
                "not safe as it is: the lowest risk score of anybody is{lowest} already"
            ));
        }
        let made = &self.made;
        (made.found.candidates == 0 && made.chosen.is_none())
            .then(|| "nobody is there who could attack".into())
    }

    /// Why motions were refused: of a model's answers all reasons, of a search's motions the first.
    pub fn refusals(&self) -> Vec<Refusal> {
        match &self.authored {
            Some(authored) => authored.refusals(),
            None => self.made.found.refused.clone(),
        }
    }
}

/// Drives the ego of a scenario, searches, and chooses.
pub fn make(entry: &Entry, wanted: &Wanted, stop: &AtomicBool) -> Result<Generated, Missed> {
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
                !stop.load(Ordering::Relaxed)
            });
            (made.map_err(|e| nothing(&e))?, None)
        }
        Some(writer) => {
            let written = writer.write(&entry.name, &workshop, wanted.effort.delay);
            let (made, authored) = written.map_err(|error| match error {
                // Whatever the scenario, the question would fail.
                WriterError::Author(_) => Missed::Unfit(format!("{}: {error}", entry.display())),
                WriterError::Workshop(_) => nothing(&error),
            })?;
            (made, Some(authored))
        }
    };
    Ok(Generated {
        name: output::visible(&entry.name),
        file: entry.display(),
        workshop,
        made,
        authored,
        took: began.elapsed(),
    })
}

/// What is done with each scenario, in order.
pub struct Job<'a> {
    pub entries: &'a [Entry],
    pub folder: Option<&'a Path>,
    pub json: bool,
    pub by: &'a str,
    pub summary: Summary,
    pub table: Table,
    pub next: usize,
}

impl Job<'_> {
    /// Saves and tells what became of the next scenario.
    pub fn take(&mut self, generated: Result<Generated, Missed>) -> Result<(), Failure> {
        let entry = &self.entries[self.next];
        self.next += 1;
        let generated = match generated {
            Ok(generated) => generated,
            Err(missed) => {
                self.summary.missed(&missed);
                output::say(&format!("nearmiss: {}", missed.words()));
                if self.json {
                    output::json(&document::missing(entry, &missed))?;
                }
                return Ok(());
            }
        };
        let saved = self.save(&generated)?;
        if let Some(authored) = &generated.authored {
            for words in document::said(authored) {
                output::say(&format!("nearmiss: {}: {words}", generated.file));
            }
        }
        let document = document::document(&generated, saved.as_ref(), self.by);
        self.tell(&Line::of(document).map_err(Failure::input)?)
    }

    /// Counts a line and writes it.
    fn tell(&mut self, line: &Line) -> Result<(), Failure> {
        self.summary.count(&line.figures);
        if self.json {
            return output::json(&line.document);
        }
        let row = self.table.row(&line.figures);
        output::text(&row)
    }

    fn save(&self, generated: &Generated) -> Result<Option<Saved>, Failure> {
        let (Some(folder), Some(chosen)) = (self.folder, &generated.made.chosen) else {
            return Ok(None);
        };
        let Some(effect) = &chosen.attack.effect else {
            return Ok(None);
        };
        // The search has asked the gate; nothing is written that it does not let through here, too.
        let change = &chosen.attack.change;
        if let Err(refusals) = generated.workshop.gate().check(change, None) {
            return Err(Failure::input(format!(
                "{}: the chosen motion does not pass the gate ({}), and was not written: this is a fault of nearmiss",
                generated.file, refusals[0]
            )));
        }
        let variant = Variant {
            closed: &generated.workshop.closed,
            change,
            asked: &chosen.attack.asked,
            effect,
            avoidability: &chosen.avoidability,
            refusals: &generated.refusals(),
            by: self.by,
        };
        let id = variant.free_id(folder);
        let saved = variant.save(folder, &id, false);
        saved.map(Some).map_err(Failure::input)
    }
}
