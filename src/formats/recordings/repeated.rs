//! Rows of a recording that say twice where someone is at a step.

use super::report::Report;
use crate::commonroad::builder::SourceLocation;
use nearmiss_base::geometry::Point;

/// Sorts the rows of a road user by step and keeps the first one of each. How many others there were, and how far from
/// these, is said about `name`.
pub fn once<T>(
    report: &Report,
    name: impl FnOnce() -> String,
    rows: &mut Vec<T>,
    step: impl Fn(&T) -> i64,
    place: impl Fn(&T) -> Point,
) {
    if rows.windows(2).all(|pair| step(&pair[0]) < step(&pair[1])) {
        return;
    }
    rows.sort_by_key(|row| step(row));
    let (mut twice, mut most) = (0, 0.0_f64);
    rows.dedup_by(|row, first| {
        let same = step(row) == step(first);
        if same {
            twice += 1;
            most = most.max((place(row) - place(first)).norm());
        }
        same
    });
    if twice > 0 {
        report.at(name()).warn(format!(
            "{twice} rows are at a step that has one already, up to {most:.2} m from it; the first of each step is used, are these two road users?"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_the_same_step_are_told_with_their_distance() {
        let point = |x| Point::new(x, 0.0);
        let mut rows = vec![(2, point(2.0)), (1, point(1.0)), (1, point(1001.0))];
        let report = Report::about("x");
        once(&report, || "track 7".into(), &mut rows, |r| r.0, |r| r.1);
        assert_eq!(rows, [(1, point(1.0)), (2, point(2.0))]);
        let said = report.into_diagnostics();
        assert_eq!((said.len(), &*said[0].element), (1, "track 7"));
        assert!(
            said[0]
                .message
                .starts_with("1 rows are at a step that has one already, up to 1000.00 m")
        );
    }
}
