//! How far the batch of an experiment is, by way of asking.

use std::collections::HashSet;

use nearmiss_store::{Item, ItemState, NewItem};
use nearmiss_study::evaluation::PromptConfig;
use nearmiss_study::evaluation::batch::configuration_of_item;

/// Questions of one way of asking by their state.
#[derive(Debug, Clone, PartialEq)]
pub struct WayProgress {
    /// The way.
    pub way: PromptConfig,
    /// Questions with a whole answer.
    pub answered: usize,
    /// Questions to which no whole answer came, those that the server cut off among them.
    pub failed: usize,
    /// Questions that were not asked yet.
    pub open: usize,
    /// Questions that cannot be asked.
    pub unaskable: usize,
}

/// All questions of a batch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExperimentProgress {
    /// By way of asking, in the order of the questions.
    pub ways: Vec<WayProgress>,
    /// Scenarios that are asked about.
    pub scenarios: usize,
    /// Windows that are asked about; a window at another lead or after a transform is another one.
    pub windows: usize,
}

/// What a window is of: path, lead, transform, steps and task.
type Window<'a> = (
    &'a str,
    Option<&'a str>,
    Option<&'a str>,
    Option<(i64, i64)>,
    &'static str,
);

impl WayProgress {
    /// All its questions.
    #[must_use]
    pub fn all(&self) -> usize {
        self.answered + self.failed + self.open + self.unaskable
    }

    fn count(&mut self, state: ItemState) -> &mut usize {
        match state {
            ItemState::Answered => &mut self.answered,
            ItemState::Failed | ItemState::Truncated => &mut self.failed,
            ItemState::Waiting => &mut self.open,
            ItemState::Unaskable => &mut self.unaskable,
        }
    }
}

impl ExperimentProgress {
    /// That of a stored batch.
    ///
    /// # Errors
    /// A question holds a word that this version does not know.
    pub fn of_items(items: &[Item]) -> Result<Self, String> {
        Self::counted(items.iter().map(|item| (&item.asked, item.state)))
    }

    /// That of a batch before it is begun.
    ///
    /// # Errors
    /// A question holds a word that this version does not know.
    pub fn of_new(items: &[NewItem]) -> Result<Self, String> {
        Self::counted(items.iter().map(|item| {
            let state = match item.unaskable {
                Some(_) => ItemState::Unaskable,
                None => ItemState::Waiting,
            };
            (item, state)
        }))
    }

    fn counted<'a>(items: impl Iterator<Item = (&'a NewItem, ItemState)>) -> Result<Self, String> {
        let mut progress = Self::default();
        let mut scenarios: HashSet<&str> = HashSet::new();
        let mut windows: HashSet<Window<'a>> = HashSet::new();
        for (asked, state) in items {
            let way = configuration_of_item(asked)?;
            *progress.of_way(&way).count(state) += 1;
            scenarios.insert(&asked.path);
            windows.insert((
                &asked.path,
                asked.lead.as_deref(),
                asked.transform.as_deref(),
                asked.window,
                asked.task.name(),
            ));
        }
        (progress.scenarios, progress.windows) = (scenarios.len(), windows.len());
        Ok(progress)
    }

    /// A question of this way changed its state.
    pub fn change(&mut self, way: &PromptConfig, before: ItemState, now: ItemState) {
        let of_way = self.of_way(way);
        let count = of_way.count(before);
        *count = count.saturating_sub(1);
        *of_way.count(now) += 1;
    }

    /// The sums over all ways: answered, failed, open, and those that cannot be asked.
    #[must_use]
    pub fn sums(&self) -> [usize; 4] {
        self.ways.iter().fold([0; 4], |sums, way| {
            let counts = [way.answered, way.failed, way.open, way.unaskable];
            std::array::from_fn(|i| sums[i] + counts[i])
        })
    }

    fn of_way(&mut self, way: &PromptConfig) -> &mut WayProgress {
        let place = self
            .ways
            .iter()
            .position(|known| known.way == *way)
            .unwrap_or_else(|| {
                self.ways.push(WayProgress {
                    way: way.clone(),
                    answered: 0,
                    failed: 0,
                    open: 0,
                    unaskable: 0,
                });
                self.ways.len() - 1
            });
        &mut self.ways[place]
    }
}

/// Why questions have no whole answer, each reason once with how many questions it holds for, the most first.
#[must_use]
pub fn reasons_of<'a>(items: impl IntoIterator<Item = &'a Item>) -> Vec<(String, usize)> {
    let mut reasons: Vec<(String, usize)> = Vec::new();
    for item in items {
        let why = item.error.as_deref().unwrap_or("not asked yet");
        match reasons.iter_mut().find(|(known, _)| known == why) {
            Some((_, count)) => *count += 1,
            None => reasons.push((why.to_string(), 1)),
        }
    }
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    reasons
}
