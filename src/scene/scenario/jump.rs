//! Jumps: displacements from one recorded step to the next that no road user can have driven.

use std::fmt;

use super::Track;
use nearmiss_base::geometry::{Placed, Sweep};

/// No road user is faster than this on average, m/s.
const FASTEST: f64 = 100.0;

/// No road user speeds up more than this between two records, m/s².
const STRONGEST: f64 = 20.0;

/// Tolerance of positions against speeds, metres: some recordings give speeds a step late.
const SLACK: f64 = 2.0;

/// The first jump of a track, and how many more there are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// The step before it.
    pub from: i64,
    /// The step after it.
    pub to: i64,
    /// How far it goes, metres.
    pub metres: f64,
    /// How far the greater of the speeds at its ends leads, metres.
    pub explained: f64,
    /// Later jumps.
    pub more: usize,
}

impl Track {
    /// The first place where the position changes by more than 100 m/s allow, or by metres more than the speeds
    /// recorded there explain; steps are `dt` seconds apart.
    #[must_use]
    pub fn jump(&self, dt: f64) -> Option<Jump> {
        let mut found: Option<Jump> = None;
        let mut records = self.iter();
        let mut before = records.next()?;
        for after in records {
            let ((from, a), (to, b)) = (before, after);
            before = after;
            let time = (to - from) as f64 * dt;
            let metres = (b.pose.position - a.pose.position).norm();
            let explained = a.velocity.abs().max(b.velocity.abs()) * time;
            let gained = STRONGEST * time * time / 2.0;
            if metres <= FASTEST * time && metres <= explained + gained + SLACK {
                continue;
            }
            match &mut found {
                Some(first) => first.more += 1,
                None => {
                    found = Some(Jump {
                        from,
                        to,
                        metres,
                        explained,
                        more: 0,
                    });
                }
            }
        }
        found
    }
}

/// The way of a body between two places that are so many seconds apart. `None` for what no road user can have driven,
/// at more than 100 m/s: a jump touches nothing on its way.
#[must_use]
pub fn driven_way<'a>(from: Placed<'a>, to: Placed<'a>, seconds: f64) -> Option<Sweep<'a>> {
    let metres = (to.pose.position - from.pose.position).norm();
    (metres <= FASTEST * seconds).then(|| Sweep::new(from, to))
}

impl fmt::Display for Jump {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            from,
            to,
            metres,
            explained,
            more,
        } = self;
        write!(
            f,
            "jumps {metres:.1} m from step {from} to {to}; its speed explains {explained:.1} m"
        )?;
        match more {
            0 => Ok(()),
            1 => f.write_str("; 1 more jump"),
            more => write!(f, "; {more} more jumps"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Sample;
    use super::*;
    use nearmiss_base::geometry::Point;

    fn track(places: &[(i64, f64)], velocity: Option<f64>) -> Track {
        let sample = |&(step, x): &(i64, f64)| Sample {
            step,
            position: Point::new(x, 0.0),
            heading: None,
            velocity,
            acceleration: None,
        };
        Track::new(places.iter().map(sample).collect(), 0.1, None)
    }

    #[test]
    fn driving_is_no_jump() {
        assert_eq!(Track::default().jump(0.1), None);
        let steady = [(0, 0.0), (1, 2.0), (2, 4.0), (9, 18.0), (10, 20.0)];
        assert_eq!(track(&steady, Some(20.0)).jump(0.1), None);
        assert_eq!(track(&steady, None).jump(0.1), None);
        // Speeds a step late, at full braking.
        assert_eq!(track(&steady, Some(15.0)).jump(0.1), None);
    }

    #[test]
    fn jumps_are_told_with_steps_and_metres() {
        let there_and_back = [(0, 0.0), (1, 2.0), (2, 99.0), (3, 6.0)];
        for velocity in [Some(20.0), None] {
            let jump = track(&there_and_back, velocity).jump(0.1);
            assert!(
                jump.is_some_and(
                    |j| (j.from, j.to, j.more) == (1, 2, 1) && (j.metres - 97.0).abs() < 1e-9
                ),
                "{jump:?}"
            );
        }
        let slow = track(&[(0, 0.0), (1, 2.0), (2, 9.0)], Some(20.0));
        assert_eq!(
            slow.jump(0.1).map(|j| j.to_string()).as_deref(),
            Some("jumps 7.0 m from step 1 to 2; its speed explains 2.0 m")
        );
    }
}
