//! Contact that a clause tells, denies or foresees, and how many it says there are of which something holds.

use std::ops::Range;

use super::clauses::{Clause, Mood, Who};
use super::number::{Number, Unit};
use super::places::{PLACES, Placed};
use super::references::{Named, types_at};
use super::speech::{Said, Speech};
use super::verbs::{Act, VERBS};
use super::{ClaimedValue, Counted, Predicate, Quantity};

impl Speech<'_> {
    /// Contact, denied, past or to come.
    pub(super) fn contact(
        &self,
        clause: &Clause,
        act: Act,
        at: Range<usize>,
        found: &mut Vec<Said>,
    ) {
        const OCCURS: &str = "occur happen occurs occurred happens happened detected occurring took exists happening present confirmed observed";
        let words = &self.tokens[clause.at.clone()];
        let says = |all: &str| words.iter().any(|t| t.is(all));
        let before = |all: &str| {
            (at.start.saturating_sub(3).max(clause.at.start)..at.start).any(|i| self.is(i, all))
        };
        let after = |all: &str| (at.end..(at.end + 8).min(clause.at.end)).any(|i| self.is(i, all));
        let Some(mut is_denied) = self.denial(clause, at.start) else {
            return;
        };
        // "It did not brake before the impact", but "it does not indicate an imminent collision".
        if act == Act::Contact {
            const SAYS: &str = "indicate indicating suggest suggesting imply implying show showing point reflect \
                confirm on in constitute represent yet";
            let says_not = (clause.at.start..at.start)
                .any(|i| self.is(i, "not never") && self.is(i + 1, SAYS));
            is_denied &= says_not || before("no not without any never nor zero");
        }
        if act == Act::Touches
            && self.is(at.start, "overlap overlaps")
            && after("along in across laterally longitudinally")
        {
            return;
        }
        let is_coming = clause.mood == Mood::Future
            || says("imminent unavoidable inevitable upcoming impending")
            || self.is(at.end, "course");
        if before(
            "risk chance likelihood possibility probability danger threat avoid prevent potential possible near close eye avoiding future",
        ) {
            return;
        }
        let will = is_coming || says("expected predicted ahead soon happen") && act == Act::Contact;
        // "No overlap with the ego's lanelet".
        if act == Act::Touches && after("lanelet lane path trajectory course") {
            return;
        }
        if act == Act::Contact
            && self.is(
                at.end,
                "scenario condition situation event path point state",
            )
        {
            return;
        }
        if act == Act::Contact && !is_denied && !will {
            let is_stated = after(OCCURS)
                || before("in is has indicating indicates confirming confirms")
                || clause.at.len() == at.len()
                    && self.tokens[clause.label.clone()]
                        .iter()
                        .any(|t| t.is("location position direction state status"))
                || after("at") && before("there a the");
            if !is_stated {
                return;
            }
            // "No collision is detected" comes with its denial before, "a collision is not detected" with it behind.
            if (at.end..clause.at.end).any(|i| self.is(i, "not never")) {
                is_denied = true;
            }
        }
        // "Hit the brakes".
        if act == Act::Touches && !self.meets_ego(clause, at.end) {
            return;
        }
        let predicate = if will {
            Predicate::WillTouch
        } else {
            Predicate::Touches
        };
        for id in self.pair(clause) {
            if !is_denied && !will {
                found.push(Said {
                    at: at.clone(),
                    of: Some(id),
                    quantity: Quantity::Contact,
                    stated: ClaimedValue::Contact,
                    is_past: self.is_past(clause, &at),
                });
            } else {
                self.push(found, clause, at.clone(), Some(id), (predicate, is_denied));
            }
        }
    }

    /// Whether a verb of contact is about the ego and the obstacle, and not "hits the brakes".
    pub(super) fn meets_ego(&self, clause: &Clause, at: usize) -> bool {
        let next = (at..clause.at.end.min(at + 6))
            .find(|i| !self.is(*i, "with the into by each side rear back front of a"));
        match next {
            None => true,
            Some(i) => {
                let met = self.reference_at(i).map(|r| r.who);
                let is_met = match met {
                    Some(Named::Ego) => clause.who != Who::Ego,
                    Some(_) => clause.who == Who::Ego,
                    None => false,
                };
                is_met
                    || self.is(i, "at other and in during on")
                    || !self.tokens[i].is_word()
                    || self.tokens[i].word.ends_with("ly")
            }
        }
    }

    /// How many a clause says there are of which something holds: "nobody is ahead of us", "two cars are braking".
    pub fn count(
        &self,
        clause: &Clause,
        numbers: &[Number],
    ) -> Option<(Range<usize>, ClaimedValue)> {
        let says = |words: &str| clause.at.clone().any(|i| self.is(i, words));
        // "At any step or between two" supposes nothing.
        let is_said = clause.mood == Mood::Said
            || says("or") && !says("if would could should might may can must likely possible");
        if !is_said || clause.mood == Mood::Future || clause.is_label {
            return None;
        }
        if let Some((at, left)) = self.free_lane(clause) {
            let (from, to) = (
                self.tokens[at.start].span.start,
                self.tokens[at.end - 1].span.end,
            );
            let stated = ClaimedValue::Count {
                number: 0,
                of: Counted::Near(left),
                types: None,
            };
            return Some((from..to, stated));
        }
        const NUMBERS: [&str; 12] = [
            "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten",
            "eleven", "twelve",
        ];
        let (number, who) = self.references.iter().find_map(|r| {
            let own = clause.at.contains(&r.at.start) && !r.is_governed && !r.is_compared;
            let first = &self.tokens[r.at.start];
            let number = match r.who {
                Named::Nobody => Some(0),
                Named::Other => { NUMBERS.iter() }
                    .position(|word| first.is(word))
                    .map(|i| i + 1)
                    .or_else(|| first.word.parse().ok()),
                _ => None,
            };
            Some((number.filter(|_| own)?, r.at.clone()))
        })?;
        // Of whom else it speaks must be the ego.
        let others = self
            .references
            .iter()
            .filter(|r| clause.at.contains(&r.at.start) && r.at != who);
        if !{ others }.all(|r| r.who == Named::Ego) {
            return None;
        }
        let types = types_at(self.tokens, who.clone());
        let said = |at: Range<usize>, of: Counted| {
            let from = self.tokens[who.start.min(at.start)].span.start;
            let to = self.tokens[at.end.max(who.end) - 1].span.end;
            let number = u8::try_from(number).unwrap_or(u8::MAX);
            Some((from..to, ClaimedValue::Count { number, of, types }))
        };
        let denies = (clause.at.start..clause.at.end)
            .any(|i| self.is(i, "not never except only other else"));
        if denies {
            return None;
        }
        let within = clause.at.clone().find_map(|i| {
            let number = &numbers[self.tokens[i].number?];
            let is_within = i > 0 && self.is(i - 1, "within")
                || i > 1 && self.is(i - 1, "than") && self.is(i - 2, "closer nearer");
            (is_within && number.unit == Unit::Metre).then_some((i, number.value))
        });
        if let Some((at, metres)) = within {
            let has_more = !PLACES.all(self.tokens, clause.at.clone()).is_empty();
            return said(at..at + 1, Counted::Within(metres)).filter(|_| !has_more);
        }
        // "No car 10 m ahead" is of that length.
        let has_length = clause.at.clone().any(|i| {
            let number = self.tokens[i].number.map(|place| &numbers[place]);
            number.is_some_and(|number| number.unit != Unit::None)
        });
        if has_length {
            return None;
        }
        let all = self.things(clause)?;
        // "There are ten vehicles around the ego."
        const AROUND: &str = "around nearby scene total scenario surround surrounding";
        let is_there = says("there are is surrounded");
        match all.as_slice() {
            [] if is_there && says(AROUND) => said(who.clone(), Counted::There),
            [(at, one)] => said(at.clone(), Counted::Word(*one)),
            // "Ahead in my lane".
            [(at, one), (_, other)] if one.quantity() != other.quantity() => {
                said(at.clone(), Counted::Both(*one, *other))
            }
            _ => None,
        }
    }

    /// What a clause says of those that it counts, each where it stands; `None` where that is not all read.
    fn things(&self, clause: &Clause) -> Option<Vec<(Range<usize>, Predicate)>> {
        let acts = VERBS.all(self.tokens, clause.at.clone());
        let places = PLACES.all(self.tokens, clause.at.clone());
        let mut all = Vec::new();
        for (act, at) in &acts {
            let predicate = match act {
                Act::Touches => Predicate::Touches,
                Act::Own(predicate) | Act::Pair(predicate) => *predicate,
                Act::Approaches | Act::Nears(true) => Predicate::Approaching(None),
                Act::Nears(false) => Predicate::Receding(None),
                // "Is left", "remains", "stays".
                Act::Other | Act::Moves if !places.is_empty() => continue,
                _ => return None,
            };
            all.push((at.clone(), predicate));
        }
        for (place, at) in &places {
            match place {
                Placed::At(side) => all.push((at.clone(), Predicate::At(*side))),
                // "Nobody is left in front".
                Placed::Field(_) if self.is(at.start, "left") && places.len() > 1 => {}
                _ => return None,
            }
        }
        all.sort_by_key(|(at, _)| at.start);
        Some(all)
    }

    /// The lane beside the ego's that a clause says is free: to the left (true) or right.
    fn free_lane(&self, clause: &Clause) -> Option<(Range<usize>, bool)> {
        let lane = clause.at.clone().find(|i| {
            self.is(*i, "left right")
                && (self.is(i + 1, "lane") || self.is(i + 1, "hand") && self.is(i + 2, "lane"))
        })?;
        let end = lane + 2 + usize::from(self.is(lane + 1, "hand"));
        let is_subject = (clause.at.start..lane)
            .all(|i| self.is(i, "the our my and but so while adjacent neighbouring"));
        let word = (end..clause.at.end).find(|i| self.is(*i, "free empty clear open"))?;
        let is_plain = self.is(end, "is") && (end + 1..word).all(|i| self.tokens[i].is_filler());
        (is_subject && is_plain && !self.is(word + 1, "of from for"))
            .then(|| (lane..word + 1, self.is(lane, "left")))
    }
}
