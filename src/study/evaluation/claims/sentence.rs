//! The claims of one sentence about one obstacle.

use super::clauses::{Clause, Mood, Who};
use super::find::ends_with_word;
use super::number::{
    Number, Unit, axis, find_axis, from_ego, only_axis, scale, without_reference,
};
use super::phrases;
use super::plans;
use super::places::{PLACES, Placed};
use super::references::{Named, Reference};
use super::score;
use super::tokens::{Token, denies, has_word};
use super::verbs::{Act, Speech, VERBS};
use super::{Claim, ClaimedValue, Predicate, Quantity};

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
    /// Whether a trajectory came with the text.
    pub has_trajectory: bool,
    /// The step that it names, or that was named for it.
    pub step: Option<i64>,
}

/// Words in a clause that make its numbers no values of the scene.
const SUPPOSED: [&str; 11] = [
    "predicted", "probability", "forecast", "expected", "example", "average", "difference", "required", "requires", "recommended", "mean",
];

/// Words before a number that make it a bound, and whether the value is above it; "" where it is no value at all.
const BOUNDS: [(&str, Option<bool>); 34] = [
    ("less than", Some(false)),
    ("lower than", Some(false)),
    ("smaller than", Some(false)),
    ("shorter than", Some(false)),
    ("closer than", Some(false)),
    ("nearer than", Some(false)),
    ("no more than", Some(false)),
    ("not more than", Some(false)),
    ("at most", Some(false)),
    ("up to", Some(false)),
    ("below", Some(false)),
    ("under", Some(false)),
    ("within", Some(false)),
    ("inside", Some(false)),
    ("<", Some(false)),
    ("≤", Some(false)),
    ("more than", Some(true)),
    ("greater than", Some(true)),
    ("larger than", Some(true)),
    ("longer than", Some(true)),
    ("higher than", Some(true)),
    ("further than", Some(true)),
    ("farther than", Some(true)),
    ("no less than", Some(true)),
    ("at least", Some(true)),
    ("above", Some(true)),
    ("over", Some(true)),
    ("exceeds", Some(true)),
    ("exceeding", Some(true)),
    ("beyond", Some(true)),
    (">", Some(true)),
    ("≥", Some(true)),
    ("than", None),
    ("by", None),
];

/// Words for lengths other than a distance to the ego.
const OTHER_LENGTHS: &[&str] = &[
    "mdc",
    "minimum",
    "min",
    "dce",
    "width",
    "length",
    "size",
    "radius",
    "offset",
    "change",
    "changed",
    "changing",
    "shift",
    "moved",
    "travels",
    "traveled",
    "travelled",
    "braking",
    "stopping",
    "lane",
    "center",
    "centre",
    "dimensions",
    "wide",
    "long,",
    "x",
    "y",
    "combined",
    "sum",
    "total",
];

/// What a number is to the value.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Bound {
    /// The value itself.
    None,
    /// The value is above it.
    Above,
    /// The value is below it.
    Below,
    /// The value is between another one and it.
    Between(f64),
}

/// Words with which a sentence supposes, asks, quotes, or denies as a whole.
const UNSAID: [&str; 29] = [
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
    "option",
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
}

/// A number in the sentence, and what it says of whom.
struct Stated {
    quantity: Quantity,
    value: ClaimedValue,
    of: i64,
    is_past: bool,
}

/// Whether what follows seconds is the contact that they lead to: "before impact", "to the collision".
fn is_before_contact(after: &str) -> bool {
    let rest = ["before ", "until ", "to ", "till ", "away from "].iter().find_map(|word| after.strip_prefix(word));
    let rest = rest.map(|rest| rest.trim_start_matches("the ").trim_start_matches("a "));
    rest.is_some_and(|rest| {
        ["impact", "collision", "contact", "crash", "hitting"].iter().any(|word| rest.starts_with(word))
    })
}

/// Whether "from" stands right before a number: where a change begins.
fn near_ends_with_from(before: &str) -> bool {
    let bare = before.trim_end_matches(['*', ' ', '~', '≈']);
    let bare = bare.strip_suffix("about").unwrap_or(bare).trim_end();
    ends_with_word(bare, "from")
}

/// Whether the last verb of words says that it gets faster (true) or slower.
fn change_of_speed(near: &str) -> Option<bool> {
    let last = |words: &[&str]| words.iter().filter_map(|word| near.rfind(word)).max();
    let faster = last(&["accelerates", "accelerating", "accelerated"]);
    let slower = last(&["decelerat", "brakes", "braking", "braked", "slows", "slowing", "deceleration"]);
    match (faster, slower) {
        (None, None) => None,
        (a, b) => Some(a > b),
    }
}

impl Sentence<'_> {
    /// Its claims, in order.
    pub fn claims(&self) -> Vec<Claim> {
        if is_unsaid(self.lower) {
            return Vec::new();
        }
        let mut found: Vec<Claim> = Vec::new();
        found.extend(self.change());
        found.extend(self.both_axes());
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
                let mut claim = self.claim(span, of, said.quantity, said.stated);
                // What never happens does so at no step.
                if let ClaimedValue::Word { predicate: Predicate::Touches | Predicate::WillTouch, .. } = claim.stated {
                    claim.step = None;
                }
                found.push(claim);
            }
        }
        let risks = score::risks(self.lower, self.above, self.numbers);
        let lanelets = score::lanelets(self.lower);
        let never = score::never(self.lower, self.above);
        for (span, quantity, value) in risks.into_iter().chain(lanelets).chain(never) {
            self.said_of_one(span, quantity, value, &mut found);
        }
        for (span, quantity, value) in score::written(self.lower, self.numbers) {
            self.said_of_one(span, quantity, value, &mut found);
        }
        if self.is_contradictory() {
            found.retain(|claim| claim.quantity != Quantity::Motion);
        }
        found.sort_by_key(|claim| claim.span.start);
        found.dedup_by(|a, b| a == b);
        found
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

    /// The clause that a byte stands in.
    fn clause(&self, at: usize) -> Option<&Clause> {
        let place = self.tokens.iter().position(|t| t.span.end > at)?;
        let own = self.clauses.iter().find(|c| c.at.contains(&place));
        own.or_else(|| self.clauses.iter().rfind(|c| c.at.end <= place))
    }

    /// Where what is said of a number begins: its clause, or the one that its bracket stands behind.
    fn begins(&self, number: &Number) -> (usize, bool) {
        let Some(clause) = self.clause(number.span.start) else {
            return (number.span.start, false);
        };
        let start = clause.at.start;
        let is_bracket = start > 0 && self.tokens[start - 1].is(&["("]);
        let own = if is_bracket {
            let before = self.clauses.iter().rfind(|c| c.at.end < start);
            before.map_or(start, |before| before.at.start)
        } else {
            start
        };
        (self.tokens[own].span.start, is_bracket)
    }

    /// The obstacle that a clause is about, or that the ego of it meets.
    fn met(clause: &Clause) -> Option<i64> {
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
        let before = &self.lower[self.tokens.get(clause.at.start).map_or(0, |t| t.span.start).min(span.start)..span.start];
        let is_of_ego = clause.who == Who::Ego && clause.object.is_none() && quantity == Quantity::Position;
        // "I rate it 2": of whom it is about.
        let is_rated = quantity == Quantity::Risk && !matches!(clause.who, Who::Obstacles(_));
        let topic = clause.topic.filter(|_| is_rated).map(|id| (id, false));
        let of = match is_of_ego {
            true => Some((self.ego, false)),
            false => self.stated_of(span.start).or(topic),
        };
        if let Some(of) = of
            && !denies(before)
        {
            found.push(self.claim(span, of, quantity, value));
        }
    }

    /// What the number at a place says; `from` is where the one before it ends, and `last` what that one said.
    fn number(&self, place: usize, from: usize, last: Option<(Quantity, Unit)>) -> Vec<Stated> {
        let number = &self.numbers[place];
        let Some(clause) = self.clause(number.span.start) else {
            return Vec::new();
        };
        let words = &self.tokens[clause.at.clone()];
        let is_past = match clause.mood {
            Mood::Said => false,
            Mood::Past => true,
            Mood::Future | Mood::Supposed => return Vec::new(),
        };
        let near = &self.lower[from..number.span.start];
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        // "0.5 s < TTC ≤ 1 s" defines a class.
        let compares = |text: &str| text.matches(['<', '≤', '>', '≥']).count();
        if compares(near) > 1 {
            return Vec::new();
        }
        let next = after.trim_start_matches(['<', '≤', '>', '≥', '=', ' ']);
        if next.len() < after.len() && next.starts_with(char::is_alphabetic) {
            return Vec::new();
        }
        // "From 3 m on".
        if near_ends_with_from(&self.lower[..number.span.start]) {
            return Vec::new();
        }
        if words.iter().any(|t| t.is(&SUPPOSED)) || number.unit == Unit::Acceleration && words.iter().any(|t| t.is(&["peak", "peaked", "maximum", "max", "up"])) {
            return Vec::new();
        }
        let begin = self.tokens[clause.at.start].span.start.clamp(from, number.span.start);
        let bound = self.bound(place, &self.lower[begin..number.span.start]);
        let Some(bound) = bound else {
            return Vec::new();
        };
        let (quantity, magnitude) = match self.quantity(place, from) {
            Some(found) => found,
            // "A TTC of 1.2 s is below 1 s": the same quantity again.
            None => match last {
                Some((quantity, unit)) if unit == number.unit && bound != Bound::None => (quantity, true),
                _ => return Vec::new(),
            },
        };
        let of = match (&clause.who, quantity) {
            (Who::Ego, Quantity::Speed | Quantity::Acceleration | Quantity::Heading) => Some(self.ego),
            _ => Self::met(clause),
        };
        let Some(of) = of else { return Vec::new() };
        // "Accelerates with 2 m/s²" is no braking, and "brakes with 2 m/s²" is.
        let verb = if quantity == Quantity::Acceleration { change_of_speed(near) } else { None };
        let value = match bound {
            Bound::None => ClaimedValue::Number {
                value: match verb {
                    Some(faster) => number.value.abs() * if faster { 1.0 } else { -1.0 },
                    None => number.value,
                },
                decimals: number.decimals,
                rough: self.rough(from, number.span.start),
                magnitude: verb.is_none() && (magnitude || self.magnitude(from, number)),
            },
            Bound::Above => ClaimedValue::Bounds {
                from: Some(number.value.abs()),
                to: None,
                decimals: number.decimals,
            },
            Bound::Below => ClaimedValue::Bounds {
                from: None,
                to: Some(number.value.abs()),
                decimals: number.decimals,
            },
            Bound::Between(first) => ClaimedValue::Bounds {
                from: Some(first.min(number.value.abs())),
                to: Some(first.max(number.value.abs())),
                decimals: number.decimals,
            },
        };
        let one = |quantity| Stated {
            quantity,
            value,
            of,
            is_past,
        };
        // "Relative velocity: 0 m/s in both dimensions", "TTClong and TTClat are both 0 s", "2 m longitudinally and laterally".
        let own = &self.lower[self.begins(number).0.min(number.span.start)..number.span.start];
        let names = |text: &str| text.contains("long") && text.contains("lat");
        let is_both = after.starts_with("in both ")
            || names(own) && has_word(own, "both")
            || after.starts_with("longitudinally and laterally");
        let across = match quantity {
            Quantity::VelocityLong | Quantity::VelocityLat => Some([Quantity::VelocityLong, Quantity::VelocityLat]),
            Quantity::TtcLong | Quantity::TtcLat => Some([Quantity::TtcLong, Quantity::TtcLat]),
            Quantity::GapLong | Quantity::GapLat => Some([Quantity::GapLong, Quantity::GapLat]),
            _ => None,
        };
        if is_both && let Some(both) = across {
            return both.map(one).into();
        }
        vec![one(quantity)]
    }

    /// What the words before a number make of it; nothing where it is no value.
    fn bound(&self, place: usize, near: &str) -> Option<Bound> {
        let number = &self.numbers[place];
        // "At the last step, the distance is 3 m": what stands before the comma bounds nothing.
        let own = near.rsplit([',', ')', ';']).next().unwrap_or(near);
        let own = own.replace("over time", "");
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        // "Between 3 and 5 m", "3 to 5 m", "3–5 m".
        if let Some(first) = place.checked_sub(1).map(|i| &self.numbers[i])
            && matches!(first.unit, Unit::None)
            && number.unit != Unit::None
        {
            let joint = self.lower.get(first.span.end..number.span.start).unwrap_or("?");
            let joint = joint.trim_matches(['*', ' ', '`']);
            let before = self.lower[..first.span.start].trim_end();
            if joint == "and" && before.ends_with("between") || joint == "to" && !before.ends_with("from") || ["-", "–"].contains(&joint) {
                return Some(Bound::Between(first.value.abs()));
            }
        }
        if let Some(first) = place.checked_sub(1).map(|i| &self.numbers[i])
            && first.unit == number.unit
            && near.trim() == "and"
            && self.lower[..first.span.start].trim_end().ends_with("between")
        {
            return Some(Bound::Between(first.value.abs()));
        }
        let ends = own.split_once("between").map(|(_, ends)| ends);
        if let Some(ends) = ends
            && !has_word(ends, "ego") && !has_word(ends, "us") && !ends.contains("flank") && !ends.contains("bodies")
        {
            return None;
        }
        const NOT_NUMBERS: [&str; 7] = ["until", "every", "per", "past", "last", "next", "changes"];
        let words: Vec<&str> = own.split_whitespace().rev().take(3).collect();
        if words.iter().any(|word| NOT_NUMBERS.contains(word)) {
            return None;
        }
        let is_symbol = |words: &str| !words.starts_with(char::is_alphabetic);
        let word = BOUNDS.iter().find(|(words, _)| {
            is_symbol(words) && own.contains(words) || !is_symbol(words) && has_word(&own, words)
        });
        let is_above = match word {
            Some(("by", None)) if ["trails", "leads", "behind", "ahead", "separated", "apart", "avoided", "missed", "cleared", "misses", "clears", "faster", "slower"].iter().any(|word| has_word(&own, word)) => {
                return Some(Bound::None);
            }
            Some((_, None)) => return None,
            Some((_, Some(above))) => *above,
            None if ["or less", "or closer"].iter().any(|words| after.starts_with(words)) => false,
            None if after.starts_with("or more") => true,
            None => return Some(Bound::None),
        };
        // "Not below 3 m", "never more than 3 m".
        let is_above = if denies(&own) && !own.contains("no more than") && !own.contains("no less than") && !own.contains("not more than") {
            !is_above
        } else {
            is_above
        };
        Some(if is_above { Bound::Above } else { Bound::Below })
    }

    /// Whether a length is that to something else than the ego or the obstacle: "the distance to the kerb".
    fn is_to_another(&self, near: &str) -> bool {
        let Some((_, to)) = near
            .split_once("distance to ")
            .or_else(|| near.split_once("gap to "))
        else {
            return false;
        };
        let to = to.strip_prefix("the ").unwrap_or(to);
        let word = to
            .split(|c: char| !c.is_alphanumeric())
            .next()
            .unwrap_or_default();
        let known = [
            "ego",
            "obstacle",
            "vehicle",
            "car",
            "truck",
            "it",
            "us",
            "collision",
            "this",
            "that",
            "bus",
            "id",
        ];
        !word.is_empty() && !known.contains(&word) && word.parse::<f64>().is_err()
    }

    /// Two numbers with their axes in the same order: "longitudinal & lateral distance: 12.57 m & -3.36 m", "12.57 m long, -3.36 m
    /// lat".
    fn both_axes(&self) -> Vec<Claim> {
        let pair = self.numbers.windows(2).find_map(|pair| {
            let (a, b) = (&pair[0], &pair[1]);
            let (before, between, after) = (
                &self.lower[..a.span.start],
                self.lower
                    .get(a.span.end..b.span.start)?
                    .trim_matches(['*', ' ', '`']),
                self.lower[b.span.end..].trim_start_matches(['*', ' ', '`']),
            );
            let same = a.unit == b.unit && matches!(a.unit, Unit::Metre | Unit::Speed);
            if !same {
                return None;
            }
            let short = |text: &str, word: &str| {
                text.strip_prefix(word)
                    .is_some_and(|rest| !rest.starts_with(char::is_alphabetic))
            };
            if short(between, "long") && short(after, "lat") {
                return Some((pair, true));
            }
            let joined = ["&", "and", ",", "/"].contains(&between);
            let part = before.rsplit([';', '.']).next().unwrap_or(before);
            let order = part.rfind("longitudinal").zip(part.rfind("lateral"));
            let (long, lat) = order.filter(|_| joined)?;
            Some((pair, long < lat))
        });
        let Some((pair, long_first)) = pair else {
            return Vec::new();
        };
        let Some(of) = self.stated_of(pair[0].span.start) else {
            return Vec::new();
        };
        let before = format!("{} {}", self.above, &self.lower[..pair[0].span.start]);
        let is_velocity = pair[0].unit == Unit::Speed;
        let says = |words: &[&str]| words.iter().any(|word| has_word(&before, word));
        if !is_velocity && !says(&["distance", "distances", "gap", "gaps"]) {
            return Vec::new();
        }
        let claim = |number: &Number, long: bool| {
            let quantity = match (is_velocity, long) {
                (false, true) => Quantity::GapLong,
                (false, false) => Quantity::GapLat,
                (true, true) => Quantity::VelocityLong,
                (true, false) => Quantity::VelocityLat,
            };
            let stated = ClaimedValue::Number {
                value: number.value,
                decimals: number.decimals,
                rough: self.rough(0, number.span.start),
                magnitude: self.magnitude(0, number),
            };
            self.claim(number.span.clone(), of, quantity, stated)
        };
        vec![claim(&pair[0], long_first), claim(&pair[1], !long_first)]
    }

    /// Whether a verb says something else than its numbers: "increased from 11 m to 9 m".
    fn is_contradictory(&self) -> bool {
        let Some([from, to]) = self.pair() else {
            return false;
        };
        let before = &self.lower[..from.span.start];
        let has = |words: &[&str]| words.iter().any(|word| before.contains(word));
        let grows = has(&["increas", "grow", "grew", "accelerat", "rose"]);
        let shrinks = has(&["decreas", "shr", "reduc", "slow", "brak", "fell", "drop"]);
        let (from, to) = (from.value.abs(), to.value.abs());
        grows && !shrinks && to < from || shrinks && !grows && to > from
    }

    /// The numbers of a change: "from 9 m to 7.8 m", "9 → 7.8 m".
    fn pair(&self) -> Option<[&Number; 2]> {
        let pairs = self.numbers.iter().enumerate().flat_map(|(i, first)| {
            let further = self.numbers[i + 1..].iter().take(2);
            further.map(move |second| [first, second])
        });
        { pairs }.find(|pair| {
            let between = self.lower.get(pair[0].span.end..pair[1].span.start);
            let between = between.unwrap_or("?").trim();
            // "From 3.75 m (4.8 s) to 0.2 m".
            let between = match (between.starts_with('('), between.rfind(')')) {
                (true, Some(end)) => between[end + 1..].trim(),
                _ => between,
            };
            let before = self.lower[..pair[0].span.start].trim_end_matches(['*', ' ', '~']);
            let is_from = before.ends_with("from") && between == "to";
            let is_arrow = ["→", "->"].contains(&between);
            let same = pair[0].unit == pair[1].unit || pair[0].unit == Unit::None;
            (is_from || is_arrow) && same
        })
    }

    /// From one number to another: "the gap decreased from 9 m to 7.8 m".
    fn change(&self) -> Option<Claim> {
        if denies(self.lower) {
            return None;
        }
        let pair = self.pair()?;
        let clause = self.clause(pair[0].span.start)?;
        let before = &self.lower[..pair[0].span.start];
        let says = |words: &[&str]| {
            words.iter().any(|word| has_word(before, word) || has_word(self.above, word))
        };
        let quantity = match pair[1].unit {
            Unit::Metre if says(&["distance", "gap", "separation", "clearance", "spacing", "headway"]) => {
                match axis(before).or_else(|| axis(self.above)) {
                    Some(true) => Quantity::GapLong,
                    Some(false) => Quantity::GapLat,
                    None => Quantity::Distance,
                }
            }
            Unit::Speed if says(&["closing", "relative"]) => Quantity::ClosingSpeed,
            Unit::Speed => Quantity::Speed,
            Unit::Second if says(&["ttc", "collision"]) => Quantity::Ttc,
            _ => return None,
        };
        let is_own = quantity == Quantity::Speed && clause.who == Who::Ego;
        let of = if is_own { self.ego } else { self.stated_of(pair[0].span.start)?.0 };
        if matches!(clause.mood, Mood::Supposed | Mood::Future) {
            return None;
        }
        // As of km/h, the unit behind the second number.
        let scale = if pair[0].unit == Unit::None { scale(&self.lower[pair[1].span.clone()]) } else { 1.0 };
        let stated = ClaimedValue::Change {
            from: pair[0].value * scale,
            to: pair[1].value,
            decimals: pair[0].decimals.min(pair[1].decimals),
        };
        let mut claim = self.claim(pair[0].span.start..pair[1].span.end, (of, false), quantity, stated);
        claim.step = None;
        Some(claim).filter(|_| !self.is_contradictory())
    }

    /// The obstacle that what stands at a byte is stated of, and whether as of a time before.
    fn stated_of(&self, at: usize) -> Option<(i64, bool)> {
        let clause = self.clause(at)?;
        let is_said = matches!(clause.mood, Mood::Said | Mood::Past);
        let id = Self::met(clause).filter(|_| is_said)?;
        Some((id, clause.mood == Mood::Past))
    }

    fn claim(
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
            quantity,
            stated,
            step: self.step,
        }
    }

    /// What the number says, and whether as a magnitude; `from` is where the number before it ends.
    fn quantity(&self, place: usize, from: usize) -> Option<(Quantity, bool)> {
        if let Some(quantity) = self.in_quotient(place) {
            return Some((quantity, true));
        }
        let number = &self.numbers[place];
        let near = &self.lower[from..number.span.start];
        let clause = self.clause(number.span.start);
        let (begin, is_bracket) = self.begins(number);
        // What the clause itself says before it.
        let own = &self.lower[begin.clamp(from, number.span.start)..number.span.start];
        let before = &self.lower[..number.span.start];
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        // "Not 3 m", "9 m/s slower", "the distance to the kerb".
        let said = near.rsplit([',', '(', ')', ':', ';']).next().unwrap_or(near);
        let compared = ["lower", "higher", "more ", "less "];
        let is_bound = BOUNDS.iter().any(|(words, _)| said.contains(words));
        let last = place.checked_sub(1).map(|i| self.numbers[i].unit);
        if self.counted(near, after, last == Some(number.unit))
            || denies(&said.replace("barely", "").replace("hardly", "")) && !is_bound
            || compared.iter().any(|word| after.starts_with(word))
            || self.is_to_another(near)
        {
            return None;
        }
        // "Longitudinal & lateral distance: 0.45 m & -2.04 m": which is which is not said beside the number.
        let both = near.contains("longitudinal") && near.contains("lateral");
        if both && (after.starts_with(['&', ',', '/']) || after.starts_with("and ")) {
            return None;
        }
        let near_or_above = format!("{} {near}", self.above);
        let label = clause.and_then(|clause| {
            let (first, last) = (clause.label.start, clause.label.end.checked_sub(1)?);
            let (first, last) = (self.tokens.get(first)?, self.tokens.get(last)?);
            only_axis(&self.lower[first.span.start..last.span.end])
        });
        let is_short = near.len() < 40 || near.contains(':');
        let named = find_axis(own, after).or(label).or_else(|| {
            let is_near = is_bracket || is_short && !near.contains("laterally") && !near.contains("longitudinally");
            if is_near { axis(near) } else { None }
        });
        let axis = named.or_else(|| {
            // A time may stand behind its calculation: "longitudinal: 12.8 m / 2.5 m/s = 5 s".
            let equals = near.contains(['=', '≈']) || near.contains("approx");
            let calculated = number.unit == Unit::Second && equals;
            let before = if calculated { only_axis(before) } else { None };
            before.or_else(|| axis(self.above))
        });
        let time = |text: &str| {
            text.contains("ttc")
                || text.contains("time-to-collision")
                || text.contains("time to collision")
        };
        // "Relative velocity: longitudinal 3 m/s, lateral 0 m/s": the word stands before the first number.
        let relative = |text: &str| {
            ["relative", "closing", "rel", "vrel", "v_rel"]
                .iter()
                .any(|word| has_word(text, word))
                || text.contains("vrel_")
                || text.contains("v_rel_")
        };
        // "2.2 m/s toward ego, lateral 0.6 m/s" is not the ego's.
        let clause_of = |text: &str| {
            let clause = text.rsplit([',', ';']).next().unwrap_or(text);
            without_reference(clause)
        };
        let is_of_ego = has_word(&clause_of(near), "ego");
        // "Position: rear-right with a longitudinal distance of 3 m": the label is not what is measured.
        let clause = near.trim_end_matches(['*', ' ', '`', ':', '=', '(']);
        let clause = clause.rsplit(':').next().unwrap_or(clause);
        use Quantity::*;
        match number.unit {
            Unit::Second if has_word(&near_or_above, "headway") || has_word(near, "time gap") || has_word(near, "thw") => {
                Some((Headway, true))
            }
            Unit::Second
                if after.starts_with("behind")
                    || after.starts_with("gap")
                    || after.starts_with("of headway")
                    || after.starts_with("headway") =>
            {
                Some((Headway, true))
            }
            Unit::Second
                if (self.is_until_contact(near) || is_before_contact(after))
                    && !self.lower.contains("probability") =>
            {
                Some((Ttc, false))
            }
            Unit::Degree if has_word(&near_or_above, "heading") || has_word(near, "orientation") => {
                Some((Heading, false))
            }
            Unit::Second if axis.is_some() && has_word(own, "time") => Some((
                if axis == Some(true) { TtcLong } else { TtcLat },
                false,
            )),
            Unit::Second if time(&near_or_above) || (time(before) && axis.is_some()) => Some((
                match axis {
                    None => Ttc,
                    Some(true) => TtcLong,
                    Some(false) => TtcLat,
                },
                false,
            )),
            Unit::Metre => {
                let first_word = after
                    .split(|c: char| !c.is_alphanumeric())
                    .next()
                    .unwrap_or_default();
                // "MDC: 7.93 m", in the words of the prompt.
                let is_least = ["mdc", "mdc_long", "mdc_lat"]
                    .iter()
                    .any(|word| has_word(clause_of(near).as_str(), word) || has_word(clause, word))
                    || has_word(self.above, "mdc")
                        && near.trim_matches(['*', ' ', '-', '~', '≈']).is_empty();
                if is_least && axis.is_none() {
                    return Some((LeastDistance, true));
                }
                let smallest = ["minimum", "smallest", "least", "min", "closest", "nearest"];
                let lengths = ["distance", "gap", "separation", "clearance", "approach", "point"];
                let is_bound = has_word(near, "at least");
                let says = |words: &[&str]| words.iter().any(|word| has_word(near, word));
                if says(&smallest) && says(&lengths) && !is_bound && axis.is_none()
                    || has_word(near, "as near as") || has_word(near, "as close as")
                {
                    return Some((MinDistance, true));
                }
                if has_word(own, "by") && ["trails", "leads", "behind", "ahead", "separated", "apart"].iter().any(|word| has_word(own, word)) {
                    return Some((Distance, true));
                }
                if ["avoided", "missed", "cleared", "misses", "clears"].iter().any(|word| has_word(own, word)) {
                    return Some((MinDistance, true));
                }
                if ["to the side", "to one side", "sideways"].iter().any(|words| after.starts_with(words)) {
                    return Some((DistanceAcross, true));
                }
                // "4 m ahead", "5 m to our right".
                let last: Vec<&str> = own.split_whitespace().rev().take(2).collect();
                let is_other = last.iter().any(|word| OTHER_LENGTHS.contains(word) && *word != "lane");
                if let Some(along) = self.place_behind(number)
                    && axis.is_none()
                    && !is_other
                {
                    return Some((
                        match along {
                            Some(true) => DistanceAlong,
                            Some(false) => DistanceAcross,
                            None => Distance,
                        },
                        true,
                    ));
                }
                if OTHER_LENGTHS.iter().any(|word| has_word(own, word))
                    || ["mdc", "dce", "min"].iter().any(|word| has_word(near, word))
                    || has_word(clause, "position")
                    || has_word(self.above, "mdc")
                    || ["long", "wide", "high", "lane"].contains(&first_word)
                    || time(near)
                {
                    return None;
                }
                let distance = [
                    "distance",
                    "distances",
                    "gap",
                    "headway",
                    "spacing",
                    "room",
                    "space",
                    "separation",
                    "clearance",
                    "dtc",
                    "dtclong",
                    "dtclat",
                ]
                .iter()
                .any(|word| has_word(&near_or_above, word))
                    || after.starts_with("distance")
                    || phrases::away_from_the_ego(after)
                    || ["from us", "from me", "from the bumper", "from my bumper", "from our bumper", "from our"]
                        .iter()
                        .any(|words| after.trim_start_matches("away ").starts_with(words))
                    || self.is_range(near, after);
                match axis.or_else(|| from_ego(after).filter(|_| !distance)) {
                    Some(true) => Some((GapLong, false)),
                    Some(false) => Some((GapLat, false)),
                    // With a sign it is one of the two gaps, but which one is not stated. "This gap closes to 3 m"
                    // continues with one of them, too.
                    None if distance && number.value >= 0.0 && !["this gap", "this distance"].iter().any(|words| near.contains(words)) => {
                        Some((Distance, false))
                    }
                    None => None,
                }
            }
            Unit::Speed => {
                let said = without_reference(&format!("{} {before}", self.above));
                match axis {
                    // Along an axis it is told as a relative one, whether the word is repeated or not.
                    Some(long) if !is_of_ego => {
                        let closing = has_word(near, "closing");
                        Some((if long { VelocityLong } else { VelocityLat }, closing))
                    }
                    None if relative(&said) && !is_of_ego && after.starts_with("in both ") => {
                        Some((VelocityLong, false))
                    }
                    None if ["closing", "closes", "approaching", "approaches", "relative", "combined", "nearing", "shrinking"]
                        .iter()
                        .any(|word| has_word(near, word))
                        || ["relative", "closing"].iter().any(|word| after.starts_with(word))
                        || self.is_of_distance(number) =>
                    {
                        Some((ClosingSpeed, true))
                    }
                    // "1.6 m/s faster than us", "faster by 0.5 m/s".
                    None if after.starts_with("faster") || after.starts_with("slower")
                        || ["faster", "slower"].iter().any(|word| has_word(near, word)) => {
                        Some((VelocityLong, true))
                    }
                    None if self.is_own(number) => Some((Speed, false)),
                    None if !relative(&said) && !is_of_ego && !has_word(&said, "ego") => {
                        let approach = ["approach", "approaching", "toward", "towards"];
                        let tail = near.rsplit(" with ").next().unwrap_or(near);
                        if approach.iter().any(|word| has_word(tail, word)) {
                            return None;
                        }
                        let bare = near.trim_end_matches(['*', ' ', '`', '(', '~']);
                        let moving = [
                            "moving at",
                            "moving slowly at",
                            "moving fast",
                            "driving at",
                            "moves at",
                            "drives at",
                            "travels at",
                            "traveling at",
                            "travelling at",
                        ]
                        .iter()
                        .any(|words| ends_with_word(bare, words));
                        let named = moving
                            || ["speed", "velocity"]
                                .iter()
                                .any(|word| has_word(&near_or_above, word));
                        named.then_some((Speed, false))
                    }
                    _ => None,
                }
            }
            Unit::Acceleration => {
                let said = own.to_owned();
                match axis {
                    Some(long) if relative(&format!("{} {before}", self.above)) && !is_of_ego => Some((
                        if long {
                            AccelerationLong
                        } else {
                            AccelerationLat
                        },
                        false,
                    )),
                    None if !relative(&said) => {
                        let slower = near.contains("decelerat")
                            || near.contains("brak")
                            || near.contains("slow");
                        let named = slower || near_or_above.contains("accelerat");
                        named.then_some((Acceleration, slower))
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Whether the number is part of a calculation or of a range.
    fn counted(&self, near: &str, after: &str, is_alike: bool) -> bool {
        const BEFORE: [char; 3] = ['/', '÷', '×'];
        let near = near.trim_end_matches(['*', ' ', '`', '(', '|', '$', '\\']);
        let behind = near.chars().next_back();
        let operand =
            behind.is_some_and(|c| BEFORE.contains(&c) || c == '+' || is_alike && (c == '-' || c == '–'));
        let first = after.chars().next();
        let goes_on = first
            .is_some_and(|c| ['/', '÷', '×', '–', '-', '+', '→'].contains(&c));
        operand
            || goes_on
            || after
                .strip_prefix("to ")
                .is_some_and(|end| end.trim_start_matches(['-', '−', '~']).starts_with(|c: char| c.is_ascii_digit()))
            || after.starts_with("or ")
            || near.ends_with("\\times")
            || near.ends_with("\\frac{")
            || after.starts_with("->")
    }

    /// What a number is in a division of a length by a speed: "8.45 m / 6.87 m/s = 1.23 s".
    fn in_quotient(&self, place: usize) -> Option<Quantity> {
        let parts = (place.saturating_sub(2)..=place).find_map(|from| {
            let parts = self.numbers.get(from..from + 3)?;
            let between = |i: usize| {
                let text = self.lower.get(parts[i].span.end..parts[i + 1].span.start);
                text.unwrap_or("?").trim_matches([' ', '*', '`', ')', '(', '~', '$', '\\', '{', '}', '|'])
            };
            let divides = ["/", "÷"].contains(&between(0));
            let gives = between(1).starts_with(['=', '≈']) || between(1).starts_with("approx");
            (divides && gives && parts[2].unit == Unit::Second).then_some((from, parts))
        });
        let (from, parts) = parts?;
        let before = &self.lower[..parts[0].span.start];
        let after = self.lower[parts[2].span.end..].trim_start_matches(['*', ' ', '`']);
        let own = before.rsplit([',', ';']).next().unwrap_or(before);
        let axis = find_axis("", after)
            .or_else(|| only_axis(own))
            .or_else(|| only_axis(before))
            .or_else(|| axis(self.above));
        let is_headway = ["headway", "time gap", "thw"].iter().any(|word| has_word(before, word));
        let has_unit = parts[place - from].unit != Unit::None;
        match (place - from, axis) {
            (0 | 1, _) if !has_unit && parts[place - from].decimals == 0 => None,
            (1, _) if is_headway => None,
            (0, Some(true)) => Some(Quantity::GapLong),
            (0, Some(false)) => Some(Quantity::GapLat),
            (0, None) => Some(Quantity::DistanceAlong),
            (1, Some(true)) => Some(Quantity::VelocityLong),
            (1, Some(false)) => Some(Quantity::VelocityLat),
            (1, None) => Some(Quantity::ClosingSpeed),
            (_, _) if is_headway => Some(Quantity::Headway),
            (_, Some(true)) => Some(Quantity::TtcLong),
            (_, Some(false)) => Some(Quantity::TtcLat),
            (_, None) => Some(Quantity::Ttc),
        }
    }

    /// The place that stands right behind a length: along the ego's heading, across it, or both.
    fn place_behind(&self, number: &Number) -> Option<Option<bool>> {
        let at = self.tokens.iter().position(|t| t.span.start >= number.span.end)?;
        let skipped = (at..at + 3)
            .take_while(|i| {
                *i == at || self.tokens.get(i - 1).is_some_and(|t| {
                    t.word.ends_with("ly") || t.is(&["straight", "right", "further", "or", "so", "("])
                })
            })
            .find_map(|i| Some((PLACES.at(self.tokens, i)?, i)));
        let ((Placed::At(side) | Placed::Field(side), end), _) = skipped? else {
            return None;
        };
        // "3 m in front of car 7", "3 m left lane".
        let follows = self.tokens.get(end);
        let is_other = self.references.iter().any(|r| {
            r.at.start <= end + 1 && r.at.end > end && !matches!(r.who, Named::Ego)
                && self.tokens[end..r.at.start.max(end)].iter().all(|t| t.is(&["of", "the", "a"]))
        });
        let is_mirrored = self.clause(number.span.start).is_some_and(|clause| clause.who == Who::Ego);
        if follows.is_some_and(|t| t.is(&["lane", "side"])) || is_other && !is_mirrored {
            return None;
        }
        Some(match (side.front, side.left) {
            (Some(_), None) => Some(true),
            (None, Some(_)) => Some(false),
            _ => None,
        })
    }

    /// Whether a length is plainly that to the other: "at 54 m", "within 5 m", "12 m clear", or all that a field says.
    fn is_range(&self, near: &str, after: &str) -> bool {
        let bare = near.trim_end_matches(['*', ' ', '`', '~', '≈', '"']);
        const ROUGHLY: [&str; 20] = [
            "less than", "more than", "under", "over", "at least", "still", "another", "now", "about", "around", "roughly", "only", "just", "some", "approximately", "like", "something", "maybe", "almost", "barely",
        ];
        let mut bare = bare;
        while let Some(rest) = ROUGHLY.iter().find_map(|word| {
            let rest = bare.strip_suffix(word)?;
            (!rest.ends_with(char::is_alphanumeric)).then_some(rest)
        }) {
            bare = rest.trim_end();
        }
        let begins = bare.trim_start_matches(['-', ' ', '*']).is_empty() || bare.ends_with([',', ':', '(', '—', '–', '|', ';']);
        let words = ["at", "with", "by", "to within", "within", "closer than", "nearer than", "is", "under", "only", "sits", "remains", "stays", "now"];
        let ends = |text: &str, words: &[&str]| words.iter().any(|word| ends_with_word(text, word));
        let first = after.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
        let follows = ["away", "off", "apart", "back", "clear", "out", "from", "ahead", "behind", "in", "to", "on", "at", "over", "margin", "gap", "distance", "clearance", "of", "between", "lateral", "laterally"].contains(&first);
        const GOES_ON: [&str; 11] = ["is", "was", "and", "with", "yet", "but", "which", "while", "so", "already", "now"];
        let is_last = after.is_empty() || GOES_ON.contains(&first) || after.starts_with(['.', ',', ';', ')', '|', '"', '!', '(', '—', '–']);
        let is_to_one = first == "to" && after.split_whitespace().nth(1).is_some_and(|word| {
            ["the", "it", "obstacle", "car", "vehicle", "truck"].contains(&word) || word.starts_with(|c: char| c.is_ascii_digit())
        });
        let is_noun = ["gap", "distance", "clearance", "separation", "headway", "margin"].contains(&first);
        // "3 m away from the kerb".
        let from = after.find("from ").filter(|at| *at < 8).map(|at| &after[at + "from ".len()..]);
        let is_of_another = from.is_some_and(|rest| {
            let rest = rest.strip_prefix("the ").unwrap_or(rest);
            !["ego", "us", "me", "our", "my", "you", "it", "bumper", "car", "vehicle"].iter().any(|word| rest.starts_with(word))
        });
        if is_of_another {
            return false;
        }
        is_to_one || is_noun || follows && !["in", "on", "to"].contains(&first) && ends(bare, &["is", "at", "sits", "be", "drives", "stands", "just", ","])
            || begins && (is_last || follows)
            || ends(bare, &words) && (is_last || follows || first == "and" || first == "with")
    }

    /// Whether seconds are those until the bodies touch: "will collide in 2 s", "impact within 1.5 s".
    fn is_until_contact(&self, near: &str) -> bool {
        let words = ["collision", "contact", "impact", "hit", "hits", "collide", "collides", "reach", "reaches", "reached"];
        let bare = near.trim_end_matches(['*', ' ', '~', '≈']);
        let bare = ["about", "around", "roughly", "only", "just", "less than", "under", "approximately"]
            .iter()
            .find_map(|word| bare.strip_suffix(word))
            .unwrap_or(bare)
            .trim_end();
        (ends_with_word(bare, "in") || ends_with_word(bare, "within")) && words.iter().any(|word| has_word(bare, word))
    }

    /// Whether the verb before a speed says how a distance changes: "draws away at 5 m/s".
    fn is_of_distance(&self, number: &Number) -> bool {
        let Some(clause) = self.clause(number.span.start) else {
            return false;
        };
        let place = |at: usize| self.tokens.iter().position(|t| t.span.start >= at).unwrap_or(clause.at.end);
        let (from, to) = (place(self.begins(number).0), place(number.span.start));
        let verbs = VERBS.all(self.tokens, from..to.max(from));
        const OWN: [&str; 5] = ["walk", "rid", "run", "driv", "travel"];
        let is_own = |at: &std::ops::Range<usize>| OWN.contains(&self.tokens[at.start].stem.as_str());
        verbs.iter().any(|(act, at)| matches!(act, Act::Nears(_) | Act::Approaches) && !is_own(at))
            && !verbs.iter().any(|(act, _)| *act == Act::Moves)
    }

    /// Whether a speed is that of whom its clause is about: "doing 50 km/h", "our speed is 8 m/s".
    fn is_own(&self, number: &Number) -> bool {
        const SAYS: [&str; 16] = [
            "speed", "velocity", "pace", "moving", "moves", "driving", "drives", "doing", "going", "riding", "walking", "rolling",
            "running", "travelling", "traveling", "cruising",
        ];
        let Some(clause) = self.clause(number.span.start) else {
            return false;
        };
        let begin = self.begins(number).0;
        let words = self.tokens.iter().filter(|t| t.span.start >= begin);
        let before = words.take_while(|t| t.span.start < number.span.start);
        let mut before = before.collect::<Vec<_>>();
        before.truncate(12);
        let is_relative = before
            .iter()
            .any(|t| t.is(&["relative", "closing", "limit", "than", "difference", "lateral", "longitudinal"]));
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        let is_compared = ["faster", "slower", "more", "less", "relative", "closing", "difference"]
            .iter()
            .any(|word| after.starts_with(word));
        // "At 24 m/s the lorry …": of whom is not told.
        let first = self.references.iter().find(|r| clause.at.contains(&r.at.start));
        let is_before = first.is_some_and(|r| self.tokens[r.at.start].span.start > number.span.start);
        if is_before && matches!(clause.who, Who::Obstacles(_)) {
            return false;
        }
        let towards = before.iter().any(|t| t.is(&["toward", "towards"]));
        let walks = before.iter().any(|t| ["walk", "rid", "run"].contains(&t.stem.as_str()));
        let is_vague = matches!(clause.who, Who::Obstacles(_)) && towards && !walks;
        let at = ["at", "with", "about", "of", "roughly", "around", "does", "do", "steady", "constant", "over", "only", "still", "is", "v", "=", "to"];
        let is_near = before.last().is_none_or(|t| t.is(&at) || t.word.ends_with("ly") || t.number.is_some() || !t.is_word());
        !is_relative && !is_compared && !is_vague && (is_near || before.iter().any(|t| t.is(&SAYS)))
    }

    fn rough(&self, from: usize, to: usize) -> bool {
        let near = &self.lower[from..to];
        [
            "approximately",
            "about",
            "around",
            "roughly",
            "nearly",
            "barely",
            "hardly",
            "some",
            "maybe",
            "approx",
            "almost",
        ]
        .iter()
        .any(|word| has_word(near, word))
            || near.contains(['~', '≈'])
    }

    /// A place said in words takes the sign: "3 m behind", "1.9 m to the left".
    fn magnitude(&self, _from: usize, number: &Number) -> bool {
        // A number with its sign written is meant with it.
        let shown = &self.lower[number.span.clone()];
        !shown.starts_with(['-', '−', '–', '+'])
    }
}
