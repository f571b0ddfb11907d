//! The Pareto front over a measure and cost.

/// The places of the points, each with its value (more is better) and its cost (less is better), that no other point
/// beats: none is at least as good in both and better in one. Of equal points the first is on the front.
pub(super) fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let beats = |a: (usize, &(f64, f64)), b: (usize, &(f64, f64))| {
        let no_worse = a.1.0 >= b.1.0 && a.1.1 <= b.1.1;
        no_worse && (a.1 != b.1 || a.0 < b.0)
    };
    let places = 0..points.len();
    let unbeaten = |at: &usize| {
        let of = |other: usize| (other, &points[other]);
        !(0..points.len()).any(|other| other != *at && beats(of(other), of(*at)))
    };
    places.filter(unbeaten).collect()
}

#[cfg(test)]
mod tests {
    use super::front;

    #[test]
    fn nothing_on_the_front_is_beaten() {
        assert_eq!(front(&[]), Vec::<usize>::new());
        assert_eq!(front(&[(0.5, 1.0)]), [0]);
        // Dearer and better, cheaper and worse, beaten by both, equal to the first.
        assert_eq!(
            front(&[(0.5, 1.0), (0.8, 2.0), (0.4, 0.5), (0.4, 1.5), (0.5, 1.0)]),
            [0, 1, 2]
        );
        assert_eq!(front(&[(0.5, 1.0), (0.5, 0.9)]), [1]);
    }
}
