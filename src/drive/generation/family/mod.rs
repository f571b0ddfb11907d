//! Families of an encounter: its other road user does the same with another gap, closing speed, lateral speed or start.
//!
//! A case is the recorded scene but for the motion of that road user, which follows from the parameters, see `motion`. At the
//! measured values it is the recorded motion.

mod motion;
mod possible;

use std::sync::Arc;

use nearmiss_formats::{VariedMotion, VariedParameter};
use nearmiss_scene::corpus::{Event, EventKind, events};
use nearmiss_scene::metrics::{Context, Grade, Moments, Thresholds, critical_moments};
use nearmiss_scene::scenario::{Motion, Obstacle, ObstacleRole, Scenario, Scene};
use strum::{IntoStaticStr, VariantArray};

use super::gate::Regions;
use crate::driver::{Field, Preventability};
use motion::Course;

/// What a family varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "snake_case")]
pub enum Varied {
    /// From the ego's front to the other's rear at the moment of its manoeuvre, m.
    Gap,
    /// The ego's speed minus the other's at that moment, m/s.
    Closing,
    /// The other's mean speed across the way while it changes lanes, m/s.
    LateralSpeed,
    /// How much later than recorded it does it, s.
    Start,
}

nearmiss_record::named!(Varied, "parameter");

impl Varied {
    /// Its unit.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Gap => "m",
            Self::Closing | Self::LateralSpeed => "m/s",
            Self::Start => "s",
        }
    }

    /// What it is.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Gap => {
                "from the front of the ego to the rear of the other at the moment of its manoeuvre"
            }
            Self::Closing => "speed of the ego minus that of the other at that moment",
            Self::LateralSpeed => "mean speed of the other across the way while it changes lanes",
            Self::Start => "how much later than recorded the other does it",
        }
    }
}

/// A value for each of [`Varied::ALL`], in their order.
pub type Values = [f64; Varied::ALL.len()];

/// The most severe encounter of a scene, and how its other road user moves with other parameters.
#[derive(Debug)]
pub struct EncounterFamily<'s> {
    scene: &'s Scene,
    thresholds: &'s Thresholds,
    /// Which of the others it is with.
    obstacle: &'s Obstacle,
    /// Its step, as recorded.
    step: i64,
    grade: Grade,
    /// The manoeuvre that leads to it.
    event: Option<Event>,
    base: [Result<f64, String>; Varied::ALL.len()],
    course: Course,
    regions: Regions,
    is_certified: bool,
}

/// An encounter that comes later after a manoeuvre does not follow from it, seconds: drivers drive before both, from 5 s before
/// the encounter on.
const LATER: f64 = 4.0;

/// An encounter may begin before the body is in the lane, seconds.
const AFTER: f64 = 1.0;

impl<'s> EncounterFamily<'s> {
    /// That of the most severe encounter in which drivers can be asked. Events are those within `radius` metres;
    /// `is_certified`: a certificate says that the ideal driver avoids it as it was recorded.
    ///
    /// # Errors
    /// There is none, or its other road user does not move by itself: in words.
    pub fn of(
        scene: &'s Scene,
        thresholds: &'s Thresholds,
        radius: f64,
        is_certified: bool,
    ) -> Result<Self, String> {
        let context = Context::under(scene, thresholds);
        let severe = critical_moments(&context).into_iter();
        let moment = severe
            .filter(|moment| moment.grade <= Grade::NearMiss)
            .find(|moment| Field::around(scene, moment.obstacle, moment.step).is_some())
            .ok_or(
                "no contact, conflict or near miss of the ego in which a driver could be asked",
            )?;
        let id = moment.obstacle;
        let scenario = &scene.scenario;
        let obstacle = scenario.obstacle(id);
        let obstacle =
            obstacle.filter(|one| one.role == ObstacleRole::Dynamic && !one.is_set_based());
        let obstacle = obstacle.ok_or_else(|| {
            format!("the most severe encounter is with {id}, which does not move")
        })?;
        let track = obstacle.track();
        if track.steps().count() != track.iter().count() {
            return Err(format!(
                "the most severe encounter is with {id}, which is not recorded for a while"
            ));
        }
        let dt = scenario.dt();
        let steps = |seconds: f64| (seconds / dt).round() as i64;
        let leads = moment.step - steps(LATER)..=moment.step + steps(AFTER);
        let all = events(scene, radius).into_iter();
        let event = all
            .filter(|event| event.obstacle == id && leads.contains(&event.first_step))
            // Of two, the change of lane.
            .max_by_key(|event| (event.manoeuvre != EventKind::Braking, event.first_step));
        let course = Course::new(&context, obstacle, event.as_ref())?;
        let base = Varied::ALL.map(|varied| base(varied, id, event.as_ref(), &course));
        Ok(Self {
            scene,
            thresholds,
            obstacle,
            step: moment.step,
            grade: moment.grade,
            event,
            base,
            course,
            regions: Regions::new(scenario),
            is_certified,
        })
    }

    /// The value of the encounter as it was recorded.
    ///
    /// # Errors
    /// Why it has none, and what can be varied instead.
    pub fn base(&self, varied: Varied) -> Result<f64, &str> {
        let value = &self.base[varied as usize];
        value.as_ref().copied().map_err(String::as_str)
    }

    /// All of them; 0 of those that it has none of.
    #[must_use]
    pub fn recorded(&self) -> Values {
        Varied::ALL.map(|varied| self.base(varied).unwrap_or_default())
    }

    /// In words: `conflict with 301 at 4.4 s, cut_in at 3.9 s`.
    #[must_use]
    pub fn words(&self) -> String {
        let time = |step| format!("{:.1} s", self.scene.time_of(step));
        let grade = nearmiss_scene::metrics::SEVERITY_NAMES[usize::from(self.grade.number())];
        let encounter = format!("{grade} with {} at {}", self.obstacle.id, time(self.step));
        match &self.event {
            Some(event) => {
                let (name, at) = (event.manoeuvre.name(), time(event.first_step));
                format!("{encounter}, {name} at {at}")
            }
            None => encounter,
        }
    }

    /// How long the recording is, seconds.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let steps = self.scene.steps();
        (steps.end - steps.start) as f64 * self.dt()
    }

    /// Seconds between two steps: starts are whole numbers of them.
    #[must_use]
    pub fn dt(&self) -> f64 {
        self.scene.scenario.dt()
    }

    /// The same for these starts (s): in between, the ego's motion counts as even.
    #[must_use]
    pub fn with_starts(mut self, starts: &[f64]) -> Self {
        self.course.allow(starts);
        self
    }

    /// The motion of the other road user in a case: at each step at which it was recorded.
    #[must_use]
    pub fn motion(&self, values: &Values) -> Vec<(i64, Motion)> {
        self.course.motion(values)
    }

    /// The scene of a case.
    #[must_use]
    pub fn changed(&self, values: &Values) -> Scene {
        let mut scenario = Scenario::clone(&self.scene.scenario);
        let own = { scenario.obstacles.iter_mut() }.find(|one| one.id == self.obstacle.id);
        if let Some(own) = own
            && let Some(moved) = own.moving(&self.motion(values), self.scene.scenario.dt())
        {
            *own = moved;
        }
        Scene::new(Arc::new(scenario), self.scene.ego.clone())
    }

    /// What drivers make of a case, around its most severe moment until 4 s after the manoeuvre.
    ///
    /// # Errors
    /// Nothing can be said of it: its vehicle could not drive so, it touches another one before, or the encounter begins with
    /// the recording. In words.
    pub fn judge(&self, values: &Values) -> Result<Preventability, String> {
        let scene = self.changed(values);
        let id = self.obstacle.id;
        let moved = scene.scenario.obstacle(id).ok_or("it is gone")?;
        self.is_possible(moved.track())?;
        let context = Context::under(&scene, self.thresholds);
        let place = { context.participants().iter() }.position(|one| one.obstacle.id == id);
        let moments = Moments::new(&context);
        let (start, dt) = (values[Varied::Start as usize], self.dt());
        let recorded = { self.event.as_ref() }.map_or(self.step, |event| event.first_step);
        let moment = recorded + (start / dt).round() as i64;
        let last = moment + (LATER / dt).round() as i64;
        let steps = context.steps().take_while(|step| *step <= last);
        let worst = place
            .and_then(|place| moments.with(place).worst(steps))
            .ok_or("it is never there with the ego")?;
        self.is_alone(&scene.scenario, moved, worst.step)?;
        // Who would begin behind the ego drives through it.
        if self.event.is_some() && worst.grade == Grade::Contact && worst.step < moment {
            return Err("it touches the ego before its manoeuvre".into());
        }
        let field = Field::around(&scene, id, worst.step)
            .ok_or("its encounter begins with the recording, or after another contact")?;
        let mut found = Preventability::of(&field);
        if self.is_certified && *values == self.recorded() {
            found.ideal_avoids();
        }
        Ok(found)
    }

    /// The motion for other programs, with parameters that have the recorded values and these ranges.
    #[must_use]
    pub fn varied(&self, ranges: &[(Varied, [f64; 2])]) -> VariedMotion {
        let parameters = ranges.iter().map(|(varied, range)| VariedParameter {
            name: varied.name(),
            meaning: format!("{}, {}", varied.meaning(), varied.unit()),
            value: self.recorded()[*varied as usize],
            range: *range,
        });
        let varied: Vec<Varied> = ranges.iter().map(|(varied, _)| *varied).collect();
        VariedMotion {
            obstacle: self.obstacle.id,
            parameters: parameters.collect(),
            vertices: self.course.vertices(&varied),
        }
    }
}

/// The value of a parameter as it was recorded.
fn base(varied: Varied, id: i64, event: Option<&Event>, course: &Course) -> Result<f64, String> {
    let name = varied.name();
    if varied == Varied::Start {
        return Ok(0.0);
    }
    let event = event.ok_or_else(|| {
        format!(
            "{id} does not cut in, merge, leave the lane or brake ahead of the ego, so {name} has no meaning; vary start"
        )
    })?;
    let what = event.manoeuvre.name();
    let unmeasured = || format!("{name} of {id} could not be measured");
    match varied {
        Varied::LateralSpeed if event.manoeuvre == EventKind::Braking => Err(format!(
            "{id} brakes ahead in its lane and has no {name}; vary gap, closing or start"
        )),
        Varied::LateralSpeed if !course.goes_sideways() => Err(unmeasured()),
        Varied::LateralSpeed => event.lateral_speed.ok_or_else(unmeasured),
        _ if event.manoeuvre == EventKind::CutOut => Err(format!(
            "{name} of a {what} is that to what it uncovers, and not to {id}; vary lateral_speed or start"
        )),
        Varied::Gap => event.gap.ok_or_else(unmeasured),
        _ if !course.drives() => Err(format!(
            "{id} stands at its {what}, so {name} cannot be another; vary gap or start"
        )),
        _ => event.closing.ok_or_else(unmeasured),
    }
}
