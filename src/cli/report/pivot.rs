//! Tables over chosen axes: `report --rows model --columns techniques`, and differences from a baseline.

use super::ReportArguments;
use crate::{Failure, Outcome};
use nearmiss_store::Store;
use nearmiss_study::evaluation::AnswerCase;
use nearmiss_study::evaluation::report::{
    AskedFacts, Axis, Measure, Pivot, PivotRequest, ReportFigure,
};

/// Options of a table over axes.
#[derive(Debug, clap::Args)]
pub struct PivotOptions {
    /// One table with this axis as rows: model, techniques, frame, task, template, lead, transform, effort, temperature,
    /// form, stride, seed, tools, sample or country; each cell has an interval of 95 % and the number of its answers.
    #[arg(long, value_name = "AXIS", conflicts_with = "paper")]
    rows: Option<Axis>,
    /// The axis of the columns.
    #[arg(long, value_name = "AXIS", conflicts_with = "paper")]
    columns: Option<Axis>,
    /// What the cells measure: right_of_all, f1, precision, recall, specificity, accuracy, naming_recall,
    /// naming_precision, seconds_median or cost_usd [default: right_of_all].
    #[arg(long, value_name = "MEASURE")]
    measure: Option<Measure>,
    /// Compare every value of the rows with this one: paired differences of the share of right answers, with intervals
    /// and p values corrected by Holm.
    #[arg(long, value_name = "VALUE")]
    against: Option<String>,
}

impl PivotOptions {
    /// What is measured.
    pub fn measure(&self) -> Measure {
        self.measure.unwrap_or_default()
    }

    /// The table that is wanted, where one is.
    pub fn request(&self) -> Option<PivotRequest> {
        let rows = self.rows?;
        Some(PivotRequest {
            rows,
            columns: self.columns,
            measure: self.measure(),
            against: self.against.clone(),
        })
    }

    /// Options that do not fit together.
    pub fn check(&self, arguments: &ReportArguments) -> Outcome {
        let wrong = |words: &str| Err(Failure::input(words));
        let Some(request) = self.request() else {
            let named = [
                (self.columns.is_some(), "--columns"),
                (
                    self.measure.is_some() && arguments.figure.is_none(),
                    "--measure",
                ),
                (self.against.is_some(), "--against"),
            ];
            return match named.into_iter().find(|(is_named, _)| *is_named) {
                Some((_, option)) => wrong(&format!("{option} needs --rows AXIS")),
                None => Ok(()),
            };
        };
        if let Some(figure) = arguments.figure.filter(|one| *one != ReportFigure::Bars) {
            return Err(Failure::input(format!(
                "--rows: only bars are drawn over axes, not {}",
                figure.name()
            )));
        }
        if let Err((part, words)) = request.check() {
            return wrong(&format!("--{part}: {words}"));
        }
        if arguments.declared.any() || arguments.pairs.is_some() {
            return wrong(
                "--baseline, --compare and --pairs belong to the whole report; --against VALUE compares the rows of --rows",
            );
        }
        Ok(())
    }
}

/// The table of these answers, with when and whom they were asked from the store.
pub fn made(
    store: &Store,
    cases: &[AnswerCase<'_>],
    request: PivotRequest,
) -> Result<Pivot, Failure> {
    let runs = store.origins().map_err(Failure::input)?;
    let asked = AskedFacts::new(cases, &runs);
    Pivot::new(cases, asked, request).map_err(Failure::input)
}
