//! What a tune is given, asks at most, tells on the way and comes to, and how it fails.

use std::collections::BTreeMap;
use std::sync::Arc;

use nearmiss_ask::llm::{self, Message, Request, Role};
use nearmiss_store::{Store, StoreError};
use nearmiss_study::evaluation::batch::{Estimate, Price, Size, question_key};
use nearmiss_study::evaluation::statistics::{FEWEST, Gain, PairedCounts, gains};
use nearmiss_study::evaluation::{Cluster, Confusion, Judge, ModelJudge, can_ask};
use strum::{IntoStaticStr, VariantArray};

use super::TuneSettings;
use super::candidate::{Candidate, CostMeasure, Refusal};
use super::prepare::{DevPart, TunePlan};
use super::reflect::{MAX_LENGTH, Reflector};
use super::rounds::{MINIBATCH, Replied};
use crate::batch::BatchControl;

/// By what templates are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Measure {
    /// F1.
    F1,
    /// Accuracy, where no window of the selection part is dangerous.
    Accuracy,
}

nearmiss_record::named!(Measure);

impl Measure {
    /// Its name for people.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::F1 => "F1",
            Self::Accuracy => "accuracy",
        }
    }

    /// Its value.
    #[must_use]
    pub fn value(self, counts: &Confusion) -> Option<f64> {
        match self {
            Self::F1 => counts.f1(),
            Self::Accuracy => counts.accuracy(),
        }
    }
}

/// What was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Usage {
    /// Answers that were asked for now.
    pub answers: usize,
    /// Answers that the store had.
    pub answers_stored: usize,
    /// Proposals that were asked for now.
    pub reflections: usize,
    /// Proposals that the store had.
    pub reflections_stored: usize,
}

/// What a tune comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct TuneOutcome {
    /// The templates that were compared; the first one is the base.
    pub candidates: Vec<Candidate>,
    /// Proposals that did not become candidates.
    pub refused: Vec<Refusal>,
    /// By what they are compared.
    pub measure: Measure,
    /// What the front holds against it.
    pub cost: CostMeasure,
    /// The number of the candidate with the largest gain; `None` where none is better than the base.
    pub best: Option<usize>,
    /// Whether its gain is no chance.
    pub found: bool,
    /// Units of the selection part, which intervals are over.
    pub units: usize,
    /// What these are.
    pub cluster: Cluster,
    /// Rounds that were begun.
    pub rounds: u32,
    /// Why it ended before its last round; `None` if it did not.
    pub stopped: Option<String>,
    /// What was asked.
    pub usage: Usage,
}

impl TuneOutcome {
    /// The best candidate, with its gain.
    #[must_use]
    pub fn best(&self) -> Option<(&Candidate, Gain)> {
        let candidate = &self.candidates[self.best?];
        Some((candidate, candidate.gain?))
    }

    /// The template that was found to be better.
    #[must_use]
    pub fn winner(&self) -> Option<&Candidate> {
        self.best().filter(|_| self.found).map(|(winner, _)| winner)
    }

    /// Whether there are enough units to tell a gain from chance.
    #[must_use]
    pub fn can_tell(&self) -> bool {
        self.units >= FEWEST as usize
    }
}

/// Gains of all candidates over the base, and the best of them. One that answers alike to every question is none: its F1
/// may be larger, and it judges nothing.
pub(super) fn conclude(
    plan: &TunePlan,
    selection: &[usize],
    candidates: &mut [Candidate],
    replies: &[Replied],
    (measure, cost): (Measure, CostMeasure),
) -> Option<usize> {
    let pairs: Vec<Vec<PairedCounts>> = (1..candidates.len())
        .map(|number| paired(plan, selection, &replies[0], &replies[number]))
        .collect();
    let found = gains(&pairs, |counts| measure.value(counts));
    for (candidate, gain) in candidates[1..].iter_mut().zip(found) {
        candidate.gain = gain;
    }
    let gain = |one: &Candidate| one.gain.map_or(0.0, |gain| gain.difference);
    // Of equally good ones the cheapest, of these the first.
    let key = |one: &Candidate| (gain(one), -cost.of_score(&one.score));
    let judges = |one: &&Candidate| one.score.counts.always().is_none();
    let better = candidates[1..]
        .iter()
        .filter(judges)
        .filter(|one| gain(one) > 0.0);
    let best = better.reduce(|best, one| if key(one) > key(best) { one } else { best });
    best.map(|one| one.number)
}

/// The counts of both by unit, of the questions that both answered.
fn paired(
    plan: &TunePlan,
    selection: &[usize],
    base: &Replied,
    candidate: &Replied,
) -> Vec<PairedCounts> {
    let unit = |at: &usize| {
        let scenario = &plan.scenarios[plan.questions[*at].scenario];
        plan.cluster().unit(scenario)
    };
    let mut counts: BTreeMap<&str, PairedCounts> = selection
        .iter()
        .map(|at| (unit(at), PairedCounts::default()))
        .collect();
    for at in selection {
        let asked = &plan.questions[*at];
        let both = (base.get(at), candidate.get(at));
        let (Some(Ok(base)), Some(Ok(other))) = both else {
            continue;
        };
        let truth = asked.truth.collides();
        let [before, after] = counts.entry(unit(at)).or_default();
        before.count(base.yes, truth);
        after.count(other.yes, truth);
    }
    counts.into_values().collect()
}

/// Who is asked, within one budget, and where answers are kept.
pub struct TuneModels {
    /// Who answers the questions.
    pub judge: Arc<Judge>,
    /// Who proposes templates.
    pub reflect: Box<ModelJudge>,
    /// Requests on their way at once.
    pub at_once: usize,
    /// Where answers are kept, and looked for.
    pub store: Arc<Store>,
    /// Stops the tune.
    pub control: BatchControl,
}

/// Events of a tune.
#[derive(Debug)]
pub enum TuneEvent<'a> {
    /// Questions are asked with a template.
    Asking {
        /// The number of the candidate; of a proposal the number that it will have.
        candidate: usize,
        /// About which part.
        part: DevPart,
        /// Answers so far.
        done: usize,
        /// Questions.
        of: usize,
    },
    /// A better template is asked for.
    Reflecting {
        /// The round, from 1.
        round: u32,
        /// The proposal in it, from 1.
        number: u32,
        /// The candidate that is to be bettered.
        parent: usize,
    },
    /// A proposal did not become a candidate.
    Refused(&'a Refusal),
    /// A candidate was asked with on the whole selection part.
    Compared(&'a Candidate),
}

/// Why there is no outcome.
#[derive(Debug, thiserror::Error)]
pub enum TuneError {
    /// The user ended it.
    #[error("interrupted")]
    Interrupted,
    /// It ended before the base was measured.
    #[error("the base template could not be measured: {0}")]
    NoBase(String),
    /// The store refused.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// Questions and proposals at most, and the most they can cost.
#[derive(Debug, Clone, PartialEq)]
pub struct TuneEstimate {
    /// Answers of the base that are missing: what is asked in any case.
    pub base: Estimate,
    /// Answers at most, all templates together, those of the store included.
    pub answers: usize,
    /// Proposals at most.
    pub reflections: usize,
    /// The most that all can cost, US dollars, with templates as long as the base; `None` where a price or a limit of
    /// tokens is unknown.
    pub most_usd: Option<f64>,
}

/// Estimates a tune; nothing is sent.
///
/// # Errors
/// The store cannot be read.
pub fn estimate(
    plan: &TunePlan,
    models: &TuneModels,
    settings: &TuneSettings,
    store: &Store,
) -> Result<TuneEstimate, StoreError> {
    let mut base = Estimate::default();
    let mut dearest: Option<f64> = Some(0.0);
    for one in &plan.questions {
        let mut size = Size::estimate(&one.question, &models.judge);
        let price = match size.price {
            Price::AtMost(usd) => Some(usd),
            Price::Free => Some(0.0),
            _ => None,
        };
        dearest = dearest.zip(price).map(|(a, b)| a.max(b));
        let key = question_key(&one.question, &models.judge)?;
        size.stored = match &key {
            Some(key) => store.has_answer(key, 0)?,
            None => false,
        };
        base.add(Some(size), None);
    }
    let proposals = (settings.rounds * settings.candidates) as usize;
    let (feedback, selection) = (
        plan.of_part(DevPart::Feedback).len(),
        plan.of_part(DevPart::Selection).len(),
    );
    // Every candidate is asked the selection part and the few shown questions; a parent all feedback questions at most.
    let parents = (settings.rounds as usize).saturating_sub(1);
    let more = proposals * (selection + MINIBATCH.min(feedback)) + parents * feedback;
    let request = longest(plan, models);
    let reflection = models.reflect.endpoint.at_most(&request);
    let known = base.unbounded == 0 && base.unpriced == 0;
    let most_usd = reflection
        .zip(dearest)
        .filter(|_| known)
        .map(|(reflection, answer)| {
            base.usd + reflection * proposals as f64 + answer * more as f64
        });
    Ok(TuneEstimate {
        answers: plan.questions.len() + more,
        reflections: proposals,
        base,
        most_usd,
    })
}

/// A request for a proposal as long as one with the base can be.
fn longest(plan: &TunePlan, models: &TuneModels) -> Request {
    let reflector = Reflector {
        model: models.reflect.clone(),
        store: Arc::clone(&models.store),
        control: models.control.clone(),
    };
    let included = plan.library.included(&plan.template.source);
    let fragments = { included.iter() }.filter_map(|name| plan.library.fragments().get(*name));
    let fragments: usize = fragments.map(String::len).sum();
    let longest = MAX_LENGTH + plan.template.source.len() + fragments;
    reflector.request(vec![Message::new(Role::User, "a".repeat(longest))])
}

/// Whether both models can be asked as things stand, and a proposal is within the budget; nothing is sent.
///
/// # Errors
/// Which cannot be, and why.
pub async fn can_tune(plan: &TunePlan, models: &TuneModels) -> Result<(), String> {
    let model = &models.reflect;
    let request = longest(plan, models);
    let checked = llm::check(&model.client, &model.endpoint, &request).await;
    checked.map_err(|why| format!("{}: a proposal cannot be asked for: {why}", model.id))?;
    let Some(first) = plan.questions.first() else {
        return Ok(());
    };
    let checked = can_ask(&first.question, &models.judge).await;
    checked.map_err(|why| format!("{}: {why}", models.judge.id()))
}
