//! The closest that recorded bodies come from each step on, in one pass from the last step to the first.

/// The future distance between two recorded bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::metrics) struct Closest {
    /// The smallest distance from now on, metres.
    pub distance: f64,
    /// The first place at which it is as small.
    pub index: usize,
    /// The first place at which the bodies overlap.
    pub overlap: Option<usize>,
}

/// Distances that differ by less are alike, metres: of two that stand, the first step counts.
const ALIKE: f64 = 1e-6;

impl Closest {
    /// By step; nothing at steps where one of the two is not there.
    pub fn rows(distances: &[Option<f64>]) -> Vec<Option<Self>> {
        let mut rows = vec![None; distances.len()];
        let mut ahead: Option<Self> = None;
        for (index, distance) in distances.iter().enumerate().rev() {
            let &Some(distance) = distance else { continue };
            let overlap = (distance == 0.0).then_some(index);
            let mut here = Self {
                distance,
                index,
                overlap: overlap.or(ahead.and_then(|a| a.overlap)),
            };
            if let Some(ahead) = ahead.filter(|a| a.distance < distance) {
                here.distance = ahead.distance;
                if ahead.distance < distance - ALIKE {
                    here.index = ahead.index;
                }
            }
            ahead = Some(here);
            rows[index] = ahead;
        }
        rows
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_future_counts_and_the_first_of_equals() {
        let rows = Closest::rows(&[Some(3.0), None, Some(1.0), Some(0.0), Some(0.0), Some(2.0)]);
        let at = |i: usize| rows[i].unwrap();
        assert_eq!(
            (at(0).distance, at(0).index, at(0).overlap),
            (0.0, 3, Some(3))
        );
        assert_eq!((at(4).index, at(4).overlap), (4, Some(4)));
        assert_eq!((at(5).distance, at(5).overlap), (2.0, None));
        assert!(rows[1].is_none());
    }
}
