//! Whom the lines above a sentence make it about: headings, items, and sentences before it.

use super::clauses::{Spoken, Who};
use super::mentions::{Mention, begins_with, is_label};
use super::number::MentionedTime;

/// The level of a heading in bold, below all that are marked as headings.
pub const BOLD: usize = 7;

/// Context that a line gives to the lines below it.
#[derive(Default)]
pub struct Above {
    /// The obstacle that the heading names.
    heading: Option<i64>,
    /// The level of that heading, 1 the highest.
    level: usize,
    /// The level of the last marked heading that is no part of what is about one obstacle; 0 before any.
    section: usize,
    /// The heading of a part of what is about one obstacle, in lower case.
    part: String,
    /// Whether what is about the obstacle of the heading has parts with headings of their own.
    has_parts: bool,
    /// Whether obstacles have headings without such parts.
    is_flat: bool,
    /// The list items that name a participant, the innermost last.
    pub named: Vec<Item>,
    /// The obstacle that the last sentence of the paragraph was about.
    pub sentence: Option<i64>,
    /// The only obstacle of the text.
    only: Option<i64>,
    /// The only two.
    both: Option<[i64; 2]>,
    /// Whether the line above is a label for the ego: "Ego:".
    pub is_of_ego: bool,
    /// The indent of that label; `None` of a heading.
    ego_indent: Option<usize>,
    /// Whether a sentence of the line left open whom the next one is about.
    pub open: bool,
    /// Whether it did so because it was about the ego.
    is_after_ego: bool,
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
    pub indent: usize,
    /// The obstacle it is about; `None` if unclear.
    obstacle: Option<i64>,
    /// Whether items beside it without a name have the same subject.
    stays: bool,
}

impl Above {
    /// Of a text that names these obstacles, each once.
    pub fn new(named: Vec<i64>) -> Self {
        Self {
            only: <[i64; 1]>::try_from(named.as_slice()).ok().map(|[id]| id),
            both: named.try_into().ok(),
            ..Self::default()
        }
    }

    /// The subject of a sentence that names no participant.
    fn obstacle(&self) -> Option<i64> {
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

    /// Of whom the next sentence speaks, so far as the text before it tells.
    pub fn spoken(&self) -> Spoken {
        // After a sentence about the ego, "the obstacle" is still the one that all of it is about.
        let is_known = !self.open || self.is_after_ego;
        let noun = { self.sentence.or_else(|| self.fixed()).or(self.only) }.filter(|_| is_known);
        Spoken {
            current: self.who(),
            noun,
            both: self.both,
        }
    }

    /// The obstacle that headings and items make the subject of everything below.
    fn fixed(&self) -> Option<i64> {
        match self.named.last() {
            Some(item) => item.obstacle,
            None => self.heading,
        }
    }

    /// The words of what a sentence stands under.
    pub fn words(&self) -> String {
        let items = self.items.iter().map(|(_, words)| words.as_str());
        let all: Vec<&str> = std::iter::once(self.part.as_str()).chain(items).collect();
        all.join(" ")
    }

    /// What follows is about this obstacle until another one is named so.
    pub fn topic(&mut self, id: Option<i64>) {
        self.heading = id;
        self.level = BOLD + 1;
        self.open = false;
    }

    /// A label that names the ego makes what follows about it, and a heading or a name ends that.
    pub fn name_ego(
        &mut self,
        (bare, lower): (&str, &str),
        (heading, item): (bool, bool),
        indent: usize,
        is_nameless: bool,
    ) {
        let words = lower.trim_matches(['*', '#', ' ', '{', '"', '-', ':', '`', '•', '+']);
        let numbered = words.trim_start_matches(|c: char| c.is_ascii_digit());
        let words = match numbered.strip_prefix(['.', ')']) {
            Some(rest) => rest.trim_start_matches(['*', ' ']),
            None => words,
        };
        let label = words.split(['(', ':']).next().unwrap_or_default();
        let label = label.trim_matches(['*', ' ', '"', '_']);
        let is_label =
            bare.trim_end_matches('*').ends_with([':', ')']) || heading || words == label;
        let names_ego = is_label && is_ego(label);
        let is_below = self.ego_indent.is_none_or(|own| indent > own) || !item;
        self.is_of_ego = names_ego || self.is_of_ego && !heading && is_nameless && is_below;
        if names_ego {
            self.ego_indent = Some(indent).filter(|_| !heading);
        }
    }

    /// Whom the next sentence is about where it does not say, after one whose clauses are about these.
    pub fn follow(&mut self, clauses: &[Who], named: &[Mention]) {
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
        let was_open = self.open && !self.is_after_ego;
        self.is_after_ego = false;
        match ids.as_slice() {
            // "The ego brakes. Its speed is 5 m/s": what follows is not about an obstacle.
            // "The ego approaches 7. It brakes": the one that it meets.
            _ if clauses.first() == Some(&Who::Ego) => {
                let mut all = named.iter().filter_map(|m| m.id);
                self.sentence = all.next().filter(|_| all.next().is_none());
                self.open = self.sentence.is_none();
                self.is_after_ego = self.open && !was_open && named.is_empty();
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
        self.is_after_ego = false;
        self.part.clear();
    }

    /// Whether a heading of this level without a name is that of a part of what is about the obstacle of the last one.
    fn is_part(&self, level: usize) -> bool {
        // Under "## Obstacles", "**Obstacle 7**" may have "### Motion" and "**Motion**" as its own.
        let is_own = level == BOLD && !self.is_flat || (1..level).contains(&self.section);
        level > self.level || self.level == BOLD && is_own
    }

    fn begin_heading(&mut self, level: usize, lower: &str, named: &[Mention]) {
        let (before, is_part) = (self.heading, self.is_part(level));
        // Under "### Obstacle 7", "**Overall risk:**" is of that obstacle.
        let is_inner = level == BOLD && (1..BOLD).contains(&self.level) && is_inner(lower);
        self.forget();
        match named {
            [one] if !one.compared => {
                self.is_flat |= before.is_some() && !self.has_parts;
                self.has_parts = false;
                self.heading = one.id;
            }
            // "**Calculations:**" under "### Obstacle 7" is about that obstacle.
            [] if before.is_some() && is_part && (is_inner || !concludes(lower)) => {
                self.heading = before;
                self.has_parts = true;
                if !lower.contains(|c: char| c.is_ascii_digit()) {
                    self.part = lower.into();
                }
                return;
            }
            _ => {}
        }
        self.level = level;
        if level < BOLD {
            self.section = level;
        }
    }

    /// A heading, an item or a line without a name begins.
    pub fn begin(&mut self, kind: LineKind, indent: usize, lower: &str, named: &[Mention]) {
        self.open = false;
        self.is_after_ego = false;
        match kind {
            LineKind::Heading(level) => self.begin_heading(level, lower, named),
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

/// Whether a label in lower case is of the ego: "ego vehicle", "the ego's state at 2.4 seconds".
fn is_ego(label: &str) -> bool {
    const NOUNS: &str = "vehicle car agent state status data information info details analysis position motion dynamics \
        behavior behaviour trajectory kinematics overview";
    let label = label
        .split(" at ")
        .next()
        .unwrap_or(label)
        .replace("'s", "");
    let label = label.strip_prefix("the ").unwrap_or(&label);
    let mut words = label.split_whitespace();
    words.next() == Some("ego") && words.all(|word| NOUNS.split(' ').any(|noun| noun == word))
}

/// Whether a heading in bold ends what is about one obstacle: "overall risk", "conclusion".
fn is_inner(lower: &str) -> bool {
    let says = |words: &[&str]| words.iter().any(|word| lower.contains(word));
    says(&["overall", "conclu", "final"])
        && !says(&[
            "summary",
            "scenario",
            "json",
            "obstacles",
            "output",
            "recommend",
        ])
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
        "critical",
        "findings",
        "obstacles",
        "recommend",
    ]
    .iter()
    .any(|word| lower.contains(word))
}
