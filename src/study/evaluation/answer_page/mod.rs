//! The answers of a report to be read in a browser: a grid of questions and configurations, texts and pictures on demand.

mod detail;

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};

use nearmiss_record::HtmlPage;
use nearmiss_scene::description::visible;
use nearmiss_scene::verdict::Task;
use nearmiss_store::StoredImage;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::{AnswerCase, AnswerStatus, PromptConfig, Scored};
use crate::evaluation::report::configuration_name;
use detail::SentPictures;

pub use detail::{AnswerDetail, ShownClaim};

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
    configuration: usize,
    sample: u32,
    /// `R` right, `W` wrong, `N` no verdict, `?` a verdict without a truth.
    letter: char,
    /// `y` yes, `n` no, `-` nothing.
    said: char,
}

/// The answers of a report. Texts that repeat, as prompts do, are kept once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AnswerPage {
    configurations: Vec<PromptConfig>,
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
        let bare = |case: &AnswerCase<'_>| bare(&case.scored.configuration, versions);
        let configurations: BTreeSet<PromptConfig> = cases.iter().map(bare).collect();
        let configurations: Vec<PromptConfig> = configurations.into_iter().collect();
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
            let configuration = configurations.binary_search(&bare(case)).unwrap_or(0);
            let (letter, said) = letters(case.scored);
            page.marks.push(Mark {
                row,
                configuration,
                sample: case.scored.sample,
                letter,
                said,
            });
            page.details.push(AnswerDetail::from_scored(case.scored));
        }
        page.configurations = configurations;
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
        self.sent.get(sha256).is_some()
    }

    /// Adds a picture that the question of an answer was sent with: as the store has it, if it has it. One that is known
    /// is kept once.
    pub fn add_sent(&mut self, place: usize, sha256: &str, found: Option<&StoredImage>) {
        let known = self.sent.get(sha256).cloned();
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
        one.configuration.task,
        one.scenario.clone(),
        case.lead_label(),
        window,
    )
}

fn row(case: &AnswerCase<'_>) -> Row {
    let one = case.scored;
    Row {
        task: one.configuration.task,
        scenario: visible(&one.scenario).into_owned(),
        lead: case.lead_label(),
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
        let configuration = &case.scored.configuration;
        let template = configuration.template.as_ref();
        let first = found
            .entry((configuration.task, configuration.frame))
            .or_insert(template);
        template.is_some() && first.is_some() && *first != template
    })
}

/// A way of asking whatever the task: tasks are rows. As each has templates of its own, these tell ways apart only where
/// there are several `versions` of one.
fn bare(configuration: &PromptConfig, versions: bool) -> PromptConfig {
    PromptConfig {
        task: Task::Collision,
        template: configuration.template.clone().filter(|_| versions),
        ..configuration.clone()
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

/// The program of the page, and its look.
const SCRIPT: &str = concat!(include_str!("grid.js"), include_str!("answer.js"));
const STYLE: &str = include_str!("answers.css");

/// Answers whose details are one block.
const DETAILS: usize = 200;

/// Bytes of texts of one block, about.
const TEXTS: usize = 256 << 10;

impl AnswerPage {
    /// Adds the answers to a page: its data, look and script.
    pub(crate) fn add_to(&self, page: &mut HtmlPage) {
        page.style += STYLE;
        page.script = SCRIPT;
        page.body += "<noscript><p>JavaScript is off: the answers cannot be shown.</p></noscript>\n<section id=\"answers\" hidden></section>\n";
        let texts = self.texts.blocks(TEXTS);
        let firsts: Vec<usize> = texts.iter().map(|(first, _)| *first).collect();
        page.add_data("grid", &self.grid(&firsts));
        for (number, (_, texts)) in texts.iter().enumerate() {
            page.add_data(&format!("texts-{number}"), &texts);
        }
        for (number, details) in self.details.chunks(DETAILS).enumerate() {
            page.add_data(&format!("details-{number}"), &details);
        }
        for (number, svg) in self.pictures.iter().enumerate() {
            page.add_data(&format!("picture-{number}"), svg);
        }
        for (number, address) in self.sent.all.iter().enumerate() {
            page.add_data(&format!("sent-{number}"), address);
        }
    }

    /// Ways, questions and marks, in columns.
    fn grid<'p>(&'p self, text_blocks: &'p [usize]) -> Grid<'p> {
        let configuration = |configuration: &'p PromptConfig| GridConfiguration {
            name: visible(&configuration_name(configuration)).into_owned(),
            frame: configuration.frame.map(|frame| frame.name()),
            techniques: configuration.techniques.map(|used| used.to_string()),
            model: visible(&configuration.model),
            settings: configuration.settings.to_stored(),
            template: configuration.template.as_ref().map(ToString::to_string),
        };
        Grid {
            configurations: self.configurations.iter().map(configuration).collect(),
            rows: &self.rows,
            marks: Marks {
                row: self.marks.iter().map(|mark| mark.row).collect(),
                configuration: self.marks.iter().map(|mark| mark.configuration).collect(),
                sample: self.marks.iter().map(|mark| mark.sample).collect(),
                letter: self.marks.iter().map(|mark| mark.letter).collect(),
                said: self.marks.iter().map(|mark| mark.said).collect(),
            },
            texts: text_blocks,
            details: DETAILS,
        }
    }
}

/// What a page shows at once.
#[derive(Serialize)]
struct Grid<'p> {
    #[serde(rename = "ways")]
    configurations: Vec<GridConfiguration<'p>>,
    rows: &'p [Row],
    marks: Marks,
    /// The first text of each block of texts.
    texts: &'p [usize],
    /// Answers whose details are one block.
    details: usize,
}

/// A way of asking: a column of the grid.
#[derive(Serialize)]
struct GridConfiguration<'p> {
    name: String,
    frame: Option<&'static str>,
    techniques: Option<String>,
    model: Cow<'p, str>,
    settings: Option<String>,
    template: Option<String>,
}

/// The answers in columns.
#[derive(Serialize)]
struct Marks {
    row: Vec<usize>,
    #[serde(rename = "way")]
    configuration: Vec<usize>,
    sample: Vec<u32>,
    letter: String,
    said: String,
}

/// Texts of a page, each once, in the order in which they came.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
struct Texts {
    all: Vec<String>,
    places: HashMap<[u8; 32], usize>,
}

impl Texts {
    /// The place of a text, which is added if it is new.
    pub fn place(&mut self, text: &str) -> usize {
        let next = self.all.len();
        let place = *(self.places)
            .entry(Sha256::digest(text.as_bytes()).into())
            .or_insert(next);
        if place == next {
            self.all.push(text.to_string());
        }
        place
    }

    /// All texts in blocks of about this many bytes, with the place of the first text of each.
    pub fn blocks(&self, bytes: usize) -> Vec<(usize, &[String])> {
        let mut blocks = Vec::new();
        let (mut first, mut size) = (0, 0);
        for (place, text) in self.all.iter().enumerate() {
            size += text.len();
            if size >= bytes || place + 1 == self.all.len() {
                blocks.push((first, &self.all[first..=place]));
                (first, size) = (place + 1, 0);
            }
        }
        blocks
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::AnswerPage;
    use crate::evaluation::tests_scored::answer;
    use crate::evaluation::{AnswerCase, AnswerStatus, Label, Lead, Scored};

    fn answered(scenario: &str, model: &str, dangerous: bool, truth: Option<Label>) -> Scored {
        Scored {
            truth,
            ..answer(scenario, model, dangerous, &[(3, 0)])
        }
    }

    #[test]
    fn questions_are_rows_and_answers_are_marked() {
        let hit = Some(Label::Collision(None));
        let mut all = vec![
            answered("A", "lab/x", true, hit),
            answered("A", "lab/y", false, hit),
            answered("B", "lab/x", true, None),
            answered("A", "lab/x", true, hit),
        ];
        for one in &mut all[..2] {
            one.window = Some((3, 12));
        }
        all[3].sample = 1;
        // Not asked, so its window is not known: it is about the same question.
        all[3].status = AnswerStatus::Unasked("not asked yet".into());
        let page = AnswerPage::new(&AnswerCase::all(&all));
        assert_eq!((page.rows.len(), page.configurations.len()), (2, 2));
        let letters: String = page.marks.iter().map(|mark| mark.letter).collect();
        assert_eq!(letters, "RW?N");
        assert_eq!(page.marks[3].row, page.marks[0].row);
        let lead = |seconds| Some(Lead::Seconds(seconds));
        let cases = [(0, lead(1.0)), (1, lead(2.0))].map(|(place, lead)| AnswerCase {
            scored: &all[place],
            lead,
        });
        assert_eq!(
            AnswerPage::new(&cases).rows.len(),
            2,
            "each lead is a question"
        );
    }

    #[test]
    fn texts_are_kept_once_and_nothing_becomes_markup() {
        let evil = "</script><img src=x onerror=alert(1)> <!-- <script> & \u{202e}\u{1b}[2J";
        let mut one = answered(evil, evil, true, Some(Label::Safe));
        if let AnswerStatus::Verdict(verdict) = &mut one.status {
            verdict.justification = evil.into();
            verdict.obstacles[0].reason = evil.into();
        }
        let all = [one.clone(), one];
        let mut page = AnswerPage::new(&AnswerCase::all(&all));
        for place in 0..2 {
            page.add_message(place, "user", evil);
            page.set_text(place, "another text");
            if let Some(detail) = page.detail_mut(place) {
                detail.model_returned = Some(evil.into());
            }
        }
        page.set_picture(0, "<svg></svg>");
        page.set_picture(0, "<svg>another</svg>");
        let mut whole = nearmiss_record::HtmlPage::default();
        page.add_to(&mut whole);
        let html = whole.html();
        for bad in ["<img", "<!--", "<svg", "\u{1b}", "\u{202e}"] {
            assert!(!html.contains(bad), "{bad}");
        }
        assert_eq!(
            html.matches("</script>").count(),
            html.matches("<script").count()
        );
        assert_eq!(html.matches("another text").count(), 1);
        assert_eq!(html.matches("id=\"data-picture-").count(), 1);
    }
}
