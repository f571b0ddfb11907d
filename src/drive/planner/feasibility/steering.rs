//! Estimates the steering angles of a motion without them, from its heading changes.

use super::step::{Moment, Turn};
use crate::planner::Limits;
use nearmiss_base::geometry::angle_between;

/// A shorter step says nothing about the steering angle, metres.
const STANDING: f64 = 0.01;

/// The mean of a tangent is not the tangent of the mean: what is estimated from means may exceed a limit by this share.
pub(super) const ESTIMATE: f64 = 0.02;

/// The mean steering angle of a step.
#[derive(Debug, Clone, Copy)]
struct Mean {
    /// Radians.
    angle: f64,
    /// When the wheels stood like this, if they turned evenly; seconds from the first step.
    at: f64,
    /// Seconds from the first step to the beginning of this one.
    from: f64,
    /// How much of the angle may be rounding, radians.
    slack: f64,
}

/// How the wheels are turned in each of the steps between `moments`.
pub(super) fn estimate(moments: &[Moment], limits: &Limits, dt: f64, rounding: f64) -> Vec<Turn> {
    let means: Vec<Option<Mean>> = moments
        .windows(2)
        .map(|pair| {
            let from = (pair[0].step - moments[0].step) as f64 * dt;
            mean(&pair[0], &pair[1], from, limits, dt, rounding)
        })
        .collect();
    // The change to each step from the last one before it that is known, rad/s, and its slack.
    let mut rates: Vec<Option<(f64, f64)>> = Vec::with_capacity(means.len());
    let mut known: Option<Mean> = None;
    for mean in &means {
        rates.push(known.zip(*mean).map(|(before, now)| {
            let time = now.at - before.at;
            let rate = (now.angle - before.angle) / time;
            let slack = (now.slack + before.slack) / time + ESTIMATE * limits.steering_rate;
            (rate, slack)
        }));
        known = mean.or(known);
    }
    let most = limits.steering_rate;
    let mut held = 0.0;
    (0..means.len())
        .map(|k| {
            let around = [Some(&rates[k]), rates.get(k + 1)];
            let around: Vec<f64> = around
                .into_iter()
                .flatten()
                .flatten()
                .map(|(rate, _)| *rate)
                .collect();
            let sum: f64 = around.iter().sum();
            let rate = (sum / around.len().max(1) as f64).clamp(-most, most);
            let (needed_rate, rate_slack) = rates[k].map_or((0.0, 0.0), |(r, s)| (r.abs(), s));
            let (from, to) = (&moments[k], &moments[k + 1]);
            let turned = angle_between(from.rear.heading, to.rear.heading);
            let across = f64::midpoint(from.velocity, to.velocity) * turned / dt;
            let Some(mean) = means[k] else {
                return Turn {
                    angle: held,
                    rate: 0.0,
                    needed_angle: 0.0,
                    needed_rate,
                    angle_slack: 0.0,
                    rate_slack,
                    across: Some(across),
                };
            };
            held = mean.angle;
            Turn {
                angle: mean.angle - rate * (mean.at - mean.from),
                rate,
                needed_angle: mean.angle.abs(),
                needed_rate,
                angle_slack: mean.slack,
                rate_slack,
                across: Some(across),
            }
        })
        .collect()
}

/// The mean angle between two moments; nothing where they are too close together, or not one step apart.
fn mean(
    from: &Moment,
    to: &Moment,
    seconds: f64,
    limits: &Limits,
    dt: f64,
    rounding: f64,
) -> Option<Mean> {
    let chord = (to.rear.position - from.rear.position).norm();
    if chord < STANDING || to.step - from.step != 1 {
        return None;
    }
    let turned = angle_between(from.rear.heading, to.rear.heading);
    let half = turned / 2.0;
    let length = if half.abs() > 1e-6 {
        chord * half / half.sin()
    } else {
        chord
    };
    // Heading is gained by length: the mean stands where half of the speed's weight is.
    let (v0, v1) = (from.velocity.max(0.0), to.velocity.max(0.0));
    let share = if v0 + v1 > 0.0 {
        (v0 / 2.0 + (v1 - v0) / 3.0) / f64::midpoint(v0, v1)
    } else {
        0.5
    };
    Some(Mean {
        angle: limits.steering_of(turned / length),
        at: seconds + share * dt,
        from: seconds,
        slack: 2.0 * rounding * (limits.wheelbase + 1.0) / length,
    })
}
