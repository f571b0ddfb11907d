//! Where a clause says that a participant is: places around the ego, lanes as values of fields, and lists.

use std::ops::Range;

use super::clauses::{Clause, Mood, Who};
use super::phrases::NOTHING;
use super::places::{PLACES, Placed};
use super::references::{Named, Reference};
use super::speech::{Said, Speech};
use super::verbs::{Act, VERBS};
use super::{ClaimedValue, Predicate, Quantity, Side};

impl Speech<'_> {
    /// Where the obstacle is said to be.
    pub(super) fn places(&self, clause: &Clause, found: &mut Vec<Said>) {
        let mut at = clause.at.start;
        let mut own: Vec<(Side, Range<usize>, bool)> = Vec::new();
        let mut origins: Vec<Range<usize>> = Vec::new();
        while at < clause.at.end {
            let Some((place, end)) = PLACES.at(&self.tokens[..clause.at.end], at) else {
                at += 1;
                continue;
            };
            // "Drops back on the left": "back" is of the verb.
            let is_of_verb = self.is(at, "back")
                && at > clause.at.start
                && self.is(
                    at - 1,
                    "drop drops dropping dropped fall falls falling fell",
                );
            if is_of_verb {
                at += 1;
                continue;
            }
            let here = at..end;
            at = end;
            // "Having left the truck behind" is a verb.
            let is_verb = self.is(here.start, "left")
                && here.len() == 1
                && self
                    .references
                    .iter()
                    .any(|r| r.at.start == end && !r.is_governed);
            if is_verb {
                continue;
            }
            let inside = |(_, s): &(_, Range<usize>)| s.start < here.end && here.start < s.end;
            if self.references.iter().any(|r| r.says.iter().any(inside)) {
                continue;
            }
            let before = here.start.checked_sub(1);
            let is_before = |words: &str| before.is_some_and(|i| self.is(i, words));
            let is_origin = is_before("from")
                || is_before("the directly our my")
                    && before
                        .and_then(|i| i.checked_sub(1))
                        .is_some_and(|i| self.is(i, "from"));
            const ELSEWHERE: &str = "look looking turn turns turning road way steer lane path drifting moves toward towards view change keep \
        pull moving";
            let is_elsewhere =
                is_before(ELSEWHERE) && !(place == Placed::Beside && is_before("moving"));
            // "Moving away to the left".
            let is_course = self.is(here.start, "to")
                && VERBS
                    .all(self.tokens, clause.at.start..here.start)
                    .iter()
                    .any(|(act, _)| {
                        matches!(
                            act,
                            Act::Nears(_)
                                | Act::Approaches
                                | Act::Moves
                                | Act::Own(Predicate::ChangesLane)
                        )
                    });
            let is_explained = self.tokens[clause.at.clone()]
                .iter()
                .any(|t| t.is("negative positive"));
            if is_elsewhere
                || is_course
                || is_explained
                || self.is(end, "lane lanelet turn turning hand side axis")
                || self.is(end, "of") && !self.is_ego(end + 1)
            {
                continue;
            }
            let side = match place {
                Placed::At(side) => side,
                Placed::Field(side) if is_origin || self.is_field(clause, &here) => side,
                Placed::Beside if clause.mood == Mood::Future => continue,
                Placed::Beside => {
                    for id in self.pair(clause) {
                        if let Some(is_denied) = self.denial(clause, here.start) {
                            self.push(
                                found,
                                clause,
                                here.clone(),
                                Some(id),
                                (Predicate::Beside, is_denied),
                            );
                        }
                    }
                    continue;
                }
                Placed::Field(_) => continue,
            };
            if is_origin {
                origins.push(here.clone());
            }
            // "Behind 7": of another one.
            let met = self.references.iter().find(|r| {
                r.at.start >= end
                    && r.at.start <= end + 2
                    && clause.at.contains(&r.at.start)
                    && self.tokens[end..r.at.start]
                        .iter()
                        .all(|t| t.is("the of a"))
            });
            let is_mirrored = clause.who == Who::Ego;
            match met.map(|r| r.who) {
                Some(Named::Ego) | None if !is_mirrored => own.push((side, here, false)),
                Some(Named::Obstacle(_) | Named::It) if is_mirrored && side.left.is_none() => {
                    own.push((side, here, true))
                }
                _ => {}
            }
        }
        // "From left to right".
        if !origins.is_empty() {
            own.retain(|(_, here, _)| origins.contains(here));
        }
        // Two places say nothing certain.
        if own.iter().any(|(side, _, _)| {
            own.iter().any(|(other, _, _)| {
                side.front.zip(other.front).is_some_and(|(a, b)| a != b)
                    || side.left.zip(other.left).is_some_and(|(a, b)| a != b)
            })
        }) {
            return;
        }
        for (mut side, here, is_mirrored) in own {
            if is_mirrored {
                side.front = side.front.map(|front| !front);
            }
            let Some(is_denied) = self.denial(clause, here.start) else {
                continue;
            };
            if clause.mood == Mood::Future {
                continue;
            }
            for id in self.pair(clause) {
                let stated = if origins.contains(&here) {
                    ClaimedValue::Word {
                        predicate: Predicate::CameFrom(side),
                        is_denied,
                    }
                } else if is_denied {
                    ClaimedValue::Word {
                        predicate: Predicate::At(side),
                        is_denied,
                    }
                } else {
                    ClaimedValue::Side(side)
                };
                found.push(Said {
                    at: here.clone(),
                    of: Some(id),
                    quantity: Quantity::Side,
                    stated,
                    is_past: clause.mood == Mood::Past && !origins.contains(&here),
                });
            }
        }
    }

    /// Whether an obstacle is named beside a description of it.
    pub(super) fn names(&self, id: i64, description: &Reference) -> bool {
        let others = self.references.iter().filter(|r| r.at != description.at);
        { others }
            .any(|r| matches!(r.who, Named::Obstacle(other) if other == id) || r.who == Named::It)
    }

    pub(super) fn is_ego(&self, at: usize) -> bool {
        (at..at + 2).any(|i| self.reference_at(i).is_some_and(|r| r.who == Named::Ego))
    }

    /// Whether a bare word is a place: the value of a field that asks for one, or in brackets behind a name or a length.
    pub(super) fn is_field(&self, clause: &Clause, here: &Range<usize>) -> bool {
        const ASKS: &str = "direction position location place side where relation placement";
        let words = &self.tokens[clause.label.clone()];
        let is_asked = self.asks_place || words.iter().any(|t| t.is(ASKS));
        let starts = here.start == clause.at.start;
        let ends = here.end == clause.at.end
            || self.is(here.end, "of")
            || self
                .tokens
                .get(here.end)
                .is_some_and(|t| t.number.is_some());
        let bracket = starts && clause.at.start > 1 && self.is(clause.at.start - 1, "(") && {
            let before = &self.tokens[clause.at.start - 2];
            before.number.is_some() || self.reference_at(clause.at.start - 2).is_some()
        };
        // "1.6 m left".
        let length = ends
            && here.start > clause.at.start
            && self.tokens[here.start - 1].number.is_some()
            && self.tokens[here.start - 1].word.ends_with(['m', 's']);
        let inline = length
            || is_asked
                && here.start > clause.at.start
                && (clause.at.start..here.start).any(|i| self.is(i, ASKS));
        // "Motorcycle directly left".
        let is_note =
            ends && (clause.at.start..here.start).all(|i| {
                self.reference_at(i).is_some()
                    || self.tokens[i].is_filler()
                    || self.tokens[i].number.is_some()
            }) && here.start > clause.at.start;
        let names = |i: usize| {
            self.reference_at(i)
                .is_some_and(|r| matches!(r.who, Named::Obstacle(_)))
        };
        let is_named = clause.label.clone().any(names);
        starts && ends && (is_asked || bracket || is_named) || inline || is_note
    }

    /// The value of a field that asks for a lane or a lanelet: "lane: same", "lanelet: 120 (different from the ego)".
    pub(super) fn lanes(&self, clause: &Clause, found: &mut Vec<Said>) {
        const REST: &str =
            "to from than as of the ego vehicle 's lane lanelet path one it hand most";
        let label = &self.tokens[clause.label.clone()];
        let is_lanelet = label.iter().any(|t| t.is("lanelet"));
        let is_all = (clause.at.start + 1..clause.at.end).all(|i| self.is(i, REST));
        if !(is_lanelet || label.iter().any(|t| t.is("lane"))) || !is_all {
            return;
        }
        let word = &self.tokens[clause.at.start];
        let predicate = match word.word.as_str() {
            "same" | "ego" | "own" if is_lanelet => Predicate::SameLanelet,
            "same" | "ego" | "own" => Predicate::SameLane,
            "other" | "adjacent" | "different" | "neighbouring" | "neighboring" | "next" => {
                if is_lanelet {
                    Predicate::OtherLanelet
                } else {
                    Predicate::OtherLane
                }
            }
            "left" => Predicate::NeighbourLane(true),
            "right" => Predicate::NeighbourLane(false),
            "opposite" | "oncoming" => Predicate::Oncoming,
            _ => return,
        };
        if found.iter().any(|said| said.at.contains(&clause.at.start)) {
            return;
        }
        for id in self.pair(clause) {
            self.push(
                found,
                clause,
                clause.at.clone(),
                Some(id),
                (predicate, false),
            );
        }
    }

    /// Those that a field lists: "standing: 7, 8".
    pub(super) fn listed(&self, clause: &Clause, found: &mut Vec<Said>) {
        let (label, at) = (clause.label.clone(), clause.at.clone());
        let is_list = !at.is_empty()
            && at
                .clone()
                .all(|i| self.reference_at(i).is_some() || self.is(i, "and ,"));
        let is_denied = self.is(label.start, "not");
        let first = label.start + usize::from(is_denied);
        let found_act = VERBS.at(&self.tokens[..label.end], first);
        let Some((act, end)) = found_act.filter(|_| is_list) else {
            return;
        };
        let act = match act {
            Act::Moves if is_denied => Act::Stands,
            _ if is_denied => return,
            act => act,
        };
        if end != label.end {
            return;
        }
        for of in Self::own(clause) {
            match act {
                Act::Stands => found.push(Said {
                    at: at.clone(),
                    of,
                    quantity: Quantity::Speed,
                    stated: NOTHING,
                    is_past: false,
                }),
                Act::Own(predicate) => self.push(found, clause, at.clone(), of, (predicate, false)),
                Act::Approaches => {
                    self.push(
                        found,
                        clause,
                        at.clone(),
                        of,
                        (Predicate::Approaching(None), false),
                    );
                }
                _ => {}
            }
        }
    }
}
