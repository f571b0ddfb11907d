//! Each value of an axis against one of them: paired differences, so that all else is the same.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;

use super::super::consumption::count;
use super::{Axis, AxisValue, Placed};
use crate::evaluation::statistics::{PairedTest, holm};

/// A value of the rows' axis against the baseline, within a column.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// The value.
    pub row: AxisValue,
    /// The column; `None` without a second axis.
    pub column: Option<AxisValue>,
    /// Units that both were asked about alike in all else.
    pub units: u32,
    /// Units that both have questions about, and that at least one was not asked so.
    pub left_out: u32,
    /// By how much the value is right more often than the baseline.
    pub test: PairedTest,
    /// Its p value, corrected for all differences of the table, by Holm.
    pub corrected: f64,
}

/// Questions that are right and that are not, by unit, and within it by scenario and how else was asked.
type Verdicts<'a> = BTreeMap<&'a str, BTreeMap<(&'a str, Vec<AxisValue>), (u32, u32)>>;

/// Every value but the baseline, in every column in which both have answers.
pub(super) fn differences(
    rows: Axis,
    baseline: &AxisValue,
    placed: &[Placed<'_>],
) -> Vec<Difference> {
    let columns: BTreeSet<&Option<AxisValue>> = placed.iter().map(|one| &one.column).collect();
    let values: BTreeSet<&AxisValue> = placed.iter().map(|one| &one.row).collect();
    let mut sides: BTreeMap<(&AxisValue, &Option<AxisValue>), Verdicts<'_>> = BTreeMap::new();
    for one in placed {
        let side = sides.entry((&one.row, &one.column)).or_default();
        take(side, rows, one);
    }
    let wanted: Vec<_> = values
        .into_iter()
        .filter(|value| *value != baseline)
        .flat_map(|value| columns.iter().map(move |column| (value, *column)))
        .collect();
    let found = wanted.into_par_iter().filter_map(|(row, column)| {
        let (one, other) = (sides.get(&(row, column))?, sides.get(&(baseline, column))?);
        difference(row, column, one, other)
    });
    let mut found: Vec<Difference> = found.collect();
    let p: Vec<f64> = found.iter().map(|one| one.test.p).collect();
    for (one, corrected) in found.iter_mut().zip(holm(&p)) {
        one.corrected = corrected;
    }
    found
}

fn take<'a>(side: &mut Verdicts<'a>, rows: Axis, one: &Placed<'a>) {
    let scored = one.case.scored;
    if scored.is_collision().is_none() {
        return;
    }
    let others = Axis::OF_QUESTIONS
        .into_iter()
        .filter(|axis| *axis != rows)
        // A template belongs to its frame: where frames are compared, templates differ, too.
        .filter(|axis| rows != Axis::Frame || *axis != Axis::Template);
    let alike: Vec<AxisValue> = others
        .map(|axis| axis.value(&one.case, one.parameters))
        .collect();
    let votes = side
        .entry(scored.cluster.of(one.case.scenario()))
        .or_default()
        .entry((one.case.scenario(), alike))
        .or_default();
    match scored.is_right() {
        Some(true) => votes.0 += 1,
        Some(false) => votes.1 += 1,
        None => {}
    }
}

fn difference(
    row: &AxisValue,
    column: &Option<AxisValue>,
    one: &Verdicts<'_>,
    other: &Verdicts<'_>,
) -> Option<Difference> {
    let share = |(right, wrong): (u32, u32)| {
        let all = right + wrong;
        (all > 0).then(|| f64::from(right) / f64::from(all))
    };
    let (mut differences, mut left_out) = (Vec::new(), 0_usize);
    for (unit, votes) in one {
        let Some(others) = other.get(unit) else {
            continue;
        };
        let pairs = votes.iter().filter_map(|(alike, votes)| {
            let other = others.get(alike)?;
            Some(share(*votes)? - share(*other)?)
        });
        let pairs: Vec<f64> = pairs.collect();
        if pairs.is_empty() {
            left_out += 1
        } else {
            differences.push(pairs.iter().sum::<f64>() / pairs.len() as f64)
        }
    }
    Some(Difference {
        row: row.clone(),
        column: column.clone(),
        units: count(differences.len()),
        left_out: count(left_out),
        test: PairedTest::of_differences(&differences)?.shown(count(differences.len())),
        corrected: 1.0,
    })
}
