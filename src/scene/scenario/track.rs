//! The motion of one participant, step by step, with the gaps of the file filled and counted, and jumps that none can drive.

use std::fmt;

use nearmiss_base::geometry::{Placed, Point, Pose, ReferencePath, Sweep, Vector, angle_between};

/// What a file says about one step; what it does not say is filled by [`Track::new`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Time step.
    pub step: i64,
    /// Centre of the footprint's frame, metres.
    pub position: Point,
    /// Radians.
    pub heading: Option<f64>,
    /// m/s along the heading.
    pub velocity: Option<f64>,
    /// m/s² along the heading.
    pub acceleration: Option<f64>,
}

/// Everything about one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Where, and which way.
    pub pose: Pose,
    /// m/s along the heading; negative when reversing.
    pub velocity: f64,
    /// m/s² along the heading.
    pub acceleration: f64,
}

impl Motion {
    /// Velocity in the plane, m/s.
    #[must_use]
    pub fn velocity_vector(&self) -> Vector {
        self.pose.forward() * self.velocity
    }

    /// Acceleration in the plane, along the heading, m/s².
    #[must_use]
    pub fn acceleration_vector(&self) -> Vector {
        self.pose.forward() * self.acceleration
    }

    /// How far the two are apart in place (m), heading (rad) and speed (m/s).
    #[must_use]
    pub fn differences(&self, other: &Self) -> [(&'static str, f64); 3] {
        let turned = angle_between(self.pose.heading, other.pose.heading).abs();
        let apart = (self.pose.position - other.pose.position).norm();
        [
            ("position", apart),
            ("heading", turned),
            ("velocity", (self.velocity - other.velocity).abs()),
        ]
    }
}

/// How many steps had to be filled, by quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DerivedCounts {
    /// Headings, from displacements or held.
    pub headings: usize,
    /// Velocities, from displacements.
    pub velocities: usize,
    /// Accelerations, from velocities.
    pub accelerations: usize,
}

/// Motion by time step; steps without a record are not there.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Track {
    /// In order of time, so that gaps cost nothing.
    motions: Vec<(i64, Motion)>,
    /// What was filled.
    pub derived: DerivedCounts,
    /// Motions until the first step have heading or velocity from the second one.
    lead: Option<(i64, i64)>,
    /// The acceleration at the first step is from the second one.
    lead_acceleration: Option<(i64, i64)>,
}

/// A displacement below this says nothing about the heading: files round to tenths of millimetres.
const STANDSTILL: f64 = 0.005;

/// Time steps between the first and the last record that a track keeps; what is later is a mistake in
/// the file, and a loop over all steps would never end.
pub const LONGEST_TRACK: i64 = 100_000;

impl Track {
    /// A track through `samples` (any order, one a step), `dt` seconds apart.
    ///
    /// A missing heading follows the displacement, and is held at standstill; before the first
    /// displacement it is `resting`, or the next heading that is known. A missing velocity is the
    /// displacement along the heading per time, a missing acceleration the change of velocity.
    #[must_use]
    pub fn new(mut samples: Vec<Sample>, dt: f64, resting: Option<f64>) -> Self {
        samples.sort_by_key(|s| s.step);
        samples.dedup_by_key(|s| s.step);
        let Some(first) = samples.first().map(|s| s.step) else {
            return Self::default();
        };
        samples.retain(|s| s.step.saturating_sub(first) <= LONGEST_TRACK);
        let lead = lead(&samples, resting);
        let next = samples.get(1).map(|s| (first, s.step));
        let lead_acceleration = next.filter(|_| samples[0].acceleration.is_none());
        let mut derived = DerivedCounts::default();
        let headings = headings(&samples, resting, &mut derived);
        let velocities = velocities(&samples, &headings, dt, &mut derived);
        let mut motions = Vec::with_capacity(samples.len());
        for (i, sample) in samples.iter().enumerate() {
            let acceleration = sample.acceleration.unwrap_or_else(|| {
                derived.accelerations += 1;
                let (a, b) = neighbours(i, samples.len());
                let time = (samples[b].step - samples[a].step) as f64 * dt;
                if time > 0.0 {
                    (velocities[b] - velocities[a]) / time
                } else {
                    0.0
                }
            });
            let pose = Pose {
                position: sample.position,
                heading: headings[i],
            };
            let motion = Motion {
                pose,
                velocity: velocities[i],
                acceleration,
            };
            motions.push((sample.step, motion));
        }
        Self {
            motions,
            derived,
            lead,
            lead_acceleration,
        }
    }

    /// The last step that heading and velocity at `step` were filled from: a later one where a track begins without them.
    #[must_use]
    pub fn motion_known_at(&self, step: i64) -> i64 {
        known_at(self.lead, step)
    }

    /// The same of the acceleration.
    #[must_use]
    pub fn acceleration_known_at(&self, step: i64) -> i64 {
        known_at(self.lead_acceleration, step).max(self.motion_known_at(step))
    }

    /// The motion at a time step; `None` before, after and in gaps.
    #[must_use]
    pub fn at(&self, step: i64) -> Option<&Motion> {
        let first = self.motions.first()?.0;
        // Nearly all tracks have no gaps, and then the place is known.
        let place = usize::try_from(step.checked_sub(first)?).ok()?;
        match self.motions.get(place) {
            Some((there, motion)) if *there == step => Some(motion),
            _ => {
                let found = self.motions.binary_search_by_key(&step, |(s, _)| *s);
                Some(&self.motions[found.ok()?].1)
            }
        }
    }

    /// The steps from the first to the last record; empty for an empty track.
    #[must_use]
    pub fn steps(&self) -> std::ops::Range<i64> {
        match (self.motions.first(), self.motions.last()) {
            (Some((first, _)), Some((last, _))) => *first..last + 1,
            _ => 0..0,
        }
    }

    /// Steps and motions that are recorded from `steps.start()` to `steps.end()`, in order.
    #[must_use]
    pub fn during(&self, steps: &std::ops::RangeInclusive<i64>) -> &[(i64, Motion)] {
        let from = self.motions.partition_point(|(s, _)| s < steps.start());
        let to = self.motions.partition_point(|(s, _)| s <= steps.end());
        self.motions.get(from..to).unwrap_or_default()
    }

    /// Steps and motions that are recorded, in order.
    pub fn iter(&self) -> impl Iterator<Item = (i64, &Motion)> {
        self.motions.iter().map(|(step, motion)| (*step, motion))
    }

    /// The path through its places, straight on behind both ends; `None` where it stands or turns back on itself.
    #[must_use]
    pub fn path(&self) -> Option<ReferencePath> {
        ReferencePath::new(way(&self.motions)).ok()
    }

    /// How long it is there, seconds, and how far it drives, metres; its gaps count for neither.
    #[must_use]
    pub fn driven(&self, dt: f64) -> (f64, f64) {
        let runs = self.motions.chunk_by(|a, b| a.0 + 1 == b.0);
        runs.fold((0.0, 0.0), |(seconds, metres), run| {
            let places = way(run);
            let legs = places.windows(2).map(|ends| (ends[1] - ends[0]).norm());
            (
                seconds + (run.len() - 1) as f64 * dt,
                metres + legs.sum::<f64>(),
            )
        })
    }
}

/// Places nearer to each other are noise of who stands, metres.
const LEAST_LEG: f64 = 1.0;

/// The first place, and those that are at least [`LEAST_LEG`] from the one before.
fn way(motions: &[(i64, Motion)]) -> Vec<Point> {
    let mut places = motions.iter().map(|(_, motion)| motion.pose.position);
    let mut way: Vec<Point> = places.next().into_iter().collect();
    for place in places {
        if way
            .last()
            .is_some_and(|last| (place - last).norm() >= LEAST_LEG)
        {
            way.push(place);
        }
    }
    way
}

fn known_at(lead: Option<(i64, i64)>, step: i64) -> i64 {
    match lead {
        Some((until, from)) if step <= until => from,
        _ => step,
    }
}

/// Until which step headings or velocities are filled from a later one, and from which.
fn lead(samples: &[Sample], resting: Option<f64>) -> Option<(i64, i64)> {
    let (first, next) = (samples.first()?, samples.get(1)?);
    let moved = |i: usize| (samples[i].position - samples[i - 1].position).norm() >= STANDSTILL;
    let known = |i: &usize| samples[*i].heading.is_some() || *i > 0 && moved(*i);
    let heading = match (resting, (0..samples.len()).find(known)) {
        (Some(_), _) | (None, Some(0)) => None,
        (None, Some(i)) => Some((samples[i - 1].step, samples[i].step)),
        // It would be that of a later displacement, if there were one.
        (None, None) => samples.last().map(|last| (last.step, last.step)),
    };
    let velocity = first.velocity.is_none().then_some((first.step, next.step));
    match (heading, velocity) {
        (Some(a), Some(b)) => Some((a.0.max(b.0), a.1.max(b.1))),
        (one, other) => one.or(other),
    }
}

/// The step before and this one; for the first, this one and the next.
fn neighbours(i: usize, count: usize) -> (usize, usize) {
    if i > 0 {
        (i - 1, i)
    } else {
        (0, usize::from(count > 1))
    }
}

fn headings(samples: &[Sample], resting: Option<f64>, derived: &mut DerivedCounts) -> Vec<f64> {
    let mut known: Vec<Option<f64>> = Vec::with_capacity(samples.len());
    for (i, sample) in samples.iter().enumerate() {
        let held = known.last().copied().flatten();
        known.push(sample.heading.or_else(|| {
            derived.headings += 1;
            let before = samples.get(i.wrapping_sub(1))?;
            let moved = sample.position - before.position;
            if moved.norm() >= STANDSTILL {
                Some(moved.y.atan2(moved.x))
            } else {
                held
            }
        }));
    }
    let first_known = known.iter().flatten().next().copied();
    let start = resting.or(first_known).unwrap_or(0.0);
    let mut last = start;
    for heading in &mut known {
        last = *heading.get_or_insert(last);
    }
    known.into_iter().flatten().collect()
}

fn velocities(
    samples: &[Sample],
    headings: &[f64],
    dt: f64,
    derived: &mut DerivedCounts,
) -> Vec<f64> {
    let filled = samples.iter().enumerate().map(|(i, sample)| {
        sample.velocity.unwrap_or_else(|| {
            derived.velocities += 1;
            let (a, b) = neighbours(i, samples.len());
            let time = (samples[b].step - samples[a].step) as f64 * dt;
            let along = Vector::new(headings[i].cos(), headings[i].sin());
            if time > 0.0 {
                (samples[b].position - samples[a].position).dot(&along) / time
            } else {
                0.0
            }
        })
    });
    filled.collect()
}

/// Forgets headings that a recorder could not know: those at steps that hardly moved, where they are nothing but the
/// direction of the last displacement, which is 0 or noise at standstill, and those of 0 at a velocity of 0, which is the
/// direction of none. Measured headings are kept.
pub fn forget_headings_at_standstill(samples: &mut [Sample]) {
    let follow = follow_displacements(samples);
    for i in (1..samples.len()).rev() {
        let moved = samples[i].position - samples[i - 1].position;
        let direction = moved.y.atan2(moved.x);
        let says_nothing = |heading: f64| {
            let is_noise = follow || angle_between(direction, heading).abs() <= NO_DIRECTION;
            moved.norm() < STANDSTILL && is_noise
                || samples[i].velocity == Some(0.0) && heading.abs() <= NO_DIRECTION
        };
        if samples[i].heading.is_some_and(says_nothing) {
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

    pub(super) fn sample(step: i64, x: f64, heading: Option<f64>) -> Sample {
        Sample {
            step,
            position: Point::new(x, 0.0),
            heading,
            velocity: None,
            acceleration: None,
        }
    }

    #[test]
    fn fills_what_is_missing() {
        let samples = vec![
            sample(3, 0.0, None),
            sample(4, 1.0, None),
            sample(5, 3.0, None),
        ];
        let track = Track::new(samples, 0.1, None);
        assert_eq!(track.steps(), 3..6);
        assert_eq!(track.derived.headings, 3);
        let last = track.at(5).expect("recorded");
        assert!((last.velocity - 20.0).abs() < 1e-9);
        assert!((last.acceleration - 100.0).abs() < 1e-9);
        assert!(track.at(2).is_none() && track.at(6).is_none());
    }

    #[test]
    fn what_is_filled_from_later_steps_is_told() {
        let told = |samples: Vec<Sample>, step| {
            let track = Track::new(samples, 0.1, None);
            (
                track.motion_known_at(step),
                track.acceleration_known_at(step),
            )
        };
        let bare = |n: i64| {
            (0..n)
                .map(|i| sample(i, i as f64, Some(0.0)))
                .collect::<Vec<_>>()
        };
        assert_eq!(
            told(bare(3), 0),
            (1, 1),
            "the first velocity is the next displacement"
        );
        assert_eq!(told(bare(3), 1), (1, 1));
        assert_eq!(told(bare(1), 0), (0, 0));
        let mut moving = bare(3);
        moving[0].velocity = Some(10.0);
        assert_eq!(told(moving.clone(), 0), (0, 1));
        moving[0].acceleration = Some(0.0);
        assert_eq!(told(moving, 0), (0, 0));
        // At rest until step 3, with no heading before.
        let mut resting: Vec<_> = (0..5)
            .map(|i| sample(i, (i - 2).max(0) as f64, None))
            .collect();
        resting[0].velocity = Some(0.0);
        assert_eq!(told(resting.clone(), 2), (3, 3));
        assert_eq!(told(resting, 3), (3, 3));
    }

    #[test]
    fn gaps_stay_gaps_and_absurd_times_are_dropped() {
        let samples = vec![
            sample(0, 0.0, None),
            sample(2, 2.0, None),
            sample(i64::MAX, 9.0, None),
        ];
        let track = Track::new(samples, 0.1, None);
        assert!(track.at(1).is_none() && track.at(2).is_some());
        assert_eq!(track.iter().count(), 2);
        assert!(track.at(i64::MIN).is_none());
    }

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
