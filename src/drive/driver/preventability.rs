//! Which drivers would have avoided a contact or near miss, and until when they could.

use nearmiss_scene::scenario::ObstacleType;
use strum::{IntoStaticStr, VariantArray};

use super::field::Field;
use super::model::{DriverModel, NotMadeFor};
use super::ride::{Ride, Touch};
use super::{DRIVERS, ideal};
use nearmiss_base::geometry::angle_between;

/// What all drivers make of one event.
#[derive(Debug, Clone)]
pub struct Preventability {
    /// The other in it.
    pub obstacle: i64,
    /// Its step: of the contact, or of a near miss its most severe one.
    pub step: i64,
    /// From this step on another one drives.
    pub from: i64,
    /// The contact of the recorded or planned ego; `None` of a near miss.
    pub contact: Option<Touch>,
    /// One for each of [`DRIVERS`], in their order.
    pub verdicts: Vec<DriverVerdict>,
}

/// What one driver makes of it.
#[derive(Debug, Clone)]
pub struct DriverVerdict {
    /// Who.
    pub driver: &'static DriverModel,
    /// What comes of it.
    pub result: DriverResult,
    /// The step at which it reacts first.
    pub reacts: Option<i64>,
    /// The last step at which it could take the wheel and still avoid it; `None` where there is none, and where that
    /// was not looked for.
    pub last_moment: Option<i64>,
}

/// How it ends with a driver.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DriverResult {
    /// Without contact.
    Avoided,
    /// With a contact that is slower by 0.5 m/s or more.
    Mitigated(Touch),
    /// With a contact.
    NotAvoided(Touch),
    /// Someone who follows its recording and does not see the braking runs into it from behind: that decides nothing.
    HitFromBehind(Touch),
    /// The model was not made for it.
    NotMadeFor(NotMadeFor),
}

/// What comes of a driver, without the contact.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum DriverOutcome {
    /// See [`DriverResult::Avoided`].
    Avoided,
    /// See [`DriverResult::Mitigated`].
    Mitigated,
    /// See [`DriverResult::NotAvoided`].
    NotAvoided,
    /// See [`DriverResult::HitFromBehind`].
    HitFromBehind,
    /// See [`DriverResult::NotMadeFor`].
    #[default]
    NotMadeFor,
}

nearmiss_record::named!(DriverOutcome, "outcome");

impl DriverOutcome {
    /// Whether it decides: avoided or not.
    #[must_use]
    pub fn decides(self) -> bool {
        !matches!(self, Self::HitFromBehind | Self::NotMadeFor)
    }
}

/// A contact that is slower by this is mitigated, m/s.
const SLOWER: f64 = 0.5;

/// Directions farther apart are crossing ones, and oncoming ones, radians.
const CROSSING: f64 = std::f64::consts::FRAC_PI_4;
const ONCOMING: f64 = 3.0 * std::f64::consts::FRAC_PI_4;

/// So long before the contact its direction counts, seconds.
const APPROACH: f64 = 2.0;

/// So long before the encounter the ego's path may be its evasion, and is no curve, seconds.
const EVASION: f64 = 2.0;

/// What is slower stands, m/s: its heading does not matter.
const STANDING: f64 = 0.5;

/// A path that turns more is a curve, radians.
const CURVE: f64 = 20.0 * std::f64::consts::PI / 180.0;

impl DriverResult {
    /// The same without the contact.
    #[must_use]
    pub fn outcome(&self) -> DriverOutcome {
        match self {
            Self::Avoided => DriverOutcome::Avoided,
            Self::Mitigated(_) => DriverOutcome::Mitigated,
            Self::NotAvoided(_) => DriverOutcome::NotAvoided,
            Self::HitFromBehind(_) => DriverOutcome::HitFromBehind,
            Self::NotMadeFor(_) => DriverOutcome::NotMadeFor,
        }
    }

    /// The contact, if it comes to one.
    #[must_use]
    pub fn contact(&self) -> Option<&Touch> {
        match self {
            Self::Mitigated(touch) | Self::NotAvoided(touch) | Self::HitFromBehind(touch) => {
                Some(touch)
            }
            Self::Avoided | Self::NotMadeFor(_) => None,
        }
    }

    /// Whether it decides: avoided or not.
    #[must_use]
    pub fn decides(&self) -> bool {
        self.outcome().decides()
    }
}

impl Preventability {
    /// What drivers make of an encounter.
    ///
    /// Each takes the wheel 5 s before, or where the recording begins, and is looked at until 4 s after it.
    #[must_use]
    pub fn of(field: &Field<'_>) -> Self {
        let contact = field.contact;
        let kinds = field.kinds();
        let from = field.first;
        let result = |ride: &Ride| match (ride.touch, contact) {
            (None, _) => DriverResult::Avoided,
            (Some(touch), _)
                if touch.is_from_behind() && contact.is_none_or(|c| !c.is_from_behind()) =>
            {
                DriverResult::HitFromBehind(touch)
            }
            (Some(touch), Some(before)) if touch.closing_speed < before.closing_speed - SLOWER => {
                DriverResult::Mitigated(touch)
            }
            (Some(touch), _) => DriverResult::NotAvoided(touch),
        };
        let verdicts = DRIVERS.iter().filter_map(|driver| {
            let kind = driver.not_made_for.iter().find(|kind| kinds.contains(kind));
            let (result, reacts) = match kind {
                Some(kind) => (DriverResult::NotMadeFor(*kind), None),
                None => {
                    let ride = field.ride_of(driver, from)?;
                    (result(&ride), ride.reacts)
                }
            };
            Some(DriverVerdict {
                driver,
                result,
                reacts,
                last_moment: None,
            })
        });
        let verdicts: Vec<DriverVerdict> = verdicts.collect();
        // What another driver does, or the ego did, the ideal one can do, too.
        let own = contact.map_or(DriverResult::Avoided, DriverResult::NotAvoided);
        let speed = |result: &DriverResult| result.contact().map_or(0.0, |c| c.closing_speed);
        let decided = verdicts
            .iter()
            .map(|v| v.result)
            .filter(DriverResult::decides)
            .chain([own]);
        let least = decided.min_by(|a, b| speed(a).total_cmp(&speed(b)));
        let mut found = Self {
            obstacle: field.obstacle,
            step: field.event,
            from,
            contact,
            verdicts,
        };
        if let (Some(least), Some(ideal)) = (least, found.ideal_mut())
            && (speed(&least) < speed(&ideal.result) || !ideal.result.decides())
        {
            ideal.result = least;
        }
        found
    }

    fn ideal_mut(&mut self) -> Option<&mut DriverVerdict> {
        { self.verdicts.iter_mut() }.find(|v| v.driver.id == ideal::MODEL.id)
    }

    /// Says that the ideal driver avoids it: a drive that does is known.
    pub fn ideal_avoids(&mut self) {
        if let Some(ideal) = self.ideal_mut() {
            ideal.result = DriverResult::Avoided;
        }
    }

    /// The same with the last moment of each driver that avoids the contact; a near miss has none: the ego avoids it.
    #[must_use]
    pub fn with_last_moments(mut self, field: &Field<'_>) -> Self {
        if self.contact.is_none() {
            return self;
        }
        let avoids = |verdict: &&mut DriverVerdict| verdict.result == DriverResult::Avoided;
        for verdict in { self.verdicts.iter_mut() }.filter(avoids) {
            verdict.last_moment = field.last_moment(verdict.driver);
        }
        // The ideal driver can do what any other does.
        let latest = self.verdicts.iter().filter_map(|v| v.last_moment).max();
        if let Some(ideal) = self
            .ideal_mut()
            .filter(|ideal| ideal.result == DriverResult::Avoided)
        {
            ideal.last_moment = latest;
        }
        self
    }

    /// How many drivers avoid it, and how many decide.
    #[must_use]
    pub fn count(&self) -> (usize, usize) {
        let decided = self.verdicts.iter().filter(|v| v.result.decides());
        let avoided = decided
            .clone()
            .filter(|v| v.result == DriverResult::Avoided);
        (avoided.count(), decided.count())
    }

    /// Whether the driver with this id avoids contact.
    #[must_use]
    pub fn is_avoided_by(&self, driver: &str) -> bool {
        self.by(driver)
            .is_some_and(|v| v.result == DriverResult::Avoided)
    }

    /// The verdict of a driver.
    #[must_use]
    pub fn by(&self, driver: &str) -> Option<&DriverVerdict> {
        self.verdicts.iter().find(|v| v.driver.id == driver)
    }
}

impl Field<'_> {
    /// The ride of a driver from a step on.
    #[must_use]
    pub fn ride_of(&self, driver: &DriverModel, from: i64) -> Option<Ride> {
        match driver.begin {
            Some(begin) => Some(self.ride(begin().as_mut(), from)),
            None => self.ideal_ride(from),
        }
    }

    /// The last step before the encounter at which a driver can take the wheel and no contact follows.
    #[must_use]
    pub fn last_moment(&self, driver: &DriverModel) -> Option<i64> {
        let steps = self.steps();
        let avoids = |step: i64| {
            let ride = self.ride_of(driver, step);
            ride.is_some_and(|ride| ride.touch.is_none())
        };
        let end = steps.end.min(self.event);
        if driver.begin.is_some() {
            return (steps.start..end).rev().find(|step| avoids(*step));
        }
        // Who knows the future can wait: what it can do from a step on, it can from every earlier one.
        let (mut low, mut high) = (steps.start, end);
        avoids(low).then_some(())?;
        while high - low > 1 {
            let middle = i64::midpoint(low, high);
            if avoids(middle) {
                low = middle
            } else {
                high = middle
            }
        }
        Some(low)
    }

    /// What kinds of conflict it is that models may not be made for.
    fn kinds(&self) -> Vec<NotMadeFor> {
        let (obstacle, step, contact) = (self.obstacle, self.event, self.contact.as_ref());
        let mut kinds = Vec::new();
        let mut all = self.scene.participants();
        let Some(other) = all.find(|one| one.obstacle.id == obstacle) else {
            return kinds;
        };
        let seen = { self.others.iter() }.find(|o| o.participant.obstacle.id == obstacle);
        let place = |at: i64| {
            let at = usize::try_from(at - self.first).ok()?;
            seen?.places.get(at).copied().flatten()
        };
        if other.obstacle.kind == ObstacleType::Pedestrian {
            kinds.push(NotMadeFor::Pedestrian);
        }
        let ego = self
            .ego
            .get((step - self.first) as usize)
            .or(self.ego.last());
        let Some(&(s, _)) = ego else {
            return kinds;
        };
        // Its direction is that before the contact: who turns across the way crosses it or comes towards the ego for a while.
        let approach = (APPROACH / self.lookout.dt).round() as i64;
        let reverses = (self.first..=step).any(|at| {
            let motions = [self.scene.ego.track.at(at), other.at(at)];
            { motions.iter().flatten() }.any(|motion| motion.velocity < -STANDING)
        });
        if reverses {
            kinds.push(NotMadeFor::Reversing);
        }
        // Who is too far aside to be on the path is compared with the ego's own heading.
        let moving = { (self.first..=step).rev() }.filter_map(|at| {
            let (own, motion) = (self.scene.ego.track.at(at)?, other.at(at)?);
            let turned = match place(at) {
                Some(place) => place.turned,
                None => angle_between(own.pose.heading, motion.pose.heading),
            };
            (motion.velocity.abs() > STANDING).then_some((at, turned.abs()))
        });
        let mut moving = moving.peekable();
        let last = moving.peek().map(|(at, _)| *at);
        let turned = moving
            .take_while(|(at, _)| last.is_some_and(|last| last - at <= approach))
            .fold(0.0, |most: f64, (_, turned)| most.max(turned));
        if turned > ONCOMING {
            kinds.push(NotMadeFor::Oncoming);
        } else if turned > CROSSING {
            kinds.push(NotMadeFor::Crossing);
        }
        let there = place(step).or_else(|| place(step - 1));
        let behind =
            there.is_some_and(|there| there.along + there.half_long < s + self.lookout.own[0].0);
        if contact.map_or(behind, Touch::is_from_behind) {
            kinds.push(NotMadeFor::Behind);
        }
        let until = (step - self.first - (EVASION / self.lookout.dt).round() as i64).max(0);
        let until = self.ego.get(until as usize).map_or(0.0, |(s, _)| *s);
        let headings = [0.0, until].map(|s| self.lookout.path.at(s).map(|pose| pose.heading));
        if let [Some(a), Some(b)] = headings
            && angle_between(a, b).abs() > CURVE
        {
            kinds.push(NotMadeFor::Curve);
        }
        kinds
    }
}
