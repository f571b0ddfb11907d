//! What a line of a plot runs through, and what its axis has to hold: the same in figures and on the screen.

use nearmiss_scene::metrics::Series;

/// A run of points, time and value, for every stretch without gaps: nothing is drawn where there is no value.
#[must_use]
pub fn runs(series: &Series, dt: f64, value: impl Fn(i64) -> Option<f64>) -> Vec<Vec<(f64, f64)>> {
    let points: Vec<_> = series
        .steps()
        .map(|step| Some((step as f64 * dt, value(step)?)))
        .collect();
    let runs = points.split(Option::is_none).filter(|run| !run.is_empty());
    runs.map(|run| run.iter().flatten().copied().collect())
        .collect()
}

/// So much of what the values take up may be added to reach a threshold.
const NEAR: f64 = 0.5;

/// From the lowest to the highest value, and to those of `near` that lie close to them; `None` without values.
#[must_use]
pub fn value_range(
    values: impl Iterator<Item = f64>,
    near: impl Iterator<Item = f64>,
) -> Option<(f64, f64)> {
    let (low, high) = values.fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return None;
    }
    let room = NEAR * (high - low);
    let within = (low - room)..=(high + room);
    let near = near.filter(|v| within.contains(v));
    let (low, high) = near.fold((low, high), |(l, h), v| (l.min(v), h.max(v)));
    if high - low <= 1e-9 * low.abs().max(1e-3) {
        // One value all the time: it stands between two others.
        let around = (low.abs() * 0.1).max(0.5);
        return Some((low - around, high + around));
    }
    Some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_reaches_what_is_near_and_is_never_empty() {
        let range = |values: &[f64], near: &[f64]| {
            value_range(values.iter().copied(), near.iter().copied())
        };
        assert_eq!(range(&[], &[1.0]), None);
        assert_eq!(range(&[2.0, 4.0], &[1.0, 9.0]), Some((1.0, 4.0)));
        assert_eq!(range(&[0.0, 0.0], &[]), Some((-0.5, 0.5)));
        assert_eq!(range(&[20.0], &[]), Some((18.0, 22.0)));
    }
}
