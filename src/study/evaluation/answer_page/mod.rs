//! The answers of a report to be read in a browser: a grid of questions and ways, texts and pictures.

mod blocks;
mod detail;
mod sent;
#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests;
mod texts;

pub(crate) use blocks::{STYLE, source_hash};
pub use detail::{AnswerDetail, ShownClaim};

use std::collections::{BTreeSet, HashMap};

use serde::Serialize;

use super::{AnswerCase, AnswerStatus, PromptConfig, Scored};
use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::Task;
use nearmiss_store::StoredImage;
use sent::SentPictures;
use texts::Texts;

/// All pictures together have at most so many bytes; a page with more opens slowly.
const MOST_PICTURES: usize = 64 << 20;

/// A question: a row of the grid.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Row {
    task: Task,
    scenario: String,
    lead: Option<String>,
    window: Option<(i64, i64)>,
    truth: Option<bool>,
    critical: Vec<i64>,
    picture: Option<usize>,
}

/// An answer: its place in the grid, and what it says.
#[derive(Debug, Clone, PartialEq)]
struct Mark {
    row: usize,
    way: usize,
    sample: u32,
    /// `R` right, `W` wrong, `N` no verdict, `?` a verdict without a truth.
    letter: char,
    /// `y` yes, `n` no, `-` nothing.
    said: char,
}

/// The answers of a report. Texts that repeat, as prompts do, are kept once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AnswerPage {
    ways: Vec<PromptConfig>,
    rows: Vec<Row>,
    marks: Vec<Mark>,
    details: Vec<AnswerDetail>,
    texts: Texts,
    pictures: Vec<String>,
    picture_bytes: usize,
    left_out: usize,
    sent: SentPictures,
}

impl AnswerPage {
    /// The grid of these answers, each with what its verdict says; texts, claims and pictures are added to it.
    #[must_use]
    pub fn new(cases: &[AnswerCase<'_>]) -> Self {
        let versions = has_versions(cases);
        let bare = |case: &AnswerCase<'_>| bare(&case.scored.way, versions);
        let ways: BTreeSet<PromptConfig> = cases.iter().map(bare).collect();
        let ways: Vec<PromptConfig> = ways.into_iter().collect();
        let mut page = Self::default();
        let mut places: HashMap<RowKey, usize> = HashMap::new();
        // Where a question was not asked, its window may be unknown: its row is that of an answer about the scene.
        let mut known: HashMap<RowKey, usize> = HashMap::new();
        for windowed in [true, false] {
            for case in cases
                .iter()
                .filter(|c| c.scored.window.is_some() == windowed)
            {
                let place = places
                    .get(&key(case, case.scored.window))
                    .copied()
                    .or_else(|| (!windowed).then(|| known.get(&key(case, None)).copied())?);
                if place.is_none() {
                    let next = page.rows.len();
                    places.insert(key(case, case.scored.window), next);
                    known.entry(key(case, None)).or_insert(next);
                    page.rows.push(row(case));
                }
            }
        }
        for case in cases {
            let exact = places.get(&key(case, case.scored.window));
            let Some(&row) = exact.or_else(|| known.get(&key(case, None))) else {
                continue;
            };
            let of = &mut page.rows[row];
            of.truth = of.truth.or(case.scored.is_collision());
            if of.critical.is_empty() {
                of.critical.clone_from(&case.scored.critical);
            }
            let way = ways.binary_search(&bare(case)).unwrap_or(0);
            let (letter, said) = letters(case.scored);
            page.marks.push(Mark {
                row,
                way,
                sample: case.scored.sample,
                letter,
                said,
            });
            page.details.push(AnswerDetail::of(case.scored));
        }
        page.ways = ways;
        page
    }

    /// Whether there is nothing to read.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.marks.is_empty()
    }

    /// Adds a message of the question to what is known of an answer, by its place among the cases.
    pub fn add_message(&mut self, place: usize, role: &str, text: &str) {
        let text = self.texts.place(&visible(text));
        if let Some(detail) = self.details.get_mut(place) {
            detail.messages.push((role.to_string(), text));
        }
    }

    /// Sets the text of an answer as [`super::claims::shown_text`] has it.
    pub fn set_text(&mut self, place: usize, text: &str) {
        let text = self.texts.place(text);
        if let Some(detail) = self.details.get_mut(place) {
            detail.text = Some(text);
        }
    }

    /// What is known of an answer beside its texts.
    pub fn detail_mut(&mut self, place: usize) -> Option<&mut AnswerDetail> {
        self.details.get_mut(place)
    }

    /// The row of an answer, and the critical obstacles of its question.
    #[must_use]
    pub fn question(&self, place: usize) -> Option<(usize, &[i64])> {
        let row = self.marks.get(place)?.row;
        Some((row, &self.rows[row].critical))
    }

    /// Sets the picture of a row, as SVG; one that other rows have, too, is kept once.
    pub fn set_picture(&mut self, row: usize, svg: &str) {
        let Some(of) = self.rows.get_mut(row).filter(|row| row.picture.is_none()) else {
            return;
        };
        let same = self.pictures.iter().position(|known| known == svg);
        if same.is_none() {
            if self.picture_bytes + svg.len() > MOST_PICTURES {
                self.left_out += 1;
                return;
            }
            self.picture_bytes += svg.len();
            self.pictures.push(svg.to_string());
        }
        of.picture = same.or(self.pictures.len().checked_sub(1));
    }

    /// Whether a picture that a question was sent with was looked for before.
    #[must_use]
    pub fn knows_sent(&self, sha256: &str) -> bool {
        self.sent.known(sha256).is_some()
    }

    /// Adds a picture that the question of an answer was sent with: as the store has it, if it has it. One that is known
    /// is kept once.
    pub fn add_sent(&mut self, place: usize, sha256: &str, found: Option<&StoredImage>) {
        let known = self.sent.known(sha256).cloned();
        let sent = known.unwrap_or_else(|| self.sent.take(sha256, found));
        if let Some(detail) = self.details.get_mut(place) {
            detail.sent.push(sent);
        }
    }

    /// How many pictures that were sent are not on the page because it would become too large.
    #[must_use]
    pub fn sent_left_out(&self) -> usize {
        self.sent.left_out
    }

    /// How many questions have no picture because the page would become too large.
    #[must_use]
    pub fn pictures_left_out(&self) -> usize {
        self.left_out
    }
}

/// What makes a question one of its own.
type RowKey = (Task, String, Option<String>, Option<(i64, i64)>);

fn key(case: &AnswerCase<'_>, window: Option<(i64, i64)>) -> RowKey {
    let one = case.scored;
    (
        one.way.task,
        one.scenario.clone(),
        case.lead_words(),
        window,
    )
}

fn row(case: &AnswerCase<'_>) -> Row {
    let one = case.scored;
    Row {
        task: one.way.task,
        scenario: visible(&one.scenario).into_owned(),
        lead: case.lead_words(),
        window: one.window,
        truth: None,
        critical: Vec::new(),
        picture: None,
    }
}

/// Whether a task asks in one frame with several versions of its template.
fn has_versions(cases: &[AnswerCase<'_>]) -> bool {
    let mut found = HashMap::new();
    cases.iter().any(|case| {
        let way = &case.scored.way;
        let template = way.template.as_ref();
        let first = found.entry((way.task, way.frame)).or_insert(template);
        template.is_some() && first.is_some() && *first != template
    })
}

/// A way of asking whatever the task: tasks are rows. As each has templates of its own, these tell ways apart only where
/// there are several `versions` of one.
fn bare(way: &PromptConfig, versions: bool) -> PromptConfig {
    PromptConfig {
        task: Task::Collision,
        template: way.template.clone().filter(|_| versions),
        ..way.clone()
    }
}

fn letters(one: &Scored) -> (char, char) {
    let AnswerStatus::Verdict(verdict) = &one.status else {
        return ('N', '-');
    };
    let letter = match one.is_collision() {
        None => '?',
        Some(truth) if truth == verdict.dangerous => 'R',
        Some(_) => 'W',
    };
    (letter, if verdict.dangerous { 'y' } else { 'n' })
}
