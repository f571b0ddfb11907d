//! Walks through a text and resolves which obstacle and time each sentence is about, from it and the lines above.

use std::collections::BTreeSet;
use std::ops::Range;

use super::mentions::{Mention, begins_with, is_distance_to, is_label, mentions};
use super::number::{MentionedTime, Unit, heading_time, name_units, numbers, times};
use super::place::has_word;
use super::sentence::Sentence;
use super::{Claim, ClaimedValue};

/// Ids and time steps that a text can refer to.
pub struct MentionContext<'a> {
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

/// The claims of a text.
pub fn claims(text: &str, world: &MentionContext<'_>) -> Vec<Claim> {
    let mut above = Above::default();
    let mut found = Vec::new();
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        take(
            line.trim_end_matches(['\n', '\r']),
            start,
            world,
            &mut above,
            &mut found,
        );
        start += line.len();
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
        above.parted = true;
        return;
    }
    if bare.starts_with('|') && bare.len() > 1 {
        return row(line, start, world, above, found);
    }
    above.titles.clear();
    let indent = line.len() - line.trim_start().len();
    let item =
        bare.starts_with(['-', '*', '•', '+']) && !bare.starts_with("**") || is_numbered(bare);
    // The boundary between reasoning and answer ends the context, too.
    let heading = bare.starts_with('#')
        || bare.starts_with("──")
        || (bare.starts_with("**")
            && bare.trim_end_matches(':').ends_with("**")
            && bare.matches("**").count() == 2);
    let lower = lowered(line);
    let named = mentions(&lower, &numbers(line), world);
    // "Obstacle 7 analysis:" without markup.
    let titled = !item
        && indent == 0
        && bare.ends_with(':')
        && bare.len() < 60
        && matches!(named.as_slice(), [one] if begins_with(&lower, one));
    let heading = heading || titled;
    above.items.retain(|(depth, _)| !heading && *depth < indent);
    let kind = match (heading, item) {
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
    above.parted = false;
    match named.as_slice() {
        // "Obstacle 7: behind the ego." is about it until another one is: as under a heading.
        [one] if indent == 0 && is_topic(&lower, one) => above.topic(one.id),
        _ if kind == LineKind::Line && closes_topic(&lower) => above.forget(),
        _ => {}
    }
    for (from, part) in sentences(line) {
        match part {
            "{" | "}" => above.forget(),
            _ => sentence((part, start + from), world, above, found),
        }
    }
    if item && bare.trim_end_matches(['*', ' ']).ends_with(':') {
        above.items.push((indent, lower));
    }
}

/// A sentence: its claims, and whom the next one is about.
fn sentence(
    (text, start): (&str, usize),
    world: &MentionContext<'_>,
    above: &mut Above,
    found: &mut Vec<Claim>,
) {
    let lower = lowered(text);
    let mut all = numbers(text);
    name_units(&lower, &mut all);
    let named = mentions(&lower, &all, world);
    let fixed = above.fixed();
    let before = above.obstacle();
    let whole = 0..text.len();
    // The obstacle it is about, and the range of text.
    let distinct = match named.as_slice() {
        // Named twice, it is still one.
        [one, more @ ..]
            if one.id.is_some() && more.iter().all(|m| m.id == one.id && !m.compared) =>
        {
            &named[..1]
        }
        all => all,
    };
    if is_of_ego(&lower) {
        // "The ego brakes. Its speed is 5 m/s": what follows is not about an obstacle.
        above.open = true;
    }
    let about = match distinct {
        [] if has_own_subject(&lower) => None,
        [one] if is_beside(&lower, one) => None,
        [] => before.map(|id| (id, whole)),
        [one] if one.compared => before.map(|id| (id, 0..one.span.start)),
        [one] if begins_with(&lower, one) || one.id.is_some() && one.id == before => {
            if fixed != one.id {
                above.sentence = one.id;
                // Under the heading of another obstacle it is an aside, and the next sentence is about the obstacle
                // it names.
                above.open = one.id.is_none();
                if above.heading.is_some() {
                    above.sentence = None;
                }
            } else {
                above.sentence = None;
                above.open = false;
            }
            one.id.map(|id| (id, whole))
        }
        // An aside in a text about another obstacle, which the next sentence goes on about.
        [one] if before.is_some() && fixed.is_none() && is_distance_to(&lower, one) => {
            one.id.map(|id| (id, whole))
        }
        // "The distance to obstacle 7 is 3 m": its subject is the obstacle unless it has another.
        [one] => {
            above.open = before.is_some() && fixed.is_none();
            if before.is_none() && !above.open && fixed.is_none() {
                above.sentence = one.id;
            }
            let alone = before.is_none() && above.names_no_obstacle() || above.fixed() == one.id;
            let part = if is_distance_to(&lower, one) {
                whole
            } else {
                one.span.end..text.len()
            };
            one.id.filter(|_| alone).map(|id| (id, part))
        }
        _ => {
            above.sentence = None;
            above.open = fixed.is_none();
            None
        }
    };
    // "Obstacles 7 and 8 are behind the ego": what has no number holds for each.
    let listed = match about {
        None => enumerated(&lower, &named),
        Some(_) => Vec::new(),
    };
    let several = !listed.is_empty();
    let subjects: Vec<(i64, Range<usize>)> = match about {
        Some(one) => vec![one],
        None => listed.into_iter().map(|id| (id, 0..text.len())).collect(),
    };
    if subjects.is_empty() {
        return;
    }
    let (times, when) = times(&lower, &all, world);
    let when = if when == MentionedTime::Unsaid {
        above.time
    } else {
        when
    };
    let step = match when {
        MentionedTime::Unsaid => None,
        MentionedTime::Step(step) => Some(step),
        MentionedTime::Unclear => return,
    };
    let taken: Vec<bool> = all
        .iter()
        .enumerate()
        .map(|(i, n)| times.contains(&i) || (n.unit == Unit::None && n.as_integer().is_some()))
        .collect();
    let words: Vec<&str> = above
        .items
        .iter()
        .map(|(_, words)| words.as_str())
        .collect();
    for (obstacle, part) in subjects {
        let sentence = Sentence {
            lower: &lower,
            numbers: &all,
            taken: &taken,
            start,
            above: &words.join(" "),
            obstacle,
            named: !named.is_empty() && (several || named.iter().all(|m| m.id == Some(obstacle))),
            step,
        };
        let contact = times.iter().find_map(|&place| sentence.contact(place));
        let claims = sentence.claims().into_iter().chain(contact);
        let inside = |claim: &Claim| {
            let numbered = matches!(claim.stated, ClaimedValue::Number { .. });
            claim.span.start >= start + part.start
                && claim.span.end <= start + part.end
                && !(several && numbered)
        };
        found.extend(claims.filter(inside));
    }
}

/// The obstacles of a list that a sentence begins with: "Obstacles 7, 8 and 9 are …"; empty if it does not.
fn enumerated(lower: &str, named: &[Mention]) -> Vec<i64> {
    let [first, .., last] = named else {
        return Vec::new();
    };
    let between = &lower[first.span.end..last.span.start];
    let joined = between
        .split(|c: char| !c.is_alphanumeric())
        .filter(|word| !word.is_empty())
        .all(|word| {
            ["and", "obstacle", "0"].contains(&word) || word.chars().all(|c| c.is_ascii_digit())
        });
    if !joined || !begins_with(lower, first) || named.iter().any(|m| m.compared) {
        return Vec::new();
    }
    let ids: Option<Vec<i64>> = named.iter().map(|m| m.id).collect();
    ids.unwrap_or_default()
}

/// The level of a heading: 1 for `#`, more for deeper ones; lines in bold are the deepest, a boundary is above all.
fn level(bare: &str) -> usize {
    if !bare.starts_with(['#', '─', '*']) {
        return 6;
    }
    match bare.chars().take_while(|c| *c == '#').count() {
        0 if bare.starts_with("──") => 0,
        0 => 7,
        marks => marks,
    }
}

/// A row of a table: every cell is a sentence under its title.
fn row(
    line: &str,
    start: usize,
    world: &MentionContext<'_>,
    above: &mut Above,
    found: &mut Vec<Claim>,
) {
    let cells: Vec<(usize, &str)> = cells(line).collect();
    if above.titles.is_empty() {
        above.titles = cells.iter().map(|(_, cell)| lowered(cell)).collect();
        return;
    }
    let named: BTreeSet<i64> = cells
        .iter()
        .enumerate()
        .filter_map(|(i, (_, cell))| {
            let title = above.titles.get(i).map_or("", String::as_str);
            let of_obstacles = ["obstacle", "id", "vehicle"]
                .iter()
                .any(|word| title.contains(word))
                || i == 0;
            let [number] = numbers(cell).try_into().ok()?;
            number
                .as_integer()
                .filter(|id| of_obstacles && world.ids.contains(id))
        })
        .collect();
    let Some(&obstacle) = named.first().filter(|_| named.len() == 1) else {
        return;
    };
    let step = match above.time {
        MentionedTime::Unclear => return,
        MentionedTime::Step(step) => Some(step),
        MentionedTime::Unsaid => None,
    };
    for (i, (from, cell)) in cells.iter().enumerate() {
        let title = above.titles.get(i).map_or("", String::as_str);
        let mut all = numbers(cell);
        if all.len() != 1 {
            continue;
        }
        if all[0].unit == Unit::None {
            // The unit stands in the title.
            let titled = numbers(&title.replace(['(', '[', ',', '_'], " 1 "));
            let unit = titled.iter().map(|n| n.unit).find(|u| *u != Unit::None);
            all[0].unit = unit.unwrap_or(Unit::None);
        }
        if all[0].unit == Unit::None || has_word(title, "time") && !title.contains("collision") {
            continue;
        }
        let lower = lowered(cell);
        let sentence = Sentence {
            lower: &lower,
            numbers: &all,
            taken: &[false],
            start: start + from,
            above: title,
            obstacle,
            named: true,
            step,
        };
        found.extend(sentence.claims());
    }
}

/// The cells of a row with the places where they begin.
fn cells(line: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 0;
    let pieces = line.split('|').map(move |piece| {
        let from = at;
        at += piece.len() + 1;
        (from, piece)
    });
    pieces.skip(1).filter(|(_, piece)| !piece.is_empty())
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
fn lowered(text: &str) -> String {
    let lower = |c: char| {
        let mut all = c.to_lowercase();
        all.next()
            .filter(|l| all.next().is_none() && l.len_utf8() == c.len_utf8())
            .unwrap_or(c)
    };
    text.chars().map(lower).collect()
}

/// Whether a sentence begins with the ego as what it is about.
fn is_of_ego(lower: &str) -> bool {
    let bare = lower.trim_start_matches(['*', ' ', '-', '•', '#', '"', '`']);
    let begins = [
        "the ego", "ego", "our ", "my ", "we ", "the av ", "the host",
    ];
    let of = [
        "of the ego is",
        "of the ego vehicle is",
        "ego's speed",
        "ego's velocity",
        "ego's acceleration",
        "ego speed",
        "ego velocity",
        "the ego is",
        "the ego vehicle is",
        "ego brakes",
        "ego decelerates",
        "ego accelerates",
    ];
    begins.iter().any(|word| bare.starts_with(word)) || of.iter().any(|word| lower.contains(word))
}

/// Whether a sentence without a name is about something else than what stands above it.
fn has_own_subject(lower: &str) -> bool {
    const OTHERS: [&str; 32] = [
        "everything",
        "everyone",
        "everybody",
        "nothing",
        "nobody",
        "rest",
        "scene",
        "scenario",
        "others",
        "traffic",
        "leader",
        "lead",
        "nearest",
        "closest",
        "our",
        "my",
        "we",
        "host",
        "av",
        "limit",
        "truck",
        "bus",
        "cyclist",
        "bicycle",
        "pedestrian",
        "motorcycle",
        "taxi",
        "kerb",
        "curb",
        "crossing",
        "intersection",
        "driver",
    ];
    const PHRASES: [&str; 9] = [
        "safe distance is",
        "stopping distance",
        "other obstacles",
        "other vehicles",
        "vehicle ahead",
        "car ahead",
        "car cutting",
        "vehicle cutting",
        "vehicle in front",
    ];
    is_of_ego(lower)
        || OTHERS.iter().any(|word| has_word(lower, word))
        || PHRASES.iter().any(|words| lower.contains(words))
}

/// Whether a name only says where another one is: "the car in front of obstacle 7 brakes".
fn is_beside(lower: &str, one: &Mention) -> bool {
    let before = lower[..one.span.start].trim_end_matches(['*', ' ', '`', '#', '(']);
    let noun = ["obstacle", "vehicle", "car", "truck", "id"];
    let before = noun
        .iter()
        .find_map(|word| before.strip_suffix(word))
        .unwrap_or(before)
        .trim_end();
    let before = before.strip_suffix("the").unwrap_or(before).trim_end();
    let places = [
        "behind",
        "in front of",
        "ahead of",
        "next to",
        "beside",
        "following",
        "left of",
        "right of",
        "near",
    ];
    places.iter().any(|word| ends_with_word(before, word))
        && ["driver", "car", "vehicle", "truck", "one", "ego", "traffic"]
            .iter()
            .any(|word| has_word(before, word))
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

/// Context that a line gives to the lines below it.
#[derive(Default)]
pub struct Above {
    /// The obstacle that the heading names.
    pub heading: Option<i64>,
    /// The level of that heading, 1 the highest.
    level: usize,
    /// The list items that name a participant, the innermost last.
    pub named: Vec<Item>,
    /// The obstacle that the last sentence of the paragraph was about.
    pub sentence: Option<i64>,
    /// Whether a sentence of the line left open whom the next one is about.
    pub open: bool,
    /// Whether the line before was empty.
    pub parted: bool,
    pub time: MentionedTime,
    /// The list items that they stand under: indent and words.
    pub items: Vec<(usize, String)>,
    /// The titles of the table that they are in.
    pub titles: Vec<String>,
}

/// A list item that names a participant.
pub struct Item {
    indent: usize,
    /// The obstacle it is about; `None` if unclear.
    obstacle: Option<i64>,
    /// Whether items beside it without a name have the same subject.
    stays: bool,
}

impl Above {
    /// The subject of a sentence that names no participant.
    pub fn obstacle(&self) -> Option<i64> {
        if self.open {
            return None;
        }
        self.sentence.or_else(|| self.fixed())
    }

    /// The obstacle that headings and items make the subject of everything below.
    pub fn fixed(&self) -> Option<i64> {
        match self.named.last() {
            Some(item) => item.obstacle,
            None => self.heading,
        }
    }

    /// Whether no item above names an obstacle.
    pub fn names_no_obstacle(&self) -> bool {
        self.named.iter().all(|item| item.obstacle.is_none())
    }

    /// What follows is about this obstacle until another one is named so.
    fn topic(&mut self, id: Option<i64>) {
        self.heading = id;
        self.level = 7;
        self.open = false;
    }

    pub fn forget(&mut self) {
        self.heading = None;
        self.named.clear();
        self.sentence = None;
        self.open = false;
    }

    /// A heading, an item or a line without a name begins.
    pub fn begin(&mut self, kind: LineKind, indent: usize, lower: &str, named: &[Mention]) {
        self.open = false;
        match kind {
            LineKind::Heading(level) => {
                let under = self.heading.filter(|_| level > self.level);
                self.forget();
                self.heading = match named {
                    [one] if !one.compared => one.id,
                    // "**Calculations:**" under "### Obstacle 7" is about that obstacle.
                    [] if under.is_some() && !concludes(lower) => {
                        self.heading = under;
                        return;
                    }
                    _ => None,
                };
                self.level = level;
            }
            LineKind::Item => {
                self.sentence = None;
                self.named
                    .retain(|item| item.indent < indent || (item.indent == indent && item.stays));
                let beside = self.named.last().is_some_and(|item| item.indent == indent);
                let firm = self.heading.is_some();
                let next = match named {
                    [] => return,
                    [one] if one.compared => return,
                    [one] if begins_with(lower, one) => Item {
                        indent,
                        obstacle: one.id,
                        stays: !firm || is_label(lower, one),
                    },
                    [one] if one.id.is_some() && one.id == self.fixed() => return,
                    _ => Item {
                        indent,
                        obstacle: None,
                        stays: !firm && !beside,
                    },
                };
                // A participant mentioned inside an item leaves the subject of sub-items open, not of sibling items.
                if beside && next.obstacle.is_some() {
                    self.named.pop();
                }
                self.named.push(next);
            }
            LineKind::Line => {
                if self.parted {
                    self.named.retain(|item| item.indent < indent);
                }
            }
        }
    }
}

/// Kind of a line.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum LineKind {
    /// With its level, 1 the highest.
    Heading(usize),
    Item,
    Line,
}

/// Whether a heading begins what is about all obstacles.
fn concludes(lower: &str) -> bool {
    [
        "summary",
        "conclu",
        "overall",
        "final",
        "json",
        "explanation",
        "scenario",
        "all ",
        "output",
    ]
    .iter()
    .any(|word| lower.contains(word))
}
