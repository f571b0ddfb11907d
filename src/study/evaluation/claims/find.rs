//! Walks through a text and resolves which obstacle and time each sentence is about, from it and the lines above.

use std::collections::BTreeSet;
use std::ops::Range;

use super::clauses::Who;
use super::mentions::{Mention, begins_with, is_label, mentions};
use super::number::{MentionedTime, Unit, heading_time, name_units, numbers, times};
use super::reading::read;
use super::tokens::{has_word, is_foreign};
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
const LONGEST_TEXT: usize = 256 << 10;
const LONGEST_LINE: usize = 32 << 10;
pub const LONGEST_SENTENCE: usize = 4 << 10;

/// The claims of a text.
pub fn claims(text: &str, world: &MentionContext<'_>) -> Vec<Claim> {
    let text = &text[..text.floor_char_boundary(LONGEST_TEXT)];
    let mut above = Above {
        only: only_one(text, world),
        ..Above::default()
    };
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

/// The only obstacle that a text names; nothing where it names none or several.
fn only_one(text: &str, world: &MentionContext<'_>) -> Option<i64> {
    let mut only = None;
    for line in text.lines() {
        let lower = lowered(line);
        for mention in mentions(&lower, &numbers(line), world) {
            match (only, mention.id) {
                (None, _) if mention.compared => return None,
                (_, None) => return None,
                (Some(one), Some(id)) if one != id => return None,
                (_, id) => only = id,
            }
        }
    }
    only
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
    let bare_words = lower.trim_matches(['*', '#', ' ', '{', '"', '-', ':', '`']);
    let label = bare_words.split(['(', ':']).next().unwrap_or_default();
    let label = label.trim_matches(['*', ' ', '"', '_']);
    let names_ego = [
        "ego",
        "the ego",
        "ego vehicle",
        "the ego vehicle",
        "ego vehicle state",
    ]
    .contains(&label);
    let is_label =
        bare.trim_end_matches('*').ends_with([':', ')']) || heading || bare_words == label;
    above.is_of_ego = names_ego && is_label
        || above.is_of_ego && !heading && named.is_empty() && (indent > above.ego_indent || !item);
    if names_ego && is_label {
        above.ego_indent = indent;
    }
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
    let words: Vec<&str> = above
        .items
        .iter()
        .map(|(_, words)| words.as_str())
        .collect();
    let words = words.join(" ");
    let asks_place = false;
    let (claims, who) = read(
        (&lower, &all, &named, start),
        (&times, when, &above.who()),
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
    if above.time == MentionedTime::Unclear {
        return;
    }
    for (i, (from, cell)) in cells.iter().enumerate() {
        let title = above.titles.get(i).map_or("", String::as_str);
        // The unit may stand in the title.
        let titled = numbers(&title.replace(['(', '[', ',', '_'], " 1 "));
        let unit = titled.iter().map(|n| n.unit).find(|u| *u != Unit::None);
        let label = title.split(['(', '[', ',']).next().unwrap_or(title).trim();
        let is_time = has_word(title, "time") && !title.contains("collision");
        if label.is_empty()
            || is_time
            || named.len() == 1
                && numbers(cell)
                    .iter()
                    .any(|n| n.as_integer() == Some(obstacle))
        {
            continue;
        }
        // A cell is the value of a field that its title names.
        let lower = format!("{label}: {}", lowered(cell).trim());
        let mut all = numbers(&lower);
        all.retain(|number| number.span.start > label.len());
        for number in &mut all {
            if number.unit == Unit::None && !title.contains("risk") && !title.contains("score") {
                number.unit = unit.unwrap_or(Unit::None);
            }
        }
        let when = above.time;
        let (mut claims, _) = read(
            (&lower, &all, &[], 0),
            (&[], when, &Who::Obstacles(vec![obstacle])),
            ("", false),
            world,
        );
        for claim in &mut claims {
            let begin = start + from + (cell.len() - cell.trim_start().len());
            claim.span = begin..start + from + cell.trim_end().len().max(1);
            claim.named = true;
        }
        found.extend(claims);
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
    /// The only obstacle of the text.
    only: Option<i64>,
    /// Whether the line above is a label for the ego: "Ego:".
    is_of_ego: bool,
    /// The indent of that label.
    ego_indent: usize,
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

    /// Whom a sentence is about that names no participant.
    fn who(&self) -> Who {
        if self.is_of_ego {
            return Who::Ego;
        }
        match self.obstacle() {
            Some(id) => Who::Obstacles(vec![id]),
            None if self.open => Who::Unknown,
            None => self
                .only
                .map_or(Who::Unknown, |id| Who::Obstacles(vec![id])),
        }
    }

    /// The obstacle that headings and items make the subject of everything below.
    pub fn fixed(&self) -> Option<i64> {
        match self.named.last() {
            Some(item) => item.obstacle,
            None => self.heading,
        }
    }

    /// What follows is about this obstacle until another one is named so.
    fn topic(&mut self, id: Option<i64>) {
        self.heading = id;
        self.level = 7;
        self.open = false;
    }

    /// Whom the next sentence is about where it does not say, after one whose clauses are about these.
    fn follow(&mut self, clauses: &[Who], named: &[Mention]) {
        let mut ids: Vec<i64> = Vec::new();
        for who in clauses {
            match who {
                Who::Obstacles(all) => ids.extend(all),
                Who::Ego | Who::Unknown => {}
            }
        }
        let last = clauses.last();
        ids.dedup();
        let fixed = self.fixed();
        match ids.as_slice() {
            // "The ego brakes. Its speed is 5 m/s": what follows is not about an obstacle.
            // "The ego approaches 7. It brakes": the one that it meets.
            _ if clauses.first() == Some(&Who::Ego) => {
                let mut all = named.iter().filter_map(|m| m.id);
                self.sentence = all.next().filter(|_| all.next().is_none());
                self.open = self.sentence.is_none();
            }
            _ if named.iter().any(|m| m.id.is_none() && !m.compared) => {
                self.sentence = None;
                self.open = true;
            }
            [] if last == Some(&Who::Unknown) => {}
            [] => {}
            [id] if fixed == Some(*id) => {
                self.sentence = None;
                self.open = false;
            }
            // Under the heading of another obstacle it is an aside.
            [_] if self.heading.is_some() => self.sentence = None,
            [id] => {
                // "7 is behind 8. It brakes": which of both is not told.
                let is_with = |m: &Mention| m.id.is_some_and(|other| other != *id) && !m.compared;
                let is_open = fixed.is_none() && named.iter().any(is_with);
                self.sentence = Some(*id).filter(|_| !is_open);
                self.open = is_open;
            }
            _ => {
                self.sentence = None;
                self.open = fixed.is_none();
            }
        }
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
