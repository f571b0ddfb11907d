//! The lanelets that a sentence puts its obstacle, the ego, or both on.

use super::clauses::{Clause, Mood, Who};
use super::references::Named;
use super::sentence::Sentence;
use super::tokens::denies;
use super::{Claim, ClaimedValue, Predicate, Quantity};

/// Words before "lanelet" that put someone on it.
const IN: &str = "in on within along occupies the ( : - , is are same different another adjacent separate own current its";

impl Sentence<'_> {
    fn is(&self, at: usize, words: &str) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(words))
    }

    /// "In lanelet 120", "lanelet id: 120.0", "the ego's lanelet (120)".
    pub(super) fn lanelets(&self) -> Vec<Claim> {
        let mut found = Vec::new();
        for at in (0..self.tokens.len()).filter(|at| self.is(*at, "lanelet")) {
            let Some((end, id)) = self.lanelet(at) else {
                continue;
            };
            let span = self.tokens[at].span.start..self.tokens[end].span.end;
            let Some(clause) = self.clause(span.start) else {
                continue;
            };
            // "Obstacle 7 is not on lanelet 120" denies it of one alone.
            let is_denied = at > 1 && self.is(at - 1, IN) && self.is(at - 2, "not");
            let value = ClaimedValue::Word {
                predicate: Predicate::OnLanelet(id),
                is_denied,
            };
            let all = self.on_lanelet(clause, at, end);
            if is_denied && all.len() > 1 {
                continue;
            }
            for of in all {
                let is_past = clause.mood == Mood::Past;
                found.push(self.claim(span.clone(), (of, is_past), Quantity::Way, value));
            }
        }
        found
    }

    /// The id behind the word "lanelet" at a place, and where it stands.
    fn lanelet(&self, at: usize) -> Option<(usize, i64)> {
        let end = (at + 1..at + 8).find(|i| !self.is(*i, "id : ( = as the ego vehicle of"))?;
        let id = self
            .numbers
            .get(self.tokens.get(end)?.number?)?
            .as_integer()?;
        // "In the same lanelet (7)", where that is whom the sentence is about.
        let is_obstacle =
            self.references.iter().any(|r| r.who == Named::Obstacle(id)) || { self.clauses.iter() }
                .any(|clause| {
                    clause.topic == Some(id)
                        || matches!(&clause.who, Who::Obstacles(ids) if ids.contains(&id))
                });
        if is_obstacle {
            return None;
        }
        let is_number = |i: usize| self.tokens.get(i).is_some_and(|t| t.number.is_some());
        // One of several, or the first of two that it passes.
        let goes_on =
            self.is(end + 1, "to → -") || self.is(end + 1, "and or , /") && is_number(end + 2);
        (!goes_on).then_some((end, id))
    }

    /// Who is on the lanelet at a place, with its id at another one.
    fn on_lanelet(&self, clause: &Clause, at: usize, end: usize) -> Vec<i64> {
        let names_ego = |from: usize, to: usize| {
            self.references
                .iter()
                .any(|r| r.who == Named::Ego && r.at.start >= from && r.at.end <= to)
        };
        // "No overlap with the ego's lanelet 120".
        let owner = at - usize::from(at > 0 && self.is(at - 1, "'s"));
        let is_egos = { self.references.iter() }.any(|r| r.who == Named::Ego && r.at.end == owner);
        if is_egos {
            return vec![self.ego];
        }
        let is_said = matches!(clause.mood, Mood::Said | Mood::Past);
        let denial = at > clause.at.start + 1 && self.is(at - 2, "not");
        let to = self.tokens[if denial { at - 2 } else { at }].span.start;
        let before = &self.lower[self.tokens[clause.at.start].span.start..to];
        let is_in = at == clause.at.start || self.is(at - 1, IN);
        if !is_said || !is_in || denies(before) {
            return Vec::new();
        }
        let mut all = match &clause.who {
            Who::Obstacles(ids) if clause.object.is_none() || clause.names_ego => ids.clone(),
            Who::Ego => vec![self.ego],
            _ => Vec::new(),
        };
        // "The ego and 7 are in lanelet 120", "in the same lanelet (120)", "in the same lanelet as the ego (120)".
        let is_joint = { self.references.iter() }.any(|r| {
            r.who == Named::Ego
                && clause.at.contains(&r.at.start)
                && r.at.end <= at
                && !r.is_governed
        });
        let is_same = at > 0 && self.is(at - 1, "same");
        if !all.is_empty()
            && !all.contains(&self.ego)
            && (is_joint || is_same || names_ego(at, end))
        {
            all.push(self.ego);
        }
        all
    }
}
