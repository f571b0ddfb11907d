//! Which quantity a number of a sentence is, from the words around it.

use super::Quantity;
use super::clauses::Who;
use super::find::ends_with_word;
use super::number::{
    Number, Unit, axis, divisions, find_axis, from_ego, only_axis, without_reference,
};
use super::phrases;
use super::references::{Named, Reference};
use super::sentence::Sentence;
use super::stated::BOUNDS;
use super::tokens::{denies, find_word, has_word};

/// Words for lengths other than a distance to the ego.
pub(super) const OTHER_LENGTHS: &[&str] = &[
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

/// Whether the last axis that is named is that of a quantity with a unit: "the lateral distance is small (3 m)".
fn names_axis_of(near: &str, unit: Unit) -> bool {
    let nouns: &[&str] = match unit {
        Unit::Metre => &["distance", "gap", "separation", "clearance", "offset"],
        Unit::Speed => &[
            "velocity", "speed", "relative", "closing", "movement", "motion",
        ],
        _ => &["acceleration", "deceleration", "relative", "ttc", "time"],
    };
    let at = near.rfind("longitudinal").max(near.rfind("lateral"));
    // "Longitudinally it is close (3 m)".
    if at.is_some_and(|at| {
        ["longitudinally", "laterally"]
            .iter()
            .any(|word| near[at..].starts_with(word))
    }) {
        return true;
    }
    let behind = at.map(|at| near[at..].split(|c: char| !c.is_alphabetic()).skip(1));
    behind.is_some_and(|mut words| words.by_ref().take(2).any(|word| nouns.contains(&word)))
}

/// Whether another number follows that is joined to one: "and 3 m", "/ 3 m".
pub(super) fn goes_on(after: &str) -> bool {
    let joint = ["&", ",", "/", "and "];
    let rest = joint.iter().find_map(|joint| after.strip_prefix(joint));
    rest.is_some_and(|rest| {
        let number = rest.trim_start_matches([' ', '*', '-', '−', '~', '≈', '(']);
        number.starts_with(|c: char| c.is_ascii_digit())
    })
}

/// Whether what follows seconds is the contact that they lead to: "before impact", "to the collision".
pub(super) fn is_before_contact(after: &str) -> bool {
    let rest = ["before ", "until ", "to ", "till ", "away from "]
        .iter()
        .find_map(|word| after.strip_prefix(word));
    let rest = rest.map(|rest| rest.trim_start_matches("the ").trim_start_matches("a "));
    // "1.3 s until 305 is reached".
    let is_reached = after.starts_with("until ") || after.starts_with("before ");
    let clause = after.split([',', ';', '.']).next().unwrap_or(after);
    is_reached
        && ["reached", "reach", "hit"]
            .iter()
            .any(|word| has_word(clause, word))
        || rest.is_some_and(|rest| {
            ["impact", "collision", "contact", "crash", "hitting"]
                .iter()
                .any(|word| rest.starts_with(word))
        })
}

impl Sentence<'_> {
    /// What the number says, and whether as a magnitude; `from` is where the number before it ends.
    pub(super) fn quantity(&self, place: usize, from: usize) -> Option<(Quantity, bool)> {
        if let Some(quantity) = self.in_quotient(place) {
            return Some((quantity, true));
        }
        let number = &self.numbers[place];
        let near = &self.lower[from..number.span.start];
        let clause = self.clause(number.span.start);
        let clause_at = clause;
        let (begin, is_bracket) = self.begins(number);
        // What the clause itself says before it.
        let own = &self.lower[begin.clamp(from, number.span.start)..number.span.start];
        let before = &self.lower[..number.span.start];
        let after = self.lower[number.span.end..].trim_start_matches(['*', ' ', '`']);
        // "Not 3 m", "9 m/s slower", "the distance to the kerb".
        let said = near
            .rsplit([',', '(', ')', ':', ';'])
            .next()
            .unwrap_or(near);
        let compared = ["lower", "higher", "more ", "less "];
        let is_bound = BOUNDS.iter().any(|(words, _)| said.contains(words));
        let last = place.checked_sub(1).map(|i| self.numbers[i].unit);
        // "Closing at 54 m/s → 2.8 s" and "brakes with 2 m/s² to 5 m/s" are no ranges.
        let next = self.numbers.get(place + 1);
        let is_other =
            next.is_some_and(|next| next.unit != number.unit && number.unit != Unit::None);
        let is_led = is_other
            && (after.starts_with(['→', '⇒'])
                || after.starts_with("->")
                || after.starts_with("to "));
        let further = if is_led { "" } else { after };
        if self.counted(near, further, last == Some(number.unit))
            || denies(&said.replace("barely", "").replace("hardly", "")) && !is_bound
            || compared.iter().any(|word| after.starts_with(word))
            || self.is_to_another(near, number.span.start)
        {
            return None;
        }
        // "Longitudinal & lateral distance: 0.45 m & -2.04 m": which is which is not said beside the number.
        let both = near.contains("longitudinal") && near.contains("lateral");
        if both && goes_on(after) {
            return None;
        }
        let near_or_above = format!("{} {near}", self.above);
        let label = clause.and_then(|clause| {
            let (first, last) = (clause.label.start, clause.label.end.checked_sub(1)?);
            let (first, last) = (self.tokens.get(first)?, self.tokens.get(last)?);
            only_axis(&self.lower[first.span.start..last.span.end])
        });
        let own_axis = find_axis(own, after).or(label).or_else(|| axis(self.above));
        let is_short = near.len() < 40 || near.contains(':');
        let named = find_axis(own, after).or(label).or_else(|| {
            // "Zero lateral offset and 2 m in front".
            let has_place =
                !is_bracket && own != near && self.place_behind(number).flatten().is_some();
            let is_near = is_bracket && names_axis_of(near, number.unit)
                || is_short
                    && !has_place
                    && !near.contains("laterally")
                    && !near.contains("longitudinally");
            if is_near { axis(near) } else { None }
        });
        // A time may stand behind its calculation: "longitudinal: 12.8 m / 2.5 m/s = 5 s".
        let equals = near.contains(['=', '≈']) || near.contains("approx");
        let is_difference = number.unit == Unit::Speed && last == Some(Unit::Speed)
            || number.unit == Unit::Speed && last == Some(Unit::None) && before.contains(" - ");
        let is_calculated = equals && (number.unit == Unit::Second || is_difference);
        let axis = named.or_else(|| {
            let before = if is_calculated {
                only_axis(before)
            } else {
                None
            };
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
            Unit::Second
                if has_word(&near_or_above, "headway")
                    || has_word(near, "time gap")
                    || has_word(near, "thw") =>
            {
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
            // "Turns by 30°" is a difference.
            Unit::Degree
                if ["changes", "change", "changed", "turns", "turned", "differs"]
                    .iter()
                    .any(|word| has_word(near, word)) =>
            {
                None
            }
            Unit::Degree
                if ["chang", "turn", "rotat"]
                    .iter()
                    .any(|word| near.contains(word)) =>
            {
                None
            }
            Unit::Degree
                if has_word(&near_or_above, "heading") || has_word(near, "orientation") =>
            {
                Some((Heading, false))
            }
            Unit::Second if axis.is_some() && has_word(own, "time") => {
                Some((if axis == Some(true) { TtcLong } else { TtcLat }, false))
            }
            Unit::Second
                if time(&near_or_above) || time(before) && (axis.is_some() || is_calculated) =>
            {
                Some((
                    match axis {
                        None => Ttc,
                        Some(true) => TtcLong,
                        Some(false) => TtcLat,
                    },
                    false,
                ))
            }
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
                if is_least && own_axis.is_none() && (axis.is_none() || has_word(own, "mdc")) {
                    return Some((LeastDistance, true));
                }
                let smallest = ["minimum", "smallest", "least", "min", "closest", "nearest"];
                let lengths = [
                    "distance",
                    "gap",
                    "separation",
                    "clearance",
                    "approach",
                    "point",
                ];
                let is_bound = has_word(near, "at least");
                // "The nearest follower keeps its distance" names none.
                let words: Vec<&str> = near
                    .split(|c: char| !c.is_alphanumeric())
                    .filter(|w| !w.is_empty())
                    .collect();
                let is_smallest = words.iter().enumerate().any(|(i, word)| {
                    let beside = words[i.saturating_sub(2)..(i + 4).min(words.len())].iter();
                    smallest.contains(word) && { beside }.any(|word| lengths.contains(word))
                });
                let is_closest = ["at its closest", "at its nearest"]
                    .iter()
                    .any(|words| self.lower.contains(words));
                if (is_smallest || is_closest) && !is_bound && axis.is_none()
                    || has_word(near, "as near as")
                    || has_word(near, "as close as")
                {
                    return Some((MinDistance, true));
                }
                if has_word(own, "by")
                    && [
                        "trails",
                        "trailed",
                        "led",
                        "leads",
                        "behind",
                        "ahead",
                        "separated",
                        "apart",
                    ]
                    .iter()
                    .any(|word| has_word(own, word))
                {
                    return Some((Distance, true));
                }
                const PASSED: [&str; 22] = [
                    "avoided",
                    "missed",
                    "cleared",
                    "misses",
                    "clears",
                    "passed",
                    "passes",
                    "slipped past",
                    "slips past",
                    "went by",
                    "goes by",
                    "went past",
                    "came within",
                    "came to within",
                    "come within",
                    "come to within",
                    "comes within",
                    "got within",
                    "gets within",
                    "came no closer than",
                    "came no nearer than",
                    "came closer than",
                ];
                // "Passed with a clearance of 2 m", "passes with 2 m to spare".
                let clears = after.starts_with("to spare")
                    || after.starts_with("clearance")
                    || has_word(near, "clearance");
                let earlier = &self.lower[..number.span.start];
                let is_passing = PASSED.iter().any(|word| has_word(own, word))
                    || clears
                        && axis.is_none()
                        && PASSED.iter().any(|word| has_word(earlier, word));
                if is_passing && !after.starts_with("later") && self.place_behind(number).is_none()
                {
                    return Some((MinDistance, true));
                }
                if ["to the side", "to one side", "sideways"]
                    .iter()
                    .any(|words| after.starts_with(words))
                {
                    return Some((DistanceAcross, true));
                }
                // "4 m ahead", "5 m to our right".
                let last: Vec<&str> = own.split_whitespace().rev().take(2).collect();
                let is_other = last
                    .iter()
                    .any(|word| OTHER_LENGTHS.contains(word) && *word != "lane");
                if let Some(side) = self.side_behind(number)
                    && axis.is_none()
                    && !is_other
                {
                    return Some((
                        match (side.front, side.left) {
                            (Some(_), None) => DistanceAlong,
                            (None, Some(_)) => DistanceAcross,
                            _ => Distance,
                        },
                        true,
                    ));
                }
                // "In the lane at 54 m"; "the minimum lateral gap" is that of the window; "longitudinal MDC".
                let is_length = |word: &&&str| match **word {
                    "lane" => last.first() == Some(&"lane"),
                    "minimum" | "min" if axis.is_some() => false,
                    "mdc" if own_axis.is_some() => false,
                    word => has_word(own, word),
                };
                if OTHER_LENGTHS.iter().any(|word| is_length(&word))
                    || axis.is_none()
                        && ["mdc", "dce", "min"]
                            .iter()
                            .any(|word| has_word(near, word))
                    || has_word(clause, "position")
                    || axis.is_none() && has_word(self.above, "mdc")
                    || ["long", "wide", "high", "lane"].contains(&first_word)
                    || time(said)
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
                    || after.starts_with("to spare")
                    || ["of clearance", "of room", "of space", "of distance"]
                        .iter()
                        .any(|words| after.starts_with(words))
                    || phrases::away_from_the_ego(after)
                    || [
                        "from us",
                        "from me",
                        "from the bumper",
                        "from my bumper",
                        "from our bumper",
                        "from our",
                    ]
                    .iter()
                    .any(|words| after.trim_start_matches("away ").starts_with(words))
                    || self.is_range(near, after);
                match axis.or_else(|| from_ego(after).filter(|_| !distance)) {
                    Some(true) => Some((GapLong, false)),
                    Some(false) => Some((GapLat, false)),
                    // With a sign it is one of the two gaps, but which one is not stated. "This gap closes to 3 m"
                    // continues with one of them, too.
                    None if distance
                        && number.value >= 0.0
                        && !["this gap", "this distance"]
                            .iter()
                            .any(|words| own.contains(words)) =>
                    {
                        Some((Distance, false))
                    }
                    None => None,
                }
            }
            Unit::Speed => {
                // "Relative velocity: ego velocity is 3 m/s": of the ego its clause alone tells.
                let is_egos = clause_at.is_some_and(|clause| clause.who == Who::Ego);
                // "We close with 3 m/s" is one clause with its verb.
                let own = if is_egos && own.starts_with("with ") {
                    said
                } else {
                    own
                };
                let near = if is_egos {
                    own.rsplit("ego").next().unwrap_or(own)
                } else {
                    near
                };
                let said = if is_egos {
                    without_reference(own)
                } else {
                    without_reference(&format!("{} {before}", self.above))
                };
                // "Moving left (3 m/s)" is across the heading.
                let moved = near.trim_end_matches(['(', ' ', '*', '~']);
                if ["moving left", "moving right", "moving laterally"]
                    .iter()
                    .any(|words| moved.ends_with(words))
                {
                    return Some((VelocityLat, true));
                }
                match axis {
                    None if is_calculated && is_difference && relative(&said) => {
                        Some((ClosingSpeed, true))
                    }
                    // Along an axis it is told as a relative one, whether the word is repeated or not.
                    Some(long) if !is_of_ego => {
                        let closing = has_word(near, "closing");
                        Some((if long { VelocityLong } else { VelocityLat }, closing))
                    }
                    None if relative(&said) && !is_of_ego && after.starts_with("in both ") => {
                        Some((VelocityLong, false))
                    }
                    // "1.6 m/s faster than us", "faster by 0.5 m/s".
                    None if after.starts_with("faster")
                        || after.starts_with("slower")
                        || ends_with_word(near.trim_end(), "by")
                            && ["faster", "slower"].iter().any(|word| has_word(own, word)) =>
                    {
                        Some((VelocityLong, true))
                    }
                    None if [
                        "closing",
                        "approach",
                        "meets",
                        "closes",
                        "approaching",
                        "approaches",
                        "relative",
                        "combined",
                        "nearing",
                        "shrinking",
                    ]
                    .iter()
                    .any(|word| self.is_beside(near, word, number))
                        || ["close at", "close with", "approach at"]
                            .iter()
                            .any(|words| near.trim_end().ends_with(words))
                        || ["relative", "closing"]
                            .iter()
                            .any(|word| after.starts_with(word))
                        || self.is_of_distance(number) =>
                    {
                        Some((ClosingSpeed, true))
                    }
                    None if after.starts_with("below its own")
                        || after.starts_with("above its own")
                        || ["faster", "slower"].iter().any(|word| has_word(near, word)) =>
                    {
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
                    Some(long) if relative(&format!("{} {before}", self.above)) && !is_of_ego => {
                        Some((
                            if long {
                                AccelerationLong
                            } else {
                                AccelerationLat
                            },
                            false,
                        ))
                    }
                    None if !relative(&said) => {
                        let slower = near.contains("decelerat")
                            || near.contains("brak")
                            || near.contains("slow");
                        // "Brakes (2.7 m/s, -5.0 m/s²)".
                        let is_second = last == Some(Unit::Speed) && near.trim() == ",";
                        let named = slower
                            || near_or_above.contains("accelerat")
                            || near.trim_end().ends_with("a =")
                            || is_second && !relative(before);
                        named.then_some((Acceleration, slower))
                    }
                    _ => None,
                }
            }
            _ => None,
        }
    }

    /// Whether a word stands before a number, and no obstacle is named in between.
    fn is_beside(&self, near: &str, word: &str, number: &Number) -> bool {
        let from = number.span.start - near.len();
        let Some(at) = find_word(near, word) else {
            return false;
        };
        let is_between = |r: &Reference| {
            let place = self.tokens[r.at.start].span.start;
            matches!(r.who, Named::Obstacle(_)) && from + at < place && place < number.span.start
        };
        let is_far = near[at..].contains(',');
        !is_far || !self.references.iter().any(is_between)
    }

    /// Whether the number is part of a calculation or of a range.
    pub(super) fn counted(&self, near: &str, after: &str, is_alike: bool) -> bool {
        const BEFORE: [char; 3] = ['/', '÷', '×'];
        let near = near.trim_end_matches(['*', ' ', '`', '(', '|', '$', '\\']);
        let behind = near.chars().next_back();
        let operand = behind
            .is_some_and(|c| BEFORE.contains(&c) || c == '+' || is_alike && (c == '-' || c == '–'));
        let first = after.chars().next();
        let goes_on = first.is_some_and(|c| ['/', '÷', '×', '–', '-', '+', '→'].contains(&c));
        operand
            || goes_on
            || after.strip_prefix("to ").is_some_and(|end| {
                end.trim_start_matches(['-', '−', '~'])
                    .starts_with(|c: char| c.is_ascii_digit())
            })
            || after.starts_with("or ") && !after.starts_with("or so")
            || near.ends_with("\\times")
            || near.ends_with("\\frac{")
            || after.starts_with("->")
    }

    /// What a number is in a division of a length by a speed: "8.45 m / 6.87 m/s = 1.23 s".
    pub(super) fn in_quotient(&self, place: usize) -> Option<Quantity> {
        let (from, parts) = divisions(self.lower, self.numbers).find(|(from, parts)| {
            (*from..from + 3).contains(&place) && parts[2].unit == Unit::Second
        })?;
        let before = &self.lower[..parts[0].span.start];
        let after = self.lower[parts[2].span.end..].trim_start_matches(['*', ' ', '`']);
        let own = before.rsplit([',', ';']).next().unwrap_or(before);
        let axis = find_axis("", after)
            .or_else(|| only_axis(own))
            .or_else(|| only_axis(before))
            .or_else(|| axis(self.above));
        let is_headway = ["headway", "time gap", "thw"]
            .iter()
            .any(|word| has_word(before, word));
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

    pub(super) fn rough(&self, from: usize, to: usize) -> bool {
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
            // "A metre and a half", "half a second".
            || self.lower[to..].starts_with("a ")
            || self.lower[to..].starts_with("half a ")
    }

    /// A place said in words takes the sign: "3 m behind", "1.9 m to the left".
    pub(super) fn magnitude(&self, _from: usize, number: &Number) -> bool {
        // A number with its sign written is meant with it.
        let shown = &self.lower[number.span.clone()];
        !shown.starts_with(['-', '−', '–', '+'])
    }
}
