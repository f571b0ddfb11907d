//! Safe windows that are like dangerous ones: an assignment of least distance.

use pathfinding::kuhn_munkres::{Weights, kuhn_munkres};
use rayon::prelude::*;

/// What windows are matched on, in words for reports.
pub const MATCHED_ON: &str = "number of steps (equal), last step, obstacles near the ego at any and at every step, and \
                              speed of the ego";

/// A window as the matching sees it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Candidate {
    /// Its last step.
    pub last: i64,
    /// How many steps it has.
    pub steps: usize,
    /// Obstacles that are near at one of its steps.
    pub obstacles: usize,
    /// Obstacles near, summed over its steps: the rows of a description.
    pub rows: usize,
    /// The ego's speed at its end, m/s.
    pub speed: f64,
}

/// Differences that weigh as much as each other: ten steps, an obstacle, ten rows, 2 m/s.
const SCALES: [f64; 4] = [10.0, 1.0, 10.0, 2.0];

impl Candidate {
    fn features(&self) -> [f64; 4] {
        [
            self.last as f64,
            self.obstacles as f64,
            self.rows as f64,
            self.speed,
        ]
    }

    /// The sum of squared differences, each on its scale.
    fn distance(&self, other: &Self) -> f64 {
        let (a, b) = (self.features(), other.features());
        let pairs = SCALES.iter().zip(a.iter().zip(b));
        pairs.map(|(scale, (a, b))| ((a - b) / scale).powi(2)).sum()
    }
}

/// A safe window: the source it is from, and the target that it is like.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Match {
    pub target: usize,
    pub source: usize,
    pub window: Candidate,
}

/// A recording that safe windows are taken from.
pub(super) struct Source {
    /// Its windows, of every number of steps that a target has.
    pub pool: Vec<Candidate>,
    /// The target from the same recording.
    pub target: Option<usize>,
    /// Whether the recording is a collision, so that its safe windows are those long before.
    pub collides: bool,
}

/// What it adds to a distance that a window is from a collision, and from the one that the target is of.
const COLLISION: f64 = 1.0;
const SAME: f64 = 9.0;

/// After the first round a match may be so far apart: twice on one scale.
const CALIPER: f64 = 4.0;

/// Safe windows for the targets: one for each, and where there are many more safe recordings than targets one more for
/// each, as often as all of these are near.
///
/// A source is taken once, or where there are fewer of them than targets so often that every target has a match; no
/// window is taken twice. In each round sources and targets are assigned to each other so that the sum of distances is
/// least: H. W. Kuhn, "The Hungarian method for the assignment problem", Naval Research Logistics Quarterly 2 (1955).
pub(super) fn matched(targets: &[Candidate], sources: &[Source]) -> Vec<Match> {
    if targets.is_empty() || sources.is_empty() {
        return Vec::new();
    }
    // Most sources are taken once: what is nearest then need not be looked for in every round.
    let first: Vec<Vec<Option<Near>>> = (0..targets.len())
        .into_par_iter()
        .map(|at| {
            let near = |source| nearest(targets, at, source, &[]);
            sources.iter().map(near).collect()
        })
        .collect();
    let mut found: Vec<Match> = Vec::new();
    let every: Vec<usize> = (0..sources.len()).collect();
    let mut open: Vec<usize> = (0..targets.len()).collect();
    let mut unused = every.clone();
    while !open.is_empty() {
        let columns = if unused.is_empty() { &every } else { &unused };
        let round = assigned(&open, columns, |target, source| {
            let taken: Vec<Candidate> = source_windows(&found, source);
            if taken.is_empty() {
                first[target][source]
            } else {
                nearest(targets, target, &sources[source], &taken)
            }
        });
        if round.is_empty() {
            break;
        }
        open.retain(|target| !round.iter().any(|(_, one)| one.target == *target));
        unused.retain(|source| !round.iter().any(|(_, one)| one.source == *source));
        found.extend(round.into_iter().map(|(_, one)| one));
    }
    unused.retain(|source| !sources[*source].collides);
    let all: Vec<usize> = (0..targets.len()).collect();
    while unused.len() >= targets.len() {
        let round = assigned(&all, &unused, |target, source| first[target][source]);
        if round.len() < targets.len() || round.iter().any(|(distance, _)| *distance > CALIPER) {
            break;
        }
        unused.retain(|source| !round.iter().any(|(_, one)| one.source == *source));
        found.extend(round.into_iter().map(|(_, one)| one));
    }
    found
}

/// The window that is most like one of the targets with as many steps.
pub(super) fn nearest_to_any(targets: &[Candidate], pool: &[Candidate]) -> Option<Candidate> {
    let pairs = pool.iter().flat_map(|one| {
        let alike = targets.iter().filter(|target| target.steps == one.steps);
        alike.map(move |target| (one.distance(target), *one))
    });
    let nearest = pairs.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(_, one)| one)
}

fn source_windows(found: &[Match], source: usize) -> Vec<Candidate> {
    let of = found.iter().filter(|one| one.source == source);
    of.map(|one| one.window).collect()
}

/// A window, and how far it is from a target.
type Near = (f64, Candidate);

/// The window of a source that is most like a target and not taken.
fn nearest(targets: &[Candidate], at: usize, source: &Source, taken: &[Candidate]) -> Option<Near> {
    let target = &targets[at];
    let free = source
        .pool
        .iter()
        .filter(|one| one.steps == target.steps && !taken.contains(one));
    let near = free.map(|one| (one.distance(target), *one));
    let (distance, window) = near.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let more = match (source.collides, source.target == Some(at)) {
        (_, true) => SAME,
        (true, false) => COLLISION,
        (false, false) => 0.0,
    };
    Some((distance + more, window))
}

/// As many pairs as there are of the fewer, with the least sum of distances; pairs without a window are left out.
fn assigned(
    targets: &[usize],
    sources: &[usize],
    near: impl Fn(usize, usize) -> Option<Near>,
) -> Vec<(f64, Match)> {
    let turned = targets.len() > sources.len();
    let (short, long) = if turned {
        (sources, targets)
    } else {
        (targets, sources)
    };
    let place = |a: usize, b: usize| {
        if turned {
            (long[b], short[a])
        } else {
            (short[a], long[b])
        }
    };
    let cells = (0..short.len()).map(|a| {
        let row = (0..long.len()).map(|b| {
            let (target, source) = place(a, b);
            near(target, source)
        });
        row.collect()
    });
    let table = Table {
        columns: long.len(),
        cells: cells.collect(),
    };
    let (_, chosen) = kuhn_munkres(&table);
    let pairs = chosen.into_iter().enumerate().filter_map(|(a, b)| {
        let (distance, window) = table.cells[a][b]?;
        let (target, source) = place(a, b);
        let one = Match {
            target,
            source,
            window,
        };
        Some((distance, one))
    });
    pairs.collect()
}

/// Distances of rows and columns, as weights.
struct Table {
    columns: usize,
    cells: Vec<Vec<Option<Near>>>,
}

/// No distance is larger: it stands for a pair that cannot be.
const APART: f64 = 1e9;

impl Weights<i64> for Table {
    fn rows(&self) -> usize {
        self.cells.len()
    }

    fn columns(&self) -> usize {
        self.columns
    }

    fn at(&self, row: usize, column: usize) -> i64 {
        let distance = self.cells[row][column].map_or(APART, |(distance, _)| distance.min(APART));
        -(distance * 1000.0) as i64
    }

    fn neg(&self) -> Self {
        let negated = self.cells.iter().map(|row| {
            let row = row
                .iter()
                .map(|cell| cell.map(|(distance, one)| (-distance, one)));
            row.collect()
        });
        Self {
            columns: self.columns,
            cells: negated.collect(),
        }
    }
}
