//! The closed loop: the ego plans anew, under the same settings, against the changed traffic.

use std::sync::Arc;

use super::{Change, ChangeError};
use crate::metrics::{Context, Series, UNROUNDED_RISK, measure};
use crate::planner::{Cancel, Forecast, Planner};
use crate::scenario::{Obstacle, PlanningProblem, Scenario, Scene};
use crate::simulation::{
    Collision, ContactSide, Cycle, DriveError, Driver, Outcome, ResumableRollout, Rollout,
    Settings, TrafficMode,
};

/// One planning problem, driven once as recorded and then repeatedly against changed traffic.
#[derive(Debug)]
pub struct ClosedLoop {
    scenario: Arc<Scenario>,
    driver: Driver,
    baseline: Baseline,
}

/// The ego's drive in the scenario as it was recorded.
#[derive(Debug)]
pub struct Baseline {
    noted: ResumableRollout,
    scores: Series,
}

/// Time steps and risk scores, 0 (collision) to 5 (negligible), of one obstacle where it is there.
pub type RiskCurve = Vec<(i64, u8)>;

/// Consequence of a change. What also happens to the ego in the baseline is not one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Consequence {
    /// The ego touches an obstacle: the attacker, or another one.
    Collision(Collision),
    /// No obstacle is touched, and the risk score of the attacker is 1 at most at some step.
    NearMiss,
    /// Neither.
    NoEffect,
}

impl Consequence {
    /// Its name in documents.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Collision(_) => "collision",
            Self::NearMiss => "near_miss",
            Self::NoEffect => "no_effect",
        }
    }
}

/// The ego's drive against a change, and how dangerous it was.
#[derive(Debug, Clone)]
pub struct Effect {
    /// The obstacle whose motion was changed.
    pub attacker: i64,
    /// The step of the last state before its motion is another one.
    pub from: i64,
    /// The scenario with the changed motion.
    pub scenario: Arc<Scenario>,
    /// The ego's drive in it. Beside a collision it may end off the road, or with nothing that can be driven.
    pub drive: Rollout,
    /// Its outcome.
    pub consequence: Consequence,
    /// The attacker's risk scores against the baseline, with its recorded motion.
    pub before: RiskCurve,
    /// The attacker's risk scores in this drive.
    pub after: RiskCurve,
    /// The lowest risk score of any obstacle in the baseline; `None` if none ever is there.
    pub anyone_before: Option<u8>,
    /// The lowest risk score of any obstacle in this drive.
    pub anyone_after: Option<u8>,
    /// The smallest distance of the attacker's body to the ego's in this drive, metres.
    pub distance: Option<f64>,
    /// The attacker's lowest risk score in this drive before it is rounded, see [`UNROUNDED_RISK`].
    pub unrounded: Option<f64>,
    /// The first step after which, before the next one, the ego touches an obstacle. Outcomes go by the steps alone, as
    /// CommonRoad does; this says where they do not see all.
    pub between: Option<i64>,
    /// Cycles that are the baseline's, as nothing had changed yet.
    pub taken_over: usize,
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
        let driver = driver.in_traffic(TrafficMode::Recorded);
        let noted = driver.drive_noted_watched(&scenario, i64::MAX, watch);
        let scores = readings(&driver, &scenario, &noted.drive, "risk");
        Self {
            scenario,
            driver,
            baseline: Baseline { noted, scores },
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
    pub fn effect(&self, change: &Change) -> Result<Effect, ChangeError> {
        self.effect_until(change, i64::MAX)
    }

    /// The same, but nothing is looked at after step `until`: a drive that has not ended then counts as a time-out.
    ///
    /// # Errors
    /// Those of [`Self::effect`].
    pub fn effect_until(&self, change: &Change, until: i64) -> Result<Effect, ChangeError> {
        let attacker = change.obstacle;
        let changed = Arc::new(change.apply(&self.scenario)?);
        let noted = match self.same_until(&changed, change) {
            Some(same) => self
                .driver
                .drive_again(&changed, &self.baseline.noted, same, until),
            None => self.driver.drive_noted(&changed, until),
        };
        let drive = noted.drive;
        let scores = readings(&self.driver, &changed, &drive, "risk");
        let after = curve(&scores, attacker);
        let least = least(&self.driver, &changed, &drive, attacker);
        let between = self.driver.touched_between(&changed, &drive);
        let before = self.baseline.risk_of(attacker);
        let recorded = self.baseline.drive();
        let same = drive.states == recorded.states && drive.outcome == recorded.outcome;
        let near = lowest(&after).is_some_and(|score| score <= NEAR_MISS);
        let consequence = match drive.outcome {
            Outcome::Collision(collision) if !same && !recorded.touches(collision.with) => {
                Consequence::Collision(collision)
            }
            _ if near && !(same && after == before) => Consequence::NearMiss,
            _ => Consequence::NoEffect,
        };
        Ok(Effect {
            attacker,
            from: change.from().ok_or(ChangeError::NotThere(attacker))?,
            scenario: changed,
            consequence,
            before,
            after,
            anyone_before: self.baseline.lowest(),
            anyone_after: lowest_of_all(&scores),
            distance: least("distance"),
            unrounded: least(UNROUNDED_RISK.id),
            between,
            taken_over: noted.taken_over,
            drive,
        })
    }

    /// The last step in whose planning cycle all that the planner is told is as it was recorded; `None` if it may
    /// differ from the beginning.
    ///
    /// A forecast that looks at the past knows nothing of a change before its first other state; one that is told the
    /// recorded future knows it a horizon earlier. States before the change are compared too: what a file leaves out of
    /// its first state is worked out from the second one.
    fn same_until(&self, changed: &Scenario, change: &Change) -> Option<i64> {
        let (from, id) = (change.from()?, change.obstacle);
        let (old, new) = (self.scenario.obstacle(id)?, changed.obstacle(id)?);
        let first = old.track().steps().start.min(new.track().steps().start);
        let differs = (first..=from).find(|&step| !alike(old, new, step));
        let known = differs.map_or(from, |step| step - 1);
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
        &self.noted.drive
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

impl Effect {
    /// The attacker's lowest risk score in the baseline; `None` if it never is there.
    #[must_use]
    pub fn lowest_before(&self) -> Option<u8> {
        lowest(&self.before)
    }

    /// The attacker's lowest risk score in this drive.
    #[must_use]
    pub fn lowest_after(&self) -> Option<u8> {
        lowest(&self.after)
    }

    /// The collision, if there is one.
    #[must_use]
    pub fn collision(&self) -> Option<Collision> {
        match self.consequence {
            Consequence::Collision(collision) => Some(collision),
            _ => None,
        }
    }

    /// Whether it is the attacker that the ego touches.
    #[must_use]
    pub fn hits_attacker(&self) -> bool {
        self.collision().is_some_and(|c| c.with == self.attacker)
    }

    /// Whether an obstacle drives into the ego's rear with the front: that proves little, since no obstacle reacts to
    /// the ego.
    #[must_use]
    pub fn is_hit_from_behind(&self) -> bool {
        self.collision()
            .is_some_and(|c| c.ego == ContactSide::Rear && c.other == ContactSide::Front)
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

/// The least values of how near the attacker comes, by the ids of their measures.
fn least(
    driver: &Driver,
    scenario: &Arc<Scenario>,
    drive: &Rollout,
    attacker: i64,
) -> impl Fn(&str) -> Option<f64> + use<> {
    let scene = scene(driver, scenario, drive);
    let context = Context::new(&scene);
    let measures = measure("distance").into_iter().chain([&UNROUNDED_RISK]);
    let series = Series::of_obstacle(&context, measures.collect(), attacker);
    move |id| {
        let readings = series.row(id, attacker).iter();
        let values = readings.filter_map(|reading| reading.value());
        values.min_by(f64::total_cmp)
    }
}

fn curve(scores: &Series, obstacle: i64) -> RiskCurve {
    let row = scores.steps().zip(scores.row("risk", obstacle));
    row.filter_map(|(step, reading)| Some((step, reading.value()? as u8)))
        .collect()
}

fn lowest(curve: &RiskCurve) -> Option<u8> {
    curve.iter().map(|(_, score)| *score).min()
}

fn lowest_of_all(scores: &Series) -> Option<u8> {
    let (_, score) = scores.most_dangerous("risk")?;
    Some(score as u8)
}
