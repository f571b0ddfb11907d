//! The families of UN Regulation 157 on a straight road: cut-in, cut-out and braking ahead, with two boxes or three.
//!
//! Motions are those of JRC-FSM (Joint Research Centre, 2021), which draws the figures of the regulation's annex: ten steps
//! a second, places that follow from the speed at their own step, contact where boxes overlap at a step.

use strum::{IntoStaticStr, VariantArray};

use super::DRIVERS;
use super::competent::WANDERING;
use super::model::{Driver, DriverModel, EXPECTATION, Now, Seen, surprise};

/// Cases that differ in their parameters alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "kebab-case")]
pub enum Family {
    /// See [`Case::CutIn`].
    CutIn,
    /// See [`Case::CutOut`].
    CutOut,
    /// See [`Case::Braking`].
    Braking,
}

nearmiss_record::named!(Family, "family");

/// A case: a family with its parameters. Speeds in m/s, lengths in m, decelerations in m/s².
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Case {
    /// A slower vehicle comes into the ego's lane.
    CutIn {
        /// The ego's.
        speed: f64,
        /// The other's.
        other: f64,
        /// Between both along the road, once it has its lateral speed.
        gap: f64,
        /// Its lateral speed.
        lateral: f64,
    },
    /// The vehicle ahead leaves the lane, in front of one that stands.
    CutOut {
        /// Of both that drive.
        speed: f64,
        /// Between the one ahead and the one that stands.
        front: f64,
        /// The lateral speed of the one ahead.
        lateral: f64,
    },
    /// The vehicle ahead brakes to a standstill.
    Braking {
        /// Of both.
        speed: f64,
        /// How hard.
        deceleration: f64,
    },
}

/// What comes of a case with a driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CaseResult {
    /// The ego's speed less the other's at the contact, m/s; `None` where it is avoided.
    pub closing_speed: Option<f64>,
    /// The gap that the driver keeps to the vehicle ahead before, metres; of a cut-in that of the case.
    pub gap: f64,
}

/// Every box, metres.
const LENGTH: f64 = 4.3;
const WIDTH: f64 = 1.9;

/// Steps of a case, and those of a second.
const STEPS: usize = 350;
const RATE: f64 = 10.0;
const DT: f64 = 1.0 / RATE;

/// Between the bodies across the road before a cut-in, metres.
const ASIDE: f64 = 1.6;

/// How fast a cut-in gets its lateral speed, m/s².
const LATERAL: f64 = 1.5;

/// From middle to middle of the lanes of a cut-out, metres.
const LANES: f64 = 4.0;

/// Where a vehicle is at a step, and how fast: along and across the road.
#[derive(Debug, Clone, Copy)]
struct At {
    x: f64,
    y: f64,
    vx: f64,
    vy: f64,
}

/// From a place on with these speeds: at each step it has moved with the speed of that step.
fn course(x: f64, y: f64, speeds: impl Iterator<Item = (f64, f64)>) -> Vec<At> {
    let mut moved = (0.0, 0.0);
    let places = speeds.map(|(vx, vy)| {
        moved = (moved.0 + vx, moved.1 + vy);
        At {
            x: moved.0 / RATE + x,
            y: moved.1 / RATE + y,
            vx,
            vy,
        }
    });
    places.collect()
}

/// To the right with a lateral speed for as long as it needs for `aside` metres, then straight on.
fn sideways(x: f64, y: f64, (speed, lateral): (f64, f64), aside: f64) -> Vec<At> {
    let whole = RATE * aside;
    let moving = if lateral == 0.0 {
        0.0
    } else {
        ((whole - whole % lateral) / lateral).round() + 1.0
    };
    course(
        x,
        y,
        (0..STEPS).map(|i| (speed, if (i as f64) < moving { -lateral } else { 0.0 })),
    )
}

/// The ego of a case and its driver.
struct Seat {
    driver: Box<dyn Driver>,
    x: f64,
    speed: f64,
    acceleration: f64,
    reacted: bool,
}

impl Seat {
    /// What it sees of a course at a step, from the lane's middle; `lane` is how wide lanes are, if it knows.
    fn see(&self, others: &[At], step: usize, lane: Option<f64>) -> Seen {
        let now = others[step];
        let (ahead, aside) = (now.x - self.x, now.y);
        let ago = (EXPECTATION * RATE) as usize;
        let then = step.checked_sub(ago).map(|then| others[then]);
        Seen {
            ahead,
            gap_long: ahead.abs() - LENGTH / 2.0 - LENGTH / 2.0,
            gap_lat: aside.abs() - WIDTH / 2.0 - WIDTH / 2.0,
            aside,
            half_lengths: LENGTH,
            speed: now.vx,
            towards: -now.vy * aside.signum(),
            acceleration: step
                .checked_sub(1)
                .map_or(0.0, |before| (now.vx - others[before].vx) * RATE),
            left_lane: lane.map(|width| width - aside.abs()),
            surprise: then.map_or(0.0, |then| {
                let (x, y) = (
                    then.x + then.vx * EXPECTATION,
                    then.y + then.vy * EXPECTATION,
                );
                surprise(now.x - x, now.y - y)
            }),
        }
    }

    /// Whether bodies overlap, and the ego's speed less the other's then; drives on for a step.
    fn step(&mut self, seen: &Seen, alarmed: bool) -> Option<f64> {
        let now = Now {
            dt: DT,
            speed: self.speed,
            acceleration: self.acceleration,
            others: std::slice::from_ref(seen),
            alarmed,
        };
        let touches = seen.gap_lat < 0.0 && seen.gap_long < 0.0;
        let closing = touches.then_some(self.speed - seen.speed);
        let before = self.speed;
        if let Some(acceleration) = self.driver.react(&now) {
            self.reacted = true;
            self.speed = (self.speed + acceleration / RATE).max(0.0);
        }
        self.acceleration = (self.speed - before) * RATE;
        self.x += self.speed / RATE;
        closing
    }
}

impl Case {
    /// The cases of JRC-FSM, by speed of the ego, then that of the other; of these every gap, front or speed has all lateral
    /// speeds or decelerations.
    #[must_use]
    pub fn grid(family: Family) -> Vec<Self> {
        let kmh = |speed: i32| f64::from(speed) / 3.6;
        let mut cases = Vec::new();
        match family {
            Family::CutIn => {
                let slow = (10..=60).step_by(10).map(|speed| (speed, 10, 1));
                let fast = (70..=130).step_by(20).map(|speed| (speed, 30, 2));
                for (speed, slower, apart) in slow.chain(fast) {
                    for other in (10..speed).step_by(slower) {
                        for gap in (1..60 * apart).step_by(apart as usize) {
                            cases.extend((0..18).map(|lateral| Self::CutIn {
                                speed: kmh(speed),
                                other: kmh(other),
                                gap: f64::from(gap),
                                lateral: f64::from(lateral) * 0.1,
                            }));
                        }
                    }
                }
            }
            Family::CutOut => {
                for speed in (10..=130).step_by(10) {
                    for front in (2..152).step_by(5) {
                        cases.extend((0..15).map(|lateral| Self::CutOut {
                            speed: kmh(speed),
                            front: f64::from(front),
                            lateral: 0.1 + f64::from(lateral) * 0.2,
                        }));
                    }
                }
            }
            Family::Braking => {
                for speed in (12..130).step_by(2) {
                    cases.extend((1..20).map(|share| Self::Braking {
                        speed: kmh(speed),
                        deceleration: 9.81 * (f64::from(share) * 0.05),
                    }));
                }
            }
        }
        cases
    }

    /// Its parameters in the order of their fields.
    #[must_use]
    pub fn parameters(&self) -> Vec<f64> {
        match *self {
            Self::CutIn {
                speed,
                other,
                gap,
                lateral,
            } => vec![speed, other, gap, lateral],
            Self::CutOut {
                speed,
                front,
                lateral,
            } => vec![speed, front, lateral],
            Self::Braking {
                speed,
                deceleration,
            } => vec![speed, deceleration],
        }
    }

    /// What comes of it with a driver. `None` for one without a rule (the ideal driver), and in families that begin with
    /// following where its source does not say how it follows.
    #[must_use]
    pub fn with(&self, driver: &DriverModel) -> Option<CaseResult> {
        self.run(driver, None)
    }

    /// The same where the driver knows the lanes, `width` metres wide: the regulation's own figures.
    #[must_use]
    pub fn with_lanes(&self, driver: &DriverModel, width: f64) -> Option<CaseResult> {
        self.run(driver, Some(width))
    }

    /// The results of all drivers that have one, in the order of [`DRIVERS`].
    pub fn all(&self) -> impl Iterator<Item = (&'static DriverModel, CaseResult)> {
        DRIVERS
            .iter()
            .filter_map(|driver| Some((driver, self.with(driver)?)))
    }

    fn run(&self, driver: &DriverModel, lane: Option<f64>) -> Option<CaseResult> {
        let (Self::CutIn { speed, .. } | Self::CutOut { speed, .. } | Self::Braking { speed, .. }) =
            *self;
        let gap = match *self {
            Self::CutIn { gap, .. } => gap,
            _ => driver.following_gap?(speed),
        };
        let seat = Seat {
            driver: (driver.begin?)(),
            x: speed / RATE,
            speed,
            acceleration: 0.0,
            reacted: false,
        };
        let ahead = gap + LENGTH;
        let closing_speed = match *self {
            Self::CutIn { other, lateral, .. } => cut_in(seat, ahead, (other, lateral), lane),
            Self::CutOut { front, lateral, .. } => {
                let leaving = sideways(ahead, LANES, (speed, lateral), LANES);
                cut_out(seat, leaving, ahead + front + LENGTH)
            }
            Self::Braking { deceleration, .. } => {
                let speeds = (0..STEPS).map(|i| (speed - i as f64 * deceleration / RATE).max(0.0));
                following(seat, &course(ahead, 0.0, speeds.map(|v| (v, 0.0))))
            }
        };
        Some(CaseResult { closing_speed, gap })
    }
}

fn cut_in(
    mut ego: Seat,
    ahead: f64,
    (other, lateral): (f64, f64),
    lane: Option<f64>,
) -> Option<f64> {
    let y = ASIDE + WIDTH;
    // Before, it gets its lateral speed.
    let count = (lateral / (LATERAL / RATE)).ceil() as usize;
    let faster: Vec<f64> = (0..count).map(|i| i as f64 * (LATERAL / RATE)).collect();
    let mut back = (0.0, 0.0);
    let mut others = vec![At {
        x: ahead,
        y,
        vx: other,
        vy: -lateral,
    }];
    ego.x = 0.0;
    for vy in faster.iter().rev() {
        back = (back.0 - other / RATE, back.1 + vy / RATE);
        others.push(At {
            x: back.0 + ahead,
            y: back.1 + y,
            vx: other,
            vy: -vy,
        });
        ego.x -= ego.speed / RATE;
    }
    others.reverse();
    others.extend(sideways(ahead, y, (other, lateral), y));
    for step in 0..others.len() - 1 {
        let seen = ego.see(&others, step, lane);
        let dismissed = ego.driver.dismisses(&seen, ego.speed);
        let touch = ego.step(&seen, false);
        if touch.is_some() || dismissed {
            return touch;
        }
    }
    None
}

fn cut_out(mut ego: Seat, mut leaving: Vec<At>, standing: f64) -> Option<f64> {
    let stands = vec![
        At {
            x: standing,
            y: 0.0,
            vx: 0.0,
            vy: 0.0
        };
        STEPS
    ];
    for at in &mut leaving {
        at.y -= LANES;
    }
    let mut crashed = false;
    let mut driven = 0.0;
    for step in 0..STEPS - 1 {
        let at = leaving[step];
        if (at.y.abs() - WIDTH / 2.0 - WIDTH / 2.0) < 0.0
            && ((standing - at.x).abs() - LENGTH / 2.0 - LENGTH / 2.0) < 0.0
        {
            crashed = true;
            leaving[step..].fill(At {
                vx: 0.0,
                vy: 0.0,
                ..at
            });
        }
        if !crashed && at.y >= -WANDERING {
            // Nothing is seen of the one that stands.
            driven += ego.speed;
            ego.x = (driven + ego.speed) / RATE;
            continue;
        }
        let others = if crashed { &leaving } else { &stands };
        let seen = ego.see(others, step, None);
        let stood = ego.speed == 0.0;
        let touch = ego.step(&seen, true);
        if touch.is_some() || stood {
            return touch;
        }
    }
    None
}

fn following(mut ego: Seat, ahead: &[At]) -> Option<f64> {
    for step in 0..STEPS - 1 {
        let seen = ego.see(ahead, step, None);
        let stood = ego.speed == 0.0;
        let touch = ego.step(&seen, true);
        if touch.is_some() || stood {
            return touch;
        }
    }
    None
}
