//! Drivers in an encounter: which of them avoid it, and the drive of the one that is shown.

use std::sync::{Arc, Weak};

use nearmiss_drive::driver::{DRIVERS, DriverModel, PreventabilityRecord, VerdictRecord};
use nearmiss_scene::metrics::{CriticalMoment, Headline, SEVERITY_NAMES};
use nearmiss_scene::scenario::Scene;

use crate::action::Action;
use crate::features::map::state::DrivenBy;
use crate::loaded::{DriverDrive, DriverSeat, Opened};
use crate::model::Model;

/// An encounter of a scene, which may be gone by now.
#[derive(Debug, Clone)]
pub struct EncounterKey {
    scene: Weak<Scene>,
    /// The other in it.
    pub obstacle: i64,
    /// Its step.
    pub step: i64,
}

/// An encounter that drivers have to be asked about.
#[derive(Debug)]
pub struct EncounterToJudge {
    /// Which.
    pub key: EncounterKey,
    /// The scene, kept until it is judged.
    pub scene: Arc<Scene>,
    /// Whether a certificate says that the ideal driver avoids it.
    pub is_certified: bool,
}

impl PartialEq for EncounterKey {
    fn eq(&self, other: &Self) -> bool {
        (self.obstacle, self.step) == (other.obstacle, other.step)
            && self.scene.ptr_eq(&other.scene)
    }
}

/// A drive that was asked for: nothing while it is worked out, then the drive, or that it cannot be drawn.
type DriveReply = Option<Option<Box<DriverDrive>>>;

/// What is known of drivers.
#[derive(Debug)]
pub struct Drivers {
    /// The one that is shown, by its place in [`DRIVERS`].
    pub shown: usize,
    /// Encounters of scenes that are still there, `None` while one is judged; without drivers where nobody can drive before
    /// it.
    judged: Vec<(EncounterKey, Option<Arc<PreventabilityRecord>>)>,
    /// The last drive that was asked for: of whom, and what came of it.
    drive: Option<(EncounterKey, usize, DriveReply)>,
}

/// Whom a certificate is about; the first that is shown.
const IDEAL: &str = "ideal";

impl Default for Drivers {
    fn default() -> Self {
        Self {
            shown: { DRIVERS.iter() }
                .position(|driver| driver.id == IDEAL)
                .unwrap_or(0),
            judged: Vec::new(),
            drive: None,
        }
    }
}

impl Drivers {
    /// Takes what came of an encounter.
    pub fn take(&mut self, key: &EncounterKey, record: PreventabilityRecord) {
        if let Some((_, found)) = self.judged.iter_mut().find(|(known, _)| known == key) {
            *found = Some(Arc::new(record));
        }
    }

    /// Takes a drive, unless another one was asked for since.
    pub fn take_drive(
        &mut self,
        key: &EncounterKey,
        driver: usize,
        drive: Option<Box<DriverDrive>>,
    ) {
        let asked = self.drive.as_mut();
        if let Some((_, _, found)) = asked.filter(|(known, who, _)| known == key && *who == driver)
        {
            *found = Some(drive);
        }
    }
}

/// The most severe grade that drivers have nothing to avoid in.
const NEAR_MISS: u8 = 2;

impl Model {
    /// The driver that is shown.
    #[must_use]
    pub fn driver_shown(&self) -> &'static DriverModel {
        &DRIVERS[self.drivers.shown]
    }

    /// What drivers are asked about, and the moment with the picked obstacle, else the one that matters: in what is open, or
    /// beside the original of a variant in that.
    #[must_use]
    pub fn encounter(&self) -> Option<(&Opened, &CriticalMoment)> {
        let opened = self.variant_opened().or(self.opened.as_deref())?;
        let headline = opened.headline.as_ref()?;
        let picked = self.picked.and_then(|id| headline.worst_with(id));
        Some((opened, picked.or_else(|| Headline::worst(headline))?))
    }

    /// Who and when, and how severe it is.
    #[must_use]
    pub fn encounter_words(&self) -> Option<String> {
        let (opened, moment) = self.encounter()?;
        let kind = opened.scenario.obstacle(moment.obstacle).map(|o| o.kind);
        let who = kind.map_or(String::new(), |kind| format!("{} ", kind.words()));
        let time = moment.step as f64 * opened.scenario.dt();
        let what = SEVERITY_NAMES[usize::from(moment.grade.number())];
        Some(format!(
            "{what} with {who}{} at {time:.1} s, step {}",
            moment.obstacle, moment.step
        ))
    }

    /// The encounter that drivers can be asked about.
    fn encounter_key(&self) -> Option<(&Opened, EncounterKey)> {
        let (opened, moment) = self.encounter()?;
        let key = EncounterKey {
            scene: Arc::downgrade(opened.scene.as_ref()?),
            obstacle: moment.obstacle,
            step: moment.step,
        };
        (moment.grade.number() <= NEAR_MISS).then_some((opened, key))
    }

    /// Which drivers avoid the encounter, once that is known; no drivers where nobody can drive before it.
    #[must_use]
    pub fn judged(&self) -> Option<&PreventabilityRecord> {
        let (_, key) = self.encounter_key()?;
        let mut all = self.drivers.judged.iter();
        all.find(|(known, _)| *known == key)?.1.as_deref()
    }

    /// The same, where the encounter is one of what is open.
    #[must_use]
    pub fn judged_here(&self) -> Option<&PreventabilityRecord> {
        self.judged()
            .filter(|found| self.is_encounter_here() && !found.drivers.is_empty())
    }

    /// Whether the encounter is one of what is open, and not of the variant of the original that is.
    #[must_use]
    pub fn is_encounter_here(&self) -> bool {
        let scene = |opened: &Opened| opened.scene.as_ref().map(Arc::as_ptr);
        let there = self.encounter().and_then(|(opened, _)| scene(opened));
        there.is_some() && there == self.opened.as_deref().and_then(scene)
    }

    /// Why drivers have nothing to say of the encounter.
    #[must_use]
    pub fn without_drivers(&self) -> Option<String> {
        if self.opened.is_none() {
            return Some("no scenario is open".into());
        }
        let Some((_, moment)) = self.encounter() else {
            return Some(self.without_ego());
        };
        if self.encounter_key().is_none() {
            let (pick, worst) = (Action::NextObstacle, Action::CollisionStep);
            let (pick, worst) = (self.look.key(pick), self.look.key(worst));
            let words = "drivers avoid contacts, conflicts and near misses; there is none with";
            return Some(format!(
                "{words} {}: {pick} picks another obstacle, {worst} goes to the moment that matters",
                moment.obstacle
            ));
        }
        let found = self.judged()?;
        let none = "no driver is judged: it begins with the recording, or follows another contact";
        found.drivers.is_empty().then(|| none.into())
    }

    /// What the driver that is shown makes of it.
    #[must_use]
    pub fn verdict_shown(&self) -> Option<&VerdictRecord> {
        self.judged()?.by(self.driver_shown().id)
    }

    /// The drive of the driver that is shown: of a variant the ideal one's is that of the certificate.
    #[must_use]
    pub fn drive_shown(&self) -> Option<(&Opened, DrivenBy)> {
        let (opened, key) = self.encounter_key()?;
        let shown = self.drivers.shown;
        if self.driver_shown().id == IDEAL
            && let Some(drive) = opened.certificate.as_deref()
        {
            return Some((&drive.opened, DrivenBy::Certificate(drive.delay)));
        }
        let (known, who, found) = self.drivers.drive.as_ref()?;
        let drive = found.as_ref()?.as_deref()?;
        let driven = DrivenBy::Driver(shown, drive.contact);
        (*known == key && *who == shown).then_some((&drive.opened, driven))
    }

    /// The encounter that has to be judged.
    pub fn unjudged(&mut self) -> Option<EncounterToJudge> {
        let (opened, key) = self.encounter_key()?;
        let encounter = EncounterToJudge {
            key: key.clone(),
            scene: opened.scene.clone()?,
            is_certified: opened.certificate.is_some(),
        };
        let judged = &mut self.drivers.judged;
        judged.retain(|(known, _)| known.scene.strong_count() > 0);
        if judged.iter().any(|(known, _)| *known == key) {
            return None;
        }
        judged.push((key, None));
        Some(encounter)
    }

    /// The drive that is missing beside the encounter.
    pub fn undriven(&mut self) -> Option<(EncounterKey, DriverSeat)> {
        let (opened, key) = self.encounter_key()?;
        let shown = self.drivers.shown;
        let asked = self.drivers.drive.as_ref();
        let known = asked.is_some_and(|(known, who, _)| *known == key && *who == shown);
        if known || (self.driver_shown().id == IDEAL && opened.certificate.is_some()) {
            return None;
        }
        let seat = DriverSeat {
            driver: shown,
            obstacle: key.obstacle,
            step: key.step,
            scene: opened.scene.clone()?,
            basemap: Arc::clone(&opened.basemap),
            thresholds: Arc::clone(&self.thresholds),
        };
        self.drivers.drive = Some((key.clone(), shown, None));
        Some((key, seat))
    }
}
