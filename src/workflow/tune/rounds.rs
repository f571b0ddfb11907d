//! The rounds: a parent, a proposal, a few questions, the whole selection part.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::TuneSettings;
use super::ask::{BatchClient, Graded, Minibatch, Replies, TuneAbort, WRONG_WANTED};
use super::candidate::{
    Candidate, Checked, CostMeasure, Proposal, Refusal, RefusedBecause, Score, check, front,
};
use super::outcome::{Measure, TuneError, TuneEvent, TuneModels, TuneOutcome, Usage, conclude};
use super::prepare::{DevPart, TunePlan};
use super::reflect::{Reflector, WrongAnswer, in_a_line, messages};
use nearmiss_study::evaluation::Question;
use nearmiss_study::evaluation::statistics::FEWEST;

/// Answers of a candidate, by the places of their questions.
pub(super) type Replied = Replies;

/// Feedback questions that a proposal is first asked with, at most.
pub(super) const MINIBATCH: usize = 2 * WRONG_WANTED;

/// Of a template whose questions remain unanswered more often nothing is known.
const MAX_MISSING: f64 = 0.1;

/// A tune on its way.
pub(super) struct Tuning<'a, F> {
    pub plan: &'a TunePlan,
    pub settings: TuneSettings,
    pub asker: BatchClient,
    pub reflector: Reflector,
    pub on_event: F,
    pub usage: Usage,
    pub selection: Vec<usize>,
    pub candidates: Vec<Candidate>,
    /// Of each candidate, about both parts.
    pub replies: Vec<Replied>,
    pub refused: Vec<Refusal>,
    /// What was tried and came of it, for the reflecting model.
    pub tries: Vec<String>,
    /// Candidates that answer all feedback questions right.
    pub exhausted: BTreeSet<usize>,
    pub measure: Measure,
    pub cost: CostMeasure,
    pub rounds: u32,
}

/// Tunes a template: asks for better ones from wrong answers, and compares them with it. Dropping the future cancels what
/// is on its way; what was answered is in the store.
///
/// # Errors
/// See [`TuneError`]. A budget that is used up, and a server that fails later, end the rounds:
/// [`TuneOutcome::stopped`].
pub async fn tune(
    plan: &TunePlan,
    models: TuneModels,
    settings: TuneSettings,
    on_event: impl FnMut(TuneEvent<'_>),
) -> Result<TuneOutcome, TuneError> {
    let mut tuning = Tuning {
        plan,
        settings,
        asker: BatchClient {
            judge: models.judge,
            store: Arc::clone(&models.store),
            at_once: models.at_once,
            control: models.control.clone(),
        },
        reflector: Reflector {
            model: models.reflect,
            store: models.store,
            control: models.control,
        },
        on_event,
        usage: Usage::default(),
        selection: plan.of_part(DevPart::Selection),
        candidates: Vec::new(),
        replies: Vec::new(),
        refused: Vec::new(),
        tries: Vec::new(),
        exhausted: BTreeSet::new(),
        measure: Measure::F1,
        cost: CostMeasure::Unknown,
        rounds: 0,
    };
    let stopped = match tuning.run().await {
        Ok(()) => None,
        Err(TuneAbort::Stopped(why)) => Some(why),
        Err(TuneAbort::Interrupted) => return Err(TuneError::Interrupted),
        Err(TuneAbort::Store(error)) => return Err(error.into()),
    };
    match (tuning.candidates.is_empty(), stopped) {
        (true, why) => Err(TuneError::NoBase(why.unwrap_or_default())),
        (false, stopped) => Ok(tuning.outcome(stopped)),
    }
}

impl<F: FnMut(TuneEvent<'_>)> Tuning<'_, F> {
    async fn run(&mut self) -> Result<(), TuneAbort> {
        self.base().await?;
        for round in 1..=self.settings.rounds {
            let mut shown = None;
            for parent in self.parents(round) {
                shown = self.minibatch(parent, round).await?;
                if shown.is_some() {
                    break;
                }
                self.exhausted.insert(parent);
            }
            let Some(shown) = shown else {
                return Err(TuneAbort::Stopped(
                    "no wrong answers are left in the feedback part".into(),
                ));
            };
            self.rounds = round;
            for number in 1..=self.settings.candidates {
                self.propose(round, number, &shown).await?;
            }
        }
        Ok(())
    }

    /// Measures the base.
    async fn base(&mut self) -> Result<(), TuneAbort> {
        let asked = self
            .selection
            .iter()
            .map(|at| (*at, self.plan.questions[*at].question.clone()));
        let replies = self.ask(0, DevPart::Selection, asked.collect()).await?;
        let score = Score::new(self.plan, &self.selection, &replies);
        if let Some(RefusedBecause::Unanswered { missing, of, why }) = unanswered(&score, &replies)
        {
            let words = format!("{missing} of {of} questions without an answer: {why}");
            return Err(TuneAbort::Stopped(words));
        }
        if score.counts.f1().is_none() {
            self.measure = Measure::Accuracy;
        }
        self.cost = CostMeasure::for_base(&score);
        self.add(
            Candidate {
                number: 0,
                parent: None,
                round: 0,
                change: String::new(),
                diagnosis: String::new(),
                source: self.plan.template.source.clone(),
                hash: self.plan.hash.clone(),
                score,
                on_front: true,
                gain: None,
            },
            replies,
        );
        Ok(())
    }

    /// Asks for a template, and tries it.
    async fn propose(
        &mut self,
        round: u32,
        number: u32,
        shown: &Minibatch,
    ) -> Result<(), TuneAbort> {
        let parent = shown.parent;
        (self.on_event)(TuneEvent::Reflecting {
            round,
            number,
            parent,
        });
        let graded = |at: &usize| self.replies[parent].get(at)?.as_ref().ok();
        let wrong: Vec<WrongAnswer<'_>> = shown
            .wrong
            .iter()
            .filter_map(|at| {
                Some(WrongAnswer {
                    place: *at,
                    question: &shown.questions[*at],
                    graded: graded(at)?,
                })
            })
            .collect();
        let told = (&wrong[..], shown.asked);
        let messages = messages(self.plan, &self.candidates[parent], told, &self.tries);
        let answer = self.reflector.ask(messages, number - 1, &mut self.usage);
        let proposal = answer.await?.and_then(|text| Proposal::read(&text));
        let mut refusal = Refusal {
            round,
            number,
            parent,
            change: String::new(),
            because: RefusedBecause::Invalid(String::new()),
        };
        let checked = proposal.and_then(|said| {
            refusal.change = in_a_line(&said.change);
            let made = check(
                self.plan,
                &said.template,
                &self.candidates[parent],
                &self.candidates,
            );
            Ok((made?, said))
        });
        let (made, said) = match checked {
            Ok(made) => made,
            Err(why) => {
                refusal.because = RefusedBecause::Invalid(why);
                self.refuse(refusal);
                return Ok(());
            }
        };
        match self.tried(&made, shown).await? {
            Err(because) => {
                refusal.because = because;
                self.refuse(refusal);
            }
            Ok((score, replies)) => self.add(
                Candidate {
                    number: self.candidates.len(),
                    parent: Some(parent),
                    round,
                    change: refusal.change,
                    diagnosis: said.diagnosis,
                    source: made.source,
                    hash: made.hash,
                    score,
                    on_front: false,
                    gain: None,
                },
                replies,
            ),
        }
        Ok(())
    }

    /// Asks with a new template: the shown questions first, then, if it is better there, the selection part.
    async fn tried(
        &mut self,
        made: &Checked,
        shown: &Minibatch,
    ) -> Result<Result<(Score, Replies), RefusedBecause>, TuneAbort> {
        let of = |places: &[usize]| {
            let asked = places.iter().map(|at| (*at, made.questions[*at].clone()));
            asked.collect::<Vec<_>>()
        };
        let (places, number) = (shown.places(), self.candidates.len());
        let mut replies = self.ask(number, DevPart::Feedback, of(&places)).await?;
        let right = |reply: Option<&Result<Graded, String>>| {
            matches!(reply, Some(Ok(Graded { right: true, .. })))
        };
        let answered: Vec<&usize> = places
            .iter()
            .filter(|at| matches!(replies.get(at), Some(Ok(_))))
            .collect();
        let now = answered.iter().filter(|at| right(replies.get(at))).count();
        let before = &self.replies[shown.parent];
        let before = answered.iter().filter(|at| right(before.get(at))).count();
        let tokens: usize = made.questions.iter().map(Question::tokens).sum();
        if now < before || now == before && tokens >= shown.tokens() {
            return Ok(Err(RefusedBecause::NotBetter {
                right: now,
                parent: before,
                of: answered.len(),
            }));
        }
        let selection = of(&self.selection);
        let selected = self.ask(number, DevPart::Selection, selection).await?;
        let score = Score::new(self.plan, &self.selection, &selected);
        if let Some(because) = unanswered(&score, &selected) {
            return Ok(Err(because));
        }
        replies.extend(selected);
        Ok(Ok((score, replies)))
    }

    fn refuse(&mut self, refusal: Refusal) {
        self.tries
            .push(format!("{} – {}", refusal.change, refusal.because));
        (self.on_event)(TuneEvent::Refused(&refusal));
        self.refused.push(refusal);
    }

    fn add(&mut self, candidate: Candidate, replies: Replied) {
        let value = |one: &Candidate| one.score.value(self.measure).unwrap_or(0.0);
        if candidate.number > 0 {
            let parent = candidate.parent.unwrap_or_default();
            self.tries.push(format!(
                "{} – {} {:.3} on other scenes, its parent {:.3}",
                candidate.change,
                self.measure.title(),
                value(&candidate),
                value(&self.candidates[parent])
            ));
        }
        self.candidates.push(candidate);
        self.replies.push(replies);
        let points: Vec<(f64, f64)> = { self.candidates.iter() }
            .map(|one| (value(one), self.cost.of_score(&one.score)))
            .collect();
        let unbeaten = front(&points);
        for one in &mut self.candidates {
            one.on_front = unbeaten.contains(&one.number);
        }
        if let Some(added) = self.candidates.last() {
            (self.on_event)(TuneEvent::Compared(added));
        }
    }

    fn outcome(mut self, stopped: Option<String>) -> TuneOutcome {
        let best = conclude(
            self.plan,
            &self.selection,
            &mut self.candidates,
            &self.replies,
            (self.measure, self.cost),
        );
        let units = self.plan.units().len();
        let gain = best.and_then(|best| self.candidates[best].gain);
        TuneOutcome {
            found: gain.is_some_and(|gain| gain.is_found()) && units >= FEWEST as usize,
            candidates: self.candidates,
            refused: self.refused,
            measure: self.measure,
            cost: self.cost,
            best,
            units,
            cluster: self.plan.cluster(),
            rounds: self.rounds,
            stopped,
            usage: self.usage,
        }
    }
}

/// Whether too many questions got no answer, and why the first of them got none.
fn unanswered(score: &Score, replies: &Replies) -> Option<RefusedBecause> {
    let (missing, of) = (score.missing, score.asked);
    let first = || {
        replies
            .values()
            .find_map(|reply| reply.as_ref().err().cloned())
    };
    (missing as f64 > MAX_MISSING * of as f64).then(|| RefusedBecause::Unanswered {
        missing,
        of,
        why: first().unwrap_or_else(|| "not asked".into()),
    })
}
