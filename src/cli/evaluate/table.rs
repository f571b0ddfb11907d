//! The tables of a batch: one row for each prompt configuration, counted as in `report`; below, changed scenes and leads.

use schemars::JsonSchema;
use serde::Serialize;

use crate::{Failure, Outcome, json, output};
use nearmiss_record::{Column, Record, columns, columns_of, rows, text_table};
use nearmiss_store::{BatchId, SplitPart};
use nearmiss_study::evaluation::batch::Answers;
use nearmiss_study::evaluation::report::{
    Cell, DataHalf, FlatRows, InSplit, InvarianceRow, LeadRow, PartProgress, Report, ReportSubject,
    SAME_WORDS, Varied,
};

/// The results of a batch, or of a part of its split.
pub struct BatchTable {
    part: Option<SplitPart>,
    /// For each way of asking all of its answers, and which half of the data they are about.
    cells: Vec<Cell>,
    varied: Varied,
}

/// The tables of a batch for programs.
#[derive(Serialize, JsonSchema)]
pub struct BatchDocument {
    /// The batch; null where a part of one has nothing to ask.
    batch: Option<String>,
    /// One prompt configuration each.
    cells: Vec<InSplit<Cell>>,
    /// Which verdicts changed on transformed scenes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    invariance: Vec<InSplit<InvarianceRow>>,
    /// Results by lead of the safety task.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lead: Vec<InSplit<LeadRow>>,
    /// Of a batch with a split: the progress of each part, whether it is locked, and looks at it before it was complete.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    splits: Vec<PartProgress>,
}

impl json::Output for BatchDocument {
    const NAME: &'static str = "evaluate";
    const TITLE: &'static str = "`evaluate --format json` of a batch: its table";
}

impl BatchTable {
    /// Counts the answers of a batch, or of a part of its split.
    pub fn new(part: Option<SplitPart>, answers: &Answers) -> Self {
        let report = Report::from_scored(&answers.plain);
        let cell = |cell: &Cell| {
            let mut halves = report
                .cells
                .iter()
                .filter(|one| one.configuration == cell.configuration);
            let half = match (halves.next(), halves.next(), halves.next()) {
                // One half and the whole, which are the same.
                (Some(only), Some(_), None) => only.half,
                _ => DataHalf::All,
            };
            Cell {
                half,
                ..cell.clone()
            }
        };
        Self {
            part,
            cells: report.full_cells().map(cell).collect(),
            varied: Varied::from_answers(answers),
        }
    }

    /// All parts for programs.
    pub fn document(
        batch: Option<BatchId>,
        parts: Vec<Self>,
        splits: Vec<PartProgress>,
    ) -> BatchDocument {
        let mut document = BatchDocument {
            batch: batch.map(|id| id.to_string()),
            cells: Vec::new(),
            invariance: Vec::new(),
            lead: Vec::new(),
            splits,
        };
        for Self {
            part,
            cells,
            varied,
        } in parts
        {
            document.cells.extend(InSplit::all(part, cells));
            let changes = InSplit::all(part, varied.changes());
            document.invariance.extend(changes);
            document.lead.extend(InSplit::all(part, varied.by_lead()));
        }
        document
    }

    /// Writes the rows of all parts as CSV.
    pub fn write_csv(batch: BatchId, parts: &[Self]) -> Outcome {
        let about = |part: &Self| ReportSubject {
            batch: Some(batch.to_string()),
            split: part.part.map(SplitPart::name),
            ..ReportSubject::default()
        };
        let abouts: Vec<ReportSubject> = parts.iter().map(about).collect();
        let parts = abouts.iter().zip(parts);
        let parts = parts.map(|(about, part)| (about, part.cells.clone()));
        output::text(&FlatRows::new(&parts.collect::<Vec<_>>()).csv())
    }

    /// For people.
    pub fn text(&self) -> Result<String, Failure> {
        let mut shown = columns_of::<Cell>("accuracy");
        for (column, known) in shown.iter_mut().zip(columns::<Cell>()) {
            if known.name.starts_with("naming_") {
                // Most batches of other tasks have none.
                *column = Column {
                    rare: true,
                    ..known
                };
            } else if ["specificity", "accuracy"].contains(&&*known.name) {
                // For want of room; `report` has them.
                column.title = "".into();
            }
        }
        let mut text = table(&shown, &self.cells)?;
        let changes = self.varied.changes();
        if !changes.is_empty() {
            text += "\ntransformed scenes, whose answer should stay the same; flips: the verdict changed\n";
            text += &table(&columns::<InvarianceRow>(), &changes)?;
        }
        if changes.iter().any(|row| row.same_words > 0) {
            text += &format!("{SAME_WORDS}\n");
        }
        let leads = self.varied.by_lead();
        if !leads.is_empty() {
            text += "\ncollisions, by seconds from the end of the window to the collision\n";
            text += &table(&columns::<LeadRow>(), &leads)?;
            text += &(self.varied.about_leads().join("\n") + "\n");
        }
        Ok(text)
    }
}

fn table<'r, R: Record + 'r>(
    columns: &[Column],
    records: impl IntoIterator<Item = &'r R>,
) -> Result<String, Failure> {
    let rows = rows(records).map_err(Failure::input)?;
    Ok(text_table(columns, &rows))
}
