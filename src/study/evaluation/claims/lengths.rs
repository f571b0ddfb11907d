//! Whether a length is that to the other, to something else, or to a place that stands behind it.

use super::Side;
use super::clauses::Who;
use super::find::ends_with_word;
use super::number::Number;
use super::places::{PLACES, Placed};
use super::references::Named;
use super::sentence::Sentence;

impl Sentence<'_> {
    /// The place that stands right behind a length: along the ego's heading, across it, or both.
    pub(super) fn place_behind(&self, number: &Number) -> Option<Option<bool>> {
        let side = self.side_behind(number)?;
        Some(match (side.front, side.left) {
            (Some(_), None) => Some(true),
            (None, Some(_)) => Some(false),
            _ => None,
        })
    }

    /// The place that stands right behind a length.
    pub(super) fn side_behind(&self, number: &Number) -> Option<Side> {
        let at = self
            .tokens
            .iter()
            .position(|t| t.span.start >= number.span.end)?;
        let skipped = (at..at + 3)
            .take_while(|i| {
                *i == at
                    || self.tokens.get(i - 1).is_some_and(|t| {
                        t.word.ends_with("ly") || t.is("straight right further or so (")
                    })
            })
            .find_map(|i| Some((PLACES.at(self.tokens, i)?, i)));
        let ((Placed::At(side) | Placed::Field(side), end), _) = skipped? else {
            return None;
        };
        // "3 m in front of car 7", "3 m left lane".
        let follows = self.tokens.get(end);
        let is_other = self.references.iter().any(|r| {
            r.at.start <= end + 1
                && r.at.end > end
                && !matches!(r.who, Named::Ego)
                && self.tokens[end..r.at.start.max(end)]
                    .iter()
                    .all(|t| t.is("of the a"))
        });
        let is_mirrored = self
            .clause(number.span.start)
            .is_some_and(|clause| clause.who == Who::Ego);
        if follows.is_some_and(|t| t.is("lane side")) || is_other && !is_mirrored {
            return None;
        }
        Some(side)
    }

    /// Whether a length is plainly that to the other: "at 54 m", "within 5 m", "12 m clear", or all that a field says.
    pub(super) fn is_range(&self, near: &str, after: &str) -> bool {
        let bare = near.trim_end_matches(['*', ' ', '`', '~', '≈', '"']);
        const ROUGHLY: [&str; 20] = [
            "less than",
            "more than",
            "under",
            "over",
            "at least",
            "still",
            "another",
            "now",
            "about",
            "around",
            "roughly",
            "only",
            "just",
            "some",
            "approximately",
            "like",
            "something",
            "maybe",
            "almost",
            "barely",
        ];
        let mut bare = bare;
        while let Some(rest) = ROUGHLY.iter().find_map(|word| {
            let rest = bare.strip_suffix(word)?;
            (!rest.ends_with(char::is_alphanumeric)).then_some(rest)
        }) {
            bare = rest.trim_end();
        }
        let begins = bare.trim_start_matches(['-', ' ', '*']).is_empty()
            || bare.ends_with([',', ':', '(', '—', '–', '|', ';']);
        let words = [
            "at",
            "with",
            "by",
            "to within",
            "within",
            "closer than",
            "nearer than",
            "is",
            "under",
            "only",
            "sits",
            "remains",
            "stays",
            "now",
            "leaves",
            "leaving",
            "holds",
            "closed to",
            "dropped to",
            "fell to",
            "fallen to",
            "down to",
            "shrunk to",
            "shrank to",
            "grown to",
            "come to",
        ];
        let ends = |text: &str, words: &[&str]| words.iter().any(|word| ends_with_word(text, word));
        let first = after
            .split(|c: char| !c.is_alphanumeric())
            .next()
            .unwrap_or_default();
        let follows = [
            "away",
            "off",
            "apart",
            "back",
            "clear",
            "out",
            "from",
            "ahead",
            "behind",
            "in",
            "to",
            "on",
            "at",
            "over",
            "margin",
            "gap",
            "distance",
            "clearance",
            "of",
            "between",
            "lateral",
            "laterally",
        ]
        .contains(&first);
        const GOES_ON: [&str; 13] = [
            "maybe", "or", "is", "was", "and", "with", "yet", "but", "which", "while", "so",
            "already", "now",
        ];
        let is_last = after.is_empty()
            || GOES_ON.contains(&first)
            || after.starts_with(['.', ',', ';', ')', '|', '"', '!', '(', '—', '–']);
        let is_to_one = first == "to"
            && after.split_whitespace().nth(1).is_some_and(|word| {
                ["the", "it", "obstacle", "car", "vehicle", "truck"].contains(&word)
                    || word.starts_with(|c: char| c.is_ascii_digit())
            });
        let is_noun = [
            "gap",
            "distance",
            "clearance",
            "separation",
            "headway",
            "margin",
        ]
        .contains(&first);
        // "3 m away from the kerb".
        let from = after
            .find("from ")
            .filter(|at| *at < 8)
            .map(|at| &after[at + "from ".len()..]);
        let is_of_another = from.is_some_and(|rest| {
            let rest = rest.strip_prefix("the ").unwrap_or(rest);
            ![
                "ego",
                "us",
                "me",
                "our",
                "my",
                "you",
                "it",
                "bumper",
                "car",
                "vehicle",
                "pedestrian",
                "truck",
                "lorry",
                "bus",
                "cyclist",
                "bicycle",
                "motorcycle",
            ]
            .iter()
            .any(|word| rest.starts_with(word))
        });
        if is_of_another {
            return false;
        }
        is_to_one
            || is_noun
            || follows
                && !["in", "on", "to"].contains(&first)
                && ends(
                    bare,
                    &[
                        "is", "are", "was", "were", "at", "sits", "be", "drives", "stands", "just",
                        ",",
                    ],
                )
            || begins && (is_last || follows)
            || ends(bare, &words) && (is_last || follows || first == "and" || first == "with")
    }

    /// Whether a length is that to something else than the ego or the obstacle: "the distance to the kerb".
    pub(super) fn is_to_another(&self, near: &str, end: usize) -> bool {
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
        let named = end - to.len();
        let is_named = self.references.iter().any(|r| {
            let first = &self.tokens[r.at.start].span;
            let last = &self.tokens[r.at.end - 1].span;
            first.start <= named && named < last.end
        });
        !word.is_empty() && !known.contains(&word) && word.parse::<f64>().is_err() && !is_named
    }
}
