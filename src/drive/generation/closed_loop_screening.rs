//! The closed loop: the ego plans anew, under the same settings, against the changed traffic.

use std::sync::Arc;

use super::effect::{self, AttackerEffect};
use super::{Change, ChangeError, Consequence, Effect, JointChange, RiskCurve};
use crate::planner::{Cancel, Forecast, Planner};
use crate::simulation::{
    Cycle, DriveError, Driver, Outcome, ResumableRollout, Rollout, Settings, TrafficMode,
};
use nearmiss_scene::metrics::{Context, Series, UNROUNDED_RISK, measure};
use nearmiss_scene::scenario::{Ego, Obstacle, PlanningProblem, Scenario, Scene};

/// One planning problem, driven once as recorded and then repeatedly against changed traffic.
#[derive(Debug)]
pub struct ClosedLoop {
    scenario: Arc<Scenario>,
    driver: Driver,
    /// The same with fewer samples; `None` for the planner of a process.
    coarse: Option<Driver>,
    baseline: Baseline,
}

/// The ego's drive in the scenario as it was recorded.
#[derive(Debug)]
pub struct Baseline {
    recorded: StagedDrive,
    scores: Series,
}

/// A drive in the scenario with changes, or with none, from whose cycles other drives continue.
#[derive(Debug)]
pub struct StagedDrive {
    changes: Vec<Change>,
    scenario: Arc<Scenario>,
    noted: ResumableRollout,
}

/// At this risk score or below it was a near miss.
pub const NEAR_MISS: u8 = 1;

impl ClosedLoop {
    /// Drives the baseline of a problem of `scenario`. `watch` receives each cycle with its planner, and returns whether
    /// to continue. When `cancel` is set, all drives end early: their results must be dropped then.
    ///
    /// # Errors
    /// The problem has no start or no goal, or no way leads to it.
    pub fn watched(
        scenario: Arc<Scenario>,
        problem: &PlanningProblem,
        settings: &Settings,
        cancel: &Cancel,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> Result<Self, DriveError> {
        let driver = Driver::new(&scenario, problem, settings)?.cancelled_by(cancel);
        Ok(Self::of_driver(scenario, driver, watch))
    }

    /// The same with a driver of this scenario, whose planner may be a process: that one is attacked then. Ways out
    /// of attacks are always those of the built-in planner and of manoeuvres.
    #[must_use]
    pub fn of_driver(
        scenario: Arc<Scenario>,
        driver: Driver,
        watch: &mut dyn FnMut(&Planner<'_>, &Cycle) -> bool,
    ) -> Self {
        // Attacks are judged against recorded traffic.
        let driver = driver
            .in_traffic(TrafficMode::Recorded)
            .sharing_forecasts(&scenario);
        let noted = driver.drive_noted_watched(&scenario, i64::MAX, watch);
        let scores = readings(&driver, &scenario, &noted.drive, "risk");
        let recorded = StagedDrive {
            changes: Vec::new(),
            scenario: Arc::clone(&scenario),
            noted,
        };
        let coarse = driver.external().is_none().then(|| {
            let settings = driver.settings().coarse(driver.dt());
            driver.with(&settings)
        });
        Self {
            scenario,
            driver,
            coarse,
            baseline: Baseline { recorded, scores },
        }
    }

    /// The recorded scenario.
    #[must_use]
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// The driver.
    #[must_use]
    pub fn driver(&self) -> &Driver {
        &self.driver
    }

    /// The drive in the recorded scenario.
    #[must_use]
    pub fn baseline(&self) -> &Baseline {
        &self.baseline
    }

    /// Drives against a change.
    ///
    /// Cycles in which the planner cannot know yet that anything changed are taken over from the baseline, which
    /// changes nothing but the time it takes, see [`Driver::drive_again`].
    ///
    /// # Errors
    /// The scenario has no such obstacle, or it cannot be changed so.
    pub fn effect(&self, change: &JointChange) -> Result<Effect, ChangeError> {
        self.effect_until(change, &self.baseline.recorded, i64::MAX)
    }

    /// The same, with cycles taken over from the drive `before`; nothing is looked at after step `until`: a drive that
    /// has not ended then counts as a time-out.
    ///
    /// # Errors
    /// Those of [`Self::effect`].
    pub fn effect_until(
        &self,
        change: &JointChange,
        before: &StagedDrive,
        until: i64,
    ) -> Result<Effect, ChangeError> {
        self.effect_on(&self.driver, change, before, until)
    }

    /// The same with an ego that plans more coarsely, see [`Settings::coarse`]: it says which changes are worth a whole
    /// drive. The planner of a process drives as ever.
    ///
    /// # Errors
    /// Those of [`Self::effect`].
    pub(super) fn coarse_effect_until(
        &self,
        change: &JointChange,
        before: &StagedDrive,
        until: i64,
    ) -> Result<Effect, ChangeError> {
        let driver = self.coarse.as_ref().unwrap_or(&self.driver);
        self.effect_on(driver, change, before, until)
    }

    fn effect_on(
        &self,
        driver: &Driver,
        change: &JointChange,
        before: &StagedDrive,
        until: i64,
    ) -> Result<Effect, ChangeError> {
        let changed = Arc::new(change.apply(&self.scenario)?);
        let noted = self.drive_after(driver, before, change, &changed, until);
        let drive = noted.drive;
        let scores = readings(&self.driver, &changed, &drive, "risk");
        let is_behind = effect::behind(&changed, &drive);
        let attackers = change.changes().iter().map(|change| {
            let id = change.obstacle;
            let absent = || ChangeError::NotThere(id);
            let least_where = least(&self.driver, &changed, &drive, id);
            let least = |measure| least_where(measure, &|_| true);
            let in_view =
                |measure| least_where(measure, &|step| is_behind(id, step) == Some(false));
            Ok(AttackerEffect {
                obstacle: id,
                from: change.from().ok_or_else(absent)?,
                until: change.until().ok_or_else(absent)?,
                before: self.baseline.risk_of(id),
                after: curve(&scores, id),
                distance: least("distance"),
                unrounded: least(UNROUNDED_RISK.id),
                distance_in_view: in_view("distance"),
                unrounded_in_view: in_view(UNROUNDED_RISK.id),
                without: None,
            })
        });
        let attackers: Vec<AttackerEffect> = attackers.collect::<Result<_, ChangeError>>()?;
        drop(is_behind);
        let recorded = self.baseline.drive();
        let same = drive.states == recorded.states && drive.outcome == recorded.outcome;
        let collision = match drive.outcome {
            Outcome::Collision(collision) => Some(collision),
            _ => None,
        };
        let contact = collision.filter(|c| !same && !recorded.touches(c.with));
        let (problem, settings) = (driver.problem(), driver.settings());
        let impact = contact.and_then(|_| drive.impact(&changed, problem, settings));
        let telling = contact.filter(|c| effect::is_telling(c, &attackers));
        let before = (&*self.scenario, recorded);
        let near = || effect::comes_near(&attackers, before, (&changed, &drive));
        let consequence = match (telling, drive.outcome) {
            (Some(collision), _) => Consequence::Collision(collision),
            (None, Outcome::PlannerError(error)) if !same => Consequence::PlannerError(error),
            (None, _) if near() => Consequence::NearMiss,
            (None, _) => Consequence::NoEffect,
        };
        Ok(Effect {
            main: Effect::place_of_main(&attackers, contact),
            from: change.from_step().ok_or(ChangeError::Nothing)?,
            attackers,
            scenario: changed,
            consequence,
            contact,
            impact,
            anyone_before: self.baseline.lowest(),
            anyone_after: lowest_of_all(&scores),
            taken_over: noted.taken_over,
            drive,
        })
    }

    /// Drives against a change to the end, so that drives against more continue from it.
    ///
    /// # Errors
    /// Those of [`Self::effect`].
    pub fn staged(&self, change: &JointChange) -> Result<StagedDrive, ChangeError> {
        let changed = Arc::new(change.apply(&self.scenario)?);
        let before = &self.baseline.recorded;
        let noted = self.drive_after(&self.driver, before, change, &changed, i64::MAX);
        Ok(StagedDrive {
            changes: change.changes().to_vec(),
            scenario: changed,
            noted,
        })
    }

    /// Notes for each attacker of an effect what the others come to while it moves as recorded, see
    /// [`Effect::needs_all`].
    ///
    /// # Errors
    /// Those of [`Self::effect`].
    pub fn leave_each_out(
        &self,
        effect: &mut Effect,
        change: &JointChange,
    ) -> Result<(), ChangeError> {
        for attacker in &mut effect.attackers {
            if let Some(others) = change.without(attacker.obstacle) {
                attacker.without = Some(self.effect(&others)?.consequence);
            }
        }
        Ok(())
    }

    fn drive_after(
        &self,
        driver: &Driver,
        before: &StagedDrive,
        change: &JointChange,
        changed: &Scenario,
        until: i64,
    ) -> ResumableRollout {
        match self.same_until(before, changed, change) {
            Some(same) => driver.drive_again(changed, &before.noted, same, until),
            None => driver.drive_noted(changed, until),
        }
    }

    /// The last step in whose planning cycle all that the planner is told is as it was in the drive `before`; `None` if
    /// it may differ from the beginning.
    ///
    /// A forecast that looks at the past knows nothing of a change before its first other state; one that is told the
    /// recorded future knows it a horizon earlier. States before the change are compared too: what a file leaves out of
    /// its first state is worked out from the second one.
    fn same_until(
        &self,
        before: &StagedDrive,
        changed: &Scenario,
        change: &JointChange,
    ) -> Option<i64> {
        let mut known = i64::MAX;
        for one in before.changes.iter().chain(change.changes()) {
            let id = one.obstacle;
            let of = |changes: &[Change]| changes.iter().position(|c| c.obstacle == id);
            let was = of(&before.changes).map(|i| &before.changes[i]);
            let is = of(change.changes()).map(|i| &change.changes()[i]);
            if was == is {
                continue;
            }
            let from = [was, is]
                .into_iter()
                .flatten()
                .filter_map(Change::from)
                .min()?;
            let (old, new) = (before.scenario.obstacle(id)?, changed.obstacle(id)?);
            let first = old.track().steps().start.min(new.track().steps().start);
            let differs = (first..=from).find(|&step| !alike(old, new, step));
            known = known.min(differs.map_or(from, |step| step - 1));
        }
        let settings = self.driver.settings();
        let ahead = match settings.forecast {
            Forecast::Recorded => settings.planner.steps(self.driver.dt()) as i64,
            Forecast::ConstantVelocity | Forecast::Lane => 0,
        };
        Some(known - ahead)
    }
}

/// Whether an obstacle is at a step exactly what and where the other one is.
fn alike(a: &Obstacle, b: &Obstacle, step: i64) -> bool {
    a.motion_at(step) == b.motion_at(step) && a.footprint_at(step) == b.footprint_at(step)
}

impl Baseline {
    /// The drive.
    #[must_use]
    pub fn drive(&self) -> &Rollout {
        &self.recorded.noted.drive
    }

    /// The same, from which others continue.
    #[must_use]
    pub fn staged(&self) -> &StagedDrive {
        &self.recorded
    }

    /// The risk scores of an obstacle.
    #[must_use]
    pub fn risk_of(&self, obstacle: i64) -> RiskCurve {
        curve(&self.scores, obstacle)
    }

    /// The lowest risk score of any obstacle.
    #[must_use]
    pub fn lowest(&self) -> Option<u8> {
        lowest_of_all(&self.scores)
    }
}

impl StagedDrive {
    /// The scenario with the changes.
    #[must_use]
    pub fn scenario(&self) -> &Arc<Scenario> {
        &self.scenario
    }

    /// Whether the ego touches an obstacle in it.
    pub(super) fn collides(&self) -> bool {
        matches!(self.noted.drive.outcome, Outcome::Collision(_))
    }

    /// The ego of the drive, as a driver of the same problem drives it.
    #[must_use]
    pub fn ego(&self, driver: &Driver) -> Ego {
        let drive = &self.noted.drive;
        drive.ego(driver.problem(), driver.settings())
    }
}

/// A drive as a scene.
fn scene(driver: &Driver, scenario: &Arc<Scenario>, drive: &Rollout) -> Scene {
    let ego = drive.ego(driver.problem(), driver.settings());
    Scene::new(Arc::clone(scenario), ego)
}

/// A measure over all obstacles but the one the ego replaces, which is absent in the drive.
fn readings(driver: &Driver, scenario: &Arc<Scenario>, drive: &Rollout, id: &str) -> Series {
    let without = driver.settings().without;
    let scene = match without {
        Some(gone) => {
            let mut others = Scenario::clone(scenario);
            others.obstacles.retain(|o| o.id != gone);
            scene(driver, &Arc::new(others), drive)
        }
        None => scene(driver, scenario, drive),
    };
    Series::compute(&scene, measure(id).into_iter().collect())
}

/// The least values of how near the attacker comes, by the ids of their measures, over the steps that are asked for.
fn least(
    driver: &Driver,
    scenario: &Arc<Scenario>,
    drive: &Rollout,
    attacker: i64,
) -> impl Fn(&str, &dyn Fn(i64) -> bool) -> Option<f64> + use<> {
    let scene = scene(driver, scenario, drive);
    let context = Context::new(&scene);
    let measures = measure("distance").into_iter().chain([&UNROUNDED_RISK]);
    let series = Series::of_obstacle(&context, measures.collect(), attacker);
    let contact = series.contact(attacker);
    move |id, asked| {
        if contact.is_some_and(|contact| asked(contact.step)) {
            return Some(0.0);
        }
        let readings = series
            .steps()
            .zip(series.row(id, attacker))
            .filter(|(step, _)| asked(*step));
        let values = readings.filter_map(|(_, reading)| reading.value());
        values.min_by(f64::total_cmp)
    }
}

fn curve(scores: &Series, obstacle: i64) -> RiskCurve {
    let row = scores.steps().zip(scores.row("risk", obstacle));
    row.filter_map(|(step, reading)| Some((step, reading.value()? as u8)))
        .collect()
}

fn lowest_of_all(scores: &Series) -> Option<u8> {
    let (_, score) = scores.most_dangerous("risk")?;
    Some(score as u8)
}
