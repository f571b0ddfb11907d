//! The result of a tune for programs, and what one would ask, before anything is sent.

use nearmiss_workflow::tune::{
    Candidate, DevPart, Refusal, RefusedBecause, TuneEstimate, TuneOutcome, TunePlan, template_diff,
};
use schemars::JsonSchema;
use serde::Serialize;

use super::Tuned;
use super::words::{can_find_gain, gain, parts, yes_or_no};
use crate::{Outcome, output};

/// A tune.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TuneDocument {
    /// The experiment file.
    experiment: String,
    task: &'static str,
    frame: Option<&'static str>,
    techniques: Option<String>,
    model: String,
    /// Model that proposed templates.
    reflect: String,
    template: String,
    template_hash: String,
    /// Seed of parts, shown answers and parents.
    seed: u64,
    /// Scenarios and questions of both parts of the dev split.
    parts: Vec<PartDocument>,
    /// Whether scenarios on the same map are in one part.
    divided_by_map: bool,
    /// Scenarios of the test split, none of which was opened.
    test_scenarios: usize,
    /// What templates are compared by: f1 or accuracy.
    measure: &'static str,
    /// What the front holds against it: usd, tokens or unknown.
    front_cost: &'static str,
    /// Templates that were asked with on the selection part; the first one is the base.
    templates: Vec<CandidateDocument>,
    /// Proposals that were refused or not better.
    refused: Vec<RefusalDocument>,
    /// Number of the candidate with the largest gain; null if none is better than the base.
    best: Option<usize>,
    /// Whether its gain is above chance.
    found: bool,
    /// The gain in a sentence.
    result: String,
    /// Rounds that were begun.
    rounds: u32,
    /// Why it ended before its last round; null if it did not.
    stopped: Option<String>,
    /// Questions that were asked now.
    answers: usize,
    /// Answers that came from the store.
    answers_stored: usize,
    /// Proposals that were asked for now.
    reflections: usize,
    /// Proposals that came from the store.
    reflections_stored: usize,
    /// Cost of this run in US dollars; of requests of unknown cost the most they can have cost.
    spent_usd: f64,
    /// Budget in US dollars.
    budget: f64,
}

/// A part of the dev split.
#[derive(Debug, Serialize, JsonSchema)]
struct PartDocument {
    /// feedback or selection.
    part: &'static str,
    scenarios: usize,
    questions: usize,
    /// Questions about dangerous windows.
    dangerous: usize,
}

/// A template that was compared.
#[derive(Debug, Serialize, JsonSchema)]
struct CandidateDocument {
    /// Its number; 0 is the base.
    number: usize,
    /// Number of the template that it was made from.
    parent: Option<usize>,
    /// Round in which it was proposed, from 1; 0 for the base.
    round: u32,
    template_hash: String,
    /// What it changes.
    change: String,
    /// What the reflecting model found wrong with its parent.
    diagnosis: String,
    tp: u32,
    fp: u32,
    #[serde(rename = "fn")]
    false_negatives: u32,
    tn: u32,
    f1: Option<f64>,
    accuracy: Option<f64>,
    specificity: Option<f64>,
    /// The one answer to every question, yes or no, which is never a gain; null if they differ.
    always: Option<&'static str>,
    /// Answers that cannot be read, which count as wrong.
    unreadable: usize,
    /// Questions without an answer.
    missing: usize,
    /// Mean cost of an answer in US dollars.
    mean_usd: Option<f64>,
    /// Mean tokens of question and answer.
    mean_tokens: Option<f64>,
    on_front: bool,
    /// Gain over the base on the questions that both answered.
    gain: Option<GainDocument>,
    /// Unified diff to the base.
    diff: String,
}

/// A gain.
#[derive(Debug, Serialize, JsonSchema)]
struct GainDocument {
    difference: f64,
    /// Lower end of the simultaneous interval of 95 %.
    low: f64,
    /// Its upper end.
    high: f64,
    /// p value, corrected for the number of templates.
    p: f64,
}

/// A proposal that did not become a candidate.
#[derive(Debug, Serialize, JsonSchema)]
struct RefusalDocument {
    round: u32,
    number: u32,
    parent: usize,
    change: String,
    /// invalid, not_better or unanswered.
    kind: &'static str,
    why: String,
}

/// The parts of a plan.
fn part_documents(plan: &TunePlan) -> Vec<PartDocument> {
    let part = |part: DevPart| {
        let (scenarios, questions, dangerous) = plan.counts(part);
        PartDocument {
            part: part.name(),
            scenarios,
            questions,
            dangerous,
        }
    };
    vec![part(DevPart::Feedback), part(DevPart::Selection)]
}

impl TuneDocument {
    /// The document of an outcome.
    pub(super) fn new(tuned: &Tuned<'_>, outcome: &TuneOutcome) -> Self {
        let (plan, usage) = (tuned.plan, &outcome.usage);
        let way = &plan.configuration;
        Self {
            experiment: tuned.arguments.experiment.display().to_string(),
            task: way.task.name(),
            frame: way.frame.map(|frame| frame.name()),
            techniques: way.techniques.map(|techniques| techniques.to_string()),
            model: way.model.clone(),
            reflect: tuned.reflect.to_string(),
            template: plan.file.clone(),
            template_hash: plan.hash.clone(),
            seed: tuned.settings.seed,
            parts: part_documents(plan),
            divided_by_map: plan.division.by_map,
            test_scenarios: tuned.test_scenarios,
            measure: outcome.measure.name(),
            front_cost: outcome.cost.name(),
            templates: outcome
                .candidates
                .iter()
                .map(|one| candidate(plan, one))
                .collect(),
            refused: outcome.refused.iter().map(refusal).collect(),
            best: outcome.best,
            found: outcome.found,
            result: gain(outcome),
            rounds: outcome.rounds,
            stopped: outcome.stopped.clone(),
            answers: usage.answers,
            answers_stored: usage.answers_stored,
            reflections: usage.reflections,
            reflections_stored: usage.reflections_stored,
            spent_usd: tuned.spent,
            budget: tuned.budget,
        }
    }
}

fn candidate(plan: &TunePlan, one: &Candidate) -> CandidateDocument {
    let counts = &one.score.counts;
    CandidateDocument {
        number: one.number,
        parent: one.parent,
        round: one.round,
        template_hash: one.hash.clone(),
        change: one.change.clone(),
        diagnosis: one.diagnosis.clone(),
        tp: counts.true_positives,
        fp: counts.false_positives,
        false_negatives: counts.false_negatives,
        tn: counts.true_negatives,
        f1: counts.f1(),
        accuracy: counts.accuracy(),
        specificity: counts.specificity(),
        always: counts.always().map(yes_or_no),
        unreadable: one.score.unreadable,
        missing: one.score.missing,
        mean_usd: one.score.usd,
        mean_tokens: one.score.tokens,
        on_front: one.on_front,
        gain: one.gain.map(|gain| GainDocument {
            difference: gain.difference,
            low: gain.interval.low,
            high: gain.interval.high,
            p: gain.p,
        }),
        diff: template_diff(&plan.file, &plan.template.source, &one.source),
    }
}

fn refusal(one: &Refusal) -> RefusalDocument {
    RefusalDocument {
        round: one.round,
        number: one.number,
        parent: one.parent,
        change: one.change.clone(),
        kind: match one.because {
            RefusedBecause::Invalid(_) => "invalid",
            RefusedBecause::NotBetter { .. } => "not_better",
            RefusedBecause::Unanswered { .. } => "unanswered",
        },
        why: one.because.to_string(),
    }
}

/// What a tune would ask.
#[derive(Debug, Serialize, JsonSchema)]
pub struct TuneDryRunDocument {
    model: String,
    /// Model that proposes templates.
    reflect: String,
    template: String,
    template_hash: String,
    /// Scenarios and questions of both parts of the dev split.
    parts: Vec<PartDocument>,
    /// Whether a gain can be found: the selection part has enough scenarios to tell it from chance.
    can_find_gain: bool,
    /// Scenarios of the test split, none of which is opened.
    test_scenarios: usize,
    /// Answers at most, those in the store included.
    answers: usize,
    /// Proposals at most.
    reflections: usize,
    most_usd: Option<f64>,
    /// Budget in US dollars; nothing is sent that could exceed it.
    budget: f64,
}

impl TuneDryRunDocument {
    /// The document of an estimate.
    pub(super) fn new(
        (plan, test_scenarios, reflect): (&TunePlan, usize, &str),
        estimate: &nearmiss_workflow::tune::TuneEstimate,
        budget: f64,
    ) -> Self {
        Self {
            model: plan.configuration.model.clone(),
            reflect: reflect.to_string(),
            template: plan.file.clone(),
            template_hash: plan.hash.clone(),
            parts: part_documents(plan),
            can_find_gain: can_find_gain(plan),
            test_scenarios,
            answers: estimate.answers,
            reflections: estimate.reflections,
            most_usd: estimate.most_usd,
            budget,
        }
    }
}

/// Writes what would be asked at most.
pub fn write_dry_run(
    estimate: &TuneEstimate,
    about: (&TunePlan, usize, &str),
    budget: f64,
    as_json: bool,
) -> Outcome {
    if as_json {
        return output::document(&TuneDryRunDocument::new(about, estimate, budget));
    }
    let (plan, test_scenarios, reflect) = about;
    let mut text = format!(
        "template       {} ({}…)\nmodel          {}\nproposals by   {reflect}\n",
        plan.file,
        &plan.hash[..plan.hash.len().min(12)],
        plan.configuration.model
    );
    for line in parts(plan, test_scenarios) {
        text += &format!("{:15}{line}\n", "");
    }
    let base = &estimate.base;
    text += &format!(
        "base           {} of both parts not in the store, {}\n",
        output::counted(base.requests as usize, "answer"),
        base.price()
    );
    text += &format!(
        "at most        {} and {}\n",
        output::counted(estimate.answers, "answer"),
        output::counted(estimate.reflections, "proposal")
    );
    text += &match estimate.most_usd {
        Some(usd) if usd <= budget => format!("cost           at most ${usd:.4}, within the budget of ${budget:.4}\n"),
        Some(usd) => format!(
            "cost           at most ${usd:.4}; the tune ends when the budget of ${budget:.4} does not cover the next request\n"
        ),
        None => "cost           unknown, so nothing is sent: set a price of the model and `max_tokens`\n".into(),
    };
    output::text(&output::visible(&text))
}
