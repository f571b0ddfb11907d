//! Headings, speeds and accelerations from where a track is, smoothed.
//!
//! A quadratic in time is fitted by least squares to the places around a moment; its derivative is the velocity
//! (Savitzky and Golay, Analytical Chemistry 36, 1964). The window grows until its ends are far enough apart for a
//! direction, and never over a gap.

use nearmiss_base::geometry::{Point, Vector};

/// So far the ends of a window are apart, metres: places written in centimetres then tell a direction to a degree.
const FAR: f64 = 0.8;

/// No window reaches farther to either side, seconds.
const LONGEST: f64 = 0.4;

/// Slower bodies stand, m/s: their places are noise.
const SLOWEST: f64 = 0.3;

/// The motion at a place of a track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Derived {
    /// Radians, counterclockwise from the x-axis. A body that stands keeps its heading; before it first moves it has
    /// that with which it starts; one that never moves has 0.
    pub heading: f64,
    /// m/s.
    pub speed: f64,
    /// m/s² along the heading.
    pub acceleration: f64,
}

/// The motion at each place; `steps` are in order and `dt` seconds apart.
pub fn derive(steps: &[i64], places: &[Point], dt: f64) -> Vec<Derived> {
    let fits: Vec<Option<Fit>> = (0..steps.len())
        .map(|i| Fit::around(i, steps, places, dt))
        .collect();
    let heading = |fit: &Fit| fit.velocity.y.atan2(fit.velocity.x);
    let first = fits.iter().flatten().find(|fit| fit.moves);
    let mut held = first.map_or(0.0, heading);
    let each = fits.iter().map(|fit| {
        let Some(fit) = fit else {
            return Derived {
                heading: held,
                speed: 0.0,
                acceleration: 0.0,
            };
        };
        if fit.moves {
            held = heading(fit);
        }
        let along = Vector::new(held.cos(), held.sin());
        Derived {
            heading: held,
            speed: if fit.moves { fit.velocity.norm() } else { 0.0 },
            acceleration: if fit.moves {
                fit.acceleration.dot(&along)
            } else {
                0.0
            },
        }
    });
    each.collect()
}

struct Fit {
    velocity: Vector,
    acceleration: Vector,
    moves: bool,
}

impl Fit {
    /// The quadratic around a place; nothing of one that is alone.
    fn around(at: usize, steps: &[i64], places: &[Point], dt: f64) -> Option<Self> {
        let (mut from, mut to) = (at, at);
        let within = |i: usize| (steps[i] - steps[at]).abs() as f64 * dt <= LONGEST + dt / 2.0;
        let joined = |a: usize, b: usize| steps[b] - steps[a] == 1;
        loop {
            let back = (from > 0 && joined(from - 1, from)).then(|| from - 1);
            let on = (to + 1 < steps.len() && joined(to, to + 1)).then_some(to + 1);
            let few = to - from < 2;
            let far = (places[to] - places[from]).norm() >= FAR;
            let (back, on) = if few {
                (back, on)
            } else {
                (back.filter(|i| within(*i)), on.filter(|i| within(*i)))
            };
            if far && !few || back.is_none() && on.is_none() {
                break;
            }
            from = back.unwrap_or(from);
            to = on.unwrap_or(to);
        }
        let count = to - from + 1;
        if count < 2 {
            // Over a gap, the nearest other place has to do.
            let other = if at > 0 { at - 1 } else { at + 1 };
            let seconds = (steps.get(other)? - steps[at]) as f64 * dt;
            let velocity = (places.get(other)? - places[at]) / seconds;
            return Some(Self {
                velocity,
                acceleration: Vector::zeros(),
                moves: velocity.norm() >= SLOWEST,
            });
        }
        let time = |i: usize| (steps[i] - steps[at]) as f64 * dt;
        let place = |i: usize| places[i] - places[at];
        let (velocity, acceleration) = if count == 2 {
            (
                (place(to) - place(from)) / (time(to) - time(from)),
                Vector::zeros(),
            )
        } else {
            quadratic((from..=to).map(|i| (time(i), place(i))))?
        };
        let moved = (places[to] - places[from]).norm();
        let seconds = time(to) - time(from);
        Some(Self {
            velocity,
            acceleration,
            moves: moved >= SLOWEST * seconds,
        })
    }
}

/// First and second derivative at 0 of the quadratic with least squared error.
fn quadratic(samples: impl Iterator<Item = (f64, Vector)>) -> Option<(Vector, Vector)> {
    let mut powers = [0.0; 5];
    let mut sums = [Vector::zeros(); 3];
    for (time, place) in samples {
        let mut power = 1.0;
        for i in 0..5 {
            powers[i] += power;
            if i < 3 {
                sums[i] += place * power;
            }
            power *= time;
        }
    }
    let matrix = nalgebra::Matrix3::from_fn(|row, column| powers[row + column]);
    let inverse = matrix.try_inverse()?;
    let coefficient = |row: usize| {
        let terms = (0..3).map(|column| sums[column] * inverse[(row, column)]);
        terms.fold(Vector::zeros(), |sum, term| sum + term)
    };
    Some((coefficient(1), coefficient(2) * 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A circle of radius 20 m at a speed, sampled ten times a second, in units of `rounding` metres.
    fn circle(speed: f64, rounding: f64) -> (Vec<i64>, Vec<Point>) {
        let places = (0..100).map(|i| {
            let angle = f64::from(i) * 0.1 * speed / 20.0;
            let round = |v: f64| (v / rounding).round() * rounding;
            Point::new(round(20.0 * angle.sin()), round(20.0 - 20.0 * angle.cos()))
        });
        ((0..100).collect(), places.collect())
    }

    #[test]
    fn a_turn_is_followed_within_a_degree() {
        for (speed, rounding) in [(1.0, 0.01), (1.2, 0.001), (5.0, 0.01), (15.0, 0.01)] {
            let (steps, places) = circle(speed, rounding);
            for (i, found) in derive(&steps, &places, 0.1).iter().enumerate() {
                let heading = i as f64 * 0.1 * speed / 20.0;
                let off = nearmiss_base::geometry::normalize_angle(found.heading - heading);
                let inner = (5..95).contains(&i);
                let most = if inner { 1.0 } else { 2.5 };
                assert!(off.to_degrees().abs() < most, "{speed} m/s, {i}: {off}");
                assert!(
                    (found.speed - speed).abs() < 0.06 * speed.max(1.0),
                    "{speed} {found:?}"
                );
            }
        }
    }

    #[test]
    fn bodies_that_stand_keep_their_heading() {
        // North, then standing with noise of centimetres, then on.
        let mut places = Vec::new();
        for i in 0..60 {
            let y = match i {
                0..20 => f64::from(i) * 0.5,
                20..40 => 9.5 + 0.01 * f64::from(i % 2),
                _ => 9.5 + f64::from(i - 39) * 0.5,
            };
            places.push(Point::new(0.01 * f64::from(i % 3), y));
        }
        let steps: Vec<i64> = (0..60).collect();
        let found = derive(&steps, &places, 0.1);
        for (i, found) in found.iter().enumerate() {
            let off = found.heading.to_degrees() - 90.0;
            assert!(off.abs() < 4.0, "{i}: {off}");
        }
        assert!(found[26..34].iter().all(|f| f.speed == 0.0));
        let alone = derive(&[3], &[Point::new(1.0, 1.0)], 0.1);
        assert_eq!((alone[0].heading, alone[0].speed), (0.0, 0.0));
    }

    #[test]
    fn windows_end_at_gaps() {
        let steps = [0, 1, 2, 10, 11, 12];
        let at = |x| Point::new(x, 0.0);
        // Eastwards before the gap, westwards after it.
        let places = [0.0, 1.0, 2.0, 2.0, 1.0, 0.0].map(at);
        let found = derive(&steps, &places, 0.1);
        assert!(found[..3].iter().all(|f| f.heading.abs() < 1e-9));
        assert!(found[3..].iter().all(|f| f.heading.abs() > 3.1));
        assert!((found[1].speed - 10.0).abs() < 1e-9);
    }
}
