//! Smooths a path so that it can be driven at speed, near the middle of the lanes.
//!
//! Maps draw curves with few points, and a path that keeps to them within centimetres has kinks that no vehicle can
//! follow. Points along the path are moved to make the squared third differences (the change of curvature) small,
//! within a tolerance: the smoother of Whittaker (1923), with more weight where the path would stray.

use nearmiss_base::geometry::{Point, ReferencePath, ReferencePathError, Vector};

/// Distance between the points that are moved, metres.
const SPACING: f64 = 1.0;

/// How far the smooth path may be from the given one, metres.
const TOLERANCE: f64 = 0.4;

/// What smoothness weighs against closeness: waves shorter than about 30 m are flattened.
const SMOOTHNESS: f64 = 1e4;

/// Where it strays, closeness weighs this much more in the next round; and this many rounds there are.
const FIRMER: f64 = 3.0;
const ROUNDS: usize = 12;

/// Points on either side that are held more firmly where one strays.
const AROUND: usize = 4;

/// A smooth path along `path` from arc length `from` to `to`, metres.
///
/// # Errors
/// No smooth curve follows the points; not for paths that are smooth themselves.
pub(super) fn smooth(
    path: &ReferencePath,
    from: f64,
    to: f64,
) -> Result<ReferencePath, ReferencePathError> {
    let pieces = ((to - from) / SPACING).ceil().max(1.0) as usize;
    let points: Vec<Vector> = (0..=pieces)
        .map(|i| {
            path.at(from + (to - from) * i as f64 / pieces as f64)
                .position
                .coords
        })
        .collect();
    let origin = points[0];
    let given: Vec<Vector> = points.iter().map(|p| p - origin).collect();
    let mut weights = vec![1.0; given.len()];
    let mut moved = given.clone();
    for _ in 0..ROUNDS {
        moved = flatten(&given, &weights);
        let strays: Vec<usize> = (0..given.len())
            .filter(|&i| (moved[i] - given[i]).norm() > TOLERANCE)
            .collect();
        if strays.is_empty() {
            break;
        }
        let mut firmer = vec![false; given.len()];
        for i in strays {
            let last = (i + AROUND).min(given.len() - 1);
            firmer[i.saturating_sub(AROUND)..=last].fill(true);
        }
        for (weight, firmer) in weights.iter_mut().zip(firmer) {
            if firmer {
                *weight *= FIRMER;
            }
        }
    }
    ReferencePath::new(finer(&moved).into_iter().map(|p| Point::from(p + origin)))
}

/// Points between those of a curve, so that what is drawn through them does not follow the chords: cubic interpolation.
fn finer(points: &[Vector]) -> Vec<Vector> {
    let last = points.len() - 1;
    let at = |i: i64| -> Vector {
        match usize::try_from(i) {
            Err(_) => points[0] * 2.0 - points[1.min(last)],
            Ok(i) if i > last => points[last] * 2.0 - points[last.saturating_sub(1)],
            Ok(i) => points[i],
        }
    };
    let mut all = Vec::with_capacity(points.len() * BETWEEN);
    for i in 0..last as i64 {
        let [a, b, c, d] = [at(i - 1), at(i), at(i + 1), at(i + 2)];
        for part in 0..BETWEEN {
            let t = part as f64 / BETWEEN as f64;
            let slope = (c - a) * t;
            let square = (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t);
            let cube = (b * 3.0 - a - c * 3.0 + d) * (t * t * t);
            all.push(b + (slope + square + cube) / 2.0);
        }
    }
    all.push(points[last]);
    all
}

/// Points for each that is moved.
const BETWEEN: usize = 8;

/// Third differences.
const DIFFERENCE: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];

/// The points that minimise Σ w‖x − given‖² + λ Σ‖Δ³x‖², by a Cholesky decomposition of the band matrix.
fn flatten(given: &[Vector], weights: &[f64]) -> Vec<Vector> {
    let n = given.len();
    // Row i holds the matrix from the diagonal to the third place left of it.
    let mut band: Vec<[f64; 4]> = weights.iter().map(|w| [*w, 0.0, 0.0, 0.0]).collect();
    for first in 0..n.saturating_sub(3) {
        for (a, da) in DIFFERENCE.iter().enumerate() {
            for (b, db) in DIFFERENCE.iter().enumerate().take(a + 1) {
                band[first + a][a - b] += SMOOTHNESS * da * db;
            }
        }
    }
    for i in 0..n {
        for j in i.saturating_sub(3)..=i {
            let before = i.saturating_sub(3).max(j.saturating_sub(3))..j;
            let sum: f64 = before.map(|k| band[i][i - k] * band[j][j - k]).sum();
            let left = band[i][i - j] - sum;
            // The weights are positive, so the matrix is positive definite.
            band[i][i - j] = if i == j {
                left.sqrt()
            } else {
                left / band[j][0]
            };
        }
    }
    let mut x: Vec<Vector> = given.iter().zip(weights).map(|(p, w)| p * *w).collect();
    for i in 0..n {
        for k in i.saturating_sub(3)..i {
            let known = x[k];
            x[i] -= known * band[i][i - k];
        }
        x[i] /= band[i][0];
    }
    for i in (0..n).rev() {
        for k in i + 1..(i + 4).min(n) {
            let known = x[k];
            x[i] -= known * band[k][k - i];
        }
        x[i] /= band[i][0];
    }
    x
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn most(path: &ReferencePath, of: impl Fn(&nearmiss_base::geometry::PathPoint) -> f64) -> f64 {
        let steps = (path.length() / 0.25) as usize;
        (0..=steps)
            .map(|i| of(&path.at(i as f64 * 0.25)).abs())
            .fold(0.0, f64::max)
    }

    #[test]
    fn kinks_go_and_corners_stay_near() {
        let corner = [
            (0., 0.),
            (40., 0.),
            (41., 0.1),
            (80., 6.),
            (90., 14.),
            (92., 50.),
        ];
        let line = corner.map(|(x, y)| Point::new(x, y));
        let rough = ReferencePath::new(line).unwrap();
        let path = smooth(&rough, 0.0, rough.length()).unwrap();
        assert!(most(&path, |p| p.curvature_rate) < most(&rough, |p| p.curvature_rate) / 10.0);
        for i in 0..=100 {
            let p = path.at(path.length() * f64::from(i) / 100.0).position;
            assert!(rough.project(&p).unwrap().d.abs() < TOLERANCE + 0.15);
        }
    }

    #[test]
    fn a_straight_line_stays() {
        let line = [(5., 5.), (105., 105.)].map(|(x, y)| Point::new(x, y));
        let straight = ReferencePath::new(line).unwrap();
        let path = smooth(&straight, 0.0, straight.length()).unwrap();
        assert!((path.length() - straight.length()).abs() < 1e-6);
        assert!(most(&path, |p| p.curvature) < 1e-9);
    }
}
