//! What the numbers of a sentence state: values, bounds, ranges and changes.

use super::clauses::{Mood, Who};
use super::find::ends_with_word;
use super::number::{Number, Unit, axis, find_axis, scale};
use super::references::{Named, Reference};
use super::sentence::Sentence;
use super::tokens::{denies, find_word, has_word};
use super::{Claim, ClaimedValue, Quantity};

/// Words in a clause that make its numbers no values of the scene.
pub(super) const SUPPOSED: &str = "predicted probability forecast expected example average difference required requires recommended mean";

/// Words before a number that make it a bound, and whether the value is above it; "" where it is no value at all.
pub(super) const BOUNDS: [(&str, Option<bool>); 35] = [
    ("less than", Some(false)),
    ("lower than", Some(false)),
    ("smaller than", Some(false)),
    ("shorter than", Some(false)),
    ("closer than", Some(false)),
    ("nearer than", Some(false)),
    ("no more than", Some(false)),
    ("not more than", Some(false)),
    ("at most", Some(false)),
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
    ("exceeded", Some(true)),
    ("exceed", Some(true)),
    ("exceeding", Some(true)),
    ("beyond", Some(true)),
    (">", Some(true)),
    ("≥", Some(true)),
    ("than", None),
    ("by", None),
];

/// Verbs that lead to a value.
const VALUES: [&str; 6] = ["is", "was", "are", "were", "reached", "amounts"];

/// What a number is to the value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Bound {
    /// The value itself.
    None,
    /// The value is above it.
    Above,
    /// The value is below it.
    Below,
    /// The value is between another one and it.
    Between(f64),
}

/// A number in the sentence, and what it says of whom.
pub(super) struct Stated {
    pub(super) quantity: Quantity,
    pub(super) value: ClaimedValue,
    pub(super) of: i64,
    pub(super) is_past: bool,
}

/// Whether "from" stands right before a number: where a change begins.
pub(super) fn near_ends_with_from(before: &str) -> bool {
    let bare = before.trim_end_matches(['*', ' ', '~', '≈']);
    let bare = bare.strip_suffix("about").unwrap_or(bare).trim_end();
    ends_with_word(bare, "from")
}

/// Whether words lead from one value to a later one of the same quantity: "and had grown to".
fn goes_on(near: &str) -> bool {
    const CHANGES: [&str; 12] = [
        "grew",
        "grown",
        "dropped",
        "drops",
        "fell",
        "fallen",
        "shrank",
        "shrunk",
        "rose",
        "risen",
        "decreased",
        "increased",
    ];
    // "Reached its lowest value, 0.3 s".
    has_word(near, "value")
        || ends_with_word(near.trim_end(), "to") && CHANGES.iter().any(|verb| has_word(near, verb))
}

/// Whether words stand behind a length, at once or behind where it leads: "2 m away at most".
fn follows(after: &str, words: &str) -> bool {
    let rest = ["away ", "ahead ", "behind ", "off "]
        .iter()
        .find_map(|place| after.strip_prefix(place));
    rest.unwrap_or(after).starts_with(words)
}

/// Whether words around a difference of speeds say that it is faster (true) or slower.
fn faster(near: &str, after: &str) -> Option<bool> {
    let says = |word: &str| after.starts_with(word) || has_word(near, word);
    match (
        says("faster"),
        says("slower") || after.starts_with("below its own"),
    ) {
        (true, false) => Some(true),
        (false, true) => Some(false),
        _ => None,
    }
}

/// Whether the last verb of words says that it gets faster (true) or slower.
pub(super) fn change_of_speed(near: &str) -> Option<bool> {
    let last = |words: &[&str]| words.iter().filter_map(|word| near.rfind(word)).max();
    let faster = last(&["accelerates", "accelerating", "accelerated"]);
    let slower = last(&[
        "decelerat",
        "brakes",
        "braking",
        "braked",
        "slows",
        "slowing",
        "deceleration",
    ]);
    match (faster, slower) {
        (None, None) => None,
        (a, b) => Some(a > b),
    }
}

impl Sentence<'_> {
    /// What the number at a place says; `from` is where the one before it ends, and `last` what that one said.
    pub(super) fn number(
        &self,
        place: usize,
        from: usize,
        last: Option<(Quantity, Unit)>,
    ) -> Vec<Stated> {
        let number = &self.numbers[place];
        let Some(clause) = self.clause(number.span.start) else {
            return Vec::new();
        };
        let words = &self.tokens[clause.at.clone()];
        // "Initially far (15 m)": as what its bracket stands behind.
        let (begin, is_bracket) = self.begins(number);
        let mood = match self.clause(begin).filter(|_| is_bracket) {
            Some(before) if before.mood == Mood::Past => Mood::Past,
            _ => clause.mood,
        };
        let is_past = match mood {
            Mood::Said => false,
            Mood::Past => true,
            // "Will collide in 2 s".
            Mood::Future if number.unit == Unit::Second => false,
            // "So I can keep my speed of 25 m/s".
            Mood::Supposed if self.is_presupposed(place) => false,
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
        let is_result = next.starts_with("approx") || next.starts_with("about");
        if next.len() < after.len() && next.starts_with(char::is_alphabetic) && !is_result {
            return Vec::new();
        }
        // "From 3 m on".
        if near_ends_with_from(&self.lower[..number.span.start]) {
            return Vec::new();
        }
        if words.iter().any(|t| t.is(SUPPOSED)) {
            return Vec::new();
        }
        let begin = self.tokens[clause.at.start]
            .span
            .start
            .clamp(from, number.span.start);
        let bound = self.bound(place, &self.lower[begin..number.span.start]);
        let Some(bound) = bound else {
            return Vec::new();
        };
        // "Between 2 m and 3 m": what is said of both stands before the first.
        let first = place
            .checked_sub(1)
            .filter(|_| matches!(bound, Bound::Between(_)));
        let own = self.quantity(place, from).or_else(|| {
            let first = first.filter(|first| self.numbers[*first].unit == number.unit)?;
            let before = (0..first).rfind(|i| !self.taken[*i]);
            self.quantity(first, before.map_or(0, |i| self.numbers[i].span.end))
        });
        let owner = self.own_speed(number);
        let (quantity, magnitude) = match own {
            _ if owner.is_some() => (Quantity::Speed, false),
            Some(found) => found,
            // "A TTC of 1.2 s is below 1 s": the same quantity again.
            None => match last {
                Some((quantity, unit))
                    if unit == number.unit && (bound != Bound::None || goes_on(near)) =>
                {
                    (quantity, true)
                }
                _ => return Vec::new(),
            },
        };
        if clause.mood == Mood::Future && quantity != Quantity::Ttc {
            return Vec::new();
        }
        let of = match (&clause.who, quantity) {
            (Who::Ego, Quantity::Speed | Quantity::Acceleration | Quantity::Heading) => {
                Some(self.ego)
            }
            // "I have two seconds before impact".
            (Who::Ego, Quantity::Ttc | Quantity::ClosingSpeed) => {
                Self::met(clause).or(clause.topic)
            }
            _ => Self::met(clause),
        };
        // "5 m/s faster than 301": a difference of the two.
        let than = { self.references.iter() }
            .find(|r| r.is_compared && clause.at.contains(&r.at.start))
            .map(|r| r.who);
        let of = match (than, &clause.who) {
            (Some(Named::Obstacle(id)), Who::Ego) if quantity == Quantity::VelocityLong => Some(id),
            (Some(Named::Obstacle(_)), _) if quantity == Quantity::VelocityLong => None,
            _ => of,
        };
        let Some(of) = owner.or(self.named_behind(number)).or(of) else {
            return Vec::new();
        };
        // "Accelerates with 2 m/s²" is no braking, and "brakes with 2 m/s²" is.
        let verb = match quantity {
            Quantity::Acceleration => change_of_speed(near),
            Quantity::VelocityLong => {
                let is_mirrored = clause.who == Who::Ego;
                faster(near, after).map(|faster| faster != is_mirrored)
            }
            _ => None,
        };
        // "A lateral gap of 2 m to the right" has the sign of its side.
        let side = self
            .side_behind(number)
            .filter(|_| self.magnitude(from, number));
        let side = side.and_then(|side| match quantity {
            Quantity::GapLat => side.left,
            Quantity::GapLong => side.front,
            _ => None,
        });
        let sign = side.map(|is_positive| is_positive != (clause.who == Who::Ego));
        let sign = verb.or(sign);
        let value = match bound {
            Bound::None => ClaimedValue::Number {
                value: match sign {
                    Some(is_positive) => number.value.abs() * if is_positive { 1.0 } else { -1.0 },
                    None => number.value,
                },
                decimals: number.decimals,
                rough: self.rough(from, number.span.start),
                magnitude: sign.is_none() && (magnitude || self.magnitude(from, number)),
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
        // Of both that are named before it, where no second number follows.
        let next = self.numbers.get(place + 1);
        let is_only = next.is_none_or(|next| {
            let between = self.lower.get(number.span.end..next.span.start);
            next.unit != number.unit || between.is_some_and(|text| axis(text).is_some())
        });
        const JOINT: [&str; 5] = [
            "longitudinal and lateral",
            "lateral and longitudinal",
            "longitudinally and laterally",
            "laterally and longitudinally",
            "ttclong and ttclat",
        ];
        let names = |text: &str| text.contains("long") && text.contains("lat");
        let is_joint = JOINT.iter().any(|words| own.contains(words));
        let is_both = after.starts_with("in both ")
            || (is_joint || names(own) && has_word(own, "both")) && is_only
            || JOINT.iter().any(|words| after.starts_with(words));
        let across = match quantity {
            Quantity::VelocityLong | Quantity::VelocityLat => {
                Some([Quantity::VelocityLong, Quantity::VelocityLat])
            }
            Quantity::TtcLong | Quantity::TtcLat => Some([Quantity::TtcLong, Quantity::TtcLat]),
            Quantity::GapLong | Quantity::GapLat => Some([Quantity::GapLong, Quantity::GapLat]),
            _ => None,
        };
        if is_both && let Some(both) = across {
            return both.map(one).into();
        }
        vec![one(quantity)]
    }

    /// Whether a number stands behind a quantity that someone has whatever is supposed of it: "my speed of 25 m/s".
    fn is_presupposed(&self, place: usize) -> bool {
        let before = self.lower[..self.numbers[place].span.start].trim_end();
        let before = ["about", "roughly", "some", "around"]
            .iter()
            .find_map(|word| before.strip_suffix(word))
            .unwrap_or(before);
        let words: Vec<&str> = before.split_whitespace().rev().take(4).collect();
        let is_own = matches!(words.as_slice(), ["of", "speed" | "velocity" | "pace", rest @ ..]
            if rest.iter().any(|word| ["my", "our", "its", "current", "present"].contains(word)));
        is_own
            && !["if", "unless"]
                .iter()
                .any(|word| has_word(self.lower, word))
    }

    /// What the words before a number make of it; nothing where it is no value.
    pub(super) fn bound(&self, place: usize, near: &str) -> Option<Bound> {
        let number = &self.numbers[place];
        // "At the last step, the distance is 3 m": what stands before the comma bounds nothing.
        let own = near.rsplit([',', ')', ';']).next().unwrap_or(near);
        let own = own.replace("over time", "");
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        // "Between 3 and 5 m", "3 to 5 m", "3–5 m"; not "the gap to 301 to 5 m".
        let is_id = |number: &Number| {
            let named = |r: &Reference| self.tokens[r.at.end - 1].span.start == number.span.start;
            self.references.iter().any(named)
        };
        if let Some(first) = place.checked_sub(1).map(|i| &self.numbers[i])
            && matches!(first.unit, Unit::None)
            && !is_id(first)
            && number.unit != Unit::None
        {
            let joint = self
                .lower
                .get(first.span.end..number.span.start)
                .unwrap_or("?");
            let joint = joint.trim_matches(['*', ' ', '`']);
            let before = self.lower[..first.span.start].trim_end();
            if joint == "and" && before.ends_with("between")
                || joint == "to" && !before.ends_with("from")
                || ["-", "–"].contains(&joint)
            {
                return Some(Bound::Between(first.value.abs()));
            }
        }
        if let Some(first) = place.checked_sub(1).map(|i| &self.numbers[i])
            && first.unit == number.unit
            && near.trim() == "and"
            && self.lower[..first.span.start]
                .trim_end()
                .ends_with("between")
        {
            return Some(Bound::Between(first.value.abs()));
        }
        let ends = own.split_once("between").map(|(_, ends)| ends);
        if let Some(ends) = ends
            && !has_word(ends, "ego")
            && !has_word(ends, "us")
            && !ends.contains("flank")
            && !ends.contains("bodies")
        {
            return None;
        }
        const NOT_NUMBERS: [&str; 7] = ["until", "every", "per", "past", "last", "next", "changes"];
        let words: Vec<&str> = own.split_whitespace().rev().take(3).collect();
        // "Slipped past within 2 m".
        let is_time = number.unit == Unit::Second;
        let spans = |word: &str| NOT_NUMBERS.contains(&word) && (is_time || word != "past");
        if words.iter().any(|word| spans(word)) {
            return None;
        }
        // "Came no nearer than 3 m": that is how near it came.
        let is_nearest = ["no nearer than", "no closer than"]
            .iter()
            .any(|words| own.contains(words));
        if is_nearest
            && ["came", "come", "comes", "got", "gets"]
                .iter()
                .any(|word| has_word(&own, word))
        {
            return Some(Bound::None);
        }
        // "Slower than us by 3 m/s" is the difference.
        let ends_by = ends_with_word(own.trim_end(), "by");
        if ends_by && ["faster", "slower"].iter().any(|word| has_word(&own, word)) {
            return Some(Bound::None);
        }
        let is_symbol = |words: &str| !words.starts_with(char::is_alphabetic);
        // "Over the whole window it is 3 m" and "> 301 drives at 3 m/s" are no bounds.
        let is_near = |rest: &str| {
            let has_digit = rest.contains(|c: char| c.is_ascii_digit());
            !has_digit && !VALUES.iter().any(|verb| has_word(rest, verb))
        };
        let word = BOUNDS.iter().find(|(words, _)| {
            let at = if is_symbol(words) {
                own.rfind(words)
            } else {
                find_word(&own, words)
            };
            let rest = at.map(|at| &own[at + words.len()..]);
            // "By braking at 5 m/s²" is no difference, and "as indicated by a gap of 3 m" bounds nothing.
            rest.is_some_and(|rest| {
                is_near(rest) && (*words != "by" || rest.split_whitespace().count() <= 1)
            })
        });
        let is_above = match word {
            Some(("by", None))
                if [
                    "trails",
                    "trailed",
                    "led",
                    "leads",
                    "behind",
                    "ahead",
                    "separated",
                    "apart",
                    "avoided",
                    "missed",
                    "cleared",
                    "misses",
                    "clears",
                    "faster",
                    "slower",
                ]
                .iter()
                .any(|word| has_word(&own, word)) =>
            {
                return Some(Bound::None);
            }
            Some((_, None)) => return None,
            Some((_, Some(above))) => *above,
            None if ["or less", "or closer"]
                .iter()
                .any(|words| after.starts_with(words)) =>
            {
                false
            }
            None if after.starts_with("or more") => true,
            None if follows(after, "at most") => false,
            None if follows(after, "at least") => true,
            None => return Some(Bound::None),
        };
        // "Not below 3 m", "never more than 3 m".
        let is_above = if denies(&own)
            && !own.contains("no more than")
            && !own.contains("no less than")
            && !own.contains("not more than")
        {
            !is_above
        } else {
            is_above
        };
        // "Just under 8 m".
        let is_close = ["just", "slightly", "barely", "little"]
            .iter()
            .any(|word| has_word(&own, word));
        let value = number.value.abs();
        Some(match is_above {
            true if is_close => Bound::Between(1.15 * value),
            false if is_close => Bound::Between(0.85 * value),
            true => Bound::Above,
            false => Bound::Below,
        })
    }

    /// Two numbers with their axes in the same order: "longitudinal & lateral distance: 12.57 m & -3.36 m", "12.57 m long, -3.36 m
    /// lat".
    pub(super) fn both_axes(&self) -> Vec<Claim> {
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

    /// Numbers of several obstacles in their order: "7 and 8 are 25 m and 15 m away".
    pub(super) fn distributed(&self) -> Vec<Claim> {
        let mut found = Vec::new();
        for clause in self.clauses {
            let Who::Obstacles(ids) = &clause.who else {
                continue;
            };
            if ids.len() < 2 || clause.mood != Mood::Said || clause.object.is_some() {
                continue;
            }
            let own: Vec<usize> = { clause.at.clone() }
                .filter_map(|i| self.tokens[i].number)
                .filter(|place| !self.taken[*place])
                .collect();
            let Some(last) = own.last().copied().filter(|_| own.len() == ids.len()) else {
                continue;
            };
            let first = own[0];
            let is_row = own.windows(2).all(|two| {
                let (a, b) = (&self.numbers[two[0]], &self.numbers[two[1]]);
                let between = self.lower.get(a.span.end..b.span.start).unwrap_or("?");
                ["and", ",", ", and"].contains(&between.trim()) && a.unit == b.unit
            });
            let from = self.tokens[clause.at.start].span.start;
            let is_bound = self.bound(first, &self.lower[from..self.numbers[first].span.start]);
            let Some((quantity, _)) = self.quantity(last, from).filter(|_| is_row) else {
                continue;
            };
            if is_bound != Some(Bound::None)
                || denies(&self.lower[from..self.numbers[first].span.start])
            {
                continue;
            }
            for (id, place) in ids.iter().zip(own) {
                let number = &self.numbers[place];
                let stated = ClaimedValue::Number {
                    value: number.value,
                    decimals: number.decimals,
                    rough: self.rough(from, number.span.start),
                    magnitude: self.magnitude(0, number),
                };
                found.push(self.claim(number.span.clone(), (*id, false), quantity, stated));
            }
        }
        found
    }

    /// Whether a verb says something else than its numbers: "increased from 11 m to 9 m".
    pub(super) fn contradiction(&self) -> Option<usize> {
        let [from, to] = self.pairs().first().copied()?;
        // "Is decreasing (from 0 m to -0.5 m)": what the bracket stands behind.
        let clause = self.clause(from.span.start)?;
        let own = &self.lower[self.tokens[clause.at.start].span.start..from.span.start];
        let says = ["increas", "decreas", "grow", "shrink", "reduc"];
        let at = if says.iter().any(|word| own.contains(word)) {
            from.span.start
        } else {
            self.begins(from).0
        };
        let before = &self.lower[..from.span.start];
        let has = |words: &[&str]| words.iter().any(|word| before.contains(word));
        let grows = has(&["increas", "grow", "grew", "accelerat", "rose"]);
        let shrinks = has(&["decreas", "shr", "reduc", "slow", "brak", "fell", "drop"]);
        let (from, to) = (from.value.abs() * self.scale_of([from, to]), to.value.abs());
        let is_other = grows && !shrinks && to < from || shrinks && !grows && to > from;
        is_other.then_some(at)
    }

    /// The numbers of a change: "from 9 m to 7.8 m", "9 → 7.8 m".
    fn pairs(&self) -> Vec<[&Number; 2]> {
        let pairs = self.numbers.iter().enumerate().flat_map(|(i, first)| {
            let further = self.numbers[i + 1..].iter().take(2);
            further.map(move |second| [first, second])
        });
        let is_change = |pair: &[&Number; 2]| {
            let between = self.lower.get(pair[0].span.end..pair[1].span.start);
            let between = between.unwrap_or("?").trim_matches([' ', '~', '≈', '*']);
            // "From 3.75 m (4.8 s) to 0.2 m", "from 3.75 m at 4.8 s to 0.2 m".
            let between = match (between.starts_with('('), between.rfind(')')) {
                (true, Some(end)) => between[end + 1..].trim(),
                _ if between.starts_with("at ") => between.rsplit(' ').next().unwrap_or(between),
                _ => between,
            };
            let before = self.lower[..pair[0].span.start].trim_end_matches(['*', ' ', '~', '≈']);
            let is_to = ["to", "down to", "up to"].contains(&between);
            let is_from = ["from", "from about", "from approximately", "from around"]
                .iter()
                .any(|words| before.ends_with(words))
                && is_to;
            // "Shrinks (25 m to 20 m)".
            let said = before.strip_suffix('(').unwrap_or_default();
            let is_change = [
                "increas", "decreas", "chang", "grow", "shrink", "clos", "widen",
            ];
            let is_from = is_from || is_to && is_change.iter().any(|word| said.contains(word));
            let is_arrow = ["→", "->"].contains(&between);
            let same = pair[0].unit == pair[1].unit || pair[0].unit == Unit::None;
            (is_from || is_arrow) && same
        };
        pairs.filter(is_change).collect()
    }

    /// How many of the unit of the claim the first number is in: as of km/h, the unit behind the second.
    fn scale_of(&self, pair: [&Number; 2]) -> f64 {
        match pair[0].unit {
            Unit::None => scale(&self.lower[pair[1].span.clone()]),
            _ => 1.0,
        }
    }

    /// From one number to another: "the gap decreased from 9 m to 7.8 m".
    pub(super) fn changes(&self) -> Vec<Claim> {
        let pairs = self.pairs().into_iter();
        pairs.filter_map(|pair| self.change(pair)).collect()
    }

    fn change(&self, pair: [&Number; 2]) -> Option<Claim> {
        let clause = self.clause(pair[0].span.start)?;
        let own = self.tokens[clause.at.start].span.start..pair[1].span.end;
        if denies(self.lower.get(own).unwrap_or_default()) {
            return None;
        }
        let before = &self.lower[..pair[0].span.start];
        let after = self.lower[pair[1].span.end..].trim_start_matches(['*', ' ', '`']);
        let says = |words: &[&str]| {
            words
                .iter()
                .any(|word| has_word(before, word) || has_word(self.above, word))
        };
        let quantity = match pair[1].unit {
            Unit::Metre
                if says(&[
                    "distance",
                    "gap",
                    "separation",
                    "clearance",
                    "spacing",
                    "headway",
                ]) || axis(before).is_some() =>
            {
                match find_axis(before, after).or_else(|| axis(self.above)) {
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
        let of = if is_own {
            self.ego
        } else {
            self.stated_of(pair[0].span.start)?.0
        };
        if matches!(clause.mood, Mood::Supposed | Mood::Future) {
            return None;
        }
        let stated = ClaimedValue::Change {
            from: pair[0].value * self.scale_of(pair),
            to: pair[1].value,
            decimals: pair[0].decimals.min(pair[1].decimals),
            rough: self.rough(pair[0].span.start.saturating_sub(12), pair[1].span.start),
        };
        let mut claim = self.claim(
            pair[0].span.start..pair[1].span.end,
            (of, false),
            quantity,
            stated,
        );
        claim.step = None;
        // Of numbers with signs, what a verb means is not told, but from what to what they change is.
        let is_signed = pair.iter().any(|number| number.value < 0.0);
        Some(claim).filter(|_| is_signed || self.contradiction().is_none())
    }
}
