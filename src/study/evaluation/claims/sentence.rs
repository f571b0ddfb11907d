//! The claims of one sentence about one obstacle.

use super::clauses::{Clause, Mood, Who};
use super::guards::Guarded;
use super::number::{Number, Unit};
use super::phrases;
use super::plans;
use super::references::{Named, Reference};
use super::score;
use super::speech::Speech;
use super::tokens::{Token, denies, find_word, has_word};
use super::{Claim, ClaimedValue, Extent, Predicate, Quantity};

/// A sentence with its context.
pub struct Sentence<'a> {
    /// Its text, in lower case with the same places of bytes.
    pub lower: &'a str,
    /// Its numbers, with places in it.
    pub numbers: &'a [Number],
    /// Whether a number is an id or a time, by its place among them.
    pub taken: &'a [bool],
    /// Where it begins in the text.
    pub start: usize,
    /// Words of the lines that it stands under, in lower case.
    pub above: &'a str,
    /// Its words and marks.
    pub tokens: &'a [Token],
    /// Whom they mean.
    pub references: &'a [Reference],
    /// Its clauses.
    pub clauses: &'a [Clause],
    /// The ego's id.
    pub ego: i64,
    /// Whether it is a field or a cell that asks for a place.
    pub asks_place: bool,
    /// Whom "both obstacles" means.
    pub both: Option<[i64; 2]>,
    /// Whether a trajectory came with the text.
    pub has_trajectory: bool,
    /// The step that it names, or that was named for it.
    pub step: Option<i64>,
}

/// Words with which a sentence supposes, asks, quotes, or denies as a whole.
const UNSAID: [&str; 28] = [
    "suppose",
    "imagine",
    "hypothetically",
    "hypothetical",
    "provided that",
    "in case",
    "given that",
    "doubt",
    "statement",
    "myth",
    "previous answer",
    "question",
    "false that",
    "true that",
    "case that",
    "rather than",
    "refrain",
    "refrains",
    "ceases",
    "ceased",
    "ceasing",
    "stops approaching",
    "stop approaching",
    "only approaching",
    "anything but",
    "excluded",
    "once the",
    "should the",
];

/// Whether nothing that a sentence says is claimed by it.
fn is_unsaid(lower: &str) -> bool {
    lower.trim_end_matches(['*', ' ', '"']).ends_with('?')
        || UNSAID.iter().any(|words| has_word(lower, words))
        || lower
            .trim_start_matches(['*', ' ', '-', '"'])
            .starts_with("had ")
        || lower
            .trim_start_matches(['*', ' ', '-', '"'])
            .starts_with("assume")
        || lower
            .trim_start_matches(['*', ' ', '-', '"'])
            .starts_with("option")
}

impl Sentence<'_> {
    /// Its claims, in order.
    pub fn claims(&self) -> Vec<Claim> {
        if is_unsaid(self.lower) {
            return Vec::new();
        }
        let mut found: Vec<Claim> = Vec::new();
        found.extend(self.changes());
        let mut ordered = self.both_axes();
        ordered.extend(self.distributed());
        let is_ordered = !ordered.is_empty();
        found.extend(ordered);
        let taken: Vec<std::ops::Range<usize>> = found.iter().map(|c| c.span.clone()).collect();
        let is_new = |number: &Number| {
            let at = self.start + number.span.start;
            !taken.iter().any(|span| span.contains(&at))
        };
        let mut from = 0;
        let mut last: Option<(Quantity, Unit)> = None;
        for (place, number) in self.numbers.iter().enumerate() {
            if !self.taken[place] && is_new(number) {
                for stated in self.number(place, from, last) {
                    last = Some((stated.quantity, number.unit));
                    found.push(self.claim(
                        number.span.clone(),
                        (stated.of, stated.is_past),
                        stated.quantity,
                        stated.value,
                    ));
                }
            }
            // "The gap to obstacle 7 is 3 m": words before an id or a time go on behind it.
            if !self.taken[place] {
                from = number.span.end;
            }
        }
        for (span, quantity, value) in phrases::stated(self.lower) {
            self.said_of_one(span, quantity, value, &mut found);
        }
        let speech = Speech {
            tokens: self.tokens,
            references: self.references,
            above: self.above,
            asks_place: self.asks_place,
            both: self.both,
            lower: self.lower,
        };
        if self.has_trajectory {
            found.extend(self.plans());
        }
        for clause in self.clauses {
            if let Some((span, stated)) = speech.count(clause, self.numbers) {
                found.push(self.claim(span, (self.ego, false), Quantity::Count, stated));
            }
            for said in speech.said(clause) {
                let (first, last) = (said.at.start, said.at.end.max(said.at.start + 1) - 1);
                let span = self.tokens[first].span.start..self.tokens[last].span.end;
                let of = (said.of.unwrap_or(self.ego), said.is_past);
                found.push(self.claim(span, of, said.quantity, said.stated));
            }
        }
        let risks = score::risks(self.lower, self.above, self.numbers);
        let never = score::never(self.lower, self.above);
        found.extend(self.lanelets());
        for (span, quantity, value) in risks.into_iter().chain(never) {
            self.said_of_one(span, quantity, value, &mut found);
        }
        for (span, quantity, value) in score::written(self.lower, self.numbers) {
            self.said_of_one(span, quantity, value, &mut found);
        }
        let same = self.so_am_i(&found);
        found.extend(same);
        self.extend(&mut found);
        let events = self.events(&found, &speech);
        found.extend(events);
        if let Some(at) = self.contradiction() {
            let own = |at: usize| self.clause(at).map(|clause| clause.at.start);
            found.retain(|claim| {
                claim.quantity != Quantity::Motion || own(claim.span.start - self.start) != own(at)
            });
        }
        let guarded = Guarded {
            tokens: self.tokens,
            references: self.references,
            clauses: self.clauses,
            numbers: self.numbers,
            lower: self.lower,
            start: self.start,
        };
        guarded.keep(&mut found);
        self.leave_to_plans(&mut found);
        // Numbers that are told in an order which is not read are of no one.
        if !is_ordered && let Some(at) = find_word(self.lower, "respectively") {
            let first = self.first_of_row(at);
            found.retain(|claim| !(first..at).contains(&(claim.span.start - self.start)));
        }
        found.sort_by_key(|claim| claim.span.start);
        found.dedup_by(|a, b| a == b);
        found
    }

    /// Where the row of numbers begins that ends before a byte: "3 m, 4 m and 5 m".
    fn first_of_row(&self, at: usize) -> usize {
        let mut first = at;
        for number in self.numbers.iter().rev().filter(|n| n.span.end <= at) {
            let between = self.lower[number.span.end..first].trim();
            if first != at && ![",", "and", ", and"].contains(&between) {
                break;
            }
            first = number.span.start;
        }
        first
    }

    /// What is said of the ego by "and so am I": the same as of whom the clauses before are about.
    fn so_am_i(&self, claims: &[Claim]) -> Vec<Claim> {
        let is = |at: usize, words: &str| self.tokens.get(at).is_some_and(|t| t.is(words));
        let so = (0..self.tokens.len()).find(|i| {
            is(*i, "so")
                && is(i + 1, "am do are does is")
                && (is(i + 2, "i we ego") || is(i + 3, "ego"))
        });
        let Some(so) = so else { return Vec::new() };
        let own = claims.iter().filter(|claim| {
            let is_before = claim.span.end <= self.start + self.tokens[so].span.start;
            let is_own = claim.quantity == Quantity::Motion
                && matches!(
                    claim.stated,
                    ClaimedValue::Word {
                        predicate: Predicate::Braking
                            | Predicate::Accelerating
                            | Predicate::Hard(_)
                            | Predicate::Gentle(_)
                            | Predicate::Steady
                            | Predicate::Turning(_),
                        ..
                    }
                );
            is_before && is_own && !claim.is_of_ego
        });
        let span =
            self.tokens[so].span.start..self.tokens[(so + 2).min(self.tokens.len() - 1)].span.end;
        own.map(|claim| {
            self.claim(
                span.clone(),
                (self.ego, claim.is_past),
                claim.quantity,
                claim.stated,
            )
        })
        .collect()
    }

    /// What the ego is said to do is held against the trajectory, not against the recording.
    fn leave_to_plans(&self, claims: &mut Vec<Claim>) {
        let of = |claim: &Claim| {
            self.clause(claim.span.start - self.start)
                .map(|c| c.at.clone())
        };
        let planned: Vec<_> = { claims.iter() }
            .filter(|claim| claim.quantity == Quantity::Plan)
            .map(of)
            .collect();
        claims.retain(|claim| {
            let is_motion = matches!(
                claim.quantity,
                Quantity::Motion | Quantity::Speed | Quantity::Way
            );
            !(claim.is_of_ego && is_motion && planned.contains(&of(claim)))
        });
    }

    /// What the ego is said to do next.
    fn plans(&self) -> Vec<Claim> {
        let mut found = Vec::new();
        for clause in self.clauses {
            for (at, predicate, is_denied) in plans::plans(self.tokens, clause) {
                let span = self.tokens[at.start].span.start..self.tokens[at.end - 1].span.end;
                let value = ClaimedValue::Word {
                    predicate,
                    is_denied,
                };
                found.push(self.claim(span, (self.ego, false), Quantity::Plan, value));
            }
        }
        found
    }

    /// Whether a description says what stands at these bytes: "the lead car".
    fn is_described(&self, span: &std::ops::Range<usize>) -> bool {
        let says = self.references.iter().flat_map(|r| &r.says);
        says.map(|(_, at)| at).any(|at| {
            let (first, last) = (&self.tokens[at.start], &self.tokens[at.end - 1]);
            first.span.start <= span.start && span.end <= last.span.end
        })
    }

    /// The clause that a byte stands in.
    pub(super) fn clause(&self, at: usize) -> Option<&Clause> {
        let place = self.tokens.iter().position(|t| t.span.end > at)?;
        let own = self.clauses.iter().find(|c| c.at.contains(&place));
        own.or_else(|| self.clauses.iter().rfind(|c| c.at.end <= place))
    }

    /// Where what is said of a number begins: its clause, or the one that its bracket stands behind.
    pub(super) fn begins(&self, number: &Number) -> (usize, bool) {
        let Some(clause) = self.clause(number.span.start) else {
            return (number.span.start, false);
        };
        let start = clause.at.start;
        let is_bracket = start > 0 && self.tokens[start - 1].is("(");
        let own = if is_bracket {
            let before = self.clauses.iter().rfind(|c| c.at.end < start);
            before.map_or(start, |before| before.at.start)
        } else {
            start
        };
        (self.tokens[own].span.start, is_bracket)
    }

    /// The obstacle that a clause is about, or that the ego of it meets.
    pub(super) fn met(clause: &Clause) -> Option<i64> {
        match &clause.who {
            Who::Obstacles(ids) => match ids.as_slice() {
                [id] if clause.object.is_none() || clause.names_ego => Some(*id),
                _ => None,
            },
            Who::Ego => clause.object,
            Who::Unknown => None,
        }
    }

    /// Adds a claim about the obstacle of its clause, where that states something.
    fn said_of_one(
        &self,
        span: std::ops::Range<usize>,
        quantity: Quantity,
        value: ClaimedValue,
        found: &mut Vec<Claim>,
    ) {
        let Some(clause) = self.clause(span.start) else {
            return;
        };
        let before = &self.lower[self
            .tokens
            .get(clause.at.start)
            .map_or(0, |t| t.span.start)
            .min(span.start)..span.start];
        let is_place = quantity == Quantity::Position;
        let is_of_ego = clause.who == Who::Ego && clause.object.is_none() && is_place;
        // "I rate it 2": of whom it is about.
        let is_all = |r: &Reference| matches!(r.who, Named::Nobody | Named::Other | Named::Both);
        let is_rated = quantity == Quantity::Risk
            && !matches!(clause.who, Who::Obstacles(_))
            && !self.references.iter().any(is_all);
        let topic = clause.topic.filter(|_| is_rated).map(|id| (id, false));
        let of = if is_place && let Some(owner) = self.owner(span.start) {
            Some((owner, false))
        } else if is_of_ego {
            Some((self.ego, false))
        } else {
            self.stated_of(span.start).or(topic)
        };
        let Some(of) = of else { return };
        let is_denied = ["not in", "not on", "not within"]
            .iter()
            .any(|words| before.trim_end().ends_with(words));
        match value {
            ClaimedValue::Word {
                predicate: predicate @ Predicate::OnLanelet(_),
                ..
            } if is_denied => {
                let value = ClaimedValue::Word {
                    predicate,
                    is_denied,
                };
                found.push(self.claim(span, of, quantity, value));
            }
            value if !denies(before) => found.push(self.claim(span, of, quantity, value)),
            _ => {}
        }
    }

    /// Whom the bracket of what stands at a byte is directly behind: "Ego (1.2, 3.4)", "the ego is at (1.2, 3.4)".
    pub(super) fn owner(&self, at: usize) -> Option<i64> {
        let place = self.tokens.iter().position(|t| t.span.end > at)?;
        let open = place.checked_sub(1).filter(|i| self.tokens[*i].is("("))?;
        let end = (0..=open)
            .rev()
            .find(|i| *i == 0 || !self.tokens[i - 1].is("at is : located position now"))?;
        let owner = self.references.iter().find(|r| r.at.end == end)?;
        // "Relative to the ego (1.2, 3.4)", but "(1.2, 3.4) vs ego (5.6, 7.8)".
        let before = owner.at.start.checked_sub(1);
        let is_beside = before.is_some_and(|i| self.tokens[i].is("vs versus and"));
        if owner.is_governed && !is_beside && owner.who == Named::Ego {
            return None;
        }
        match owner.who {
            Named::Ego => Some(self.ego),
            Named::Obstacle(id) => Some(id),
            _ => Self::met(self.clause(self.tokens[owner.at.start].span.start)?),
        }
    }

    /// The obstacle that what stands at a byte is stated of, and whether as of a time before.
    pub(super) fn stated_of(&self, at: usize) -> Option<(i64, bool)> {
        let clause = self.clause(at)?;
        let is_said = matches!(clause.mood, Mood::Said | Mood::Past);
        let id = Self::met(clause).filter(|_| is_said)?;
        Some((id, clause.mood == Mood::Past))
    }

    pub(super) fn claim(
        &self,
        span: std::ops::Range<usize>,
        (obstacle, is_past): (i64, bool),
        quantity: Quantity,
        stated: ClaimedValue,
    ) -> Claim {
        let named = |r: &Reference| r.who == Named::Obstacle(obstacle);
        Claim {
            span: self.start + span.start..self.start + span.end,
            obstacle,
            is_of_ego: obstacle == self.ego,
            is_past,
            named: self.references.iter().any(named),
            is_described: self.is_described(&span),
            quantity,
            stated,
            step: self.step,
            extent: Extent::Moment,
            is_apart: false,
        }
    }
}
