//! What a clause says in words of a participant: how it moves, and what a description says of it.

use std::ops::Range;

use super::clauses::{Clause, Mood, Who};
use super::phrases::{NOTHING, axis_before};
use super::references::{Described, Named, Reference};
use super::tokens::Token;
use super::verbs::{Act, VERBS};
use super::{ClaimedValue, Predicate, Quantity, Side};

/// A claim in words: where it stands, of whom, and what.
#[derive(Debug, Clone, PartialEq)]
pub struct Said {
    /// Its tokens.
    pub at: Range<usize>,
    /// Of whom; `None` for the ego.
    pub of: Option<i64>,
    pub quantity: Quantity,
    pub stated: ClaimedValue,
    /// Whether it is said of a time before.
    pub is_past: bool,
}

/// A sentence for its claims in words.
pub struct Speech<'a> {
    pub tokens: &'a [Token],
    pub references: &'a [Reference],
    /// The words of what it stands under, in lower case.
    pub above: &'a str,
    /// Whether it is a field or a cell that asks for a place.
    pub asks_place: bool,
    /// Whom "both obstacles" means.
    pub both: Option<[i64; 2]>,
    pub lower: &'a str,
}

impl Speech<'_> {
    /// What a clause says in words.
    pub fn said(&self, clause: &Clause) -> Vec<Said> {
        let mut found = Vec::new();
        // "It is ahead of the ego: false".
        if self.is(clause.at.end, ":") && self.is(clause.at.end + 1, "false no not") {
            return found;
        }
        self.described(clause, &mut found);
        if clause.mood != Mood::Supposed && !clause.is_label {
            self.places(clause, &mut found);
        }
        self.acts(clause, &mut found);
        if !matches!(clause.mood, Mood::Supposed | Mood::Future) {
            self.trends(clause, &mut found);
            self.signs(clause, &mut found);
            self.lanes(clause, &mut found);
            self.listed(clause, &mut found);
            self.comparisons(clause, &mut found);
        }
        found
    }

    pub(super) fn is(&self, at: usize, words: &str) -> bool {
        self.tokens.get(at).is_some_and(|token| token.is(words))
    }

    pub(super) fn reference_at(&self, at: usize) -> Option<&Reference> {
        self.references.iter().find(|r| r.at.contains(&at))
    }

    /// Of whom something holds that is said of a pair: an obstacle and the ego.
    pub(super) fn pair(&self, clause: &Clause) -> Vec<i64> {
        match &clause.who {
            Who::Obstacles(_) if clause.object.is_some() && !clause.names_ego => Vec::new(),
            Who::Obstacles(ids) => ids.clone(),
            Who::Ego => clause.object.into_iter().collect(),
            Who::Unknown => Vec::new(),
        }
    }

    /// Of whom something holds that is said of its own motion.
    pub(super) fn own(clause: &Clause) -> Vec<Option<i64>> {
        match &clause.who {
            Who::Obstacles(ids) => ids.iter().copied().map(Some).collect(),
            Who::Ego => vec![None],
            Who::Unknown => Vec::new(),
        }
    }

    /// Whether words before a place in a clause deny it; `None` where that cannot be told.
    pub(super) fn denial(&self, clause: &Clause, at: usize) -> Option<bool> {
        const DENIALS: &str = "not no never without neither nor none nobody";
        const UNCLEAR: &str = "hardly barely rarely scarcely seldom fails fail refrains refrain ceases ceased instead than nothing excluded \
        only almost nearly";
        let (mut denials, mut is_weighed) = (0, false);
        for place in (self.begins(clause)..at).rev() {
            let token = &self.tokens[place];
            const ENDS: &str = "and but due because since despite given as for applicable with";
            if token.is(ENDS) {
                break;
            }
            // "No less than 1 m ahead" denies nothing.
            let is_of_bound = token.is("no not") && self.is(place + 1, "less more fewer");
            if token.is("nearly almost") || is_of_bound {
                continue;
            }
            // "Less than 8 m ahead".
            let is_bound =
                token.is("than") && place > 0 && self.is(place - 1, "less more under over closer");
            if token.is(UNCLEAR) && !(token.is("only") && place + 1 < at) && !is_bound {
                return None;
            }
            // "Neither … nor" is one.
            let is_second = token.is("neither") && denials > 0;
            // "No significant approach" may be a slight one.
            is_weighed |=
                token.is("significant significantly substantial substantially notable notably");
            if token.is(DENIALS) && !self.is(place + 1, "only doubt") && !is_second {
                if is_weighed {
                    return None;
                }
                denials += 1;
            }
        }
        // "Not closing fast enough" may be closing.
        let is_weighed = denials == 1
            && (at..clause.at.end)
                .any(|i| self.is(i, "significantly substantially notably dramatically enough"));
        (denials < 2 && !is_weighed).then_some(denials == 1)
    }

    /// Where a clause begins that goes on behind brackets: "neither 7 (2 m) touches the ego".
    pub(super) fn begins(&self, clause: &Clause) -> usize {
        let mut from = clause.at.start;
        while from > 0 && self.is(from - 1, ")") {
            let open = (0..from).rfind(|i| self.is(*i, "("));
            let Some(open) = open else { break };
            let before = (0..open).rfind(|i| self.is(*i, ", ; : ( )"));
            let start = before.map_or(0, |i| i + 1);
            if start >= from {
                break;
            }
            from = start;
        }
        from
    }

    pub(super) fn push(
        &self,
        found: &mut Vec<Said>,
        clause: &Clause,
        at: Range<usize>,
        of: Option<i64>,
        word: (Predicate, bool),
    ) {
        let (predicate, is_denied) = word;
        found.push(Said {
            is_past: self.is_past(clause, &at),
            at,
            of,
            quantity: predicate.quantity(),
            stated: ClaimedValue::Word {
                predicate,
                is_denied,
            },
        });
    }

    /// Whether a verb speaks of a time before: "braked", "has braked".
    pub(super) fn is_past(&self, clause: &Clause, at: &Range<usize>) -> bool {
        let verb = &self.tokens[at.start];
        let is_participle = (clause.at.start..at.start).any(|i| self.is(i, "is are am be being"));
        clause.mood == Mood::Past
            || verb.word.ends_with("ed") && verb.stem != verb.word && !is_participle
    }

    /// The verbs of a clause.
    pub(super) fn acts(&self, clause: &Clause, found: &mut Vec<Said>) {
        const NO_NOUN: &str = "application distance distances light lights sign line signal rate trajectory path speed velocity time behavior behaviour \
        capability force approximation assumption model maneuver manoeuvre vehicles traffic obstacles cars threshold phase objects gap lane lanes";
        let mut acts = VERBS.all(self.tokens, clause.at.clone());
        // "Closing in the same lane" is two.
        let words = &self.tokens[..clause.at.end];
        let lanes: Vec<_> = { acts.iter() }
            .filter(|(_, at)| at.len() > 1 && self.is(at.end - 1, "in"))
            .filter_map(|(_, at)| Some((at.clone(), VERBS.at(words, at.end - 1)?)))
            .filter(|(at, (act, end))| matches!(act, Act::Pair(_)) && *end > at.end)
            .map(|(at, (act, end))| (act, at.end - 1..end))
            .collect();
        acts.extend(lanes);
        for (act, at) in acts {
            if act == Act::Other || clause.is_label {
                continue;
            }
            // A description is no verb: "the parked car".
            if self
                .references
                .iter()
                .any(|r| r.at.contains(&at.start) && r.at.contains(&(at.end - 1)))
            {
                continue;
            }
            let is_stated = clause.mood != Mood::Supposed;
            if matches!(act, Act::Touches | Act::Contact) {
                if is_stated {
                    self.contact(clause, act, at, found);
                }
                continue;
            }
            if !is_stated || clause.mood == Mood::Future {
                continue;
            }
            let next = self.tokens.get(at.end);
            if next.is_some_and(|t| t.is(NO_NOUN)) {
                continue;
            }
            // "The rate of closing", "from approaching".
            let before = at.start.checked_sub(1).filter(|i| *i >= clause.at.start);
            let begins = before.and_then(|i| i.checked_sub(1)).is_some_and(|i| {
                let stems = [
                    "begin", "began", "start", "continu", "keep", "kept", "begun", "manag",
                    "forced", "forc",
                ];
                self.is(i + 1, "to") && stems.contains(&self.tokens[i].stem.as_str())
            });
            // "Reacts by braking".
            let is_means = before.is_some_and(|i| self.is(i, "by"))
                && clause.at.clone().any(|i| {
                    self.is(
                        i,
                        "reacted reacts react reacting responded responds respond responding",
                    )
                });
            if before.is_some_and(|i| self.is(i, "of from for by avoid to"))
                && !is_means
                && !self.is(at.start, "in on at same")
                && !begins
            {
                continue;
            }
            // "3 m away laterally", "is further away laterally" are places.
            let is_place = before.is_some_and(|i| {
                let is_far = self.is(i, "further farther far") && i > 0;
                self.tokens[i].number.is_some() || is_far && self.is(i - 1, "is are remains")
            });
            if is_place && self.is(at.start, "away") {
                continue;
            }
            // "The relative velocity is higher than the ego's".
            let is_relative = before.is_some_and(|i| self.is(i, "relative closing initial"));
            if is_relative && self.is(at.start, "speed velocity") && matches!(act, Act::Pair(_)) {
                continue;
            }
            // "Onto the crossing" is a place; "we stop" is a verb, and "the stop" none.
            let is_noun = self.is(at.start, "crossing")
                && before.is_some_and(|i| self.is(i, "the a"))
                || self.is(at.start, "stop")
                    && at.len() == 1
                    && !before.is_some_and(|i| self.is(i, "i we and they to not"));
            if is_noun {
                continue;
            }
            // "The brake", "its brake".
            if self.is(at.start, "brake")
                && before.is_some_and(|i| self.is(i, "the a its emergency my full"))
            {
                continue;
            }
            let Some(is_denied) = self.denial(clause, at.start) else {
                continue;
            };
            let is_distance = matches!(act, Act::Nears(_) | Act::Approaches);
            let mut pair = self.pair(clause);
            // "The ego is closing the gap": to whom all of it is about.
            let is_of_another = self.is(at.end, "from") && !self.is_named(at.end + 1);
            if clause.who == Who::Ego && pair.is_empty() && is_distance && !is_of_another {
                pair.extend(clause.topic);
            }
            match act {
                Act::Nears(_) | Act::Approaches => {
                    if act == Act::Approaches && !self.is_of_ego(at.end, clause) {
                        continue;
                    }
                    let is_denied = is_denied || self.is(at.start, "no zero without");
                    let nears = !matches!(act, Act::Nears(false));
                    // "I am pulling away again".
                    if clause.who == Who::Ego
                        && clause.object.is_none()
                        && self.tokens[at.start].stem == "pull"
                    {
                        self.push(
                            found,
                            clause,
                            at,
                            None,
                            (Predicate::Accelerating, is_denied),
                        );
                        continue;
                    }
                    for axis in self.axes(clause, &at) {
                        let predicate = if nears {
                            Predicate::Approaching(axis)
                        } else {
                            Predicate::Receding(axis)
                        };
                        for id in &pair {
                            self.push(found, clause, at.clone(), Some(*id), (predicate, is_denied));
                        }
                    }
                }
                // "The closing speed accelerates" is not said of a body.
                Act::Own(Predicate::Braking | Predicate::Accelerating)
                    if before.is_some_and(|i| self.is(i, "speed velocity rate closing")) => {}
                // "It slows us down".
                Act::Own(_)
                    if self.tokens[at.start].stem == "slow"
                        && (at.start + 1..at.end + 1).any(|i| self.is(i, "us me you")) => {}
                // "I keep my lane".
                Act::Pair(Predicate::SameLane)
                    if clause.who == Who::Ego
                        && self.is(at.start, "keep keeps keeping stay stays") =>
                {
                    let keeps = (Predicate::ChangesLane, !is_denied);
                    self.push(found, clause, at, None, keeps);
                }
                Act::Own(predicate) => {
                    let predicate = self.how_much(predicate, clause, &at, is_denied);
                    for of in Self::own(clause) {
                        self.push(found, clause, at.clone(), of, (predicate, is_denied));
                    }
                }
                Act::Never(predicate) if !is_denied => {
                    for of in Self::own(clause) {
                        self.push(found, clause, at.clone(), of, (predicate, true));
                    }
                }
                Act::Drives(predicate, nears) if !is_denied => {
                    let other = if nears {
                        Predicate::Approaching(None)
                    } else {
                        Predicate::Receding(None)
                    };
                    for of in Self::own(clause) {
                        self.push(found, clause, at.clone(), of, (predicate, false));
                    }
                    for id in &pair {
                        self.push(found, clause, at.clone(), Some(*id), (other, false));
                    }
                }
                Act::Note(_) if at.start != clause.at.start => {}
                Act::Pair(_) if self.is_of_change(&at) => {}
                // "301 (left lane)"; "left lane free" is of a lane.
                Act::Note(Predicate::NeighbourLane(_)) if at != clause.at => {}
                // "I am in the oncoming lane".
                Act::Pair(Predicate::Oncoming | Predicate::NeighbourLane(_))
                    if clause.who == Who::Ego => {}
                Act::Pair(predicate) | Act::Note(predicate) => {
                    // "They are in the same lane": it and the ego.
                    let are_both = clause.who == Who::Unknown
                        && self.is(clause.at.start, "they both")
                        && predicate.quantity() == Quantity::Way;
                    let pair = if are_both {
                        clause.topic.into_iter().collect()
                    } else {
                        pair
                    };
                    // "I drop back behind 7": seen from there 7 goes ahead.
                    let predicate = match predicate {
                        Predicate::Signed(long, more) if clause.who == Who::Ego => {
                            Predicate::Signed(long, !more)
                        }
                        predicate => predicate,
                    };
                    for id in pair {
                        self.push(found, clause, at.clone(), Some(id), (predicate, is_denied));
                    }
                }
                Act::Stands | Act::Moves => self.stands(clause, act, at, is_denied, found),
                Act::Follows => {
                    let front = match &clause.who {
                        Who::Ego => clause.object.map(|id| (id, true)),
                        Who::Obstacles(ids)
                            if clause.object.is_none()
                                && (self.is_ego(at.end)
                                    || self.is(at.end, "at by closely behind close")) =>
                        {
                            ids.first().map(|id| (*id, false))
                        }
                        _ => None,
                    };
                    if let Some((id, front)) = front.filter(|_| !is_denied) {
                        let side = Side {
                            front: Some(front),
                            left: None,
                        };
                        found.push(Said {
                            is_past: self.is_past(clause, &at),
                            at,
                            of: Some(id),
                            quantity: Quantity::Side,
                            stated: ClaimedValue::Side(side),
                        });
                    }
                }
                Act::Never(_)
                | Act::Drives(..)
                | Act::Passes
                | Act::Touches
                | Act::Contact
                | Act::Other => {}
            }
        }
    }

    /// A change of speed with the words for how much of it: "brakes hard". Who does not stop may brake all the same.
    fn how_much(
        &self,
        predicate: Predicate,
        clause: &Clause,
        at: &Range<usize>,
        is_denied: bool,
    ) -> Predicate {
        const HARD: &str = "hard harshly heavily sharply abruptly aggressively violently strongly fiercely slams slamming slam";
        const GENTLE: &str = "gently mildly softly lightly smoothly slightly";
        let brakes = match predicate {
            Predicate::Braking if is_denied && self.is(at.start, "stopping") => {
                return Predicate::Stops;
            }
            Predicate::Braking => true,
            Predicate::Accelerating => false,
            _ => return predicate,
        };
        let near = at.start.saturating_sub(2).max(clause.at.start)..(at.end + 3).min(clause.at.end);
        let says = |words: &str| near.clone().any(|i| self.is(i, words));
        match () {
            () if says(HARD) => Predicate::Hard(brakes),
            () if says(GENTLE) => Predicate::Gentle(brakes),
            () => predicate,
        }
    }

    /// Whether what follows "approaching" is the ego, or says how.
    pub(super) fn is_of_ego(&self, at: usize, clause: &Clause) -> bool {
        const HOW: &str = "from at rapidly quickly slowly steadily gradually slightly fast directly head longitudinally laterally and \
        but while with in on as us again very both along closely now further each by over during throughout since \
        within for";
        if at >= clause.at.end {
            return true;
        }
        self.is(at, HOW)
            || self.tokens[at].word.ends_with("ly")
            || !self.tokens[at].is_word()
            || self.is_named(at)
            || self.is(at, "the") && (at..at + 4).any(|i| self.is(i, "distance gap"))
    }

    /// Whether a participant is named right at a place.
    fn is_named(&self, at: usize) -> bool {
        (at..at + 3).any(|i| {
            self.reference_at(i)
                .is_some_and(|r| matches!(r.who, Named::Ego | Named::Obstacle(_) | Named::It))
        })
    }

    /// The axes along which a clause speaks: those that it names, or that its label or what it stands under does.
    pub(super) fn axes(&self, clause: &Clause, at: &Range<usize>) -> Vec<Option<bool>> {
        let named = |range: Range<usize>| {
            let words = self.tokens.get(range).unwrap_or_default();
            let long = words.iter().any(|t| t.stem.starts_with("longitudinal"));
            let side = words
                .windows(2)
                .any(|t| t[0].is("side") && t[1].is("gap clearance distance"));
            let lat = side || words.iter().any(|t| t.word.starts_with("lateral"));
            match (long, lat) {
                (true, true) => vec![Some(true), Some(false)],
                (true, false) => vec![Some(true)],
                (false, true) => vec![Some(false)],
                _ => Vec::new(),
            }
        };
        let own = named(clause.at.clone());
        let words = &self.tokens[clause.at.clone()];
        let says = |word: &str| words.iter().any(|t| t.is(word));
        match own.as_slice() {
            // "Longitudinally (3 m/s) and laterally".
            [one] => {
                let close = (clause.at.end..clause.at.end + 4).find(|i| self.is(*i, ")"));
                let other = close.filter(|i| self.is(clause.at.end, "(") && self.is(i + 1, "and"));
                let other = other.map_or(Vec::new(), |i| named(i + 2..i + 3));
                return std::iter::once(*one).chain(other).collect();
            }
            [_, _] if says("both") || says("and") => return own,
            [_, _] => return Vec::new(),
            _ => {}
        }
        let is_both = words.windows(2).any(|t| {
            t[0].is("both") && t[1].is("axes dimensions directions")
                || t[0].is("in") && t[1].is("both")
        });
        if is_both {
            return vec![Some(true), Some(false)];
        }
        // "Longitudinal -3 m/s, lateral -2 m/s (both approaching)".
        let is_bracket = clause.at.start > 0 && self.is(clause.at.start - 1, "(");
        let before = named(0..clause.at.start);
        if is_bracket && self.is(clause.at.start, "both") && before.len() == 2 {
            return before;
        }
        let labelled = named(clause.label.clone());
        if let [one] = labelled.as_slice() {
            return vec![*one];
        }
        // "Lateral 2 m (approaching)": the part before the bracket.
        if is_bracket && at.start == clause.at.start {
            let part = &self.tokens[..clause.at.start - 1];
            let from = part.iter().rposition(|t| t.is(", ;")).map_or(0, |i| i + 1);
            if let [one] = named(from..clause.at.start - 1).as_slice() {
                return vec![*one];
            }
        }
        // "Lateral TTC = 3 s (approaching)": in a field that names one.
        let head = self
            .tokens
            .iter()
            .position(|t| t.is(": ="))
            .filter(|i| *i < 6);
        if let Some([one]) = head.map(|end| named(0..end)).as_deref() {
            return vec![*one];
        }
        // "Lateral distance 2 m but closing": a short clause behind one that names an axis.
        let start = clause.at.start;
        let last = self.tokens[..start]
            .iter()
            .rposition(|t| t.is(", ; : ( ) but and while"));
        let last = last.filter(|_| self.is(start, "but and") && clause.at.len() <= 4);
        if let Some([one]) = last.map(|from| named(from..start)).as_deref() {
            return vec![*one];
        }
        vec![super::number::axis(self.above)]
    }

    /// That a body stands, or does not move along an axis.
    pub(super) fn stands(
        &self,
        clause: &Clause,
        act: Act,
        at: Range<usize>,
        is_denied: bool,
        found: &mut Vec<Said>,
    ) {
        let is_motion = act == Act::Moves;
        let next = self.tokens.get(at.end).filter(|_| at.end < clause.at.end);
        let is_bare =
            next.is_none_or(|t| t.is("at now anymore yet any and") || t.word.ends_with("ly"));
        let words = &self.tokens[clause.at.clone()];
        let has_axis = words
            .iter()
            .any(|t| t.word.starts_with("lateral") || t.stem.starts_with("longitudinal"));
        let is_relative = words.iter().any(|t| t.is("relative"));
        // "No longitudinal velocity" is read by [`super::phrases`].
        if has_axis || is_relative || is_motion && !is_bare {
            return;
        }
        if self.is(at.end, ":") || words.iter().any(|t| t.is("becomes became")) {
            return;
        }
        let says_zero = self.is(at.start, "no zero");
        let stands = is_motion == is_denied || says_zero;
        // "Longitudinal velocity: 0.0 m/s (stationary)" is the velocity along that axis.
        let before = &self.lower[..self.tokens[at.start].span.start];
        let axis = axis_before(before).filter(|_| stands);
        if is_motion && !is_denied && !(next.is_none() || self.is(at.end, "now")) {
            return;
        }
        let is_rough = (at.start.saturating_sub(2).max(clause.at.start)..at.start)
            .any(|i| self.is(i, "almost nearly basically practically virtually close"));
        for of in Self::own(clause) {
            let is_past = clause.mood == Mood::Past;
            let (quantity, stated) = if stands && is_rough {
                let slow = ClaimedValue::Bounds {
                    from: None,
                    to: Some(1.0),
                    decimals: 0,
                };
                (Quantity::Speed, slow)
            } else if stands {
                (axis.unwrap_or(Quantity::Speed), NOTHING)
            } else {
                let word = ClaimedValue::Word {
                    predicate: Predicate::Moving,
                    is_denied: false,
                };
                (Quantity::Motion, word)
            };
            found.push(Said {
                at: at.clone(),
                of,
                quantity,
                stated,
                is_past,
            });
        }
    }

    /// What descriptions say: "the car ahead".
    pub(super) fn described(&self, clause: &Clause, found: &mut Vec<Said>) {
        // "If the car on my left brakes": there is one.
        let is_said = clause.mood != Mood::Supposed;
        let own = self
            .references
            .iter()
            .filter(|r| clause.at.contains(&r.at.start) && (is_said || r.is_definite));
        for reference in own {
            let id = match (reference.who, &clause.who) {
                (Named::Obstacle(id), _) => id,
                (Named::It, Who::Obstacles(ids)) if ids.len() == 1 => ids[0],
                _ => continue,
            };
            for (said, at) in &reference.says {
                let (quantity, stated) = match said {
                    Described::At(side) => (Quantity::Side, ClaimedValue::Side(*side)),
                    Described::Stands => (Quantity::Speed, NOTHING),
                    Described::Is(predicate) => {
                        self.push(found, clause, at.clone(), Some(id), (*predicate, false));
                        continue;
                    }
                };
                found.push(Said {
                    at: at.clone(),
                    of: Some(id),
                    quantity,
                    stated,
                    is_past: clause.mood == Mood::Past,
                });
            }
        }
    }
}
