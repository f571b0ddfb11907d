//! Asks with a template on a part of the questions, and chooses the questions that are shown.

use super::DevPart;
use super::ask::{Graded, Halt, Replies};
use super::candidate::Candidate;
use super::check::rendered;
use super::request::TuneEvent;
use super::rounds::Tuning;
use nearmiss_study::evaluation::Question;
use nearmiss_study::evaluation::statistics::SplitMix;

/// Wrong answers that are looked for before a template is reflected on; as many right ones are asked again with them.
pub(super) const WRONG: usize = 6;

/// Feedback questions that are asked at a time until enough wrong answers are there.
const AT_A_TIME: usize = 8;

/// The feedback questions of a round.
pub(super) struct Minibatch {
    /// The candidate that answered them.
    pub parent: usize,
    /// All dev questions as it asks them.
    pub questions: Vec<Question>,
    /// Those it answered wrong.
    pub wrong: Vec<usize>,
    /// Some of those it answered right, so that what is spoilt is seen, too.
    pub right: Vec<usize>,
    /// Of all that were asked: how many it answered right, and how many not.
    pub asked: (usize, usize),
}

impl Minibatch {
    /// Tokens of all dev questions as the parent asks them.
    pub fn tokens(&self) -> usize {
        self.questions.iter().map(Question::tokens).sum()
    }

    /// All places.
    pub fn places(&self) -> Vec<usize> {
        [&self.wrong[..], &self.right].concat()
    }
}

impl<F: FnMut(TuneEvent<'_>)> Tuning<'_, F> {
    /// Asks these questions; `number` is what the template is called.
    pub(super) async fn ask(
        &mut self,
        number: usize,
        part: DevPart,
        questions: Vec<(usize, Question)>,
    ) -> Result<Replies, Halt> {
        let of = questions.len();
        let (on_event, mut done) = (&mut self.on_event, 0);
        on_event(TuneEvent::Asking {
            candidate: number,
            part,
            done,
            of,
        });
        let asked = self.asker.ask(self.plan, questions, &mut self.usage, || {
            done += 1;
            on_event(TuneEvent::Asking {
                candidate: number,
                part,
                done,
                of,
            });
        });
        asked.await
    }

    /// The questions of a candidate that are shown in a round; `None` where it answers all feedback questions right.
    pub(super) async fn minibatch(
        &mut self,
        parent: usize,
        round: u32,
    ) -> Result<Option<Minibatch>, Halt> {
        let questions = self.questions_of(parent)?;
        let seed = self.settings.seed ^ (u64::from(round) << 32);
        let mut order = self.plan.of_part(DevPart::Feedback);
        shuffle(&mut order, seed);
        let (mut wrong, mut right) = (Vec::new(), Vec::new());
        for some in order.chunks(AT_A_TIME) {
            let known = &self.replies[parent];
            let open: Vec<(usize, Question)> = some
                .iter()
                .filter(|at| !known.contains_key(at))
                .map(|at| (*at, questions[*at].clone()))
                .collect();
            if !open.is_empty() {
                let replies = self.ask(parent, DevPart::Feedback, open).await?;
                self.replies[parent].extend(replies);
            }
            for at in some {
                match self.replies[parent].get(at) {
                    Some(Ok(Graded { right: true, .. })) => right.push(*at),
                    Some(Ok(_)) => wrong.push(*at),
                    Some(Err(_)) | None => {}
                }
            }
            if wrong.len() >= WRONG {
                break;
            }
        }
        let asked = (right.len(), wrong.len());
        wrong.truncate(WRONG);
        right.truncate(wrong.len());
        Ok((!wrong.is_empty()).then_some(Minibatch {
            parent,
            questions,
            wrong,
            right,
            asked,
        }))
    }

    /// All dev questions as a candidate asks them.
    pub(super) fn questions_of(&self, number: usize) -> Result<Vec<Question>, Halt> {
        let source = &self.candidates[number].source;
        rendered(self.plan, source).map_err(Halt::Stopped)
    }

    /// The candidate that is changed in a round: in odd ones the best of the front, else another of it.
    pub(super) fn parents(&self, round: u32) -> Vec<usize> {
        let mut front: Vec<&Candidate> = self.candidates.iter().filter(|c| c.on_front).collect();
        let value = |one: &Candidate| one.score.value(self.measure).unwrap_or(0.0);
        front.sort_by(|a, b| value(b).total_cmp(&value(a)).then(a.number.cmp(&b.number)));
        let mut numbers: Vec<usize> = front.iter().map(|one| one.number).collect();
        if round.is_multiple_of(2) && numbers.len() > 1 {
            let mut random = SplitMix(self.settings.seed ^ u64::from(round));
            let other = 1 + random.below(numbers.len() - 1);
            let other = numbers.remove(other);
            numbers.insert(0, other);
        }
        numbers.retain(|number| !self.exhausted.contains(number));
        numbers
    }
}

/// Fisher and Yates.
fn shuffle(places: &mut [usize], seed: u64) {
    let mut random = SplitMix(seed);
    for last in (1..places.len()).rev() {
        places.swap(last, random.below(last + 1));
    }
}
