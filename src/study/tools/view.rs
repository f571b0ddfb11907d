//! What tools see of a scene: the steps of one window, with times that count from its end.

use super::ToolError;
use nearmiss_base::geometry::Footprint;
use nearmiss_scene::metrics::{Context, Thresholds};
use nearmiss_scene::scenario::{Motion, Participant, Scene, Track, Window};

/// A scene as it is known at the end of a window. Instruments read it through this type alone, and nothing that it
/// gives them depends on later steps.
#[derive(Debug)]
pub struct WindowView<'s> {
    context: Context<'s>,
    scene: &'s Scene,
    window: Window,
    /// Obstacles that are there at some step of the window, with their places in the context.
    there: Vec<(usize, Participant<'s>)>,
}

/// The ego, or one other.
#[derive(Debug, Clone, Copy)]
pub(super) enum Who<'s> {
    /// The ego.
    Ego,
    /// An obstacle, with its place in the context.
    Other(usize, Participant<'s>),
}

impl Who<'_> {
    /// The words for it.
    pub fn name(&self) -> String {
        match self {
            Self::Ego => "the ego".into(),
            Self::Other(_, p) => format!("obstacle {}", p.obstacle.id),
        }
    }
}

impl<'s> WindowView<'s> {
    /// The view of a window, measured with these thresholds.
    #[must_use]
    pub fn new(scene: &'s Scene, thresholds: &'s Thresholds, window: Window) -> Self {
        let context = Context::under(scene, thresholds).during(&window);
        let all = context.participants().iter().copied().enumerate();
        let there = all
            .filter(|(_, p)| window.steps().any(|step| p.at(step).is_some()))
            .collect();
        Self {
            context,
            scene,
            window,
            there,
        }
    }

    /// The scene during the window, prepared for measuring.
    pub(super) fn context(&self) -> &Context<'s> {
        &self.context
    }

    /// The obstacles that are there at some step of the window.
    pub(super) fn there(&self) -> &[(usize, Participant<'s>)] {
        &self.there
    }

    /// Seconds from the end of the window to a step; negative before it.
    pub(super) fn seconds(&self, step: i64) -> f64 {
        (step - self.window.last()) as f64 * self.scene.scenario.dt()
    }

    /// The step at `t` seconds from the end of the window; without a time its last one.
    pub(super) fn step(&self, t: Option<f64>) -> Result<i64, ToolError> {
        let Some(t) = t else {
            return Ok(self.window.last());
        };
        let dt = self.scene.scenario.dt();
        let steps = t / dt;
        if steps > 0.25 {
            return Err(ToolError::new(format!(
                "t = {t} s is after the end of the described window; nothing after t = 0 can be asked"
            )));
        }
        let first = self.seconds(self.window.first());
        if steps.round() < first / dt - 0.25 {
            return Err(ToolError::new(format!(
                "t = {t} s is before the described window, which begins at t = {first:.2} s"
            )));
        }
        Ok(self.window.last() + steps.round() as i64)
    }

    /// The participant with an id; 0 is the ego.
    pub(super) fn participant(&self, id: i64) -> Result<Who<'s>, ToolError> {
        if id == 0 {
            return Ok(Who::Ego);
        }
        let found = self.there.iter().find(|(_, p)| p.obstacle.id == id);
        found
            .map(|(place, p)| Who::Other(*place, *p))
            .ok_or_else(|| {
                let ids = self.there.iter().map(|(_, p)| p.obstacle.id.to_string());
                let mut ids: Vec<String> = ids.take(40).collect();
                if ids.len() < self.there.len() {
                    ids.push("…".into());
                }
                let known = if ids.is_empty() {
                    "it has none".to_string()
                } else {
                    format!("it has {}", ids.join(", "))
                };
                ToolError::new(format!("no obstacle {id} in the described window; {known}"))
            })
    }

    /// Motion and body of a participant at a step.
    pub(super) fn at(
        &self,
        who: &Who<'s>,
        step: i64,
    ) -> Result<(&'s Motion, &'s Footprint), ToolError> {
        let found = match who {
            Who::Ego => {
                let motion = self.scene.ego.track.at(step);
                motion.zip(Some(self.scene.ego_footprint_at(step)))
            }
            Who::Other(_, p) if p.obstacle.is_occupancy_at(step) => {
                return Err(ToolError::new(format!(
                    "{} is a region that it may cover at t = {:.2} s (occupancy set), without heading and speed; ask for \
                     the measure `distance`",
                    who.name(),
                    self.seconds(step)
                )));
            }
            Who::Other(_, p) => p.at(step).zip(Some(p.footprint_at(step))),
        };
        let t = self.seconds(step);
        let found = found.ok_or_else(|| {
            ToolError::new(format!("{} is not there at t = {t:.2} s", who.name()))
        })?;
        if self.track(who).motion_known_at(step) > self.window.last() {
            return Err(ToolError::new(format!(
                "heading and speed of {} are not known yet: its record begins without them at the end of the described \
                 window",
                who.name()
            )));
        }
        Ok(found)
    }

    /// Whether the acceleration of a participant at a step follows from the steps of the window.
    pub(super) fn knows_acceleration(&self, who: &Who<'s>, step: i64) -> bool {
        self.track(who).acceleration_known_at(step) <= self.window.last()
    }

    fn track(&self, who: &Who<'s>) -> &'s Track {
        match who {
            Who::Ego => &self.scene.ego.track,
            Who::Other(_, p) => p.obstacle.track(),
        }
    }
}

/// A number as results have it, rounded to thousandths; only a true 0 becomes 0, since a distance of 0 is a contact.
pub(super) fn number(value: f64) -> f64 {
    let rounded = time(value);
    if rounded == 0.0 && value != 0.0 {
        0.001_f64.copysign(value)
    } else {
        rounded
    }
}

/// A time as results have it, seconds.
pub(super) fn time(seconds: f64) -> f64 {
    (seconds * 1e3).round() / 1e3 + 0.0
}
