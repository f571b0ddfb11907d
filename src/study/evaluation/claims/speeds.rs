//! Whose speed a number is, or whether it is that of a distance, and whether a time is that until a contact.

use super::Predicate;
use super::clauses::Who;
use super::find::ends_with_word;
use super::number::{Number, Unit};
use super::references::Named;
use super::sentence::Sentence;
use super::tokens::has_word;
use super::verbs::{Act, VERBS};

impl Sentence<'_> {
    /// Whether a bracket with a number is right behind the ego, whom something is likened to.
    fn is_likened(&self, number: &Number) -> bool {
        let at = { self.tokens.iter() }.position(|t| t.span.end > number.span.start);
        let Some(open) = at.and_then(|at| at.checked_sub(1)) else {
            return false;
        };
        let ego = { self.references.iter() }.find(|r| r.at.end == open && r.who == Named::Ego);
        let says =
            |from: usize, to: usize, words: &str| self.tokens[from..to].iter().any(|t| t.is(words));
        ego.is_some_and(|ego| {
            let start = ego.at.start;
            self.tokens[open].is("(")
                && says(start.saturating_sub(2), start, "to as")
                && says(
                    start.saturating_sub(6),
                    start,
                    "similar same equal comparable close",
                )
        })
    }

    /// Whom a bracket right behind a number names: "1.2 m (7), 3.4 m (8)".
    pub(super) fn named_behind(&self, number: &Number) -> Option<i64> {
        let at = { self.tokens.iter() }.position(|t| t.span.start >= number.span.end)?;
        let first = at + 1 + usize::from(self.tokens.get(at + 1)?.is("to for"));
        let reference = { self.references.iter() }.find(|r| r.at.start == first)?;
        let is_bracket = self.tokens[at].is("(") && self.tokens.get(reference.at.end)?.is(")");
        match reference.who {
            Named::Obstacle(id) if is_bracket => Some(id),
            _ => None,
        }
    }

    /// Whose own speed a number in a bracket is, where the ego's stands beside it: "ego (9.1 m/s), obstacle (10.7 m/s)".
    pub(super) fn own_speed(&self, number: &Number) -> Option<i64> {
        let is_alone = |number: &&Number| {
            let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
            number.unit == Unit::Speed && after.starts_with(')')
        };
        let all = self.numbers.iter().filter(is_alone);
        let owners: Vec<i64> = all
            .filter_map(|other| self.owner(other.span.start))
            .collect();
        // "A speed similar to the ego (9.1 m/s)" is the ego's.
        if is_alone(&number) && self.is_likened(number) {
            return Some(self.ego);
        }
        let is_compared = owners.len() > 1 && owners.contains(&self.ego);
        Some(number)
            .filter(|number| is_compared && is_alone(number))
            .and_then(|number| self.owner(number.span.start))
    }

    /// Whether seconds are those until the bodies touch: "will collide in 2 s", "impact within 1.5 s".
    pub(super) fn is_until_contact(&self, near: &str) -> bool {
        let words = [
            "collision",
            "contact",
            "impact",
            "hit",
            "hits",
            "collide",
            "collides",
            "reach",
            "reaches",
            "reached",
            "reaching",
            "arriving",
            "arrives",
            "touch",
            "here",
        ];
        let bare = near.trim_end_matches(['*', ' ', '~', '≈']);
        let bare = [
            "about",
            "around",
            "roughly",
            "only",
            "just",
            "less than",
            "under",
            "approximately",
            "some",
            "maybe",
            "roughly another",
        ]
        .iter()
        .find_map(|word| bare.strip_suffix(word))
        .unwrap_or(bare)
        .trim_end();
        (ends_with_word(bare, "in") || ends_with_word(bare, "within"))
            && words.iter().any(|word| has_word(bare, word))
    }

    /// Whether the verb before a speed says how a distance changes: "draws away at 5 m/s".
    pub(super) fn is_of_distance(&self, number: &Number) -> bool {
        let Some(clause) = self.clause(number.span.start) else {
            return false;
        };
        let place = |at: usize| {
            self.tokens
                .iter()
                .position(|t| t.span.start >= at)
                .unwrap_or(clause.at.end)
        };
        let (from, to) = (place(self.begins(number).0), place(number.span.start));
        let verbs = VERBS.all(self.tokens, from..to.max(from));
        const OWN: [&str; 5] = ["walk", "rid", "run", "driv", "travel"];
        let is_own =
            |at: &std::ops::Range<usize>| OWN.contains(&self.tokens[at.start].stem.as_str());
        verbs.iter().any(|(act, at)| {
            matches!(
                act,
                Act::Nears(_) | Act::Approaches | Act::Pair(Predicate::Signed(..))
            ) && !is_own(at)
        }) && !verbs.iter().any(|(act, _)| *act == Act::Moves)
    }

    /// Whether a speed is that of whom its clause is about: "doing 50 km/h", "our speed is 8 m/s".
    pub(super) fn is_own(&self, number: &Number) -> bool {
        const SAYS: &str = "maintain maintains maintained maintaining reached reaches hold holds held keeps kept speed velocity pace moving moves driving drives doing going riding walking rolling running travelling \
        traveling cruising";
        let Some(clause) = self.clause(number.span.start) else {
            return false;
        };
        let begin = self.begins(number).0;
        let words = self.tokens.iter().filter(|t| t.span.start >= begin);
        let before = words.take_while(|t| t.span.start < number.span.start);
        let mut before = before.collect::<Vec<_>>();
        before.truncate(12);
        // "At no more than 2 m/s" compares with no one.
        let is_bound = |i: usize| i > 0 && before[i - 1].is("more less greater lower higher");
        let is_relative = before.iter().enumerate().any(|(i, t)| {
            t.is("relative closing limit difference lateral longitudinal")
                || t.is("than") && !is_bound(i)
        });
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        let is_compared = [
            "faster",
            "slower",
            "more",
            "less",
            "relative",
            "closing",
            "difference",
        ]
        .iter()
        .any(|word| after.starts_with(word));
        // "At 24 m/s the lorry …": of whom is not told.
        let first = self
            .references
            .iter()
            .find(|r| clause.at.contains(&r.at.start) && r.who != Named::Ego);
        // "2 m to 301 at 30 m/s": of whom is not told.
        let is_to = first.is_some_and(|r| {
            r.is_governed
                && (clause.at.start..r.at.start)
                    .rfind(|i| !self.tokens[*i].is("the car vehicle truck obstacle"))
                    .is_some_and(|i| self.tokens[i].is("to"))
                && self.tokens[r.at.end..]
                    .iter()
                    .take_while(|t| t.span.start < number.span.start)
                    .all(|t| t.is("at with about"))
        });
        if is_to {
            return false;
        }
        let is_before =
            first.is_some_and(|r| self.tokens[r.at.start].span.start > number.span.start);
        if is_before && matches!(clause.who, Who::Obstacles(_)) {
            return false;
        }
        let towards = { self.tokens.iter().rev() }
            .skip_while(|t| t.span.start >= number.span.start)
            .take(4)
            .any(|t| t.is("toward towards"));
        let walks = before
            .iter()
            .any(|t| ["walk", "rid", "run"].contains(&t.stem.as_str()));
        let is_vague = matches!(clause.who, Who::Obstacles(_)) && towards && !walks;
        let at =
            "at with about of roughly around does do steady constant over only still is v = to";
        let is_near = before.last().is_none_or(|t| {
            t.is(at) || t.word.ends_with("ly") || t.number.is_some() || !t.is_word()
        });
        !is_relative && !is_compared && !is_vague && (is_near || before.iter().any(|t| t.is(SAYS)))
    }
}
