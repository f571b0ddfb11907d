//! The claims of one sentence about one obstacle.

use super::find::ends_with_word;
use super::mentions;
use super::number::{
    Number, Unit, axis, find_axis, from_ego, from_number, only_axis, without_reference,
};
use super::phrases;
use super::place::{denies, has_word, is_unsaid, side_in, touches_before};
use super::words;
use super::{Claim, ClaimedValue, Quantity};

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
    /// The obstacle it is about.
    pub obstacle: i64,
    /// Whether it names it itself.
    pub named: bool,
    /// The step that it names, or that was named for it.
    pub step: Option<i64>,
}

/// Words that make numbers conditions, examples, or values of other times.
const SUPPOSED: &[&str] = &[
    "if",
    "would",
    "could",
    "should",
    "threshold",
    "thresholds",
    "assume",
    "assuming",
    "assumed",
    "example",
    "average",
    "decreased",
    "increased",
    "decreases",
    "increases",
    "dropped",
    "reduced",
    "changes",
    "initially",
    "previous",
    "previously",
    "earlier",
    "after",
    "was",
    "were",
    "seen",
    "next",
    "limit",
    "must",
    "difference",
    "used to",
];

/// Words that make a number a bound.
const BOUNDS: &[&str] = &[
    "than",
    "below",
    "above",
    "under",
    "within",
    "over",
    "exceeds",
    "exceed",
    "exceeding",
    "until",
    "least",
    "at most",
    "up",
    "between",
    "every",
    "per",
    "by",
    "past",
    "last",
    "beyond",
    "minimum",
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

/// Where something is, behind a length: three places along the ego's heading, and those across it.
const PLACES: [&str; 7] = [
    "ahead",
    "behind",
    "in front",
    "to the side",
    "to the left",
    "to the right",
    "sideways",
];

impl Sentence<'_> {
    /// Its claims, in order.
    pub fn claims(&self) -> Vec<Claim> {
        if is_unsaid(self.lower) {
            return Vec::new();
        }
        let supposed =
            SUPPOSED.iter().any(|word| has_word(self.lower, word)) || from_number(self.lower);
        let mut found: Vec<Claim> = Vec::new();
        found.extend(self.change());
        if !supposed {
            found.extend(self.both_axes());
        }
        if !supposed {
            let mut from = 0;
            for (place, number) in self.numbers.iter().enumerate() {
                if !self.taken[place]
                    && let Some((quantity, magnitude)) = self.quantity(place, from)
                {
                    let stated = ClaimedValue::Number {
                        value: number.value,
                        decimals: number.decimals,
                        rough: self.rough(from, number.span.start),
                        magnitude: magnitude || self.magnitude(from, number),
                    };
                    found.push(self.claim(number.span.clone(), quantity, stated));
                    // "Relative velocity: 0 m/s in both dimensions".
                    let after = self.lower[number.span.end..].trim_start_matches(['*', ' ']);
                    if quantity == Quantity::VelocityLong && after.starts_with("in both ") {
                        let across = Quantity::VelocityLat;
                        found.push(self.claim(number.span.clone(), across, stated));
                    }
                }
                // "The gap to obstacle 7 is 3 m": words before an id or a time go on behind it.
                if !self.taken[place] {
                    from = number.span.end;
                }
            }
        }
        if let Some((span, side)) = side_in(self.lower) {
            found.push(self.claim(span, Quantity::Side, ClaimedValue::Side(side)));
        }
        for (span, quantity) in phrases::find_standstill(self.lower) {
            found.push(self.claim(span, quantity, phrases::NOTHING));
        }
        for (span, quantity, value) in phrases::times(self.lower) {
            found.push(self.claim(span, quantity, value));
        }
        if let Some(span) = phrases::touches_now(self.lower) {
            found.push(self.claim(span, Quantity::Contact, ClaimedValue::Contact));
        }
        for (span, quantity, value) in words::in_words(self.lower, self.above, self.numbers) {
            found.push(self.claim(span, quantity, value));
        }
        found.sort_by_key(|claim| claim.span.start);
        found
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
            self.claim(number.span.clone(), quantity, stated)
        };
        vec![claim(&pair[0], long_first), claim(&pair[1], !long_first)]
    }

    /// From one number to another: "the gap decreased from 9 m to 7.8 m".
    fn change(&self) -> Option<Claim> {
        const SUPPOSED: [&str; 5] = ["if", "would", "could", "should", "assume"];
        if denies(self.lower) || SUPPOSED.iter().any(|word| has_word(self.lower, word)) {
            return None;
        }
        let pair = self.numbers.windows(2).find(|pair| {
            let between = self.lower.get(pair[0].span.end..pair[1].span.start);
            let between = between.unwrap_or("?").trim();
            let before = self.lower[..pair[0].span.start].trim_end_matches(['*', ' ', '~']);
            let is_from =
                before.ends_with("from") && between == "to" || ["→", "->"].contains(&between);
            is_from
                && pair[1].unit == Unit::Metre
                && matches!(pair[0].unit, Unit::Metre | Unit::None)
        })?;
        let before = &self.lower[..pair[0].span.start];
        let is_length = ["distance", "gap", "separation", "clearance"]
            .iter()
            .any(|word| has_word(before, word) || has_word(self.above, word));
        let quantity = match axis(before).or_else(|| axis(self.above)) {
            Some(true) => Quantity::GapLong,
            Some(false) => Quantity::GapLat,
            None => Quantity::Distance,
        };
        let stated = ClaimedValue::Change {
            from: pair[0].value,
            to: pair[1].value,
            decimals: pair[0].decimals.min(pair[1].decimals),
        };
        // "Increased from 11 m to 9 m" says two things.
        let (from, to) = (pair[0].value.abs(), pair[1].value.abs());
        let grows =
            before.contains("increas") || before.contains("grow") || before.contains("grew");
        let shrinks =
            before.contains("decreas") || before.contains("shr") || before.contains("reduc");
        let is_one = !(grows && to < from || shrinks && to > from);
        (is_length && is_one)
            .then(|| self.claim(pair[0].span.start..pair[1].span.end, quantity, stated))
    }

    /// That the bodies touch at the time whose number stands at `place`.
    pub fn contact(&self, place: usize) -> Option<Claim> {
        let number = &self.numbers[place];
        let from = touches_before(&self.lower[..number.span.start])?;
        let span = from..number.span.end;
        Some(self.claim(span, Quantity::Contact, ClaimedValue::Contact))
    }

    fn claim(
        &self,
        span: std::ops::Range<usize>,
        quantity: Quantity,
        stated: ClaimedValue,
    ) -> Claim {
        Claim {
            span: self.start + span.start..self.start + span.end,
            obstacle: self.obstacle,
            named: self.named,
            quantity,
            stated,
            step: self.step,
        }
    }

    /// What the number says, and whether as a magnitude; `from` is where the number before it ends.
    fn quantity(&self, place: usize, from: usize) -> Option<(Quantity, bool)> {
        let number = &self.numbers[place];
        let near = &self.lower[from..number.span.start];
        let before = &self.lower[..number.span.start];
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        // "At the last step, the distance is 3 m": what stands before the comma bounds nothing.
        let own = near.rsplit([',', ')']).next().unwrap_or(near);
        let mut bounds = own.replace("over time", "");
        // "The distance between the ego and car 301 is 3 m" has ends and no bounds.
        if bounds
            .split_once("between")
            .is_some_and(|(_, ends)| has_word(ends, "ego"))
        {
            bounds = bounds.replacen("between", "", 1);
        }
        if self.counted(near, after) || BOUNDS.iter().any(|word| has_word(&bounds, word)) {
            return None;
        }
        // "Not 3 m", ">= 3 m", "9 m/s slower", "the distance to the kerb".
        let said = bounds.rsplit([':', ';']).next().unwrap_or(&bounds);
        let compared = ["lower", "higher", "slower", "faster", "more ", "less "];
        if denies(said)
            || bounds.contains(">=")
            || bounds.contains("<=")
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
        let axis = find_axis(near, after).or_else(|| {
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
        let own = has_word(&clause_of(near), "ego");
        // "Position: rear-right with a longitudinal distance of 3 m": the label is not what is measured.
        let clause = near.trim_end_matches(['*', ' ', '`', ':', '=', '(']);
        let clause = clause.rsplit(':').next().unwrap_or(clause);
        use Quantity::*;
        match number.unit {
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
                // "4 m ahead", "5 m to the side".
                let along = PLACES.iter().position(|word| {
                    after.strip_prefix(word).is_some_and(|rest| {
                        let rest = rest.trim_start();
                        rest.is_empty() || rest.starts_with([',', '.', ')', ';'])
                    })
                });
                if let Some(place) = along {
                    return Some((if place < 3 { GapLong } else { GapLat }, true));
                }
                if OTHER_LENGTHS.iter().any(|word| has_word(near, word))
                    || has_word(clause, "position")
                    || has_word(self.above, "mdc")
                    || ["long", "wide", "high", "lane", "off"].contains(&first_word)
                    || time(near)
                {
                    return None;
                }
                let distance = [
                    "distance",
                    "distances",
                    "gap",
                    "separation",
                    "clearance",
                    "dtc",
                    "dtclong",
                    "dtclat",
                ]
                .iter()
                .any(|word| has_word(&near_or_above, word))
                    || after.starts_with("distance")
                    || phrases::away_from_the_ego(after);
                match axis.or_else(|| from_ego(after).filter(|_| !distance)) {
                    Some(true) => Some((GapLong, false)),
                    Some(false) => Some((GapLat, false)),
                    // With a sign it is one of the two gaps, but which one is not stated. "This gap closes to 3 m"
                    // continues with one of them, too.
                    None if distance && number.value >= 0.0 && !has_word(near, "this") => {
                        Some((Distance, false))
                    }
                    None => None,
                }
            }
            Unit::Speed => {
                let said = without_reference(&format!("{} {before}", self.above));
                match axis {
                    // Along an axis it is told as a relative one, whether the word is repeated or not.
                    Some(long) if !own => {
                        let closing = has_word(near, "closing");
                        Some((if long { VelocityLong } else { VelocityLat }, closing))
                    }
                    None if relative(&said) && !own && after.starts_with("in both ") => {
                        Some((VelocityLong, false))
                    }
                    None if !relative(&said) && !own && !has_word(&said, "ego") => {
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
                let said = format!("{} {before}", self.above);
                match axis {
                    Some(long) if relative(&said) && !own => Some((
                        if long {
                            AccelerationLong
                        } else {
                            AccelerationLat
                        },
                        false,
                    )),
                    None if !relative(&said) && !own && !has_word(&said, "ego") => {
                        let slower =
                            has_word(near, "deceleration") || has_word(near, "decelerating");
                        let named = slower || has_word(&near_or_above, "acceleration");
                        named.then_some((Acceleration, slower))
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Whether the number is part of a calculation or of a range.
    fn counted(&self, near: &str, after: &str) -> bool {
        const BEFORE: [char; 7] = ['/', '÷', '×', '<', '>', '≤', '≥'];
        let near = near.trim_end_matches(['*', ' ', '`', '(', '|', '$', '\\']);
        let behind = near.chars().next_back();
        let operand =
            behind.is_some_and(|c| BEFORE.contains(&c) || c == '-' || c == '–' || c == '+');
        let first = after.chars().next();
        let goes_on = first
            .is_some_and(|c| ['/', '÷', '×', '–', '-', '+', '→', '<', '>', '≤', '≥'].contains(&c));
        operand
            || goes_on
            || after
                .strip_prefix("to ")
                .is_some_and(|end| !mentions::begins_with_noun(end))
            || after.starts_with("or ")
            || near.ends_with("\\times")
            || near.ends_with("\\frac{")
            || after.starts_with("->")
    }

    fn rough(&self, from: usize, to: usize) -> bool {
        let near = &self.lower[from..to];
        [
            "approximately",
            "about",
            "around",
            "roughly",
            "nearly",
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
