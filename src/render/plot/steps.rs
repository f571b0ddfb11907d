//! Steps for measures whose values are levels.

/// Levels hold until the next one: the corners of their steps.
#[must_use]
pub fn steps(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let corners = points.windows(2).map(|pair| (pair[1].0, pair[0].1));
    let mut all = Vec::with_capacity(points.len() * 2);
    for (point, corner) in points.iter().zip(corners.map(Some).chain([None])) {
        all.push(*point);
        all.extend(corner);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_hold_until_the_next_one() {
        let points = [(0.0, 5.0), (1.0, 3.0), (2.0, 3.0)];
        let corners = [(0.0, 5.0), (1.0, 5.0), (1.0, 3.0), (2.0, 3.0), (2.0, 3.0)];
        assert_eq!(steps(&points), corners);
        assert_eq!(steps(&points[..1]), points[..1]);
        assert!(steps(&[]).is_empty());
    }
}
