//! Context a line of text gives to the lines below it: its obstacles, and its time.

use super::mentions::{Mention, begins_with, is_label};
use super::times::MentionedTime;

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
