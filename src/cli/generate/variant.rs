//! One scenario's variant: newly generated or taken over from an earlier run, then saved, counted and reported.

use std::ops::ControlFlow;
use std::path::Path;

use nearmiss_drive::generation::VariantFiles;
use nearmiss_drive::planner::Cancel;
use nearmiss_formats::Entry;
use nearmiss_workflow::variant::{AttackRequest, Generated, VariantLine};
use nearmiss_workflow::{AttackWriter, ModelWriter, PlanError, prepare_beside};

use super::line::authoring_notes;
use super::model::Writer;
use super::resume::EarlierRun;
use super::summary::Summary;
use super::table::Table;
use crate::many_files::{NEXT, Taken};
use crate::{Failure, output};

/// The request.
pub struct GenerateJob {
    /// The model; nothing for the search.
    pub writer: Option<Writer>,
    pub problem: Option<i64>,
    pub attack: AttackRequest,
    /// The results of an earlier run, if it is resumed.
    pub past: Option<EarlierRun>,
    /// What the planner's process says of itself, where an earlier run is resumed: name and version.
    pub identity: Option<(String, String)>,
}

/// The result for one scenario.
pub enum Product {
    /// Newly generated.
    New(Box<Generated>),
    /// Taken over from an earlier run.
    TakenOver(Box<VariantLine>),
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
    let attack = &wanted.attack;
    let prepared = prepare_beside(entry, wanted.problem, &attack.settings)?;
    let writer = wanted.writer.as_ref();
    let settings = attack.settings(prepared.problem().id, writer.map(Writer::settings));
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
    let author = writer.map(|writer| (writer.author(&entry.name), writer.runtime()));
    let model = author
        .as_ref()
        .map(|(author, runtime)| ModelWriter { author, runtime });
    let model = model.as_ref().map(|model| model as &dyn AttackWriter);
    let made = Generated::make(entry, prepared, (attack, settings), model, cancel)?;
    Ok(made.map(|made| Product::New(Box::new(made))))
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
        let line = line.with_rejected(generated);
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
        let Some(folder) = self.folder else {
            return Ok(None);
        };
        generated.save(folder, line).map_err(Failure::input)
    }
}
