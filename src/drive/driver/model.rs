//! What a driver is: what it sees at a step, and how hard it brakes then.

use strum::{IntoStaticStr, VariantArray};

/// A row of [`super::DRIVERS`].
#[derive(Debug, Clone, Copy)]
pub struct DriverModel {
    /// Its id on the command line and in tables.
    pub id: &'static str,
    /// Its name in sentences.
    pub name: &'static str,
    /// When it reacts and what it does, as a formula.
    pub formula: &'static str,
    /// The numbers in the formula.
    pub parameters: &'static [Parameter],
    /// Where it is published.
    pub source: &'static str,
    /// What it leaves out.
    pub limits: &'static str,
    /// What it was not made for.
    pub not_made_for: &'static [NotMadeFor],
    /// The gap (m) that it keeps behind a vehicle as fast as itself (m/s), where its source says so.
    pub following_gap: Option<fn(f64) -> f64>,
    /// A fresh one; `None` for the ideal driver, which is a search and not a rule.
    pub(crate) begin: Option<fn() -> Box<dyn Driver>>,
}

/// A number in a driver's formula.
#[derive(Debug, Clone, Copy)]
pub struct Parameter {
    /// Its symbol in the formula.
    pub symbol: &'static str,
    /// Its value.
    pub value: f64,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub what: &'static str,
}

/// A kind of conflict that a driver was not made for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum NotMadeFor {
    /// Pedestrians, and who else is no vehicle.
    Pedestrian,
    /// Traffic across the ego's path: more than 45° and less than 135° apart.
    Crossing,
    /// Traffic in the opposite direction.
    Oncoming,
    /// Traffic that comes from behind.
    Behind,
    /// A path that turns by more than 20° until 2 s before the conflict: what comes later may be an evasion.
    Curve,
    /// One of them drives backwards.
    Reversing,
}

nearmiss_record::named!(NotMadeFor, "kind of encounter");

impl NotMadeFor {
    /// In words, after "not made for".
    #[must_use]
    pub fn words(self) -> &'static str {
        match self {
            Self::Pedestrian => "pedestrians",
            Self::Crossing => "crossing traffic",
            Self::Oncoming => "oncoming traffic",
            Self::Behind => "traffic from behind",
            Self::Curve => "curves",
            Self::Reversing => "reversing",
        }
    }
}

/// Another road user at one step, along the path of the ego. Metres and m/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// From the ego's centre to its centre along the path; negative behind.
    pub ahead: f64,
    /// Between both bodies along the path; negative where they overlap.
    pub gap_long: f64,
    /// Between both bodies across the path; negative where they overlap.
    pub gap_lat: f64,
    /// Its centre's offset from the path, to the left.
    pub aside: f64,
    /// Half of both lengths along the path.
    pub half_lengths: f64,
    /// Its speed along the path.
    pub speed: f64,
    /// Its speed towards the path; negative away from it.
    pub towards: f64,
    /// How fast its speed along the path changed in the last 0.4 s, m/s².
    pub acceleration: f64,
    /// How far its centre left the middle of its lane towards the ego's, where the lane is known.
    pub left_lane: Option<f64>,
    /// How surprising its place is to who expected it a second ago to keep its speed and direction, nats: the residual
    /// information ½z² along and across the path (Dinparastdjadid, Supeene and Engström, arXiv 2305.07733, 2023).
    pub surprise: f64,
}

impl Seen {
    /// Seconds until the gap is closed at the speeds of the moment; infinite or negative where it opens.
    #[must_use]
    pub fn ttc(&self, speed: f64) -> f64 {
        self.gap_long / (speed - self.speed)
    }
}

/// What a driver knows at a step.
#[derive(Debug, Clone, Copy)]
pub struct Now<'a> {
    /// Seconds since the step before.
    pub dt: f64,
    /// The ego's speed, m/s.
    pub speed: f64,
    /// The ego's acceleration in the step before, m/s².
    pub acceleration: f64,
    /// The others that it can see.
    pub others: &'a [Seen],
    /// Whether a danger is there by definition: in the families that begin with it.
    pub alarmed: bool,
}

/// A person at the wheel: asked once a step, in order.
pub trait Driver: Send {
    /// The acceleration (m/s²) until the next step where something makes it react; `None` where nothing does.
    fn react(&mut self, now: &Now<'_>) -> Option<f64>;

    /// Whether its source calls a cut-in by this one no danger for good, with the ego at this speed (m/s).
    fn dismisses(&self, _: &Seen, _: f64) -> bool {
        false
    }
}

/// What is surprising, see [`Seen::surprise`]: `along` and `aside` are how far it is from where it was expected, metres.
///
/// The expectation is as wide as ordinary accelerations of 1 m/s² move someone within that second.
pub(super) fn surprise(along: f64, aside: f64) -> f64 {
    (along * along + aside * aside) / (2.0 * EXPECTED * EXPECTED)
}

/// Metres.
const EXPECTED: f64 = 0.5;

/// How far ahead others are expected to be somewhere, seconds.
pub(super) const EXPECTATION: f64 = 1.0;

/// A foot on its way to the brake, and on it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Foot {
    /// The seconds that it takes to the brake, and back.
    whole: f64,
    /// Until it is on the brake, seconds.
    pub delay: f64,
    /// Since nothing made it react, seconds.
    idle: f64,
    /// The present deceleration, m/s².
    pub deceleration: f64,
}

impl Foot {
    /// A foot that needs so many seconds.
    pub fn after(delay: f64) -> Self {
        Self {
            whole: delay,
            delay,
            idle: 0.0,
            deceleration: 0.0,
        }
    }

    /// What it does in this step if there is a risk, as `act` says.
    pub fn react(
        &mut self,
        risky: bool,
        dt: f64,
        act: impl FnOnce(&mut Self) -> f64,
    ) -> Option<f64> {
        if risky {
            self.idle = 0.0;
            return Some(act(self));
        }
        self.rest(dt);
        None
    }

    /// A step without a risk. After as many as it took to the brake it is back, and needs that time again: whether it is.
    pub fn rest(&mut self, dt: f64) -> bool {
        self.idle += dt;
        let is_back = self.idle > self.whole - 1e-9;
        if is_back {
            *self = Self::after(self.whole);
        }
        is_back
    }

    /// Whether it is still on its way in this step.
    pub fn is_late(&mut self, dt: f64) -> bool {
        // Steps of 0.05 s leave a residue.
        let late = self.delay > 1e-9;
        if late {
            self.delay -= dt;
        }
        late
    }

    /// Presses on, by `jerk` (m/s³) and up to `most` (m/s²): the acceleration.
    pub fn press(&mut self, jerk: f64, most: f64, dt: f64) -> f64 {
        self.deceleration = (self.deceleration + jerk * dt).min(most);
        -self.deceleration
    }
}

#[cfg(test)]
mod tests {
    use super::Foot;

    #[test]
    fn a_delay_is_as_many_steps_as_it_has() {
        for (delay, dt, steps) in [
            (0.35, 0.05, 7),
            (0.35, 0.1, 4),
            (0.75, 0.1, 8),
            (0.75, 0.05, 15),
        ] {
            let mut foot = Foot::after(delay);
            let late = (0..100).take_while(|_| foot.is_late(dt)).count();
            assert_eq!(late, steps, "{delay} s in steps of {dt} s");
        }
    }

    #[test]
    fn a_new_risk_takes_the_delay_again() {
        let dt = 0.1;
        let mut foot = Foot::after(0.75);
        let mut braking = |risky| {
            let act = |foot: &mut Foot| {
                if foot.is_late(dt) {
                    0.0
                } else {
                    foot.press(10.0, 7.0, dt)
                }
            };
            foot.react(risky, dt, act)
        };
        let mut late = |quiet: usize| {
            let calm: Vec<_> = (0..quiet).map(|_| braking(false)).collect();
            assert!(calm.iter().all(Option::is_none));
            (0..20).filter(|_| braking(true) == Some(0.0)).count()
        };
        assert_eq!((late(0), late(7), late(8)), (8, 0, 8));
    }
}
