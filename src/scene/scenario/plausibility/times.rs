//! Checks for time steps that are missing, repeated, out of order or far away.

use super::and_more;
use crate::scenario::LONGEST_TRACK;

/// What is wrong with the time steps of a row of states, in the order of the file: the place of the state at which it
/// shows, and the words.
pub(crate) fn check(steps: &[i64]) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let mut order: Vec<usize> = (0..steps.len()).collect();
    order.sort_by_key(|i| steps[*i]);
    let pairs = || order.windows(2).map(|pair| (pair[0], pair[1]));
    let twice = pairs().find(|(a, b)| steps[*a] == steps[*b]);
    let back = steps.windows(2).position(|pair| pair[1] < pair[0]);
    if let Some((_, second)) = twice {
        let message = format!(
            "time step {} has two states; the first is used",
            steps[second]
        );
        found.push((second, message));
    }
    if let Some(place) = back.filter(|_| twice.is_none()) {
        let falling = steps.windows(2).all(|pair| pair[1] < pair[0]);
        let message = if falling && steps.len() > 2 {
            "the states run backwards in time and were sorted"
        } else {
            "the states are not in time order and were sorted"
        };
        found.push((place + 1, message.into()));
    }
    found.extend(gaps(steps, pairs()));
    let (Some(first), Some(last)) = (order.first(), order.last()) else {
        return found;
    };
    if steps[*first] < 0 {
        let message = format!("starts at time step {}, before the scenario", steps[*first]);
        found.push((*first, message));
    }
    if steps[*first] > LONGEST_TRACK {
        let message = format!("starts only at time step {}", steps[*first]);
        found.push((*first, message));
    }
    if steps[*last].saturating_sub(steps[*first]) > LONGEST_TRACK {
        let late = order
            .iter()
            .find(|i| steps[**i].saturating_sub(steps[*first]) > LONGEST_TRACK);
        let message =
            format!("states more than {LONGEST_TRACK} steps after the first were left out");
        found.push((*late.unwrap_or(last), message));
    }
    found
}

/// The diagnostic for gaps between steps in order of time.
pub fn missing(steps: &[i64]) -> Option<(usize, String)> {
    gaps(steps, (1..steps.len()).map(|i| (i - 1, i)))
}

/// Steps between the first and the last without a state.
fn gaps(steps: &[i64], pairs: impl Iterator<Item = (usize, usize)>) -> Option<(usize, String)> {
    let apart: Vec<(usize, i64, i64)> = pairs
        .map(|(a, b)| (b, steps[a], steps[b]))
        .filter(|(_, a, b)| a != b)
        .collect();
    let stride = apart.first().map_or(1, |(_, a, b)| b - a);
    let gaps = apart.iter().filter(|(_, a, b)| b - a > 1);
    let (place, a, b) = *gaps.clone().next()?;
    let even = apart.len() > 2 && apart.iter().all(|(_, a, b)| b - a == stride);
    let message = if even {
        format!("only one state every {stride} time steps; are its times in another unit?")
    } else {
        let missing = match b - a {
            2 => format!("no state at time step {}", a + 1),
            _ => format!("no states from time step {} to {}", a + 1, b - 1),
        };
        and_more(format!("{missing}; assumed absent"), gaps.count() - 1)
    };
    Some((place, message))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_that_are_wrong_are_told_where_they_show() {
        let all = |steps: &[i64]| check(steps);
        assert_eq!(all(&[]), []);
        assert_eq!(all(&[0, 1, 2, 3]), []);
        assert_eq!(all(&[7]), []);
        for (steps, place, words) in [
            (&[0, 1, 1, 2][..], 2, "time step 1 has two states"),
            (&[0, 2, 1, 3], 2, "not in time order"),
            (&[3, 2, 1, 0], 1, "run backwards"),
            (&[0, 1, 3, 4], 2, "no state at time step 2;"),
            (&[0, 1, 12, 13], 2, "no states from time step 2 to 11;"),
            (&[0, 2, 3, 9, 10], 1, "(and 1 more)"),
            (
                &[0, 100, 200, 300],
                1,
                "only one state every 100 time steps",
            ),
            (&[-3, -2, -1, 0], 0, "starts at time step -3"),
            (&[0, 1_000_000], 1, "were left out"),
            (&[900_000, 900_001], 0, "starts only at time step 900000"),
        ] {
            let found = all(steps);
            let hit = found
                .iter()
                .any(|(at, said)| *at == place && said.contains(words));
            assert!(hit, "{steps:?}: {found:?}");
        }
    }
}
