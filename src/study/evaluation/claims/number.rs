//! Numbers with units in text, which axis of the ego they are about, and times with the steps they denote.

use std::ops::Range;

use super::find::{MentionContext, ends_with_word};
use super::place::has_word;

/// The unit behind a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    None,
    Metre,
    Second,
    Speed,
    Acceleration,
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
    ("km/h", Unit::Other),
    ("mph", Unit::Other),
    ("meters", Unit::Metre),
    ("metres", Unit::Metre),
    ("meter", Unit::Metre),
    ("metre", Unit::Metre),
    ("seconds", Unit::Second),
    ("second", Unit::Second),
    ("secs", Unit::Second),
    ("sec", Unit::Second),
    ("ms", Unit::Other),
    ("km", Unit::Other),
    ("cm", Unit::Other),
    ("rad", Unit::Other),
    ("degrees", Unit::Other),
    ("°", Unit::Other),
    ("%", Unit::Other),
    ("m", Unit::Metre),
    ("s", Unit::Second),
];

/// What TeX may have between a number and its unit.
const TEX: &[&str] = &["\\,", "\\;", "\\ ", "\\text{", "\\mathrm{", "\\"];

/// Names of quantities whose unit goes without saying.
const NAMED: &[(&[&str], Unit)] = &[
    (&["velocity", "speed"], Unit::Speed),
    (&["acceleration", "deceleration"], Unit::Acceleration),
    (&["dtclong", "dtclat"], Unit::Metre),
    (&["ttclong", "ttclat"], Unit::Second),
];

/// Gives numbers without a unit that of the quantity whose name stands right before them: "velocity (2.743)",
/// "DTClat is 0.0"; `lower` is the text in lower case. A whole number may be an id or a score.
pub fn name_units(lower: &str, all: &mut [Number]) {
    for number in all {
        if number.unit != Unit::None || number.decimals == 0 {
            continue;
        }
        let markup = ['*', ' ', '`', ':', '=', '('];
        let before = lower[..number.span.start].trim_end_matches(markup);
        let before = [" is", " of"]
            .iter()
            .find_map(|word| before.strip_suffix(word))
            .unwrap_or(before);
        let named = |(names, _): &&(&[&str], Unit)| {
            names.iter().any(|name| {
                let rest = before.strip_suffix(name);
                rest.is_some_and(|rest| !rest.ends_with(char::is_alphanumeric))
            })
        };
        if let Some((_, unit)) = NAMED.iter().find(named) {
            number.unit = *unit;
        }
    }
}

/// All numbers of a text, in its order.
pub fn numbers(text: &str) -> Vec<Number> {
    let bytes = text.as_bytes();
    let mut found = Vec::new();
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
                found.push(Number {
                    value: sign * value,
                    decimals,
                    unit,
                    span: start..stop,
                });
            }
        }
        at = end;
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

/// Whether a number is where a change begins: "from 5 m to 3 m"; "approaching from behind" says nothing of numbers.
pub fn from_number(lower: &str) -> bool {
    lower.match_indices("from ").any(|(at, word)| {
        let rest = lower[at + word.len()..].trim_start_matches(['*', '~', '-', '−', '+', '`', ' ']);
        let begins = !lower[..at].ends_with(char::is_alphanumeric);
        begins && rest.starts_with(|c: char| c.is_ascii_digit())
    })
}

/// A text without the ego where something is only told relative to it: "closing in on the ego at".
pub fn without_reference(text: &str) -> String {
    let mut text = text.replace("the ego", "ego").replace("towards", "toward");
    for before in [
        "toward",
        "from",
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
    let after = after.strip_prefix("relative ").unwrap_or(after);
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
    let long = last(&["longitudinal", "_long", "dtclong", "ttclong", "vrellong"]);
    let lat = last(&["lateral", "_lat", "dtclat", "ttclat", "vrellat"]);
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

/// Which numbers are times, and the step that they name.
pub fn times(
    lower: &str,
    all: &[Number],
    world: &MentionContext<'_>,
) -> (Vec<usize>, MentionedTime) {
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
        let ago = world.now.is_some() && is_ago(after);
        let timed = counted
            || leads
            || ago
            || ["at", "t", "time", "at around", "at about", "by"]
                .iter()
                .any(|word| ends_with_word(before, word));
        let named = match number.unit {
            Unit::Second if ago => step_at(-number.value.abs(), world),
            Unit::Second if timed => step_at(number.value, world),
            // "Step 1" of an answer that was told no time steps is one of its reasoning.
            Unit::None if world.now.is_some() && number.decimals == 0 => continue,
            Unit::None if counted && number.decimals == 0 => {
                number.as_integer().filter(|s| world.steps.contains(s))
            }
            Unit::None if counted => step_at(number.value, world),
            _ => continue,
        };
        places.push(place);
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
    match when {
        // "timestep 6.5s - 7.3s", "timesteps 3 to 9"
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
    let steps = (seconds / world.dt).round();
    let near = (steps * world.dt - seconds).abs() < 0.1 * world.dt;
    let step = (steps as i64).saturating_add(world.now.unwrap_or(0));
    let told = world.now.is_none_or(|now| step <= now);
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
