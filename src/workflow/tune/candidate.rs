//! Templates that were proposed and tried: whether they may be asked with, what came of them, and which are on the front.

use std::collections::BTreeSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Duration;

use nearmiss_ask::prompts::{Library, Template, answer_form};
use nearmiss_scene::scenario::identity;
use nearmiss_scene::verdict::{self, object_in};
use nearmiss_study::evaluation::statistics::Gain;
use nearmiss_study::evaluation::{Confusion, Question, prepare};
use rayon::prelude::*;
use serde::Deserialize;
use serde_json::{Value, json};
use similar::TextDiff;
use strum::{IntoStaticStr, VariantArray};

use super::ask::{Graded, Replies};
use super::outcome::Measure;
use super::prepare::TunePlan;

/// A template that was asked with on the whole selection part; the first one is the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its number; 0 is the base.
    pub number: usize,
    /// The candidate that it was made from; `None` of the base.
    pub parent: Option<usize>,
    /// The round in which it was proposed, from 1; 0 of the base.
    pub round: u32,
    /// What it changes, in the words of the reflecting model.
    pub change: String,
    /// What the reflecting model found wrong with its parent.
    pub diagnosis: String,
    /// The whole template.
    pub source: String,
    /// SHA-256 of it and of what it includes.
    pub hash: String,
    /// Its answers on the selection part.
    pub score: Score,
    /// Whether no other candidate is better and no dearer, or cheaper and no worse.
    pub on_front: bool,
    /// By how much it is better than the base; `None` of the base, and where the measure has no value.
    pub gain: Option<Gain>,
}

/// Answers of a template on a part.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Score {
    /// Right and wrong answers; those that cannot be read are wrong.
    pub counts: Confusion,
    /// Questions.
    pub asked: usize,
    /// Answers that cannot be read.
    pub unreadable: usize,
    /// Questions without an answer.
    pub missing: usize,
    /// Mean cost of an answer, US dollars; `None` where one is unknown.
    pub usd: Option<f64>,
    /// Mean tokens of question and answer; `None` where the server did not count.
    pub tokens: Option<f64>,
}

/// What the front holds against the measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum CostMeasure {
    /// Mean US dollars of an answer.
    Usd,
    /// Mean tokens of question and answer, where nothing is paid or a cost is unknown.
    Tokens,
    /// Nothing: the server told neither.
    Unknown,
}

nearmiss_record::named!(CostMeasure);

impl CostMeasure {
    /// What is known of the base and not 0.
    #[must_use]
    pub fn for_base(base: &Score) -> Self {
        match (base.usd, base.tokens) {
            (Some(usd), _) if usd > 0.0 => Self::Usd,
            (_, Some(_)) => Self::Tokens,
            (_, None) => Self::Unknown,
        }
    }

    /// Its value.
    #[must_use]
    pub fn of_score(self, score: &Score) -> f64 {
        let known = match self {
            Self::Usd => score.usd,
            Self::Tokens => score.tokens,
            Self::Unknown => Some(0.0),
        };
        known.unwrap_or(f64::INFINITY)
    }
}

impl Score {
    /// The score of these questions.
    pub(super) fn new(plan: &TunePlan, places: &[usize], replies: &Replies) -> Self {
        let mut score = Self {
            asked: places.len(),
            ..Self::default()
        };
        let mut graded: Vec<&Graded> = Vec::with_capacity(places.len());
        for place in places {
            match replies.get(place) {
                Some(Ok(one)) => {
                    let truth = plan.questions[*place].truth.collides();
                    score.counts.count(one.yes, truth);
                    score.unreadable += usize::from(one.unreadable.is_some());
                    graded.push(one);
                }
                Some(Err(_)) | None => score.missing += 1,
            }
        }
        let n = graded.len() as f64;
        let mean = |all: Option<f64>| all.filter(|_| n > 0.0).map(|sum| sum / n);
        score.usd = mean(graded.iter().map(|one| one.usd).sum());
        score.tokens = mean(graded.iter().map(|one| Some(one.tokens? as f64)).sum());
        score
    }

    /// Its value of a measure.
    #[must_use]
    pub fn value(&self, measure: Measure) -> Option<f64> {
        measure.value(&self.counts)
    }
}

/// A proposal that did not become a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Refusal {
    /// The round, from 1.
    pub round: u32,
    /// Its number in the round, from 1.
    pub number: u32,
    /// The candidate that it was made from.
    pub parent: usize,
    /// What it changes; blank where that could not be read.
    pub change: String,
    /// Why it is none.
    pub because: RefusedBecause,
}

/// Why a proposal did not become a candidate.
#[derive(Debug, Clone, PartialEq)]
pub enum RefusedBecause {
    /// It is no template that may be asked with.
    Invalid(String),
    /// It was not better on a few questions of the feedback part.
    NotBetter {
        /// How many it answered right.
        right: usize,
        /// How many its parent did.
        parent: usize,
        /// Of so many.
        of: usize,
    },
    /// Too many of its questions got no answer.
    Unanswered {
        /// How many.
        missing: usize,
        /// Of so many.
        of: usize,
        /// Why the first of them got none.
        why: String,
    },
}

impl std::fmt::Display for RefusedBecause {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Invalid(why) => write!(f, "refused: {why}"),
            Self::NotBetter { right, parent, of } => {
                write!(
                    f,
                    "not better: {right} of {of} shown questions right, its parent {parent}"
                )
            }
            Self::Unanswered { missing, of, why } => {
                write!(f, "{missing} of {of} questions without an answer: {why}")
            }
        }
    }
}

/// A proposal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub(super) struct Proposal {
    /// What the template lets the model do wrong.
    #[serde(default)]
    pub diagnosis: String,
    /// What is changed, in a sentence.
    #[serde(default)]
    pub change: String,
    /// The text after the front matter.
    pub template: String,
}

/// The schema of the answer.
pub(super) fn schema() -> Value {
    let text = |about: &str| json!({ "type": "string", "description": about });
    json!({
        "type": "object",
        "properties": {
            "diagnosis": text("What the template lets the model do wrong, in general."),
            "change": text("What the new template changes, in one sentence."),
            "template": text("The whole new text of the template after its front matter."),
        },
        "required": ["diagnosis", "change", "template"],
        "additionalProperties": false,
    })
}

impl Proposal {
    /// Reads an answer: one JSON object, alone or within other text.
    ///
    /// # Errors
    /// There is none: in words.
    pub fn read(text: &str) -> Result<Self, String> {
        let part = match (text.find('{'), text.rfind('}')) {
            (Some(from), Some(to)) if from < to => &text[from..=to],
            _ => text,
        };
        // Long texts in JSON often have lines of their own, which JSON forbids.
        let lenient = || serde_json::from_value(object_in(text)?).ok();
        let found: Self = match serde_json::from_str(part) {
            Ok(found) => found,
            Err(error) => {
                lenient().ok_or_else(|| format!("the answer is not the JSON asked for: {error}"))?
            }
        };
        if found.template.trim().is_empty() {
            Err("the answer has no template".into())
        } else {
            Ok(found)
        }
    }
}

/// The places of the points, each with its value (more is better) and its cost (less is better), that no other point
/// beats: none is at least as good in both and better in one. Of equal points the first is on the front.
pub(super) fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let beats = |a: (usize, &(f64, f64)), b: (usize, &(f64, f64))| {
        let no_worse = a.1.0 >= b.1.0 && a.1.1 <= b.1.1;
        no_worse && (a.1 != b.1 || a.0 < b.0)
    };
    let places = 0..points.len();
    let unbeaten = |at: &usize| {
        let of = |other: usize| (other, &points[other]);
        !(0..points.len()).any(|other| other != *at && beats(of(other), of(*at)))
    };
    places.filter(unbeaten).collect()
}

/// A template that may be asked with, and all dev questions as it asks them.
pub(super) struct Checked {
    pub source: String,
    pub hash: String,
    pub questions: Vec<Question>,
}

/// Checks the text of a proposal: it is a template, no known one, keeps description and form of the answer in the
/// messages of all dev scenarios, and has nothing of these scenarios in itself.
///
/// # Errors
/// Why it may not be asked with, in words that name no scenario but one it names itself.
pub(super) fn check(
    plan: &TunePlan,
    text: &str,
    parent: &Candidate,
    known: &[Candidate],
) -> Result<Checked, String> {
    let body = Template::strip_front_matter(text.trim_start());
    let source = plan.template.with_body(body);
    let template = Template::read(&source).map_err(|error| error.in_file(&plan.file))?;
    let hash = plan.library.hash(&source);
    if let Some(same) = known.iter().find(|one| one.hash == hash) {
        return Err(match same.number {
            0 => "it is the base template".to_string(),
            number => format!("it is candidate {number}"),
        });
    }
    let before = Template::strip_front_matter(&parent.source);
    if let Some(why) = plan.traces.found(template.body(), before) {
        return Err(why);
    }
    let included = plan.library.included(&source);
    let of_base = plan.library.included(&plan.template.source);
    if let Some(name) = of_base
        .iter()
        .find(|name| is_of_answer(name) && !included.contains(*name))
    {
        return Err(format!(
            "it does not include \"{name}\", which says the form of the answer"
        ));
    }
    let questions = rendered(plan, &source)?;
    for (question, base) in questions.iter().zip(&plan.questions) {
        keeps(question, &base.question)?;
    }
    Ok(Checked {
        source,
        hash,
        questions,
    })
}

/// Whether a fragment says the form of the answer.
fn is_of_answer(name: &str) -> bool {
    name.contains("answer")
}

/// All dev questions as a template asks them.
///
/// # Errors
/// The first that cannot be rendered.
pub(super) fn rendered(plan: &TunePlan, source: &str) -> Result<Vec<Question>, String> {
    if source == plan.template.source {
        let questions = plan.questions.iter().map(|one| one.question.clone());
        return Ok(questions.collect());
    }
    let library = with_template(plan, source)?;
    let of = |question: &Question| {
        let made = prepare(question.case.clone(), &library, None);
        made.map_err(|error| format!("it cannot be filled: {error}"))
    };
    let questions = plan.questions.par_iter().map(|one| of(&one.question));
    questions.collect()
}

/// The templates with this one in the place of the base.
fn with_template(plan: &TunePlan, source: &str) -> Result<Library, String> {
    let mut library = plan.library.clone();
    let used = library.use_draft(&plan.file, source);
    used.map_err(|error| error.in_file(&plan.file))?;
    Ok(library)
}

/// Whether a message still has what the base's has.
fn keeps(question: &Question, base: &Question) -> Result<(), String> {
    let texts =
        |question: &Question| format!("{}\n{}", question.prompt.system, question.prompt.user);
    let (now, before) = (texts(question), texts(base));
    let form = answer_form(&verdict::schema(base.case.task));
    let lost = |part: &str| before.contains(part) && !now.contains(part);
    if lost(base.description.trim()) {
        return Err(
            "the description of the scene is not in the messages: keep {{ description }}".into(),
        );
    }
    if lost(form.trim()) {
        return Err(
            "the form of the answer is not in the messages: keep the include of _answer.md".into(),
        );
    }
    let name = base.case.name.as_str();
    if now.contains(name) && !before.contains(name) {
        return Err(
            "the messages say the name of the scenario: {{ scenario }} may not be shown".into(),
        );
    }
    Ok(())
}

/// Names, ids and numbers of the dev scenarios.
#[derive(Debug, Default)]
pub(super) struct Traces {
    /// In small letters.
    names: BTreeSet<String>,
    ids: BTreeSet<u64>,
    /// Hashes of so many numbers in a row.
    runs: BTreeSet<u64>,
}

/// So many numbers in the same order are no chance.
const IN_A_ROW: usize = 5;

/// Shorter names are words of the language, too.
const SHORTEST_NAME: usize = 6;

/// Ids from here on are no quantities of a rule.
const LONG_ID: u64 = 100;

/// What obstacles are called in descriptions, before their ids.
const KINDS: [&str; 14] = [
    "obstacle",
    "vehicle",
    "car",
    "truck",
    "bus",
    "van",
    "bicycle",
    "cyclist",
    "motorcycle",
    "pedestrian",
    "train",
    "id",
    "object",
    "building",
];

impl Traces {
    pub fn new<'a>(scenarios: &[String], questions: impl Iterator<Item = &'a Question>) -> Self {
        let mut found = Self::default();
        for name in scenarios {
            let parts = [name.as_str(), identity::family(name)];
            let long = parts.iter().filter(|name| name.len() >= SHORTEST_NAME);
            found.names.extend(long.map(|name| name.to_lowercase()));
        }
        for question in questions {
            let scene = &question.case.scene;
            let ids = scene.scenario.obstacles.iter().map(|obstacle| obstacle.id);
            found
                .ids
                .extend(ids.filter_map(|id| u64::try_from(id).ok()));
            found.runs.extend(runs(&question.description));
        }
        found
    }

    /// What of the scenarios a text says that `before` does not.
    pub fn found(&self, text: &str, before: &str) -> Option<String> {
        let (small, before_small) = (text.to_lowercase(), before.to_lowercase());
        let name = self
            .names
            .iter()
            .find(|name| small.contains(name.as_str()) && !before_small.contains(name.as_str()));
        if let Some(name) = name {
            return Some(format!("it names a scenario that it was tuned on ({name})"));
        }
        let known = self.named_ids(&before_small);
        if let Some(id) = self.named_ids(&small).difference(&known).next() {
            return Some(format!(
                "it names obstacle {id} of a scene that it was tuned on"
            ));
        }
        let known: BTreeSet<u64> = runs(before).collect();
        runs(text)
            .any(|run| self.runs.contains(&run) && !known.contains(&run))
            .then(|| {
                format!("it copies {IN_A_ROW} numbers in a row of a scene that it was tuned on")
            })
    }

    /// The ids of obstacles in a text of small letters.
    fn named_ids(&self, text: &str) -> BTreeSet<u64> {
        let mut found = BTreeSet::new();
        let mut before = "";
        for word in text.split(|c: char| !(c.is_alphanumeric() || c == '.' || c == '_')) {
            let word = word.trim_matches('.');
            if let Ok(id) = word.parse::<u64>()
                && self.ids.contains(&id)
                && (id >= LONG_ID || KINDS.contains(&before.trim_end_matches('s')))
            {
                found.insert(id);
            }
            if !word.is_empty() {
                before = word;
            }
        }
        found
    }
}

/// A hash of each [`IN_A_ROW`] numbers in a row with a fraction: times and whole numbers repeat in every scene.
fn runs(text: &str) -> impl Iterator<Item = u64> {
    let numbers: Vec<&str> = text
        .split(|c: char| !(c.is_ascii_digit() || c == '.'))
        .map(|number| number.trim_matches('.'))
        .filter(|number| number.contains('.') && !number.trim_matches(['0', '.']).is_empty())
        .collect();
    let hash = |run: &[&str]| {
        let mut hasher = DefaultHasher::new();
        run.hash(&mut hasher);
        hasher.finish()
    };
    let all: Vec<u64> = numbers.windows(IN_A_ROW).map(hash).collect();
    all.into_iter()
}

/// A unified diff of a template file; blank where both are the same.
#[must_use]
pub fn template_diff(file: &str, before: &str, after: &str) -> String {
    // Of texts that have little in common a coarser difference will do.
    let difference = TextDiff::configure()
        .timeout(Duration::from_millis(300))
        .diff_lines(before, after);
    let mut unified = difference.unified_diff();
    unified.header(file, file).to_string()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::{front, template_diff, *};

    #[test]
    fn an_answer_is_read_alone_and_within_text() {
        let object = json!({ "diagnosis": "d", "change": "c", "template": "{% block user %}" });
        let alone = Proposal::read(&object.to_string()).unwrap();
        assert_eq!(
            (alone.change.as_str(), alone.template.as_str()),
            ("c", "{% block user %}")
        );
        let within = format!("Here it is:\n```json\n{object}\n```\n");
        assert_eq!(Proposal::read(&within).unwrap(), alone);
        let lines = "{\"diagnosis\": \"d\", \"change\": \"c\", \"template\": \"{% block user %}\n{{ description }}\n{% endblock %}\"}";
        let lines = Proposal::read(lines).unwrap();
        assert_eq!(
            lines.template,
            "{% block user %}\n{{ description }}\n{% endblock %}"
        );
        for (wrong, why) in [
            ("no", "not the JSON"),
            ("{\"change\": \"c\"}", "missing field `template`"),
            ("{\"template\": \" \"}", "no template"),
            ("} {", "not the JSON"),
        ] {
            assert!(Proposal::read(wrong).unwrap_err().contains(why), "{wrong}");
        }
    }

    #[test]
    fn nothing_on_the_front_is_beaten() {
        assert_eq!(front(&[]), Vec::<usize>::new());
        assert_eq!(front(&[(0.5, 1.0)]), [0]);
        // Dearer and better, cheaper and worse, beaten by both, equal to the first.
        assert_eq!(
            front(&[(0.5, 1.0), (0.8, 2.0), (0.4, 0.5), (0.4, 1.5), (0.5, 1.0)]),
            [0, 1, 2]
        );
        assert_eq!(front(&[(0.5, 1.0), (0.5, 0.9)]), [1]);
    }

    #[test]
    fn names_ids_and_numbers_in_a_row_are_traces() {
        let traces = Traces {
            names: BTreeSet::from(["deu_town-7".to_string()]),
            ids: BTreeSet::from([7, 301]),
            runs: runs("car 301: 3.25 m, 1.50 m/s, 0.00 s, 7.75 m, 8.50 m, 9.25 m").collect(),
        };
        let found = |text: &str, before: &str| traces.found(text, before).unwrap_or_default();
        assert!(found("as in DEU_Town-7_1_T-1", "").contains("names a scenario"));
        assert!(found("mind 301 then", "").contains("obstacle 301"));
        assert!(found("mind car 7 then", "").contains("obstacle 7"));
        assert_eq!(found("wait 7 s", ""), "");
        assert_eq!(found("car 301 is far", "Example: car 301"), "");
        let copied = "3.25 and 1.50 and 7.75 and 8.50 and 9.25";
        assert!(found(copied, "").contains("numbers in a row"));
        assert_eq!(found(copied, copied), "");
        assert_eq!(found("3.25 and 1.50 and 7.75 and 8.50 and 9.5", ""), "");
    }

    #[test]
    fn a_changed_line_is_shown_with_its_file() {
        let diff = template_diff("t.md", "a\nb\nc\n", "a\nx\nc\n");
        assert_eq!(
            diff,
            "--- t.md\n+++ t.md\n@@ -1,3 +1,3 @@\n a\n-b\n+x\n c\n"
        );
        assert_eq!(template_diff("t.md", "a\n", "a\n"), "");
    }
}
