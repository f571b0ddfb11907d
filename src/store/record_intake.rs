//! Takes in the lines of an export or a bundle: batches at once, runs in parts, questions last.

use std::collections::BTreeMap;

use super::{BatchId, Intake, Item, Record, Run, Store, StoreError};

/// Runs, and bytes of lines, that are added in one transaction.
const PART: (usize, usize) = (200, 16 << 20);

/// What is being taken in; questions wait for the end, as they name runs.
pub struct RecordIntake<'a> {
    /// Where batches, runs and questions go.
    pub intake: Intake<'a>,
    runs: Vec<Run>,
    bytes: usize,
    questions: BTreeMap<BatchId, Vec<Item>>,
}

impl<'a> RecordIntake<'a> {
    /// Nothing so far.
    #[must_use]
    pub fn new(store: &'a Store) -> Self {
        Self {
            intake: Intake::new(store),
            runs: Vec::new(),
            bytes: 0,
            questions: BTreeMap::new(),
        }
    }

    /// Takes in the record of a line of so many bytes.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn take(&mut self, record: Record, bytes: usize) -> Result<(), StoreError> {
        match record {
            Record::Batch(batch) => self.intake.batch(&batch),
            Record::Question(batch, item) => {
                self.questions.entry(batch).or_default().push(*item);
                Ok(())
            }
            Record::Image(image) => self.intake.image(&image),
            Record::Run(run) => {
                self.runs.push(*run);
                self.bytes += bytes;
                if self.runs.len() >= PART.0 || self.bytes >= PART.1 {
                    self.add()
                } else {
                    Ok(())
                }
            }
        }
    }

    /// Takes in what is left, and the questions.
    ///
    /// # Errors
    /// SQLite refused.
    pub fn finish(mut self) -> Result<Intake<'a>, StoreError> {
        self.add()?;
        for (batch, items) in &self.questions {
            self.intake.items(*batch, items)?;
        }
        Ok(self.intake)
    }

    fn add(&mut self) -> Result<(), StoreError> {
        self.bytes = 0;
        self.intake.runs(std::mem::take(&mut self.runs))
    }
}
