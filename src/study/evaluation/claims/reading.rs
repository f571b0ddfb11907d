//! Reads a sentence: its words, whom they mean, its clauses, its claims and their times.

use super::cast::Cast;
use super::clauses::{Clause, Spoken, Who, clauses};
use super::find::MentionContext;
use super::mentions::Mention;
use super::number::{MentionedTime, Number, Unit};
use super::references::{Named, Reference, references};
use super::sentence::Sentence;
use super::tokens::{Token, tokens};
use super::{Claim, ClaimedValue, Extent, Judgement, Predicate, Quantity, Subject, check};

/// The claims of a sentence, and whom its clauses are about.
///
/// Of whom a description means that fits several is one of whom all holds: "there is a car 20 m ahead" is so if there is one.
pub fn read(
    words: (&str, &[Number], &[Mention], usize),
    (times, when, spoken): (&[(usize, Option<i64>)], MentionedTime, &Spoken),
    above: (&str, bool),
    world: &MentionContext<'_>,
) -> (Vec<Claim>, Vec<Who>) {
    let (lower, all, named, _) = words;
    let tokens = tokens(lower, all);
    let cast = Cast {
        scene: world.subject.map(|subject| subject.scene),
        step: match when {
            MentionedTime::Step(step) => step,
            _ => world.present,
        },
    };
    let references = references(&tokens, named, cast);
    let of = |references: &[Reference]| {
        let sentence = (tokens.as_slice(), references);
        read_as(sentence, words, (times, when, spoken), above, world)
    };
    let found = of(&references);
    let open = references.iter().position(|r| !r.candidates.is_empty());
    let (Some(place), Some(subject)) = (open, world.subject) else {
        return found;
    };
    let one = &references[place];
    let of_one = |id: i64| {
        let mut as_one = references.clone();
        as_one[place].who = Named::Obstacle(id);
        of(&as_one)
    };
    // One of whom all holds is meant before one of whom nothing is wrong.
    let mut likely = None;
    for id in one.candidates.iter().take(CANDIDATES) {
        let reading = of_one(*id);
        match suits(one, &reading.0, *id, subject) {
            Some(true) => return reading,
            Some(false) => likely = likely.or(Some(reading)),
            None => {}
        }
    }
    likely
        .or_else(|| by_number(one, &of_one, subject))
        .unwrap_or(found)
}

/// Whether what is said of a description may be said of an obstacle: whether all of it holds, or nothing of it is wrong.
fn suits(one: &Reference, claims: &[Claim], id: i64, subject: &Subject<'_>) -> Option<bool> {
    let own = claims.iter().filter(|claim| claim.obstacle == id);
    let judged: Vec<(&Claim, Judgement)> = own
        .map(|claim| (claim, check(claim.clone(), subject).judgement))
        .collect();
    let is_right = |(_, judgement): &(&Claim, Judgement)| *judgement == Judgement::Right;
    // "The car" is a certain one: that all holds of it must be no chance.
    let tells = |(claim, _): &(&Claim, Judgement)| match claim.stated {
        ClaimedValue::Number { .. } => true,
        ClaimedValue::Word { predicate, .. } => matches!(
            predicate,
            Predicate::CutsIn | Predicate::ChangesLane | Predicate::Crossing
        ),
        _ => false,
    };
    let is_told = judged
        .iter()
        .any(|one| is_right(one) && !one.0.is_described)
        && (!one.is_definite || judged.iter().any(|one| is_right(one) && tells(one)));
    let is_wrong = judged.iter().any(|one| one.1 == Judgement::Wrong);
    (is_told && !is_wrong).then(|| judged.iter().all(is_right))
}

/// The reading of a description by the only one of whom a number with a digit behind the point holds, whatever else is said.
fn by_number(
    one: &Reference,
    of: &dyn Fn(i64) -> (Vec<Claim>, Vec<Who>),
    subject: &Subject<'_>,
) -> Option<(Vec<Claim>, Vec<Who>)> {
    let mut all = { one.candidates.iter().take(CANDIDATES) }.filter_map(|id| {
        let (claims, who) = of(*id);
        let tells = |claim: &Claim| {
            let is_exact = matches!(
                claim.stated,
                ClaimedValue::Number {
                    decimals: 1..,
                    rough: false,
                    ..
                }
            );
            claim.obstacle == *id
                && is_exact
                && check(claim.clone(), subject).judgement == Judgement::Right
        };
        claims.iter().any(tells).then_some((claims, who))
    });
    all.next().filter(|_| all.next().is_none())
}

/// Of a description that fits several so many are tried.
const CANDIDATES: usize = 12;

/// The claims of a sentence whose words mean these participants.
fn read_as(
    (tokens, references): (&[Token], &[Reference]),
    (lower, all, _, start): (&str, &[Number], &[Mention], usize),
    (times, when, spoken): (&[(usize, Option<i64>)], MentionedTime, &Spoken),
    (above, asks_place): (&str, bool),
    world: &MentionContext<'_>,
) -> (Vec<Claim>, Vec<Who>) {
    let step = match when {
        MentionedTime::Step(step) => Some(step),
        _ => None,
    };
    let clauses = clauses(tokens, references, spoken);
    let who = clauses.iter().map(|clause| clause.who.clone()).collect();
    let taken: Vec<bool> = all
        .iter()
        .enumerate()
        .map(|(i, n)| {
            times.iter().any(|(place, _)| *place == i)
                || (n.unit == Unit::None && n.as_integer().is_some())
        })
        .collect();
    let sentence = Sentence {
        lower,
        numbers: all,
        taken: &taken,
        tokens,
        references,
        clauses: &clauses,
        ego: world.ego,
        start,
        above,
        asks_place,
        both: spoken.both,
        has_trajectory: world.has_trajectory,
        step,
    };
    let mut claims = sentence.claims();
    let dated = Dated {
        tokens,
        clauses: &clauses,
        times: { times.iter() }
            .map(|(place, step)| (all[*place].span.start, *step))
            .collect(),
        start,
    };
    dated.leave_asides(&mut claims);
    if when == MentionedTime::Unclear {
        dated.each(&mut claims);
    }
    if let [(_, Some(first)), (_, Some(second))] = times {
        let all = claims.into_iter();
        claims = all
            .flat_map(|claim| at_both(claim, *first, *second))
            .collect();
    }
    (claims, who)
}

/// A sentence with the times that it names.
struct Dated<'a> {
    tokens: &'a [Token],
    clauses: &'a [Clause],
    /// Where each stands in the sentence, bytes, and its step.
    times: Vec<(usize, Option<i64>)>,
    /// Where the sentence begins in the text.
    start: usize,
}

impl Dated<'_> {
    /// "301, which was 2 m away at 3 s, is braking": the time is that of the aside alone.
    fn leave_asides(&self, claims: &mut [Claim]) {
        let is_in = |clause: &Clause, at: usize| {
            let (first, last) = (
                &self.tokens[clause.at.start],
                &self.tokens[clause.at.end - 1],
            );
            (first.span.start..last.span.end).contains(&at)
        };
        let of_time = |clause: &&Clause| {
            clause.is_aside && self.times.iter().all(|(at, _)| is_in(clause, *at))
        };
        if self.times.is_empty() {
            return;
        }
        // "305 passed at 5 s and is now 28 m behind".
        let is_now = |clause: &&Clause| {
            let words = &self.tokens[clause.at.clone()];
            words.iter().any(|t| t.is("now currently meanwhile"))
                && !self.times.iter().any(|(at, _)| is_in(clause, *at))
        };
        for clause in self.clauses.iter().filter(is_now) {
            for claim in claims.iter_mut() {
                if is_in(clause, claim.span.start - self.start) {
                    claim.step = None;
                }
            }
        }
        let Some(aside) = self.clauses.iter().find(of_time) else {
            return;
        };
        for claim in claims {
            if !is_in(aside, claim.span.start - self.start) {
                claim.step = None;
            }
        }
    }

    /// Of several times, each is that of its clause, or of the one before that names none.
    fn each(&self, claims: &mut Vec<Claim>) {
        let ends: Vec<usize> = { self.clauses.iter() }
            .filter_map(|clause| Some(self.start + self.tokens.get(clause.at.end - 1)?.span.end))
            .collect();
        let clause_of = |at: usize| ends.iter().position(|end| at < *end);
        claims.retain_mut(|claim| {
            // Of the window, not of a step.
            let is_wide = claim.extent != Extent::Moment || claim.quantity == Quantity::MinDistance;
            if is_wide || matches!(claim.stated, ClaimedValue::Change { .. }) {
                return claim.extent != Extent::All;
            }
            let own = clause_of(claim.span.start);
            let of = |clause: Option<usize>| {
                let in_clause = |(at, _): &&(usize, _)| clause_of(self.start + at) == clause;
                let mut all = self.times.iter().filter(in_clause);
                let first = all.next()?;
                all.all(|other| other.1 == first.1).then_some(first.1)?
            };
            claim.step = of(own).or_else(|| of(own.map(|clause| clause + 1)));
            claim.step.is_some()
        });
    }
}

/// A change between two times is two numbers, each at its time; other claims are left as they are.
fn at_both(claim: Claim, first: i64, second: i64) -> Vec<Claim> {
    let ClaimedValue::Change {
        from,
        to,
        decimals,
        rough,
    } = claim.stated
    else {
        return vec![claim];
    };
    let one = |value: f64, step| Claim {
        step: Some(step),
        stated: ClaimedValue::Number {
            value,
            decimals,
            rough,
            magnitude: value >= 0.0,
        },
        ..claim.clone()
    };
    vec![one(from, first), one(to, second)]
}
