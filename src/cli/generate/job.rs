//! Processes one scenario: saves, counts and reports its variant.

use std::ops::ControlFlow;
use std::path::Path;

use serde_json::json;

use super::document::authoring_notes;
use super::line::VariantLine;
use super::summary::Summary;
use super::table::Table;
use super::variant::{Generated, Product};
use crate::many_files::{NEXT, Taken};
use crate::{Failure, output};
use nearmiss_drive::generation::{Variant, VariantFiles};
use nearmiss_formats::Entry;
use nearmiss_workflow::PlanError;

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
        if output::heard(text)? || self.unheard {
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
