//! The tables of a batch, or of each part of its split: one row for each prompt configuration, counted as in `report`;
//! below, changed scenes and leads. Of a locked test split its progress alone.

use schemars::JsonSchema;
use serde::Serialize;

use super::built_in::BuiltInDocument;
use super::options::Format;
use crate::{Failure, Outcome, output};
use nearmiss_record::{Column, Record, columns, columns_of, rows, text_table};
use nearmiss_store::{BatchId, SplitPart, Store};
use nearmiss_study::evaluation::batch::{Answers, TestSplit, answers_of_part};
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
#[derive(Default, Serialize, JsonSchema)]
pub struct BatchDocument {
    /// The batch; null of the built-in judge alone, and where a part of a batch has nothing to ask.
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
    #[serde(flatten)]
    built_in: Option<BuiltInDocument>,
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
        built_in: Option<BuiltInDocument>,
    ) -> BatchDocument {
        let mut document = BatchDocument {
            batch: batch.map(|id| id.to_string()),
            splits,
            built_in,
            ..BatchDocument::default()
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

    /// The rows by lead.
    pub fn by_lead(&self) -> Vec<LeadRow> {
        self.varied.by_lead()
    }

    /// The rows of all parts as CSV.
    pub fn csv(batch: Option<BatchId>, parts: &[Self]) -> String {
        let about = |part: &Self| ReportSubject {
            batch: batch.map(|id| id.to_string()),
            split: part.part.map(SplitPart::name),
            ..ReportSubject::default()
        };
        let abouts: Vec<ReportSubject> = parts.iter().map(about).collect();
        let parts = abouts.iter().zip(parts);
        let parts = parts.map(|(about, part)| (about, part.cells.clone()));
        FlatRows::new(&parts.collect::<Vec<_>>()).csv()
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

/// Writes the tables of a batch, in parts where it has a split; `text` is what people read.
pub fn write(
    format: Format,
    batch: BatchId,
    parts: Vec<BatchTable>,
    splits: Vec<PartProgress>,
    text: impl FnOnce(&[BatchTable]) -> Result<String, Failure>,
) -> Outcome {
    match format {
        Format::Json => output::document(&BatchTable::document(Some(batch), parts, splits, None)),
        Format::Csv => output::text(&BatchTable::csv(Some(batch), &parts)),
        Format::Table => output::text(&text(&parts)?),
    }
}

/// Writes the tables of a batch with a split: one for each part that may be shown.
pub fn write_parts(format: Format, store: &Store, id: BatchId, test: &TestSplit) -> Outcome {
    let visible = test.visible_parts();
    let of_part = |part: &SplitPart| {
        let answers = answers_of_part(store, id, Some(*part)).map_err(Failure::input)?;
        Ok(BatchTable::new(Some(*part), &answers))
    };
    let shown: Result<Vec<BatchTable>, Failure> = visible.iter().map(of_part).collect();
    let dev = store
        .split_progress(id, SplitPart::Dev)
        .map_err(Failure::input)?;
    let looks = test.looks_note();
    write(format, id, shown?, test.parts(dev).to_vec(), |shown| {
        let mut text = format!(
            "dev split: {} of {} answered\n",
            dev.answered, dev.questions
        );
        for (part, table) in visible.iter().zip(shown) {
            if *part == SplitPart::Test {
                text += &format!("\n{}\n", test.summary());
            }
            text += &table.text()?;
        }
        if test.is_locked() {
            text += &format!("\n{}\n", test.summary());
        }
        text.extend(looks.iter().map(|words| format!("{words}\n")));
        Ok(text)
    })?;
    if format != Format::Table {
        // Programs have it in their data.
        output::say(&format!("nearmiss: {}", test.summary()));
        if let Some(words) = looks {
            output::say(&format!("nearmiss: {words}"));
        }
    }
    Ok(())
}

/// Records as a table for people.
pub fn table<'r, R: Record + 'r>(
    columns: &[Column],
    records: impl IntoIterator<Item = &'r R>,
) -> Result<String, Failure> {
    let rows = rows(records).map_err(Failure::input)?;
    Ok(text_table(columns, &rows))
}
