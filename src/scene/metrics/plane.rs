//! Measures in the plane, without a road: distance, time to collision, worst-case time to collision.
//!
//! Swept, not sampled. The two-dimensional form of the measure of Hayward (1972).
//!
//! Worst-case time to collision: when the two can touch at the earliest, whatever both do.
//!
//! Around where each would be at constant velocity grows a circle of radius R + ½·a·t², with R that of the body
//! around its position and a = `worst_case` in any direction, 0 for what stands for ever; WTTC is the first t at
//! which the circles touch. Source: Wachenfeld, Junietz, Wenzel and Winner 2016.

use nearmiss_base::geometry::Contact;

use super::{Danger, Encounter, Measure, NoValue, Reading};

pub(super) const TIME_TO_COLLISION: Measure = Measure::new(
    "ttc",
    "time to collision",
    "s",
    Danger::Low,
    "Hayward 1972, bodies in the plane at constant velocity",
    time_to_collision,
);

/// Contacts later than this are not looked for, seconds.
pub const HORIZON: f64 = 10.0;

/// Seconds to contact; 0 in contact, whatever the velocities.
fn time_to_collision(encounter: &Encounter<'_>) -> Reading {
    let contact = encounter.ego_placed().contact(
        &encounter.ego.velocity_vector(),
        &encounter.other_placed(),
        &encounter.other.velocity_vector(),
        HORIZON,
    );
    match contact {
        Contact::Now => Reading::Value(0.0),
        Contact::In(time) => Reading::Value(time),
        Contact::NotWithinHorizon => Reading::None(NoValue::NoContact),
    }
}

pub(super) const WORST_CASE_TTC: Measure = Measure::new(
    "wttc",
    "worst-case time to collision",
    "s",
    Danger::Low,
    "first touch of circles that grow with worst_case (Wachenfeld 2016)",
    worst_case_ttc,
);

fn worst_case_ttc(encounter: &Encounter<'_>) -> Reading {
    let feared = encounter.thresholds().limits.worst_case;
    let stands = encounter.ask(|c, other, _| Ok(c.stands(other)));
    let others = if stands == Ok(true) { 0.0 } else { feared };
    let away = encounter.other.pose.position - encounter.ego.pose.position;
    let velocity = encounter.other.velocity_vector() - encounter.ego.velocity_vector();
    let reach = encounter.ego_body.reach() + encounter.other_body.reach();
    let circles = Circles {
        growth: (feared + others) / 2.0,
        reach,
        distance: away.norm_squared(),
        closing: -away.dot(&velocity),
        speed: velocity.norm_squared(),
    };
    Reading::Value(circles.touch())
}

/// Newton's steps in the concave part.
const MOST_STEPS: usize = 1000;

/// Two circles: they touch where (R + g·t²)² = |p + v·t|².
struct Circles {
    /// g, m/s².
    growth: f64,
    /// R, metres.
    reach: f64,
    /// |p|², m².
    distance: f64,
    /// −p·v, m²/s.
    closing: f64,
    /// |v|², m²/s².
    speed: f64,
}

impl Circles {
    /// The difference of the squares, which is negative until they touch, and its slope.
    fn value(&self, t: f64) -> (f64, f64) {
        let radius = self.reach + self.growth * t * t;
        let apart = self.distance - 2.0 * self.closing * t + self.speed * t * t;
        let slope = 4.0 * self.growth * t * radius + 2.0 * self.closing - 2.0 * self.speed * t;
        (radius * radius - apart, slope)
    }

    /// The first touch, seconds.
    fn touch(&self) -> f64 {
        if self.value(0.0).0 >= 0.0 {
            return 0.0;
        }
        // The second derivative of the difference grows with t: first it is concave, then convex. Where it is
        // concave, Newton's steps from the left stop short of a root, so that none is passed over.
        let bend = 2.0 * self.speed - 4.0 * self.growth * self.reach;
        let concave = (bend.max(0.0) / 12.0).sqrt() / self.growth;
        let mut low = 0.0;
        // Each step doubles the digits; more than a few are rounding.
        for _ in 0..MOST_STEPS {
            if low >= concave {
                break;
            }
            let (value, slope) = self.value(low);
            let step = -value / slope;
            if slope <= 0.0 || low + step > concave {
                break;
            }
            if step <= 1e-15 * low || value >= 0.0 {
                return low;
            }
            low += step;
        }
        self.beyond(low)
    }

    /// The touch after `low`, between which and the touch there is no other.
    fn beyond(&self, mut low: f64) -> f64 {
        let mut high = low.max(0.1);
        while self.value(high).0 < 0.0 {
            low = high;
            high *= 2.0;
        }
        let mut t = high;
        for _ in 0..100 {
            let (value, slope) = self.value(t);
            if value < 0.0 {
                low = t;
            } else {
                high = t;
            }
            let newton = t - value / slope;
            let next = if newton > low && newton < high {
                newton
            } else {
                f64::midpoint(low, high)
            };
            let step = (next - t).abs();
            t = next;
            if step <= 1e-14 * t {
                break;
            }
        }
        t
    }
}

pub(super) const DISTANCE: Measure = Measure::new(
    "distance",
    "distance",
    "m",
    Danger::Low,
    "exact distance of the bodies (GJK, parry)",
    |e| Reading::Value(e.distance()),
);

#[cfg(test)]
mod tests {
    use super::super::relation::tests::{motion, with};
    use super::*;

    #[test]
    fn following_and_crossing() {
        let follow = with(
            motion(0., 0., 0., 10.),
            motion(14., 0., 0., 5.),
            time_to_collision,
        );
        assert!(follow.value().is_some_and(|t| (t - 2.0).abs() < 1e-6));
        let up = std::f64::consts::FRAC_PI_2;
        // Both reach the crossing at the same time; the fronts meet before the centres do.
        let cross = with(
            motion(-20., 0., 0., 10.),
            motion(0., -20., up, 10.),
            time_to_collision,
        );
        assert!(
            cross.value().is_some_and(|t| t > 1.5 && t < 2.0),
            "{cross:?}"
        );
        let past = with(
            motion(0., 0., 0., 10.),
            motion(14., 5., 0., 5.),
            time_to_collision,
        );
        assert_eq!(past, Reading::None(NoValue::NoContact));
    }

    /// The first of many small steps at which the circles touch.
    fn scanned(circles: &Circles) -> f64 {
        let steps = (0..600_000).map(|i| f64::from(i) * 1e-4);
        steps
            .into_iter()
            .find(|t| circles.value(*t).0 >= 0.0)
            .unwrap_or(f64::MAX)
    }

    #[test]
    fn the_first_touch_is_found_where_fast_circles_pass_and_grow_again() {
        let mut passing = 0;
        for (x, y) in [
            (20.0, 0.0),
            (20.0, 6.0),
            (40.0, 9.0),
            (60.0, -15.0),
            (5.0, 30.0),
        ] {
            for (u, v) in [
                (-10.0, 0.0),
                (-30.0, 0.0),
                (-45.0, 4.0),
                (20.0, 0.0),
                (0.0, 0.0),
            ] {
                for growth in [1.0, 2.0, 11.5] {
                    let circles = Circles {
                        growth,
                        reach: 4.6,
                        distance: x * x + y * y,
                        closing: -(x * u + y * v),
                        speed: u * u + v * v,
                    };
                    let (found, expected) = (circles.touch(), scanned(&circles));
                    assert!(
                        (found - expected).abs() <= 1e-4,
                        "{x} {y} {u} {v} {growth}: {found} {expected}"
                    );
                    // Touching early and parting again before the circles have grown.
                    passing += u32::from(circles.value(found + 2.0).0 < 0.0);
                }
            }
        }
        assert!(passing > 0, "no case has several touches");
    }
}
