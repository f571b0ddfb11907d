//! The claims of one sentence about one obstacle.

use super::number::{Number, Unit};
use super::place::{has_word, side_in, touches_before};
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
    "from",
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
    "most",
    "up",
    "between",
    "every",
    "per",
    "by",
    "past",
    "last",
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

impl Sentence<'_> {
    /// Its claims, in order.
    pub fn claims(&self) -> Vec<Claim> {
        let supposed = SUPPOSED.iter().any(|word| has_word(self.lower, word));
        let mut found: Vec<Claim> = Vec::new();
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
        found.sort_by_key(|claim| claim.span.start);
        found
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
        if self.counted(near, after) || BOUNDS.iter().any(|word| has_word(near, word)) {
            return None;
        }
        // "Longitudinal & lateral distance: 0.45 m & -2.04 m": which is which is not said beside the number.
        let both = near.contains("longitudinal") && near.contains("lateral");
        if both && (after.starts_with(['&', ',', '/']) || after.starts_with("and ")) {
            return None;
        }
        let near_or_above = format!("{} {near}", self.above);
        let axis = axis_of(near, after).or_else(|| {
            // A time may stand behind its calculation: "longitudinal: 12.8 m / 2.5 m/s = 5 s".
            let calculated = number.unit == Unit::Second && near.contains(['=', '≈']);
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
        let toward = near.replace("towards", "toward").replace("the ego", "ego");
        let own = has_word(&toward.replace("toward ego", ""), "ego");
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
                .any(|word| has_word(&near_or_above, word));
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
                let said = format!("{} {before}", self.above);
                match axis {
                    Some(long) if relative(&said) && !own => {
                        let closing = has_word(near, "closing");
                        Some((if long { VelocityLong } else { VelocityLat }, closing))
                    }
                    None if !relative(&said) && !own && !has_word(&said, "ego") => {
                        let approach = ["approach", "approaching", "toward", "towards"];
                        if approach.iter().any(|word| has_word(near, word)) {
                            return None;
                        }
                        let named = ["speed", "velocity"]
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
            || after.starts_with("to ")
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

/// The axis of a number: named before it, or right behind it, as in "2.4 m longitudinal, 9.4 m lateral".
fn axis_of(near: &str, after: &str) -> Option<bool> {
    let after = after.trim_start_matches('(');
    let behind = ["longitudinal", "lateral"].map(|word| after.starts_with(word));
    let words = near.trim_end_matches(['*', ' ', '`', ':', '=', '(', '≈', '~', '-', '−']);
    let before = words.ends_with("longitudinal") || words.ends_with("lateral");
    match behind {
        [true, _] if !before => Some(true),
        [_, true] if !before => Some(false),
        _ => axis(near),
    }
}

/// The axis of "3 m in front of the ego" or "2 m to the left of the ego".
fn from_ego(after: &str) -> Option<bool> {
    let said = |words: &[&str]| {
        let rest = words.iter().find_map(|word| after.strip_prefix(word));
        rest.is_some_and(|rest| {
            let rest = rest.trim_start_matches([' ', '*']);
            rest.starts_with("the ego") || rest.starts_with("ego")
        })
    };
    if said(&["in front of", "ahead of", "behind"]) {
        Some(true)
    } else {
        said(&["to the left of", "to the right of", "left of", "right of"]).then_some(false)
    }
}

/// The axis that is named, if it is the only one.
fn only_axis(text: &str) -> Option<bool> {
    let other = |long| if long { "lateral" } else { "longitudinal" };
    axis(text).filter(|long| !text.contains(other(*long)))
}

/// The last axis that is named: along (true) or across the ego's heading.
fn axis(near: &str) -> Option<bool> {
    let last = |words: &[&str]| words.iter().filter_map(|word| near.rfind(word)).max();
    let long = last(&["longitudinal", "_long", "dtclong", "vrellong"]);
    let lat = last(&["lateral", "_lat", "dtclat", "vrellat"]);
    match (long, lat) {
        (None, None) => None,
        (a, b) => Some(a > b),
    }
}
