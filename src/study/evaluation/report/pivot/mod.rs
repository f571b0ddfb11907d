//! Tables over any axes: a measure by model and techniques, by lead and frame; and differences from a baseline.

mod against;
mod axis;
mod facts;
mod measure;
mod output;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;

pub use against::Difference;
pub use axis::{Axis, AxisValue};
pub use facts::AskedFacts;
pub use measure::Measure;
pub use output::AxesDocument;

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::{Cell, DataHalf, Report, ReportSubject};
use crate::evaluation::{AnswerCase, Scored};
use nearmiss_ask::llm::Parameters;
use nearmiss_base::system::available;
use nearmiss_scene::verdict::Task;

nearmiss_record::fields! {
    /// Which table is wanted.
    #[derive(Eq)]
    pub struct PivotRequest {
        "table" {
            /// The axis of the rows.
            rows [required]: Axis = Axis::Techniques;
            /// That of the columns; by default one column.
            columns: Option<Axis>;
            /// What is measured.
            measure: Measure;
            /// The value of the rows' axis that all others are compared with.
            against: Option<String>;
        }
    }
}

impl PivotRequest {
    /// Whether its axes fit together.
    ///
    /// # Errors
    /// The name of the wrong part, and what to do.
    pub fn check(&self) -> Result<(), (&'static str, &'static str)> {
        let compared = self.against.is_some();
        match self.rows {
            rows if self.columns == Some(rows) => {
                Err(("columns", "the rows have this axis; choose another"))
            }
            Axis::Task if compared => Err((
                "against",
                "tasks have different truths; choose another axis for the rows",
            )),
            Axis::Country if compared => Err((
                "against",
                "scenarios of different countries cannot be paired; choose another axis for the rows",
            )),
            _ => Ok(()),
        }
    }

    /// The same in words: `f1 by techniques and model, against base`.
    #[must_use]
    pub fn words(&self) -> String {
        let columns = self.columns.map(|axis| format!(" and {}", axis.name()));
        let against = self
            .against
            .as_ref()
            .map(|name| format!(", against {name}"));
        format!(
            "{} by {}{}{}",
            self.measure.name(),
            self.rows.name(),
            columns.unwrap_or_default(),
            against.unwrap_or_default()
        )
    }
}

/// A table for each task.
#[derive(Debug, Clone, PartialEq)]
pub struct Pivot {
    /// Which table.
    pub request: PivotRequest,
    /// The tables, in the order of tasks; one of all tasks where a task is a value of an axis.
    pub parts: Vec<PivotPart>,
    /// Which answers these are, and beside which truth.
    pub about: ReportSubject,
    /// When they were asked, and whom.
    pub asked: AskedFacts,
    /// What is said before every table.
    warnings: Vec<String>,
}

/// The table of a task.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotPart {
    /// The task; `None` of all.
    pub task: Option<Task>,
    /// Scenarios, and questions about them.
    pub counted: (usize, usize),
    /// Cells that have answers, row by row.
    pub cells: Vec<PivotCell>,
    /// Differences from the baseline, where there is one.
    pub differences: Vec<Difference>,
}

/// The answers with one value of each axis.
#[derive(Debug, Clone, PartialEq)]
pub struct PivotCell {
    /// The value of the rows' axis.
    pub row: AxisValue,
    /// That of the columns' axis.
    pub column: Option<AxisValue>,
    /// What they come to.
    pub cell: Cell,
}

/// An answer with its values of the axes.
struct Placed<'a> {
    case: AnswerCase<'a>,
    parameters: Option<&'a Parameters>,
    row: AxisValue,
    column: Option<AxisValue>,
}

impl Pivot {
    /// Counts answers by the axes. Other leads and transformed scenes count only where an axis tells them apart.
    ///
    /// # Errors
    /// No answer has the value that is to be compared with.
    pub fn new(
        cases: &[AnswerCase<'_>],
        asked: AskedFacts,
        request: PivotRequest,
    ) -> Result<Self, String> {
        let has = |axis| request.rows == axis || request.columns == Some(axis);
        let safety = |case: &&AnswerCase<'_>| case.scored.way.task == Task::Safety;
        let first = cases.iter().find(safety).and_then(|case| case.lead);
        let counts = |case: &&AnswerCase<'_>| {
            let changed = case.transform().is_some() && !has(Axis::Transform);
            let other_lead = safety(case) && case.lead != first && !has(Axis::Lead);
            !changed && !other_lead
        };
        let placed = cases.iter().filter(counts).map(|case| {
            let parameters = case.scored.run.and_then(|run| asked.parameters.get(&run));
            Placed {
                case: *case,
                parameters,
                row: request.rows.value(case, parameters),
                column: request.columns.map(|axis| axis.value(case, parameters)),
            }
        });
        let mut tasks: BTreeMap<Option<Task>, Vec<Placed<'_>>> = BTreeMap::new();
        for one in placed {
            let task = (!has(Axis::Task)).then_some(one.case.scored.way.task);
            tasks.entry(task).or_default().push(one);
        }
        let mut values = BTreeSet::new();
        values.extend(tasks.values().flatten().map(|one| one.row.clone()));
        if let Some(name) = &request.against
            && !values.iter().any(|value| value.text == *name)
        {
            let known = values.iter().map(|value| value.text.as_str());
            let axis = request.rows.name();
            return Err(format!(
                "no answer has the {axis} `{name}`{}",
                available(name, known)
            ));
        }
        let parts = tasks
            .iter()
            .map(|(task, placed)| part(*task, placed, &request));
        Ok(Self {
            parts: parts.collect(),
            request,
            about: ReportSubject::default(),
            asked,
            warnings: Report::warnings_of(cases.iter().map(|case| case.scored)).collect(),
        })
    }

    /// The same, saying what it is of, who left out much and whose verdicts are doubtful.
    #[must_use]
    pub fn about(self, mut about: ReportSubject) -> Self {
        about.notes.splice(0..0, self.warnings.iter().cloned());
        Self { about, ..self }
    }
}

fn part(task: Option<Task>, placed: &[Placed<'_>], request: &PivotRequest) -> PivotPart {
    let mut groups: BTreeMap<(&AxisValue, &Option<AxisValue>), Vec<&Scored>> = BTreeMap::new();
    for one in placed {
        let group = groups.entry((&one.row, &one.column)).or_default();
        group.push(one.case.scored);
    }
    let groups: Vec<_> = groups.into_iter().collect();
    let cells = groups.par_iter().filter_map(|((row, column), scored)| {
        Some(PivotCell {
            row: (*row).clone(),
            column: (*column).clone(),
            cell: Cell::count(&scored.first()?.way, DataHalf::All, scored),
        })
    });
    let baseline = request.against.as_ref().and_then(|name| {
        let named = placed.iter().find(|one| one.row.text == *name)?;
        Some(named.row.clone())
    });
    let differences = baseline.map(|value| against::differences(request.rows, &value, placed));
    let scenarios: BTreeSet<&str> = placed.iter().map(|one| one.case.scenario()).collect();
    PivotPart {
        task,
        counted: (scenarios.len(), placed.len()),
        cells: cells.collect(),
        differences: differences.unwrap_or_default(),
    }
}
