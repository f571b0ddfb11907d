//! Numbers with units in text, which axis of the ego they are about, and times with the steps they denote.

use std::ops::Range;

use super::find::{MentionContext, ends_with_word};
use super::tokens::has_word;

/// The unit behind a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    None,
    Metre,
    Second,
    Speed,
    Acceleration,
    Degree,
    /// One that no claim is made in.
    Other,
}

/// A number in a text.
#[derive(Debug, Clone, PartialEq)]
pub struct Number {
    pub value: f64,
    pub decimals: u8,
    pub unit: Unit,
    /// The number with its unit, bytes.
    pub span: Range<usize>,
}

impl Number {
    /// The whole number that it is, also when it is written as 30674.0.
    pub fn as_integer(&self) -> Option<i64> {
        let fits = self.value.fract() == 0.0 && self.value.abs() < 1e15;
        (fits && matches!(self.unit, Unit::None)).then_some(self.value as i64)
    }
}

/// Longer names first.
const UNITS: &[(&str, Unit)] = &[
    ("meters per second squared", Unit::Acceleration),
    ("metres per second squared", Unit::Acceleration),
    ("meters per second", Unit::Speed),
    ("metres per second", Unit::Speed),
    ("m/s²", Unit::Acceleration),
    ("m/s^2", Unit::Acceleration),
    ("m/s2", Unit::Acceleration),
    ("m/s", Unit::Speed),
    ("km/h", Unit::Speed),
    ("kph", Unit::Speed),
    ("kmh", Unit::Speed),
    ("mph", Unit::Speed),
    ("g", Unit::Other),
    ("meters", Unit::Metre),
    ("metres", Unit::Metre),
    ("meter", Unit::Metre),
    ("metre", Unit::Metre),
    ("seconds", Unit::Second),
    ("second", Unit::Second),
    ("secs", Unit::Second),
    ("sec", Unit::Second),
    ("ms", Unit::Second),
    ("km", Unit::Metre),
    ("cm", Unit::Metre),
    ("radians", Unit::Degree),
    ("rad", Unit::Degree),
    ("degrees", Unit::Degree),
    ("°", Unit::Degree),
    ("%", Unit::Other),
    ("m", Unit::Metre),
    ("s", Unit::Second),
];

/// How many of the unit that a claim is made in one of a name is.
const SCALES: &[(&str, f64)] = &[
    ("km/h", 1.0 / 3.6),
    ("kph", 1.0 / 3.6),
    ("kmh", 1.0 / 3.6),
    ("mph", 0.447_04),
    ("ms", 0.001),
    ("km", 1000.0),
    ("cm", 0.01),
    ("rad", 180.0 / std::f64::consts::PI),
    ("radians", 180.0 / std::f64::consts::PI),
];

/// How many of the unit of a claim the unit that a text ends with is.
pub fn scale(text: &str) -> f64 {
    let lower = text.to_lowercase();
    let own = SCALES.iter().find(|(name, _)| {
        let rest = lower.strip_suffix(name);
        rest.is_some_and(|rest| !rest.ends_with(char::is_alphabetic))
    });
    own.map_or(1.0, |(_, scale)| *scale)
}

/// What TeX may have between a number and its unit.
const TEX: &[&str] = &["\\,", "\\;", "\\ ", "\\)", "\\text{", "\\mathrm{", "\\"];

/// Names of quantities whose unit goes without saying.
const NAMED: &[(&[&str], Unit)] = &[
    (&["velocity", "speed"], Unit::Speed),
    (&["acceleration", "deceleration"], Unit::Acceleration),
    (&["dtclong", "dtclat", "distance", "gap"], Unit::Metre),
    (&["ttclong", "ttclat"], Unit::Second),
    (&["heading", "orientation"], Unit::Degree),
];

/// Gives numbers without a unit that of the quantity whose name stands right before them: "velocity (2.743)",
/// "DTClat is 0.0"; `lower` is the text in lower case. A whole number may be an id or a score.
pub fn name_units(lower: &str, all: &mut [Number]) {
    for number in all {
        let is_zero = number.value == 0.0;
        if number.unit != Unit::None || number.decimals == 0 && !is_zero {
            continue;
        }
        let markup = ['*', ' ', '`', ':', '=', '(', '"'];
        let before = lower[..number.span.start].trim_end_matches(markup);
        let before = [" is", " of"]
            .iter()
            .find_map(|word| before.strip_suffix(word))
            .unwrap_or(before);
        // A key of JSON with its unit: "ttc_s".
        let key = lower[..number.span.start].trim_end_matches(markup);
        let is_key = lower[key.len()..number.span.start].contains('"');
        let keyed = [
            ("_m", Unit::Metre),
            ("_s", Unit::Second),
            ("_mps", Unit::Speed),
            ("_m_s", Unit::Speed),
        ]
        .iter()
        .rfind(|(end, _)| is_key && key.ends_with(end));
        if let Some((_, unit)) = keyed {
            number.unit = *unit;
            continue;
        }
        let named = |(names, _): &&(&[&str], Unit)| {
            names.iter().any(|name| {
                let rest = before.strip_suffix(name);
                rest.is_some_and(|rest| !rest.ends_with(char::is_alphanumeric))
            })
        };
        let is_motion = |unit: Unit| matches!(unit, Unit::Speed | Unit::Acceleration);
        let named = NAMED
            .iter()
            .find(named)
            .filter(|one| number.decimals > 0 || is_motion(one.1));
        if let Some((_, unit)) = named {
            number.unit = *unit;
            // Without a unit, angles are in radians.
            if *unit == Unit::Degree {
                number.value = number.value.to_degrees();
                number.decimals = number.decimals.saturating_sub(2);
            }
        }
    }
}

/// Numbers that are written as words, where a unit stands behind them.
pub const WORDS: [(&str, f64); 28] = [
    ("half a", 0.5),
    ("one", 1.0),
    ("two", 2.0),
    ("three", 3.0),
    ("four", 4.0),
    ("five", 5.0),
    ("six", 6.0),
    ("seven", 7.0),
    ("eight", 8.0),
    ("nine", 9.0),
    ("ten", 10.0),
    ("eleven", 11.0),
    ("twelve", 12.0),
    ("thirteen", 13.0),
    ("fourteen", 14.0),
    ("fifteen", 15.0),
    ("sixteen", 16.0),
    ("seventeen", 17.0),
    ("eighteen", 18.0),
    ("nineteen", 19.0),
    ("twenty", 20.0),
    ("thirty", 30.0),
    ("forty", 40.0),
    ("fifty", 50.0),
    ("sixty", 60.0),
    ("seventy", 70.0),
    ("eighty", 80.0),
    ("ninety", 90.0),
];

/// The numbers in words of a text: "fifteen metres".
fn in_words(text: &str) -> Vec<Number> {
    let mut found = Vec::new();
    let units = text.match_indices([' ']).filter_map(|(at, _)| {
        let (unit, end) = unit(text, at);
        Some((at, unit.filter(|unit| *unit != Unit::None)?, end))
    });
    for (at, unit, end) in units {
        let before = text[..at].to_lowercase();
        if let Some(one) = one_unit(&before, &text[at..], (at, unit, end)) {
            found.push(one);
            continue;
        }
        if before.len() == at
            && let Some((start, value)) = value_of(&before)
        {
            found.push(Number {
                value: value * scale(&text[at..end]),
                decimals: u8::from(value.fract() != 0.0),
                unit,
                span: start..end,
            });
        }
    }
    found
}

/// The number in words that a text ends with, and where it begins: "twenty-five", "two and a half".
fn value_of(text: &str) -> Option<(usize, f64)> {
    let last = |text: &str| {
        let (word, value) = WORDS.iter().find(|(word, _)| ends_with_word(text, word))?;
        Some((text.len() - word.len(), *value))
    };
    if let Some(whole) = text.strip_suffix(" and a half") {
        return value_of(whole).map(|(start, value)| (start, value + 0.5));
    }
    let (start, value) = last(text)?;
    // "One hundred and five".
    let is_large = text[..start]
        .split_whitespace()
        .rev()
        .take(3)
        .any(|word| word.starts_with("hundred") || word.starts_with("thousand"));
    if is_large {
        return None;
    }
    let before = text[..start].trim_end_matches(['-', ' ']);
    let tens = last(before).filter(|(_, tens)| *tens >= 20.0 && tens % 10.0 == 0.0);
    match tens {
        Some((start, tens)) if (1.0..10.0).contains(&value) => Some((start, tens + value)),
        _ => Some((start, value)),
    }
}

/// One of a unit that is not written as a number: "a metre", "under a second", "a metre and a half".
fn one_unit(before: &str, rest: &str, (at, unit, end): (usize, Unit, usize)) -> Option<Number> {
    const HALF: &str = " and a half";
    const MEASURED: [&str; 13] = [
        "than", "under", "within", "about", "in", "almost", "nearly", "roughly", "over", "around",
        "just", "even", "maybe",
    ];
    const ENDS: [&str; 8] = ["before", "away", "off", "until", "from", "to", "of", "or"];
    let bare = ["a", "an"]
        .iter()
        .find(|word| ends_with_word(before, word))?;
    let start = at - bare.len();
    let named = rest.trim_start().to_lowercase();
    let is_whole = ["metre", "meter", "second"]
        .iter()
        .any(|name| begins_with_word(&named, name));
    let lead = before[..start].trim_end();
    let tail = rest[end - at..].trim_start().to_lowercase();
    let has_half = tail.starts_with(HALF.trim_start());
    let is_measured = MEASURED.iter().any(|word| ends_with_word(lead, word))
        || lead.is_empty()
        || lead.ends_with(',');
    let ends = tail.is_empty()
        || tail.starts_with(['.', ',', ';', ')', '!', '?'])
        || ENDS.iter().any(|word| begins_with_word(&tail, word));
    // "A second car".
    let is_number = is_whole && (has_half || is_measured && ends);
    let stop = if has_half {
        end + rest[end - at..].find("half")? + "half".len()
    } else {
        end
    };
    is_number.then(|| Number {
        value: if has_half { 1.5 } else { 1.0 },
        decimals: u8::from(has_half),
        unit,
        span: start..stop,
    })
}

/// All numbers of a text, in its order.
pub fn numbers(text: &str) -> Vec<Number> {
    let bytes = text.as_bytes();
    let mut found = in_words(text);
    let has_words = !found.is_empty();
    let mut at = 0;
    while at < bytes.len() {
        if !bytes[at].is_ascii_digit() {
            at += 1;
            continue;
        }
        let mut end = at;
        while end < bytes.len() && bytes[end].is_ascii_digit() {
            end += 1;
        }
        let mut decimals = 0;
        if bytes.get(end) == Some(&b'.') && bytes.get(end + 1).is_some_and(u8::is_ascii_digit) {
            let point = end;
            end += 1;
            while end < bytes.len() && bytes[end].is_ascii_digit() {
                end += 1;
            }
            decimals = u8::try_from(end - point - 1).unwrap_or(u8::MAX);
        }
        let mut decimal = None;
        if decimals == 0 && bytes.get(end) == Some(&b',') {
            let digits = bytes[end + 1..]
                .iter()
                .take_while(|b| b.is_ascii_digit())
                .count();
            let stop = end + 1 + digits;
            // "22,8 m/s": of thousands there are three.
            if (1..=2).contains(&digits) && matches!(unit(text, stop).0, Some(u) if u != Unit::None)
            {
                decimal = text[at..stop].replace(',', ".").parse::<f64>().ok();
                decimals = digits as u8;
                end = stop;
            }
        }
        let before = text[..at].chars().next_back();
        // Part of a name, a version, a date.
        let inside = before.is_some_and(|c| c.is_alphanumeric() || c == '_' || c == '.');
        let (start, sign) = sign(text, at);
        let value = decimal.or_else(|| text[at..end].parse::<f64>().ok());
        if !inside && let Some(value) = value {
            let (unit, stop) = unit(text, end);
            if let Some(unit) = unit {
                let scale = scale(&text[end..stop]);
                // As many digits as tell half of the last one in the unit of the claim, at least.
                let decimals = if scale == 1.0 {
                    decimals
                } else {
                    let digits = f64::from(decimals) - scale.log10();
                    digits.round().clamp(0.0, 9.0) as u8
                };
                found.push(Number {
                    value: sign * value * scale,
                    decimals,
                    unit,
                    span: start..stop,
                });
            }
        }
        at = end;
    }
    if has_words {
        found.sort_by_key(|number| number.span.start);
    }
    found
}

/// Where a number begins with its sign; a dash behind something is none.
fn sign(text: &str, at: usize) -> (usize, f64) {
    let mut back = text[..at].char_indices().rev();
    let Some((place, dash @ ('-' | '−' | '–' | '+'))) = back.next() else {
        return (at, 1.0);
    };
    let behind = back.next().map(|(_, c)| c);
    let range = behind.is_some_and(|c| c.is_alphanumeric() || matches!(c, ')' | ']' | '%' | '°'));
    match (range, dash) {
        (true, _) => (at, 1.0),
        (_, '+') => (place, 1.0),
        _ => (place, -1.0),
    }
}

/// The unit behind a number, and where it ends; `None` for digits that go on as a word.
fn unit(text: &str, end: usize) -> (Option<Unit>, usize) {
    let rest = &text[end..];
    // Markup and TeX may stand between: `3.2** m`, `3.2\,m`, `3.2 \, \text{m}`.
    let mut tail = rest.trim_start_matches([' ', '\u{a0}', '*', '`', '$']);
    while let Some(further) = TEX.iter().find_map(|tex| tail.strip_prefix(tex)) {
        tail = further.trim_start_matches([' ', '\u{a0}', '*', '`', '$']);
    }
    let skipped = rest.len() - tail.len();
    let lower = |n: usize| tail.get(..n).map(str::to_lowercase);
    for (name, unit) in UNITS {
        let fits = lower(name.len()).is_some_and(|t| t == *name);
        let after = tail.get(name.len()..).and_then(|t| t.chars().next());
        let ends = after.is_none_or(|c| !c.is_alphanumeric() && !matches!(c, '/' | '^' | '²'))
            || name.ends_with('²');
        if fits && ends {
            return (Some(*unit), end + skipped + name.len());
        }
    }
    let next = rest.chars().next();
    let goes_on = next.is_some_and(|c| c.is_alphanumeric() || c == '_');
    (Some(Unit::None).filter(|_| !goes_on), end)
}

/// A text without the ego where something is only told relative to it: "closing in on the ego at".
pub fn without_reference(text: &str) -> String {
    let mut text = text.replace("the ego", "ego").replace("towards", "toward");
    for before in [
        "toward",
        "from",
        "approaching",
        "approaches",
        "approach",
        "nearing",
        "relative to",
        "in front of",
        "ahead of",
        "behind",
        "to",
        "on",
        "with",
        "of",
        "as",
        "both",
    ] {
        text = text.replace(&format!(" {before} ego"), " ");
    }
    text
}

/// The axis of a number: named before it, or right behind it, as in "2.4 m longitudinal, 9.4 m lateral".
pub fn find_axis(near: &str, after: &str) -> Option<bool> {
    let after = after.trim_start_matches('(');
    let after = [
        "relative ",
        "absolute ",
        "adjusted ",
        "off ",
        "away ",
        "apart ",
    ]
    .iter()
    .find_map(|word| after.strip_prefix(word))
    .unwrap_or(after);
    let short = |words: [&str; 2]| words.iter().any(|word| begins_with_word(after, word));
    let behind = [
        after.starts_with("longitudinal") || short(["along", "along the"]),
        after.starts_with("lateral") || short(["across", "sideways"]),
    ];
    let words = near.trim_end_matches(['*', ' ', '`', ':', '=', '(', '≈', '~', '-', '−']);
    let before = words.ends_with("longitudinal") || words.ends_with("lateral");
    match behind {
        [true, _] if !before => Some(true),
        [_, true] if !before => Some(false),
        _ => axis(near),
    }
}

/// Whether a text begins with a word, not with a part of another.
pub fn begins_with_word(text: &str, word: &str) -> bool {
    text.strip_prefix(word)
        .is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
}

/// The divisions of a text with their results, each by the place of its dividend among the numbers: "12.8 m / 2.5 m/s = 5.1 s",
/// "\frac{12.8}{2.5} \approx 5.1 s".
pub fn divisions<'n>(
    lower: &'n str,
    all: &'n [Number],
) -> impl Iterator<Item = (usize, &'n [Number])> {
    const MARKUP: [char; 14] = [
        ' ', '*', '`', '(', ')', '[', ']', '~', '$', '\\', '{', '}', '|', '\u{a0}',
    ];
    let three = all.windows(3).enumerate();
    three.filter(|(_, parts)| {
        let between = |i: usize| {
            let text = lower.get(parts[i].span.end..parts[i + 1].span.start);
            text.unwrap_or("?").trim_matches(MARKUP)
        };
        let head = lower[..parts[0].span.start].trim_end_matches(MARKUP);
        let divides = match between(0) {
            "/" | "÷" => true,
            "" => head.ends_with("frac"),
            _ => false,
        };
        let result = between(1);
        let bare = result.trim_start_matches(['=', '≈', ' ', '~']);
        let is_rough = ["approx", "approx.", "approximately", "about", "roughly"].contains(&bare);
        divides && (is_rough || bare.is_empty() && !result.is_empty())
    })
}

/// The axis of "3 m in front of the ego" or "2 m to the left of the ego".
pub fn from_ego(after: &str) -> Option<bool> {
    let said = |words: &[&str]| {
        let rest = words.iter().find_map(|word| after.strip_prefix(word));
        rest.is_some_and(|rest| {
            let rest = rest.trim_start_matches([' ', '*']);
            let rest = rest.strip_prefix("the ").unwrap_or(rest);
            rest.starts_with("ego") || rest.starts_with("current ego")
        })
    };
    if said(&["in front of", "ahead of", "behind"]) {
        Some(true)
    } else {
        said(&["to the left of", "to the right of", "left of", "right of"]).then_some(false)
    }
}

/// The axis that is named, if it is the only one.
pub fn only_axis(text: &str) -> Option<bool> {
    let other = |long| if long { "lateral" } else { "longitudinal" };
    axis(text).filter(|long| !text.contains(other(*long)))
}

/// The last axis that is named: along (true) or across the ego's heading.
pub fn axis(near: &str) -> Option<bool> {
    let last = |words: &[&str]| words.iter().filter_map(|word| near.rfind(word)).max();
    let long = last(&[
        "longitudinal",
        "_long",
        "{long",
        "dtclong",
        "ttclong",
        "vrellong",
    ]);
    let lat = last(&["lateral", "_lat", "{lat", "dtclat", "ttclat", "vrellat"]);
    match (long, lat) {
        (None, None) => None,
        (a, b) => Some(a > b),
    }
}

/// The time that a text speaks of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum MentionedTime {
    #[default]
    Unsaid,
    Step(i64),
    /// Several times, or one that is no time step.
    Unclear,
}

/// Which numbers are times, each with the step that it names if there is one, and the step that all of them name.
pub fn times(
    lower: &str,
    all: &[Number],
    world: &MentionContext<'_>,
) -> (Vec<(usize, Option<i64>)>, MentionedTime) {
    let mut places = Vec::new();
    let mut when = MentionedTime::Unsaid;
    for (place, number) in all.iter().enumerate() {
        let before =
            lower[..number.span.start].trim_end_matches(['*', ' ', '`', ':', '=', '(', '~', '"']);
        let counted = ["step", "timestep", "time_step", "steps"]
            .iter()
            .any(|word| ends_with_word(before, word));
        let after = &lower[number.span.end..];
        // "- 4.8 s: longitudinal 3.75 m"
        let leads = before.chars().all(|c| !c.is_alphanumeric()) && after.starts_with(':');
        let ago = is_ago(after);
        let timed = counted
            || leads
            || ago
            || ["at", "t", "time", "at around", "at about", "by"]
                .iter()
                .any(|word| ends_with_word(before, word));
        let named = match number.unit {
            // From now, whatever other times count from.
            Unit::Second if ago => {
                let now = world.now.unwrap_or(world.present);
                step_from(-number.value.abs(), Some(now), world)
            }
            Unit::Second if timed => step_at(number.value, world),
            // "Step 1" of an answer that was told no time steps is one of its reasoning.
            Unit::None if world.now.is_some() && number.decimals == 0 => continue,
            Unit::None if counted && number.decimals == 0 => {
                number.as_integer().filter(|s| world.steps.contains(s))
            }
            Unit::None if counted => step_at(number.value, world),
            _ => continue,
        };
        places.push((place, named));
        when = match (when, named) {
            (MentionedTime::Unsaid, Some(step)) => MentionedTime::Step(step),
            (MentionedTime::Step(now), Some(step)) if now == step => when,
            _ => MentionedTime::Unclear,
        };
    }
    if when == MentionedTime::Unsaid
        && let Some(now) = world.now
        && has_word(lower, "now")
    {
        let elsewhere = ["until now", "from now", "up to now", "by now"];
        when = if elsewhere.iter().any(|words| lower.contains(words)) {
            MentionedTime::Unclear
        } else {
            MentionedTime::Step(now)
        };
    }
    (places, when)
}

/// Whether the words behind a number of seconds say that it lies so long in the past: "0.5 s ago".
fn is_ago(after: &str) -> bool {
    let after = after.trim_start_matches(['*', ' ', '`', ')']);
    ["ago", "before now", "before the end", "before the present"]
        .iter()
        .any(|words| {
            let rest = after.strip_prefix(words);
            rest.is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
        })
}

/// The time that a heading sets for what stands under it; `now` is that of the heading before.
pub fn heading_time(
    lower: &str,
    line: &str,
    world: &MentionContext<'_>,
    now: MentionedTime,
) -> MentionedTime {
    let all = numbers(line);
    let (_, when) = times(lower, &all, world);
    let seconds: Vec<&Number> = all.iter().filter(|n| n.unit == Unit::Second).collect();
    let last = { seconds.iter() }.map(|n| n.value).max_by(f64::total_cmp);
    // What is said of all that was described, "timestep 6.5s - 7.3s", is said of its end, too.
    let is_all = last.and_then(|last| step_at(last, world)) == Some(world.present);
    match when {
        _ if seconds.len() > 1 && is_all => MentionedTime::Unsaid,
        // "timesteps 3 to 9"
        _ if seconds.len() > 1 || has_word(lower, "timesteps") => MentionedTime::Unclear,
        MentionedTime::Unsaid if lower.contains("step") => match seconds.as_slice() {
            // "most recent timestep (0.9 seconds)"
            [one] => step_at(one.value, world).map_or(MentionedTime::Unclear, MentionedTime::Step),
            _ if ["summary", "conclusion"]
                .iter()
                .any(|word| lower.contains(word)) =>
            {
                MentionedTime::Unsaid
            }
            _ => now,
        },
        MentionedTime::Unsaid
            if ["summary", "conclusion", "json"]
                .iter()
                .any(|word| lower.contains(word)) =>
        {
            MentionedTime::Unsaid
        }
        MentionedTime::Unsaid => now,
        said => said,
    }
}

/// The step at a time, seconds; nothing between steps, outside the recording, and after what was described.
fn step_at(seconds: f64, world: &MentionContext<'_>) -> Option<i64> {
    step_from(seconds, world.now, world)
}

/// The same, of a time from a step; from time step 0 where there is none.
fn step_from(seconds: f64, now: Option<i64>, world: &MentionContext<'_>) -> Option<i64> {
    let steps = (seconds / world.dt).round();
    let near = (steps * world.dt - seconds).abs() < 0.1 * world.dt;
    let step = (steps as i64).saturating_add(now.unwrap_or(0));
    let told = now.is_none_or(|now| step <= now);
    Some(step).filter(|s| near && told && world.steps.contains(s))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_signs_digits_and_units() {
        let text = "30674.0 at −4.12 m, 6.83m/s, **4.98s**, 1.5 m/s², 2-3 s, v2.1x, 7 meters, id_3, 12.3m/s2 5 m/s/x";
        let seen: Vec<_> = numbers(text)
            .iter()
            .map(|n| (n.value, n.decimals, n.unit, &text[n.span.clone()]))
            .collect();
        use Unit::{Acceleration, Metre, None, Second, Speed};
        assert_eq!(
            seen,
            [
                (30674.0, 1, None, "30674.0"),
                (-4.12, 2, Metre, "−4.12 m"),
                (6.83, 2, Speed, "6.83m/s"),
                (4.98, 2, Second, "4.98s"),
                (1.5, 1, Acceleration, "1.5 m/s²"),
                (2.0, 0, None, "2"),
                (3.0, 0, Second, "3 s"),
                (7.0, 0, Metre, "7 meters"),
                (12.3, 1, Acceleration, "12.3m/s2"),
                (5.0, 0, None, "5"),
            ]
        );
    }
}
