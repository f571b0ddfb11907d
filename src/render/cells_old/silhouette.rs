//! Silhouettes of bodies in parts of blocks: covered by half, without spurs, clear of their neighbours.

/// Lines of a part in which its coverage is measured.
const LINES: usize = 4;
/// Parts around the map that a silhouette may reach.
const REACH: f64 = 2.0;
/// A part belongs to a body that covers so much of it; a little less than half, so that rounding decides nothing.
const COVERED: f64 = 0.499;
/// Silhouettes of fewer parts keep their spurs.
const MIN_PARTS_FOR_SPURS: usize = 6;

/// A place in parts of blocks, from the upper left corner of the map.
type Place = (f64, f64);

/// The parts of blocks that a body covers.
#[derive(Debug, Clone, PartialEq)]
pub struct Silhouette {
    /// The upper left part of the box; beside the map it may be negative.
    at: (i64, i64),
    columns: usize,
    rows: usize,
    /// Row by row.
    set: Vec<bool>,
}

/// How far points are moved, in parts, so that their middle lies on the corner of a part or on its middle: whichever
/// covers as many parts as the points are wide and high.
pub fn snap(places: impl Iterator<Item = Place>) -> (f64, f64) {
    let (low, high) = bounds(places);
    let by = |low: f64, high: f64| {
        let (middle, count) = (f64::midpoint(low, high), (high - low).round().max(1.0));
        let half = if count % 2.0 == 0.0 { 0.0 } else { 0.5 };
        let by = (middle - half).round() + half - middle;
        if by.is_finite() { by } else { 0.0 }
    };
    (by(low.0, high.0), by(low.1, high.1))
}

fn bounds(places: impl Iterator<Item = Place>) -> (Place, Place) {
    let none = ((f64::MAX, f64::MAX), (f64::MIN, f64::MIN));
    places.fold(none, |(low, high), (x, y)| {
        ((low.0.min(x), low.1.min(y)), (high.0.max(x), high.1.max(y)))
    })
}

impl Silhouette {
    /// The parts that rings (not closed) cover by half, on a map of so many parts.
    pub fn new(rings: &[Vec<Place>], (columns, rows): (usize, usize)) -> Self {
        let (low, high) = bounds(rings.iter().flatten().copied());
        let within = |v: f64, size: usize| v.clamp(-REACH, size as f64 + REACH);
        let from = (
            within(low.0.floor() - 1.0, columns) as i64,
            within(low.1.floor() - 1.0, rows) as i64,
        );
        let to = (
            within(high.0.ceil() + 1.0, columns) as i64,
            within(high.1.ceil() + 1.0, rows) as i64,
        );
        let count = |from: i64, to: i64| usize::try_from(to - from).unwrap_or(0);
        let mut parts = Self {
            at: from,
            columns: count(from.0, to.0),
            rows: count(from.1, to.1),
            set: Vec::new(),
        };
        let mut covered = vec![0.0; parts.columns * parts.rows];
        for ring in rings {
            parts.cover(ring, &mut covered);
        }
        parts.set = covered.iter().map(|part| *part >= COVERED).collect();
        parts
    }

    /// Adds how much of each part a ring covers, 0 to 1: exact along each of a few lines.
    fn cover(&self, ring: &[Place], covered: &mut [f64]) {
        let mut crossings: Vec<f64> = Vec::new();
        for line in 0..self.rows * LINES {
            let y = self.at.1 as f64 + (line as f64 + 0.5) / LINES as f64;
            crossings.clear();
            for (i, &(x1, y1)) in ring.iter().enumerate() {
                let (x2, y2) = ring[(i + 1) % ring.len()];
                if (y1 > y) != (y2 > y) {
                    crossings.push(x1 + (y - y1) / (y2 - y1) * (x2 - x1) - self.at.0 as f64);
                }
            }
            crossings.sort_by(f64::total_cmp);
            let row = line / LINES * self.columns;
            for pair in crossings.chunks_exact(2) {
                let most = self.columns as f64;
                let (from, to) = (pair[0].clamp(0.0, most), pair[1].clamp(0.0, most));
                for column in from as usize..(to.ceil() as usize).min(self.columns) {
                    let left = from.max(column as f64);
                    let right = to.min(column as f64 + 1.0);
                    covered[row + column] += (right - left).max(0.0) / LINES as f64;
                }
            }
        }
    }

    fn index(&self, column: i64, row: i64) -> Option<usize> {
        let column = usize::try_from(column - self.at.0).ok()?;
        let row = usize::try_from(row - self.at.1).ok()?;
        (column < self.columns && row < self.rows).then_some(row * self.columns + column)
    }

    fn has(&self, column: i64, row: i64) -> bool {
        self.index(column, row).is_some_and(|i| self.set[i])
    }

    /// All its parts: columns and rows, which may lie beside the map.
    fn parts(&self) -> impl Iterator<Item = (i64, i64)> + '_ {
        let columns = self.columns.max(1);
        let set = self.set.iter().enumerate().filter(|(_, set)| **set);
        set.map(move |(i, _)| {
            let (column, row) = (i % columns, i / columns);
            (self.at.0 + column as i64, self.at.1 + row as i64)
        })
    }

    /// Those on a map of so many parts.
    pub fn within(&self, size: (usize, usize)) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.parts().filter_map(move |(column, row)| {
            let (column, row) = (usize::try_from(column).ok()?, usize::try_from(row).ok()?);
            (column < size.0 && row < size.1).then_some((column, row))
        })
    }

    /// The same box without parts.
    pub fn emptied(&self) -> Self {
        Self {
            set: vec![false; self.set.len()],
            ..*self
        }
    }

    /// How many parts it has.
    pub fn count(&self) -> usize {
        self.set.iter().filter(|set| **set).count()
    }

    /// Adds the parts on a line between two places.
    pub fn add_line(&mut self, from: Place, to: Place) {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let steps = (dx.abs().max(dy.abs()).ceil()).clamp(1.0, 1e4) as usize;
        for step in 0..=steps {
            let part = step as f64 / steps as f64;
            let (x, y) = (from.0 + dx * part, from.1 + dy * part);
            if let Some(i) = self.index(x.floor() as i64, y.floor() as i64) {
                self.set[i] = true;
            }
        }
    }

    /// Takes off single parts that stick out, and fills single notches.
    pub fn smooth(&mut self) {
        if self.count() < MIN_PARTS_FOR_SPURS {
            return;
        }
        let before = self.clone();
        for row in 0..self.rows {
            for column in 0..self.columns {
                let (x, y) = (self.at.0 + column as i64, self.at.1 + row as i64);
                let beside = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)]
                    .iter()
                    .filter(|(x, y)| before.has(*x, *y))
                    .count();
                let part = &mut self.set[row * self.columns + column];
                *part = if *part { beside > 1 } else { beside > 2 };
            }
        }
    }

    /// Leaves the parts that another one has too.
    pub fn only_in(&mut self, other: &Self) {
        let outside = self.parts().filter(|(x, y)| !other.has(*x, *y));
        let outside: Vec<(i64, i64)> = outside.collect();
        self.without(&outside);
    }

    /// Its parts that another one has too, or that lie beside or corner to corner with it.
    pub fn touching(&self, other: &Self) -> Vec<(i64, i64)> {
        let apart = |a: i64, length: usize, b: i64| a > b + length as i64 + 1;
        let far = apart(self.at.0, other.columns, other.at.0)
            || apart(other.at.0, self.columns, self.at.0)
            || apart(self.at.1, other.rows, other.at.1)
            || apart(other.at.1, self.rows, self.at.1);
        if far {
            return Vec::new();
        }
        let near =
            |(x, y): &(i64, i64)| (-1..=1).any(|dx| (-1..=1).any(|dy| other.has(x + dx, y + dy)));
        self.parts().filter(near).collect()
    }

    /// Takes parts off.
    pub fn without(&mut self, parts: &[(i64, i64)]) {
        for (column, row) in parts {
            if let Some(i) = self.index(*column, *row) {
                self.set[i] = false;
            }
        }
    }
}

