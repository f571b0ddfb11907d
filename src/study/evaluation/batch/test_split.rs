//! The lock of a test split: what may be shown of it before it is complete.

use super::Spec;
use crate::evaluation::report::PartProgress;
use nearmiss_store::{Batch, SplitPart, SplitProgress, Store, StoreError, UnlockRecord};

/// The test split of a batch as it stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TestSplit {
    /// How far it is.
    pub progress: SplitProgress,
    /// The parts of the batch that are here, such as `1/4`; `None` if it is whole.
    pub shard: Option<String>,
    /// Looks at its figures before it was complete.
    pub looks: Vec<UnlockRecord>,
    /// Whether its figures are shown although it is not complete.
    pub unlocked: bool,
}

impl TestSplit {
    /// That of a batch; `None` if the batch has no split. With `unlock` a split that is not complete is shown, and the
    /// look is recorded.
    ///
    /// # Errors
    /// The store cannot be read or written.
    pub fn open(store: &Store, batch: &Batch, unlock: bool) -> Result<Option<Self>, StoreError> {
        let spec = Spec::from_json(&batch.spec).ok();
        if spec.is_none_or(|spec| spec.experiment.split.is_none()) {
            return Ok(None);
        }
        let mut found = Self {
            progress: store.split_progress(batch.id, SplitPart::Test)?,
            shard: batch.shard.clone(),
            looks: Vec::new(),
            unlocked: false,
        };
        if unlock && !found.is_complete() {
            store.record_look(batch.id, found.progress)?;
            found.unlocked = true;
        }
        found.looks = store.looks(batch.id)?;
        Ok(Some(found))
    }

    /// Whether every question that can be asked has its answer, and no part is on another machine.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.progress.answered == self.progress.questions && self.shard.is_none()
    }

    /// Whether nothing but the progress may be shown.
    #[must_use]
    pub fn is_locked(&self) -> bool {
        !self.is_complete() && !self.unlocked
    }

    /// How far it is, in words: `test split: 12 of 40 answered, locked`.
    #[must_use]
    pub fn summary(&self) -> String {
        let SplitProgress {
            questions,
            answered,
        } = self.progress;
        let part = self
            .shard
            .as_ref()
            .map_or_else(String::new, |shard| format!(" in part {shard}"));
        let state = match (self.is_complete(), self.unlocked) {
            (true, _) => "",
            (false, true) => ", unlocked before it is complete",
            (false, false) => ", locked",
        };
        format!("test split: {answered} of {questions} answered{part}{state}")
    }

    /// How far both parts are, for programs; `dev` is the progress of the other part.
    #[must_use]
    pub fn parts(&self, dev: SplitProgress) -> [PartProgress; 2] {
        let dev = PartProgress {
            split: SplitPart::Dev.name(),
            questions: dev.questions,
            answered: dev.answered,
            locked: false,
            looks: 0,
        };
        let test = PartProgress {
            split: SplitPart::Test.name(),
            questions: self.progress.questions,
            answered: self.progress.answered,
            locked: self.is_locked(),
            looks: self.looks.len(),
        };
        [dev, test]
    }

    /// The parts whose figures may be shown.
    #[must_use]
    pub fn visible_parts(&self) -> &'static [SplitPart] {
        if self.is_locked() {
            &[SplitPart::Dev]
        } else {
            &[SplitPart::Dev, SplitPart::Test]
        }
    }

    /// That it was looked at before it was complete; `None` if it was not.
    #[must_use]
    pub fn looks_note(&self) -> Option<String> {
        let times = match self.looks.len() {
            0 => return None,
            1 => "once".to_string(),
            n => format!("{n} times"),
        };
        Some(format!(
            "the test split was looked at {times} before it was complete"
        ))
    }
}
