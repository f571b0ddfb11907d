//! Of what of the window a clause speaks: the least or greatest value, all of it, the moment of an event, or another time.

use std::ops::Range;
use std::sync::LazyLock;

use super::clauses::{Clause, Mood};
use super::number::{Number, Unit};
use super::sentence::Sentence;
use super::speech::Speech;
use super::tokens::Lexicon;
use super::verbs::{Act, VERBS};
use super::{Claim, ClaimedValue, Event, Extent, Predicate, Quantity};

/// Words of the extent of what a clause says.
static EXTENTS: LazyLock<Lexicon<Extent>> = LazyLock::new(|| {
    Lexicon::new(&[
        ("throughout", Extent::All),
        ("=always|=constantly|=permanently", Extent::All),
        ("all time|along|while", Extent::All),
        ("at all times", Extent::All),
        ("at|in every|each ?time step|moment|instant", Extent::All),
        (
            "whole|entire|full|complete time|window|interval|period|recording|observation|manoeuvre|maneuver|scene|sequence|duration|phase",
            Extent::All,
        ),
        ("since|from ?very beginning|start", Extent::All),
        (
            "peak|maximum|=max|highest|greatest|largest|=top",
            Extent::Most,
        ),
        ("up to", Extent::Most),
        ("as much|high|fast|far as", Extent::Most),
        (
            "minimum|=min|lowest|smallest|shortest|narrowest|tightest",
            Extent::Least,
        ),
        ("as low|little|slow as", Extent::Least),
        ("dips|bottoms ?out ?to|at", Extent::Least),
    ])
});

/// Words of other times than that of the sentences around, and of cases.
const ELSEWHEN: &str = "then later afterwards until soon eventually initially earlier once case scenario version centres centers centre \
    center";

impl Sentence<'_> {
    /// Gives claims the extent that the words around them have, and tells those of other times from the rest.
    pub(super) fn extend(&self, claims: &mut [Claim]) {
        for claim in claims {
            let at = claim.span.start - self.start;
            let Some(clause) = self.clause(at) else {
                continue;
            };
            claim.is_apart = self.is_elsewhen(clause);
            let extent = self.extent(claim, clause, at).unwrap_or_default();
            let is_timed = { self.numbers.iter().enumerate() }.any(|(place, number)| {
                let is_time = self.taken[place] && number.unit == Unit::Second;
                is_time && self.clause(number.span.start) == Some(clause)
            });
            // A step that another clause names is not that of all steps.
            if extent != Extent::All || !is_timed && self.times_in_clauses() || claim.step.is_none()
            {
                claim.extent = extent;
            }
            if claim.extent == Extent::All {
                claim.step = None;
            }
        }
    }

    /// The extent of a claim at a byte, from the words of its clause; where a step is named that is of the moment.
    fn extent(&self, claim: &Claim, clause: &Clause, at: usize) -> Option<Extent> {
        let is_bound = matches!(claim.stated, ClaimedValue::Bounds { .. });
        let is_number = is_bound
            || matches!(claim.stated, ClaimedValue::Number { value, .. } if value.is_finite());
        let is_word = match claim.stated {
            ClaimedValue::Word { predicate, .. } => !matches!(
                predicate,
                Predicate::Touches
                    | Predicate::WillTouch
                    | Predicate::CutsIn
                    | Predicate::CameFrom(_)
                    | Predicate::ChangesLane
            ),
            ClaimedValue::Side(_) => true,
            _ => false,
        };
        let is_least = matches!(
            claim.quantity,
            Quantity::MinDistance | Quantity::LeastDistance
        );
        if !is_number && !is_word || is_least || claim.quantity == Quantity::Plan {
            return None;
        }
        let said = |part: &Range<usize>| EXTENTS.all(self.tokens, part.clone());
        let says = |words: &str| clause.at.clone().any(|i| self.tokens[i].is(words));
        let mut all = said(&clause.at);
        all.extend(said(&clause.label));
        // "The lowest of all", "the peak of the three", "higher than".
        let is_compared = says("all any among three two four both obstacles than every");
        let number = self.tokens.iter().position(|t| t.span.start >= at)?;
        let peak = all.iter().rev().find(|(extent, place)| {
            let is_value = |i: usize| {
                self.number_at(&self.tokens[i])
                    .is_some_and(|n| n.unit != Unit::None)
            };
            let is_before = place.end <= number && !(place.start..number).any(is_value);
            *extent != Extent::All && is_before
        });
        // The least of its two times at a step is told so, too.
        const OVER: &str = "window interval during reached reaches period recording drops dropped dips dipped fell falls whole entire over";
        let is_time = matches!(
            claim.quantity,
            Quantity::Ttc | Quantity::TtcLong | Quantity::TtcLat
        );
        let is_over = !is_time || clause.mood == Mood::Past || says(OVER);
        if let Some((extent, _)) = peak.filter(|_| is_number && !is_compared && is_over) {
            return Some(*extent);
        }
        // "During the whole window, 301 stays behind me."
        let is_first = |part: &&Clause| {
            const LEADS: &str = "throughout during over for in since from at all within";
            part.at.start == 0
                && self.tokens[0].is(LEADS)
                && self.tokens.get(part.at.end).is_some_and(|t| t.is(","))
        };
        let first = self
            .clauses
            .first()
            .filter(is_first)
            .map(|part| said(&part.at));
        let is_all = all
            .iter()
            .chain(first.iter().flatten())
            .any(|(extent, _)| *extent == Extent::All);
        let stays = is_bound && says("stayed remained stays remains never kept")
            || says("never") && is_word;
        (is_all || stays).then_some(Extent::All)
    }

    /// Whether the times of a sentence stand in it, and not in what it stands under.
    fn times_in_clauses(&self) -> bool {
        let mut all = self.numbers.iter().enumerate();
        all.any(|(place, number)| self.taken[place] && number.unit == Unit::Second)
    }

    /// Whether a clause may speak of another time than the sentences around it, or of a case.
    fn is_elsewhen(&self, clause: &Clause) -> bool {
        let words = &self.tokens[clause.at.clone()];
        let is_next = self
            .tokens
            .get(clause.at.end)
            .is_some_and(|t| t.is("before after until"));
        let opens = words.first().is_some_and(|t| t.is("before after until"));
        let later = words.windows(2).any(|two| {
            two[0].is("in after")
                && self
                    .number_at(&two[1])
                    .is_some_and(|n| n.unit == Unit::Second)
        });
        opens || is_next || later || words.iter().any(|t| t.is(ELSEWHEN))
    }

    fn number_at(&self, token: &super::tokens::Token) -> Option<&Number> {
        self.numbers.get(token.number?)
    }

    /// When something happened, said by the times of a sentence: "the minimum distance is reached at 4.1 s".
    pub(super) fn events(&self, claims: &[Claim], speech: &Speech<'_>) -> Vec<Claim> {
        let mut found = Vec::new();
        for (place, number) in self.numbers.iter().enumerate() {
            if !self.taken[place] || number.unit != Unit::Second {
                continue;
            }
            let Some(clause) = self.clause(number.span.start) else {
                continue;
            };
            let token = self
                .tokens
                .iter()
                .position(|t| t.number == Some(place))
                .unwrap_or(0);
            let is_span = (token.saturating_sub(3)..token)
                .any(|i| self.tokens[i].is("by until till to from after before since between"));
            if is_span {
                continue;
            }
            let (id, event) = match self.happened(claims, clause, speech) {
                Some(found) => found,
                None => continue,
            };
            found.push(self.claim(
                number.span.clone(),
                (id, false),
                Quantity::Time,
                ClaimedValue::Event(event),
            ));
        }
        found
    }

    /// What a clause with a time tells of whom.
    fn happened(
        &self,
        claims: &[Claim],
        clause: &Clause,
        speech: &Speech<'_>,
    ) -> Option<(i64, Event)> {
        let mut closest = claims
            .iter()
            .filter(|c| c.quantity == Quantity::MinDistance);
        let says = |words: &str| clause.at.clone().any(|i| self.tokens[i].is(words));
        if let Some(first) = closest.next()
            && closest.all(|other| other.obstacle == first.obstacle)
            && (says("reached occurs occurred happens happened attained")
                || clause
                    .at
                    .clone()
                    .any(|i| self.tokens[i].span.start + self.start == first.span.start))
        {
            return Some((first.obstacle, Event::Closest));
        }
        // "The minimum distance to 301 is reached at 4.4 s."
        let is_least = { EXTENTS.all(self.tokens, clause.at.clone()) }
            .iter()
            .any(|(extent, _)| *extent == Extent::Least)
            || says("closest nearest");
        if is_least
            && says("distance gap clearance separation approach point")
            && says("reached occurs occurred happens happened attained")
        {
            return Some((Self::met(clause)?, Event::Closest));
        }
        let is_contact = |c: &&Claim| {
            c.stated == ClaimedValue::Contact
                && self.clause(c.span.start - self.start) == Some(clause)
        };
        if let Some(contact) = claims.iter().find(is_contact) {
            return Some((contact.obstacle, Event::Contact));
        }
        let passes = { VERBS.all(self.tokens, clause.at.clone()) }
            .iter()
            .any(|(act, _)| *act == Act::Passes);
        match speech.pair(clause).as_slice() {
            [id] if passes => Some((*id, Event::Passing)),
            _ => None,
        }
    }
}
