//! Headings of recorders at standstill: the direction of no movement.

use super::{STANDSTILL, Sample};
use nearmiss_base::geometry::angle_between;

/// Forgets headings that a recorder could not know: those at steps that hardly moved, where they are nothing but the
/// direction of the last displacement, which is 0 or noise at standstill. Measured headings are kept.
pub fn forget_headings_at_standstill(samples: &mut [Sample]) {
    let follow = follow_displacements(samples);
    for i in (1..samples.len()).rev() {
        let moved = samples[i].position - samples[i - 1].position;
        let direction = moved.y.atan2(moved.x);
        let says_nothing =
            |heading: f64| follow || angle_between(direction, heading).abs() <= NO_DIRECTION;
        if moved.norm() < STANDSTILL && samples[i].heading.is_some_and(says_nothing) {
            samples[i].heading = None;
        }
    }
    // The first step copies the second one's direction.
    if let [first, second, ..] = samples
        && second.heading.is_none()
    {
        first.heading = None;
    }
}

/// At standstill a heading this near to the direction of noise, or to 0 where there is none, is that direction, radians.
const NO_DIRECTION: f64 = 1e-6;

/// A heading that differs by less from a displacement's direction is that direction: radians, and the error of rounded
/// positions, metres.
const SAME_DIRECTION: (f64, f64) = (1e-3, 2e-4);

/// Whether nine of ten headings where it moved are the directions of the displacements.
fn follow_displacements(samples: &[Sample]) -> bool {
    let (mut moving, mut along) = (0, 0);
    for pair in samples.windows(2) {
        let moved = pair[1].position - pair[0].position;
        let Some(heading) = pair[1].heading.filter(|_| moved.norm() >= STANDSTILL) else {
            continue;
        };
        let (angle, rounding) = SAME_DIRECTION;
        let most = angle + rounding / moved.norm();
        moving += 1;
        along += usize::from(angle_between(moved.y.atan2(moved.x), heading).abs() <= most);
    }
    moving > 0 && along * 10 >= moving * 9
}

#[cfg(test)]
mod tests {
    use super::super::Track;
    use super::super::tests::sample;
    use super::*;

    #[test]
    fn holds_the_heading_at_standstill() {
        let mut samples: Vec<_> = (0..4).map(|i| sample(i, 0.0, Some(0.0))).collect();
        samples[0].position.y = -1.0;
        samples[1].heading = Some(std::f64::consts::FRAC_PI_2);
        forget_headings_at_standstill(&mut samples);
        let heading = |samples: &[Sample], step| {
            let track = Track::new(samples.to_vec(), 0.1, None);
            track.at(step).map_or(f64::NAN, |m| m.pose.heading)
        };
        let turned = heading(&samples, 3) - std::f64::consts::FRAC_PI_2;
        assert!(turned.abs() < 1e-12);
        // Who measures headings knows them at standstill, too.
        let mut measured: Vec<_> = (0..4).map(|i| sample(i, 0.0, Some(1.52))).collect();
        measured[0].position.y = -1.0;
        measured[3].heading = Some(1.49);
        let mut resting = measured[1..].to_vec();
        for all in [&mut measured, &mut resting] {
            forget_headings_at_standstill(all);
            assert_eq!(heading(all, 2).to_bits(), 1.52_f64.to_bits());
            assert_eq!(heading(all, 3).to_bits(), 1.49_f64.to_bits());
        }
    }

    #[test]
    fn rests_along_the_planned_heading() {
        let mut samples: Vec<_> = (0..3).map(|i| sample(i, 0.0, Some(0.0))).collect();
        forget_headings_at_standstill(&mut samples);
        let track = Track::new(samples, 0.1, Some(2.0));
        assert!(
            track
                .at(0)
                .is_some_and(|m| (m.pose.heading - 2.0).abs() < 1e-12)
        );
    }
}
