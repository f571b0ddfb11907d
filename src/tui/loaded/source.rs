//! The source of a scenario: its XML lines, and the lines of its obstacles.

use std::collections::HashMap;
use std::ops::Range;

use nearmiss_formats::Entry;

/// The text of a scenario's file.
#[derive(Debug)]
pub struct Source {
    /// Where it was read from.
    pub file: String,
    text: String,
    /// The rows that it is shown in: the number of the line from 1, and the bytes.
    rows: Vec<(usize, Range<usize>)>,
    /// Rows of obstacles, by id.
    obstacles: HashMap<i64, usize>,
}

/// Lines from here on are shown element by element, bytes: some files are a single line.
const LONG: usize = 1000;

/// Rows are no longer than this, bytes.
const MAX_ROW_BYTES: usize = 4000;

impl Source {
    /// Reads the file of a scenario.
    ///
    /// # Errors
    /// It cannot be read, or is not XML.
    pub fn read(entry: &Entry) -> Result<Self, String> {
        Ok(Self::new(entry.display(), entry.source()?))
    }

    fn new(file: String, text: String) -> Self {
        let mut rows = Vec::new();
        let mut start = 0;
        for (number, line) in text.split('\n').enumerate() {
            let end = start + line.len();
            if line.len() <= LONG {
                rows.push((number + 1, start..end));
            } else {
                elements(&text, start..end, |part| rows.push((number + 1, part)));
            }
            start = end + 1;
        }
        let mut obstacles = HashMap::new();
        for (row, (_, bytes)) in rows.iter().enumerate() {
            for id in ids(&text[bytes.clone()]) {
                obstacles.entry(id).or_insert(row);
            }
        }
        Self {
            file,
            text,
            rows,
            obstacles,
        }
    }

    /// How many rows there are.
    #[must_use]
    pub fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Rows of it: the number of the line, and its text.
    pub fn rows(&self, range: Range<usize>) -> impl Iterator<Item = (usize, &str)> {
        let last = range.end.min(self.rows.len());
        self.rows[range.start.min(last)..last]
            .iter()
            .map(|(number, bytes)| (*number, &self.text[bytes.clone()]))
    }

    /// The row in which an obstacle's element begins.
    #[must_use]
    pub fn row_of(&self, obstacle: i64) -> Option<usize> {
        self.obstacles.get(&obstacle).copied()
    }
}

/// Cuts a long line between elements, and where there are none at its longest.
fn elements(text: &str, line: Range<usize>, mut part: impl FnMut(Range<usize>)) {
    let mut start = line.start;
    while start < line.end {
        let rest = &text[start..line.end];
        let mut end = rest
            .find("><")
            .map_or(rest.len(), |at| at + 1)
            .min(MAX_ROW_BYTES);
        while !rest.is_char_boundary(end) {
            end -= 1;
        }
        part(start..start + end);
        start += end;
    }
}

/// Ids of the obstacles whose elements begin in a row.
fn ids(row: &str) -> impl Iterator<Item = i64> + '_ {
    row.split('<').skip(1).filter_map(|tag| {
        let tag = tag.split('>').next().unwrap_or_default();
        let (name, rest) = tag.split_once(char::is_whitespace)?;
        let obstacle = name == "obstacle" || name.ends_with("Obstacle");
        let value = rest.split("id=").nth(1).filter(|_| obstacle)?;
        let digits = value.trim_start_matches(['"', '\'']);
        let end = digits.find(['"', '\'']).unwrap_or(digits.len());
        digits[..end].trim().parse().ok()
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn obstacles_are_found_by_line() {
        let text = "<commonRoad>\n<lanelet id=\"7\"/>\n <dynamicObstacle id=\"301\">\n<staticObstacle  id='4'/>\n</commonRoad>\n";
        let source = Source::new("a.xml".into(), text.into());
        assert_eq!(
            (source.row_of(301), source.row_of(4), source.row_of(7)),
            (Some(2), Some(3), None)
        );
        assert_eq!(
            source.rows(2..3).collect::<Vec<_>>(),
            [(3, " <dynamicObstacle id=\"301\">")]
        );
        assert_eq!(source.rows(90..99).count(), 0);
    }

    #[test]
    fn a_file_of_one_line_is_shown_by_elements() {
        let state = "<state><x>1</x></state>".repeat(150_000);
        let text = format!("<r>{state}<dynamicObstacle id=\"8\"></dynamicObstacle></r>");
        assert!(text.len() > 3_000_000);
        let begun = std::time::Instant::now();
        let source = Source::new("a.xml".into(), text);
        let row = source.row_of(8).unwrap();
        assert_eq!(
            source.rows(row..row + 1).next(),
            Some((1, "<dynamicObstacle id=\"8\">"))
        );
        assert!(begun.elapsed().as_secs() < 5, "{:?}", begun.elapsed());
        let plain = Source::new("b.xml".into(), "ä".repeat(5_000));
        assert!(
            plain.row_count() > 1
                && plain
                    .rows(0..9)
                    .all(|(n, row)| n == 1 && row.len() <= MAX_ROW_BYTES)
        );
    }

    #[test]
    fn bundled_scenarios_have_a_source() {
        for entry in nearmiss_formats::bundled() {
            let source = Source::read(&entry).unwrap();
            for obstacle in &entry.read().unwrap().obstacles {
                assert!(
                    source.row_of(obstacle.id).is_some(),
                    "{} {}",
                    entry.name,
                    obstacle.id
                );
            }
        }
    }
}
