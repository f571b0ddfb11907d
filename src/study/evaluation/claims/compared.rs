//! How a clause says that distances and speeds change, and how it compares participants.

use std::ops::Range;
use std::sync::LazyLock;

use super::clauses::{Clause, Who};
use super::references::Named;
use super::speech::{Said, Speech};
use super::tokens::Lexicon;
use super::{Compared, Dimension, Predicate};

/// How distances and speeds are said to change, with the noun before the verb: "the gap is closing".
static TRENDS: LazyLock<Lexicon<bool>> = LazyLock::new(|| {
    Lexicon::new(&[
        (
            "increases|grows|grew|grown|widens|rises|rose|climbs|=up",
            true,
        ),
        ("gets|becomes larger|bigger|longer|wider", true),
        ("=opening|=opens", true),
        (
            "decreases|shrinks|shrank|shrunk|narrows|melts|drops|falls|fell|fallen|reduces|diminishes|tightens|shortens|declines|=closes|=closing|=down",
            false,
        ),
        ("gets|becomes smaller|shorter|tighter|less", false),
    ])
});

static NOUNS: LazyLock<Lexicon<Dimension>> = LazyLock::new(|| {
    Lexicon::new(&[
        (
            "distance|gap|separation|clearance|spacing|dtc",
            Dimension::Distance,
        ),
        ("speed|velocity", Dimension::Speed),
        ("ttc", Dimension::Ttc),
        (
            "braking|stopping|safe|following|safety distance|gap",
            Dimension::Risk,
        ),
    ])
});

/// Comparatives, and whether they say more; those of all say the most.
static COMPARATIVES: LazyLock<Lexicon<(Dimension, bool, bool)>> = LazyLock::new(|| {
    use Dimension::{Braking, Distance, Risk, Speed, Ttc};
    Lexicon::new(&[
        ("closer|nearer", (Distance, false, false)),
        ("farther|further ?away ?from", (Distance, true, false)),
        ("more distant", (Distance, true, false)),
        ("faster|quicker", (Speed, true, false)),
        ("slower", (Speed, false, false)),
        (
            "smaller|shorter|lower distance|gap",
            (Distance, false, false),
        ),
        (
            "larger|greater|longer|bigger distance|gap",
            (Distance, true, false),
        ),
        ("smaller|shorter|lower ttc", (Ttc, false, false)),
        ("larger|greater|longer|higher ttc", (Ttc, true, false)),
        ("higher|greater|larger speed|velocity", (Speed, true, false)),
        ("lower|smaller speed|velocity", (Speed, false, false)),
        (
            "more|much dangerous|critical|risky|threatening|relevant",
            (Risk, true, false),
        ),
        (
            "less dangerous|critical|risky|threatening",
            (Risk, false, false),
        ),
        (
            "higher|greater|riskier|larger ?risk|danger|threat",
            (Risk, true, false),
        ),
        ("lower|smaller risk|danger|threat", (Risk, false, false)),
        ("brake|decelerate|slow harder|more", (Braking, true, false)),
        ("brake|decelerate|slow hardest|most", (Braking, true, true)),
        ("closest|nearest", (Distance, false, true)),
        (
            "closest|nearest approach|point|distance|gap",
            (Distance, false, false),
        ),
        ("farthest|furthest", (Distance, true, true)),
        ("fastest|quickest", (Speed, true, true)),
        ("slowest", (Speed, false, true)),
        (
            "most immediate|significant|serious|severe|imminent ?collision|safety risk|threat|danger",
            (Risk, true, true),
        ),
        (
            "most dangerous|critical|risky|threatening",
            (Risk, true, true),
        ),
        (
            "highest|greatest|riskiest|biggest ?risk|danger|threat",
            (Risk, true, true),
        ),
        (
            "smallest|lowest|least risk|danger|threat",
            (Risk, false, true),
        ),
        (
            "least dangerous|critical|risky|threatening",
            (Risk, false, true),
        ),
        ("smallest|shortest|lowest|minimum ttc", (Ttc, false, true)),
        ("longest|largest|highest ttc", (Ttc, true, true)),
        (
            "smallest|shortest|lowest|minimum time to|until collision|contact",
            (Ttc, false, true),
        ),
        (
            "smallest|shortest|lowest distance|gap|clearance",
            (Distance, false, true),
        ),
    ])
});

/// The first of what was found.
trait First<T> {
    fn copied_first(self) -> Option<T>;
}

impl<T: Copy> First<(T, Range<usize>)> for Option<&(T, Range<usize>)> {
    fn copied_first(self) -> Option<(T, Range<usize>)> {
        self.map(|(said, at)| (*said, at.clone()))
    }
}

impl Speech<'_> {
    /// How a distance or a speed is said to change.
    pub(super) fn trends(&self, clause: &Clause, found: &mut Vec<Said>) {
        let nouns = NOUNS.all(self.tokens, clause.at.clone());
        self.constant(clause, &nouns, found);
        self.steady(clause, found);
        let trends = TRENDS.all(self.tokens, clause.at.clone());
        let [(grows, verb)] = trends.as_slice() else {
            return;
        };
        // "Gap 4.4 m, opening".
        // "The distance (3 m) is opening".
        let begin = self.begins(clause);
        let earlier = if begin < clause.at.start {
            NOUNS.all(self.tokens, begin..clause.at.start)
        } else if verb.start == clause.at.start {
            NOUNS.all(
                self.tokens,
                clause.at.start.saturating_sub(5)..clause.at.start,
            )
        } else {
            Vec::new()
        };
        let before = nouns.iter().rfind(|(_, noun)| noun.end <= verb.start);
        let Some((dimension, noun)) = before.or_else(|| nouns.first()).or_else(|| earlier.last())
        else {
            return;
        };
        let is_near = verb.start >= noun.end && verb.start - noun.end <= 8
            || noun.start < clause.at.start && begin < clause.at.start
            || noun.start >= verb.end
                && (verb.end..noun.start)
                    .all(|i| self.is(i, "in of the its both longitudinal lateral and relative"));
        // "Increasing the distance" is a verb of its own.
        let is_taken = found
            .iter()
            .any(|s| s.at.start < verb.end && verb.start < s.at.end);
        // "Never fell below 3 m" bounds it.
        let is_bound = self.is(verb.end, "below under above over beyond")
            && clause.at.clone().any(|i| self.is(i, "never not"));
        if !is_near || is_taken || is_bound {
            return;
        }
        let Some(is_denied) = self.denial(clause, verb.start) else {
            return;
        };
        let at = noun.start.min(verb.start)..noun.end.max(verb.end);
        match dimension {
            Dimension::Distance => {
                for axis in self.axes(clause, &at) {
                    let predicate = if *grows {
                        Predicate::Receding(axis)
                    } else {
                        Predicate::Approaching(axis)
                    };
                    // "We see a decrease in distance": to whom all of it is about.
                    let mut pair = self.pair(clause);
                    if pair.is_empty() && clause.who == Who::Ego {
                        pair.extend(clause.topic);
                    }
                    for id in pair {
                        self.push(found, clause, at.clone(), Some(id), (predicate, is_denied));
                    }
                }
            }
            Dimension::Speed => {
                let is_relative = self.tokens[clause.at.clone()]
                    .iter()
                    .any(|t| t.is("relative closing longitudinal lateral approach"));
                if !is_relative {
                    let predicate = if *grows {
                        Predicate::Accelerating
                    } else {
                        Predicate::Braking
                    };
                    for of in Self::own(clause) {
                        self.push(found, clause, at.clone(), of, (predicate, is_denied));
                    }
                }
            }
            Dimension::Ttc | Dimension::Risk | Dimension::Braking => {}
        }
    }

    /// How many are before one that a superlative is of: "the second closest".
    fn rank(&self, at: usize) -> u8 {
        match at.checked_sub(1).map(|i| self.tokens[i].word.as_str()) {
            Some("second") => 1,
            Some("third") => 2,
            _ => 0,
        }
    }

    /// That a speed stays as it is: "at a steady 82 km/h".
    fn steady(&self, clause: &Clause, found: &mut Vec<Said>) {
        let is_speed = |i: usize| {
            self.tokens.get(i).is_some_and(|t| {
                t.number.is_some()
                    && (t.word.ends_with("/h") || t.word.ends_with("m/s") || t.word.ends_with("ph"))
            })
        };
        let at = clause
            .at
            .clone()
            .find(|i| self.is(*i, "constant steady") && is_speed(i + 1));
        if let Some(at) = at
            && let Some(is_denied) = self.denial(clause, at)
        {
            for of in Self::own(clause) {
                self.push(
                    found,
                    clause,
                    at..at + 1,
                    of,
                    (Predicate::Steady, is_denied),
                );
            }
        }
    }

    /// That a distance stays as it is: "the gap is steady", "keeps its distance".
    fn constant(
        &self,
        clause: &Clause,
        nouns: &[(Dimension, Range<usize>)],
        found: &mut Vec<Said>,
    ) {
        const SAME: &str = "constant steady unchanged stable";
        let Some((_, noun)) = nouns.iter().find(|(of, _)| *of == Dimension::Distance) else {
            return;
        };
        let next = (noun.end..(noun.end + 8).min(clause.at.end)).find(|i| self.is(*i, SAME));
        let is_said = next.is_some_and(|at| (noun.end..at).all(|i| !self.is(i, "speed velocity")));
        let keeps = (noun.start.saturating_sub(4).max(clause.at.start)..noun.start)
            .any(|i| self.is(i, "keeps keep keeping holds maintains maintaining"));
        let is_own = keeps
            && (noun.start.saturating_sub(2)..noun.start)
                .any(|i| self.is(i, "its my our his constant steady"));
        if !is_said && !is_own {
            return;
        }
        let at = noun.start..next.filter(|_| is_said).map_or(noun.end, |next| next + 1);
        let Some(is_denied) = self.denial(clause, noun.start.max(at.end - 1)) else {
            return;
        };
        for axis in self.axes(clause, &at) {
            for id in self.pair(clause) {
                self.push(
                    found,
                    clause,
                    at.clone(),
                    Some(id),
                    (Predicate::KeepsDistance(axis), is_denied),
                );
            }
        }
    }

    /// The sign of a relative velocity: "a negative longitudinal velocity", "the relative velocity is positive".
    pub(super) fn signs(&self, clause: &Clause, found: &mut Vec<Said>) {
        let of = |words: &str| clause.at.clone().find(|i| self.is(*i, words));
        let (Some(sign), Some(noun)) = (of("negative positive"), of("velocity velocities")) else {
            return;
        };
        let is_near = sign < noun && noun - sign <= 3
            || sign > noun
                && sign - noun <= if self.is(sign + 1, "direction") { 6 } else { 4 }
                && (noun..sign).any(|i| self.is(i, "is becomes remains are was has"));
        let is_relative = (sign.min(noun).saturating_sub(3)..noun.max(sign))
            .any(|i| self.is(i, "relative longitudinal lateral closing"));
        if !is_near
            || !is_relative
            || (sign..noun.max(sign) + 2)
                .any(|i| self.tokens.get(i).is_some_and(|t| t.number.is_some()))
        {
            return;
        }
        let Some(is_denied) = self.denial(clause, sign) else {
            return;
        };
        let at = sign.min(noun)..sign.max(noun) + 1;
        let is_lateral = at
            .clone()
            .chain(noun.saturating_sub(2)..noun)
            .any(|i| self.is(i, "lateral"));
        // "Negative relative velocities" are those along both axes.
        let names_one = at
            .clone()
            .any(|i| self.is(i, "lateral longitudinal closing"));
        let is_both = self.is(noun, "velocities") && !names_one;
        for long in [true, false] {
            if long == is_lateral && !is_both {
                continue;
            }
            let predicate = Predicate::Signed(long, self.is(sign, "positive"));
            for id in self.pair(clause) {
                self.push(found, clause, at.clone(), Some(id), (predicate, is_denied));
            }
        }
    }

    /// Whether a comparative says how fast something changes: "decelerates faster".
    pub(super) fn is_of_change(&self, at: &Range<usize>) -> bool {
        const CHANGES: [&str; 12] = [
            "decelerat",
            "accelerat",
            "brak",
            "slow",
            "clos",
            "approach",
            "reced",
            "chang",
            "decreas",
            "increas",
            "shrink",
            "rat",
        ];
        let before = (at.start.saturating_sub(3)..at.start)
            .rev()
            .find(|i| !self.tokens[*i].is_filler() && !self.is(*i, "slightly"));
        self.is(at.start, "faster slower quicker")
            && before.is_some_and(|i| CHANGES.contains(&self.tokens[i].stem.as_str()))
    }

    /// Comparisons with another obstacle, and with all.
    pub(super) fn comparisons(&self, clause: &Clause, found: &mut Vec<Said>) {
        for ((of, is_more, is_most), at) in COMPARATIVES.all(self.tokens, clause.at.clone()) {
            // "Its lowest risk score" is one of its own.
            if is_most && self.is(at.end, "score scores") {
                continue;
            }
            if self.is_of_change(&at) {
                continue;
            }
            // "The slower truck" says so itself; "the fastest of the three" is of some.
            let is_in = self
                .references
                .iter()
                .any(|r| r.says.iter().any(|(_, place)| place.contains(&at.start)));
            let some = (at.end..at.end + 3).any(|i| {
                self.is(i, "of among near nearby around close here")
                    && !(i..i + 3).any(|k| self.is(k, "all every scene"))
            });
            // "At its closest" is when.
            let is_when = at.start > 0 && self.is(at.start - 1, "its their");
            if is_in || is_most && (some || is_when) {
                continue;
            }
            // "The ego is faster than both".
            if clause.who == Who::Ego && of == Dimension::Speed && !is_most {
                let than = self
                    .references
                    .iter()
                    .find(|r| r.at.start > at.start && clause.at.contains(&r.at.start));
                let others = match than.map(|r| r.who) {
                    Some(Named::Obstacle(id)) => vec![id],
                    Some(Named::Both) => self.both.map_or(Vec::new(), Vec::from),
                    _ => clause.topic.into_iter().collect(),
                };
                let Some(is_denied) = self.denial(clause, at.start) else {
                    continue;
                };
                for id in others {
                    let predicate = Predicate::Compared(Compared {
                        of,
                        is_more,
                        than: Some(id),
                        rank: 0,
                    });
                    self.push(found, clause, at.clone(), None, (predicate, is_denied));
                }
                continue;
            }
            let Who::Obstacles(ids) = &clause.who else {
                continue;
            };
            let [id] = ids.as_slice() else { continue };
            let Some(is_denied) = self.denial(clause, at.start) else {
                continue;
            };
            // "Car 7: nearest at step 47" tells when.
            if is_most && self.is(at.end, "at in within") {
                continue;
            }
            let than = if is_most {
                // "The nearest car brakes" names it, and "7 is the nearest" says so.
                let naming = self.reference_at(at.start);
                if naming.is_some_and(|r| {
                    !r.says.is_empty() || r.who == Named::Obstacle(*id) && !self.names(*id, r)
                }) {
                    continue;
                }
                None
            } else {
                let limit = (at.end + 8).min(self.tokens.len());
                let Some(than) = (at.end..limit).find(|i| self.is(*i, "than")) else {
                    // "It is way faster".
                    if of == Dimension::Speed && at.end == clause.at.end {
                        let predicate = if is_more {
                            Predicate::FasterThanEgo
                        } else {
                            Predicate::SlowerThanEgo
                        };
                        self.push(found, clause, at, Some(*id), (predicate, is_denied));
                    }
                    continue;
                };
                let next = self
                    .references
                    .iter()
                    .find(|r| r.at.start > than && r.at.start <= than + 3);
                match next.map(|r| r.who) {
                    Some(Named::Obstacle(other)) if other != *id => Some(other),
                    _ => continue,
                }
            };
            let predicate = Predicate::Compared(Compared {
                of,
                is_more,
                than,
                rank: self.rank(at.start),
            });
            self.push(found, clause, at, Some(*id), (predicate, is_denied));
        }
        // "Its TTC of 1 s is the smallest".
        let all = NOUNS.all(self.tokens, clause.at.clone());
        let bare = clause
            .at
            .clone()
            .find(|i| self.is(*i, "smallest shortest lowest minimum least"));
        if let ([(of @ (Dimension::Ttc | Dimension::Distance), noun), ..], Some(at)) =
            (all.as_slice(), bare)
            && at > noun.start
            && (noun.start..at).any(|i| self.is(i, "is"))
            && let Who::Obstacles(ids) = &clause.who
            && let [id] = ids.as_slice()
            && let Some(is_denied) = self.denial(clause, at)
        {
            let predicate = Predicate::Compared(Compared {
                of: *of,
                is_more: false,
                than: None,
                rank: 0,
            });
            self.push(found, clause, at..at + 1, Some(*id), (predicate, is_denied));
        }
        // "Most dangerous: 304".
        let is_of_some = clause
            .label
            .clone()
            .any(|i| self.is(i, "nearby around close of among here"));
        if let (false, Some(((of, is_more, true), _)), Who::Obstacles(ids)) = (
            is_of_some,
            COMPARATIVES
                .all(self.tokens, clause.label.clone())
                .first()
                .copied_first(),
            &clause.who,
        ) && let [id] = ids.as_slice()
            && self.tokens[clause.at.clone()].len() <= 4
        {
            let predicate = Predicate::Compared(Compared {
                of,
                is_more,
                than: None,
                rank: 0,
            });
            self.push(
                found,
                clause,
                clause.at.clone(),
                Some(*id),
                (predicate, false),
            );
        }
    }
}
