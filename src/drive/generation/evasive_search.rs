//! Searches for an evasive trajectory of the ego, and verifies it.

use std::sync::Arc;

use nearmiss_base::geometry::{Pose, normalize_angle};
use nearmiss_scene::scenario::{ObstacleRole, Scenario};

use super::certificate::{
    Certificate, EvasiveTrajectory, Finder, NotFound, SearchEffort, Unavoidable,
};
use super::{ClosedLoop, Effect};
use crate::planner::{Feasibility, Forecast, Limits, ReferenceTrack, RuleMode, VehicleState};
use crate::simulation::{
    Collision, Cycle, DriveSpan, DrivenTraffic, Driver, EndOfDriveCheck, Outcome, Rollout, Settings,
};

/// A search around one change, or of a whole problem.
pub(super) struct Search<'a> {
    driver: &'a Driver,
    /// The drive that goes on until the reaction; of a whole problem nothing is driven before.
    unchanged: Option<&'a Rollout>,
    scenario: &'a Scenario,
    from: i64,
    /// The step that a trajectory must reach.
    last: i64,
    /// A goal ends the trajectory from this step on, not just before the contact.
    goal_from: i64,
}

/// The unchanged drive up to the end of the reaction time.
struct ReactionPhase<'a> {
    states: Vec<(i64, VehicleState)>,
    look: EndOfDriveCheck<'a>,
    /// Arc length along the path, metres.
    along: Option<f64>,
}

/// A trajectory continues this long after the avoided contact and after the last attacker has gone, seconds.
const AFTER: f64 = 1.0;

/// Shares of the friction circle for braking to standstill; 0 keeps the speed.
const BRAKING: [f64; 7] = [1.0, 0.8, 0.6, 0.45, 0.3, 0.15, 0.0];

/// Shares of the friction circle for braking, and the share of the speed to keep.
const SLOWING: [(f64, f64); 4] = [(1.0, 0.7), (1.0, 0.4), (0.5, 0.7), (0.5, 0.4)];

/// Shares of the engine's acceleration, and the gain in speed (m/s).
const ACCELERATING: [(f64, f64); 4] = [(0.4, 4.0), (1.0, 4.0), (0.6, 10.0), (1.0, 10.0)];

/// Changes of the offset to either side, metres.
const OFFSETS: [f64; 6] = [0.0, 0.5, 1.0, 1.75, 2.5, 3.5];

/// Shares of the friction that steering may take.
const GRIP: [f64; 2] = [0.5, 0.95];

impl<'a> Search<'a> {
    pub fn new(closed: &'a ClosedLoop, effect: &'a Effect) -> Self {
        let driver = closed.driver();
        let after = (AFTER / driver.dt()).ceil() as i64;
        let deadline = driver.full_span().last;
        let contact = effect.contact.map(|c| c.step);
        let goal_from = contact.map_or(effect.from, |step| step.saturating_add(after));
        let obstacles = effect.scenario.obstacles.iter();
        let moving = obstacles.filter(|o| o.role == ObstacleRole::Dynamic);
        let gone = moving
            .map(|o| {
                let end = o.track().steps().end - 1;
                if effect.is_attacker(o.id) {
                    end.saturating_add(after)
                } else {
                    end
                }
            })
            .max()
            .unwrap_or(effect.from);
        Self {
            driver,
            unchanged: Some(closed.baseline().drive()),
            scenario: &effect.scenario,
            from: effect.from,
            last: gone.max(goal_from).min(deadline),
            goal_from: goal_from.min(deadline),
        }
    }

    /// From the start of the driver's problem to its goal or deadline.
    pub fn of_problem(driver: &'a Driver, scenario: &'a Scenario) -> Self {
        let span = driver.full_span();
        Self {
            driver,
            unchanged: None,
            scenario,
            from: span.step,
            last: span.last,
            goal_from: span.goal_from,
        }
    }

    /// The step at which the reaction time ends.
    pub fn reaction(&self, delay: f64) -> i64 {
        self.from + (delay / self.driver.dt()).round() as i64
    }

    /// Searches from the end of a reaction time on.
    pub fn from(&self, reaction: i64) -> Certificate {
        let mut searched = SearchEffort::default();
        let unchanged = self.unchanged(reaction);
        if let Some(avoidance) = unchanged.filter(|found| self.verify(found, reaction)) {
            return Certificate::Avoided(Arc::new(avoidance));
        }
        let begun = match self.begin(reaction) {
            Ok(begun) => begun,
            Err(why) => return Certificate::NotFound(NotFound { why, searched }),
        };
        let found = self
            .manoeuvres(&begun, reaction, &mut searched)
            .or_else(|| self.plans(&begun, reaction, &mut searched));
        match found {
            Some(avoidance) => Certificate::Avoided(Arc::new(avoidance)),
            None => Certificate::NotFound(NotFound {
                why: Unavoidable::NothingFound,
                searched,
            }),
        }
    }

    /// The unchanged drive, if it ends at the goal or the deadline.
    fn unchanged(&self, reaction: i64) -> Option<EvasiveTrajectory> {
        let drive = self.unchanged.filter(|drive| drive.outcome.is_unharmed())?;
        Some(EvasiveTrajectory {
            drive: Rollout {
                cycles: Vec::new(),
                ..drive.clone()
            },
            reaction,
            found: Finder::Unchanged,
            searched: SearchEffort::default(),
        })
    }

    /// Drives unchanged until the reaction time has passed.
    fn begin(&self, reaction: i64) -> Result<ReactionPhase<'a>, Unavoidable> {
        let driver = self.driver;
        let span = driver.full_span();
        let start = [(span.step, span.state)];
        let (states, outcome) = match self.unchanged {
            Some(drive) => (&drive.states[..], drive.outcome),
            None => (&start[..], Outcome::Infeasible),
        };
        let path = &driver.guide().path;
        let mut begun = ReactionPhase {
            states: Vec::new(),
            look: EndOfDriveCheck::new(driver, self.scenario, self.goal_from),
            along: None,
        };
        let mut along = driver.guide().start;
        for (step, state) in states.iter().take_while(|(s, _)| *s <= reaction) {
            match begun.look.at(*step, state) {
                Some(Outcome::Collision(collision)) => {
                    return Err(Unavoidable::TooEarly(collision));
                }
                Some(outcome) => return Err(Unavoidable::Ended(outcome)),
                None => begun.states.push((*step, *state)),
            }
            if let Ok(on) = path.project_near(&state.rear.position, along, SEARCH_REACH) {
                along = on.s;
                begun.along = Some(on.s);
            }
        }
        match begun.states.last() {
            Some((step, _)) if *step == reaction => Ok(begun),
            _ => Err(Unavoidable::Ended(outcome)),
        }
    }

    fn manoeuvres(
        &self,
        begun: &ReactionPhase<'_>,
        reaction: i64,
        searched: &mut SearchEffort,
    ) -> Option<EvasiveTrajectory> {
        let driver = self.driver;
        let (_, now) = begun.states.last()?;
        let path = &driver.guide().path;
        let on = path.project_near(&now.rear.position, begun.along?, SEARCH_REACH);
        let present = on.ok()?.d;
        for manoeuvre in self.grid(now.velocity, present) {
            if driver.is_cancelled() {
                return None;
            }
            searched.manoeuvres += 1;
            let Some(drive) = self.drive(begun, &manoeuvre) else {
                continue;
            };
            let avoidance = EvasiveTrajectory {
                drive,
                reaction,
                found: Finder::Manoeuvre(manoeuvre),
                searched: *searched,
            };
            if self.verify(&avoidance, reaction) {
                return Some(avoidance);
            }
            searched.refused += 1;
        }
        None
    }

    /// The manoeuvres to try, small offsets first.
    fn grid(&self, speed: f64, present: f64) -> impl Iterator<Item = EvasiveManoeuvre> {
        let limits = *self.driver.limits();
        let most = limits.acceleration;
        let braking = BRAKING.map(|share| match share {
            0.0 => (0.0, speed),
            _ => (-share * most, 0.0),
        });
        let slowing = SLOWING.map(|(share, left)| (-share * most, left * speed));
        let forward = limits.forward(speed);
        let faster = ACCELERATING.map(|(share, gain)| {
            let until = (speed + gain).min(limits.speed);
            (share * forward, until)
        });
        let along: Vec<(f64, f64)> = braking.into_iter().chain(slowing).chain(faster).collect();
        let sides = OFFSETS.into_iter().flat_map(|aside| match aside {
            0.0 => vec![0.0],
            _ => vec![aside, -aside],
        });
        sides.flat_map(move |aside| {
            let along = along.clone();
            GRIP.into_iter().flat_map(move |grip| {
                let along = along.clone().into_iter();
                along.map(move |(acceleration, until)| EvasiveManoeuvre {
                    acceleration,
                    until,
                    offset: present + aside,
                    grip,
                })
            })
        })
    }

    /// Drives a manoeuvre to the end; `None` if it touches an obstacle or leaves the road or the path.
    fn drive(&self, begun: &ReactionPhase<'_>, manoeuvre: &EvasiveManoeuvre) -> Option<Rollout> {
        let driver = self.driver;
        let (mut step, mut state) = *begun.states.last()?;
        let (mut look, mut along) = (begun.look.clone(), begun.along);
        let mut states = begun.states.clone();
        let mut outcome = Outcome::Timeout;
        while step < self.last {
            step += 1;
            let (limits, dt) = (driver.limits(), driver.dt());
            state = manoeuvre.step(&state, driver.guide(), &mut along, limits, dt)?;
            states.push((step, state));
            match look.at(step, &state) {
                None => {}
                Some(goal @ Outcome::Goal(_)) => {
                    outcome = goal;
                    break;
                }
                Some(_) => return None,
            }
        }
        Some(self.full_rollout(states, outcome))
    }

    fn full_rollout(&self, states: Vec<(i64, VehicleState)>, outcome: Outcome) -> Rollout {
        let driver = self.driver;
        Rollout {
            states,
            cycles: Vec::new(),
            outcome,
            traffic: DrivenTraffic::default(),
            limits: *driver.limits(),
            dt: driver.dt(),
            external: None,
        }
    }

    /// Tries drives of the planner with known futures.
    fn plans(
        &self,
        begun: &ReactionPhase<'_>,
        reaction: i64,
        searched: &mut SearchEffort,
    ) -> Option<EvasiveTrajectory> {
        let (step, state) = *begun.states.last()?;
        let stretch = DriveSpan {
            step,
            state,
            last: self.last,
            goal_from: self.goal_from,
        };
        let usual = self.driver;
        for (name, settings) in attempts(usual.settings()) {
            if usual.is_cancelled() {
                return None;
            }
            let driver: Driver = usual.with(&settings);
            let mut doomed = 0;
            let drive = driver.drive_watched(self.scenario, &stretch, &mut |_, cycle| {
                doomed += usize::from(self.is_doomed(cycle));
                doomed < DOOMED
            });
            searched.drives += 1;
            searched.cycles += drive.cycles.len();
            let candidates = drive.cycles.iter().map(|c| c.plan.candidates);
            searched.candidates += candidates.sum::<usize>();
            // An abandoned drive ends like a time-out.
            if doomed >= DOOMED || !drive.outcome.is_unharmed() {
                continue;
            }
            let later = drive.states.iter().skip(1);
            let states = begun.states.iter().chain(later).copied().collect();
            let avoidance = EvasiveTrajectory {
                drive: self.full_rollout(states, drive.outcome),
                reaction,
                found: Finder::Planner(name),
                searched: *searched,
            };
            if self.verify(&avoidance, reaction) {
                return Some(avoidance);
            }
            searched.refused += 1;
        }
        None
    }

    /// Whether the planner found no feasible plan in a cycle and its emergency manoeuvre touches an obstacle.
    fn is_doomed(&self, cycle: &Cycle) -> bool {
        let driver = self.driver;
        let states = (cycle.step..=self.last).zip(cycle.plan.states.windows(2));
        let pose = |state: &VehicleState| state.centre(driver.limits()).pose;
        cycle.plan.emergency.is_some() && { states }.any(|(step, pair)| {
            let body = driver.road().body().at(pose(&pair[1]));
            let (before, without) = (Some(pose(&pair[0])), driver.settings().without);
            Collision::first(self.scenario, &body, before, step + 1, without).is_some()
        })
    }
}

/// A drive is abandoned after this many doomed cycles.
const DOOMED: usize = 3;

/// Range around the last arc length in which the path is projected on, metres.
const SEARCH_REACH: f64 = 20.0;

/// Planner settings to try, the cheapest first.
fn attempts(usual: &Settings) -> [(&'static str, Settings); 4] {
    let mut told = Settings {
        forecast: Forecast::Recorded,
        replan: 1,
        policy: None,
        ..*usual
    };
    // To survive goes before the rules of the road: a way out may cross a line or drive faster than allowed.
    told.planner.rules = RuleMode::Off;
    let mut wide = told;
    let planner = &mut wide.planner;
    planner.sampling.widest = planner.sampling.widest.max(6.0);
    planner.sampling.offsets = planner.sampling.offsets.max(15);
    planner.sampling.changes = planner.sampling.changes.max(3);
    // The samples are dense already: another refinement takes seconds and finds next to nothing.
    planner.sampling.refinements = planner.sampling.refinements.min(1);
    planner.share = planner.share.max(0.98);
    planner.margin = planner.margin.min(0.03);
    planner.braking = planner.braking.max(9.0);
    let mut short = wide;
    let planner = &mut short.planner;
    planner.horizon = planner.horizon.min(2.5);
    planner.sampling.durations = planner.sampling.durations.max(5);
    planner.sampling.speeds = planner.sampling.speeds.max(13);
    [
        ("planning every step", told),
        ("planning every third step", Settings { replan: 3, ..told }),
        ("wide offsets and the whole friction", wide),
        ("wide offsets, a short horizon and dense samples", short),
    ]
}

/// After the evasive trajectory the ego must be able to drive on this long (s) at one of these accelerations (m/s²).
const GOING_ON: f64 = 2.0;
const GOING_ON_WITH: [f64; 4] = [-8.0, -3.0, 0.0, 3.0];

impl Search<'_> {
    /// Whether a finished trajectory touches no obstacle, stays on the road, gets to its end, and can be driven from
    /// step `reaction` on.
    pub fn verify(&self, avoidance: &EvasiveTrajectory, reaction: i64) -> bool {
        let driver = self.driver;
        let drive = &avoidance.drive;
        let mut look = EndOfDriveCheck::new(driver, self.scenario, self.goal_from);
        let mut goal = None;
        for (step, state) in &drive.states {
            match look.at(*step, state) {
                Some(Outcome::Goal(_)) => goal = Some(*step),
                Some(_) => return false,
                None => {}
            }
        }
        let end = drive.states.last().map(|(step, _)| *step);
        let arrived = end.is_some_and(|end| end >= self.last) || goal == end;
        // The unchanged drive may be over before: then there is nothing to avoid.
        let over = avoidance.found == Finder::Unchanged;
        let changed = drive.states.iter().filter(|(step, _)| *step >= reaction);
        let changed: Vec<VehicleState> = changed.map(|(_, state)| *state).collect();
        let check = Feasibility::new(*driver.limits(), driver.dt());
        (arrived || over)
            && check.states(reaction, &changed).is_ok()
            && (over || self.can_go_on(drive))
    }

    /// Whether an ego that ends here does not end right before a bumper: straight on, with one of a few accelerations,
    /// no obstacle is touched for a while.
    fn can_go_on(&self, drive: &Rollout) -> bool {
        let Some((end, state)) = drive.states.last() else {
            return false;
        };
        let driver = self.driver;
        let (dt, limits, without) = (driver.dt(), driver.limits(), driver.settings().without);
        let later = (GOING_ON / dt).round() as i64;
        let start = state.centre(limits);
        GOING_ON_WITH.iter().any(|acceleration| {
            let (mut s, mut v, mut before) = (0.0, start.velocity, start.pose);
            (1..=later).all(|k| {
                let next = (v + acceleration * dt).clamp(0.0, limits.speed);
                s += f64::midpoint(v, next) * dt;
                v = next;
                let pose = Pose {
                    position: start.pose.position + start.pose.forward() * s,
                    ..start.pose
                };
                let body = driver.road().body().at(pose);
                let was = Some(std::mem::replace(&mut before, pose));
                Collision::first(self.scenario, &body, was, end + k, without).is_none()
            })
        })
    }
}

/// An evasive manoeuvre that a driver begins and holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EvasiveManoeuvre {
    /// Acceleration along the heading, m/s²; negative for braking. Bounded by the friction that steering leaves.
    pub acceleration: f64,
    /// The speed (m/s) at which braking or accelerating ends.
    pub until: f64,
    /// The target offset from the path, metres to the left.
    pub offset: f64,
    /// The share of the friction that steering may take, 0 to 1.
    pub grip: f64,
}

/// Integration substeps per step.
const PARTS: usize = 16;

/// Share of the limits to use, since the exact check comes afterwards.
const SHARE: f64 = 0.995;

/// Time constant of the heading (s), and a distance added to the one covered in it (m).
const TURNING: f64 = 0.25;
const AT_LEAST: f64 = 1.0;

/// The offset is corrected over this multiple of the turning distance.
const SLOWER: f64 = 2.5;

/// Range around the last arc length in which the path is projected on, metres.
const MANOEUVRE_REACH: f64 = 15.0;

impl EvasiveManoeuvre {
    /// The state one step of `dt` seconds later, with constant inputs; `None` past the end of the path. `hint` is the
    /// arc length (m) along the path.
    pub(super) fn step(
        &self,
        at: &VehicleState,
        guide: &ReferenceTrack,
        hint: &mut Option<f64>,
        limits: &Limits,
        dt: f64,
    ) -> Option<VehicleState> {
        let v = at.velocity.max(0.0);
        let by_grip = self.grip * SHARE * limits.acceleration / (v * v).max(1.0);
        let most = by_grip.min(SHARE * limits.curvature());
        // A standing vehicle does not steer.
        let wanted = if v > 0.0 {
            self.curvature(at, guide, hint, most)?
        } else {
            at.curvature
        };
        let angle = limits.steering_of(at.curvature);
        let fastest = SHARE * limits.steering_rate;
        let turn = (limits.steering_of(wanted.clamp(-most, most)) - angle) / dt;
        let rate = turn.clamp(-fastest, fastest);
        let end = (angle + rate * dt).tan() / limits.wheelbase;
        let acceleration = self.along(at, end, limits, dt);
        let part = dt / PARTS as f64;
        let rear = at.rear;
        let (mut x, mut y, mut heading) = (rear.position.x, rear.position.y, rear.heading);
        for i in 0..PARTS {
            let t = (i as f64 + 0.5) * part;
            let speed = v + acceleration * t;
            let curvature = (angle + rate * t).tan() / limits.wheelbase;
            let middle = heading + speed * curvature * part / 2.0;
            x += speed * part * middle.cos();
            y += speed * part * middle.sin();
            heading += speed * curvature * part;
        }
        let velocity = (v + acceleration * dt).max(0.0);
        Some(VehicleState {
            rear: Pose::new(x, y, normalize_angle(heading)),
            velocity,
            acceleration: if velocity > 0.0 { acceleration } else { 0.0 },
            curvature: end,
        })
    }

    /// Acceleration along the heading while the curvature changes to `end`, m/s².
    fn along(&self, at: &VehicleState, end: f64, limits: &Limits, dt: f64) -> f64 {
        let v = at.velocity.max(0.0);
        let towards = (self.until - v) / dt;
        let wanted = if self.acceleration < 0.0 {
            self.acceleration.max(towards.min(0.0))
        } else {
            self.acceleration.min(towards.max(0.0))
        };
        let faster = v + wanted.max(0.0) * dt;
        let across = faster * faster * at.curvature.abs().max(end.abs());
        let squared = (SHARE * limits.acceleration).powi(2) - across * across;
        let room = squared.max(0.0).sqrt();
        let forward = (SHARE * limits.forward(faster)).min((limits.speed - v).max(0.0) / dt);
        wanted.clamp(-room.min(v / dt), room.min(forward))
    }

    /// The curvature (1/m) that leads to the offset, at most `most`.
    ///
    /// From the target heading, half of `most` suffices to straighten up before the offset is passed.
    fn curvature(
        &self,
        at: &VehicleState,
        guide: &ReferenceTrack,
        hint: &mut Option<f64>,
        most: f64,
    ) -> Option<f64> {
        let path = &guide.path;
        let near = match *hint {
            Some(s) => path.project_near(&at.rear.position, s, MANOEUVRE_REACH),
            None => path.project(&at.rear.position),
        };
        let on = near.ok()?;
        *hint = Some(on.s);
        let point = path.at(on.s);
        let way = at.velocity * TURNING + AT_LEAST;
        let off = self.offset - on.d;
        let aim = (off.abs() / (SLOWER * way)).min((most * off.abs()).sqrt());
        let turn = aim.copysign(off) - normalize_angle(at.rear.heading - point.heading);
        let stretch = (1.0 - point.curvature * on.d).max(0.1);
        Some(point.curvature / stretch + turn / way)
    }
}
