//! Walks through a text and resolves which obstacle and time each sentence is about, from it and the lines above.

use std::collections::BTreeSet;
use std::ops::Range;

use super::above::{Above, BOLD, LineKind};
use super::mentions::{Mention, begins_with, mentions};
use super::number::{MentionedTime, heading_time, name_units, numbers, times};
use super::reading::read;
use super::tables::{row, separator};
use super::tokens::is_foreign;
use super::{Claim, Subject};

/// Ids and time steps that a text can refer to.
pub struct MentionContext<'a> {
    /// What the text is about; without it nobody is found by a description.
    pub subject: Option<&'a Subject<'a>>,
    /// The step that is meant where none is named.
    pub present: i64,
    /// Whether a trajectory came with the text: what the ego is to do is held against it.
    pub has_trajectory: bool,
    /// Ids of the obstacles.
    pub ids: &'a BTreeSet<i64>,
    /// The ego's id, which no obstacle has.
    pub ego: i64,
    /// Seconds of a time step.
    pub dt: f64,
    /// The steps of the recording.
    pub steps: Range<i64>,
    /// The step that times are relative to; `None` where they count from time step 0.
    pub now: Option<i64>,
}

/// Of a text so much is read, of a line and of a sentence so much, bytes: nobody writes longer ones, but servers send them.
pub const LONGEST_TEXT: usize = 256 << 10;
const LONGEST_LINE: usize = 32 << 10;
pub const LONGEST_SENTENCE: usize = 4 << 10;

/// The claims of a text.
pub fn claims(text: &str, world: &MentionContext<'_>) -> Vec<Claim> {
    let text = &text[..text.floor_char_boundary(LONGEST_TEXT)];
    let mut named = named_in(text, world);
    // "The obstacle" of a scene that has one.
    if named.is_empty() && world.ids.len() == 1 {
        named.extend(world.ids);
    }
    let mut above = Above::new(named);
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        if line.len() <= LONGEST_LINE {
            take(
                line.trim_end_matches(['\n', '\r']),
                start,
                world,
                &mut above,
                &mut found,
            );
        }
        start += line.len();
    }
    found
}

/// The obstacles that a text names, each once; none where it names one that is not there, or begins with one that is only
/// compared with.
fn named_in(text: &str, world: &MentionContext<'_>) -> Vec<i64> {
    let mut found = Vec::new();
    for line in text.lines() {
        let lower = lowered(line);
        for mention in mentions(&lower, &numbers(line), world) {
            match mention.id {
                Some(id) if !(found.is_empty() && mention.compared) => {
                    if !found.contains(&id) {
                        found.push(id);
                    }
                }
                _ => return Vec::new(),
            }
        }
    }
    found
}

fn take(
    line: &str,
    start: usize,
    world: &MentionContext<'_>,
    above: &mut Above,
    found: &mut Vec<Claim>,
) {
    let bare = line.trim();
    if bare.is_empty() {
        above.titles.clear();
        above.sentence = None;
        above.is_of_ego = false;
        above.parted = true;
        return;
    }
    if let Some(separator) = separator(line, &above.titles) {
        return row((line, separator, start), world, above, found);
    }
    above.titles.clear();
    let indent = line.len() - line.trim_start().len();
    let item =
        bare.starts_with(['-', '*', '•', '+']) && !bare.starts_with("**") || is_numbered(bare);
    // The boundary between reasoning and answer ends the context, too.
    let is_bold = bare.starts_with("**")
        && bare.trim_end_matches(':').ends_with("**")
        && bare.matches("**").count() == 2;
    // Inside an item that names a participant, a line in bold is the label of what follows there.
    let is_inner = is_bold && above.named.iter().any(|item| item.indent < indent);
    let heading = bare.starts_with('#') || bare.starts_with("──") || is_bold && !is_inner;
    let lower = lowered(line);
    let named = mentions(&lower, &numbers(line), world);
    // "Obstacle 7 analysis:" without markup.
    let titled = !item
        && indent == 0
        && bare.ends_with(':')
        && bare.len() < 60
        && matches!(named.as_slice(), [one] if begins_with(&lower, one));
    let heading = heading || titled;
    let depth = indent - usize::from(is_inner);
    above.items.retain(|(other, _)| !heading && *other < depth);
    let kind = match (heading, item || is_inner) {
        (true, _) => LineKind::Heading(level(bare)),
        (_, true) => LineKind::Item,
        _ => LineKind::Line,
    };
    if heading {
        above.time = heading_time(&lower, line, world, above.time);
    } else if !item && named.is_empty() && bare.len() < 40 && bare.ends_with(':') {
        // "At t = 2.7 s:" stands above what follows, like a heading.
        if let (_, time @ MentionedTime::Step(_)) = times(&lower, &numbers(line), world) {
            above.time = time;
        }
    }
    above.begin(kind, indent, &lower, &named);
    above.name_ego((bare, &lower), (heading, item), indent, named.is_empty());
    above.parted = false;
    match named.as_slice() {
        // "Obstacle 7: behind the ego." is about it until another one is: as under a heading.
        [one] if indent == 0 && !heading && is_topic(&lower, one) => above.topic(one.id),
        _ if kind == LineKind::Line && closes_topic(&lower) => above.forget(),
        _ => {}
    }
    for (from, part) in sentences(line) {
        match part {
            "{" | "}" => above.forget(),
            _ => sentence((part, start + from), world, above, found),
        }
    }
    if (item || is_inner) && bare.trim_end_matches(['*', ' ']).ends_with(':') {
        above.items.push((depth, lower));
    }
}

/// A sentence: its claims, and whom the next one is about.
fn sentence(
    (text, start): (&str, usize),
    world: &MentionContext<'_>,
    above: &mut Above,
    found: &mut Vec<Claim>,
) {
    if text.len() > LONGEST_SENTENCE {
        above.open = true;
        return;
    }
    let lower = lowered(text);
    let mut all = numbers(text);
    name_units(&lower, &mut all);
    let named = mentions(&lower, &all, world);
    if is_foreign(&lower) {
        above.open = true;
        return;
    }
    let (times, when) = times(&lower, &all, world);
    let when = if when == MentionedTime::Unsaid {
        above.time
    } else {
        when
    };
    let words = above.words();
    let asks_place = false;
    let (claims, who) = read(
        (&lower, &all, &named, start),
        (&times, when, &above.spoken()),
        (&words, asks_place),
        world,
    );
    found.extend(claims);
    above.follow(&who, &named);
}

/// The level of a heading: 1 for `#`, more for deeper ones; lines in bold are the deepest, a boundary is above all.
fn level(bare: &str) -> usize {
    if !bare.starts_with(['#', '─', '*']) {
        return 6;
    }
    match bare.chars().take_while(|c| *c == '#').count() {
        0 if bare.starts_with("──") => 0,
        0 => BOLD,
        marks => marks,
    }
}

/// Sentences of a line with the places where they begin; braces of JSON stand alone.
pub fn sentences(line: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    let mut from = 0;
    // In formulas braces stand around units.
    let tex = ["\\text", "\\frac", "\\approx", "\\("]
        .iter()
        .any(|command| line.contains(command));
    let mut chars = line.char_indices().peekable();
    while let Some((at, c)) = chars.next() {
        let next = chars.peek().map(|(_, c)| *c);
        let ends = match c {
            '{' | '}' => !tex,
            ';' => true,
            '.' | '!' | '?' => next.is_none_or(|n| n == ' ' || n == '*' || n == '"'),
            _ => false,
        };
        if !ends {
            continue;
        }
        let end = at + c.len_utf8();
        if matches!(c, '{' | '}') {
            found.push((from, &line[from..at]));
            found.push((at, &line[at..end]));
        } else {
            found.push((from, &line[from..end]));
        }
        from = end;
    }
    found.push((from, &line[from..]));
    found.retain(|(_, part)| !part.trim().is_empty());
    found
}

/// Whether a text ends with a word, not with a part of another.
pub fn ends_with_word(text: &str, word: &str) -> bool {
    text.strip_suffix(word)
        .is_some_and(|rest| !rest.ends_with(char::is_alphanumeric))
}

fn is_numbered(bare: &str) -> bool {
    let digits = bare.trim_start_matches(|c: char| c.is_ascii_digit());
    digits.len() < bare.len() && digits.starts_with(['.', ')']) && digits[1..].starts_with(' ')
}

/// In lower case, with every character where it was.
pub fn lowered(text: &str) -> String {
    let lower = |c: char| {
        let mut all = c.to_lowercase();
        all.next()
            .filter(|l| all.next().is_none() && l.len_utf8() == c.len_utf8())
            .unwrap_or(c)
    };
    text.chars().map(lower).collect()
}

/// Whether a line begins with a name and a colon behind it, at most with a few words in between: "Obstacle 7 (car): …".
fn is_topic(lower: &str, one: &Mention) -> bool {
    let rest = lower[one.span.end..].trim_start_matches(['*', ' ', '`']);
    let Some((label, _)) = rest.split_once(':') else {
        return false;
    };
    begins_with(lower, one) && label.len() < 30 && !label.contains(['.', ',', ';'])
}

/// Whether a line goes on about all of it.
fn closes_topic(lower: &str) -> bool {
    let bare = lower.trim_start_matches(['*', ' ', '#']);
    [
        "ego",
        "the ego",
        "overall,",
        "in summary",
        "in conclusion",
        "conclusion",
        "summary",
        "therefore",
        "based on",
        "final",
        "all other",
        "the other obstacles",
        "other obstacles",
        "none of",
        "after analy",
        "considering all",
        "given the",
    ]
    .iter()
    .any(|words| bare.starts_with(words))
}
