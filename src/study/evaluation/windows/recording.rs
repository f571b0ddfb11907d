//! What is kept of a recording to draw windows from: contacts, traffic near the ego, its speed.

use std::collections::BTreeSet;

use super::super::{Label, Labelled, Lead};
use super::Moment;
use super::matching::Candidate;
use nearmiss_scene::metrics::Contact;
use nearmiss_scene::scenario::{Participant, Scene, Window};

/// How long after the horizon of a safe window nothing is touched either, seconds: a contact just after the horizon
/// makes a window that is neither safe nor dangerous.
pub const CLEAR: f64 = 1.0;

/// A labelled recording, reduced to what the drawing of windows looks at.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    name: String,
    label: Label,
    /// Seconds between steps.
    dt: f64,
    /// The ego's first step and the one after its last.
    steps: std::ops::Range<i64>,
    /// The first contact of the label: the exact one, else the last recorded step of what is labelled a collision.
    contact: Option<i64>,
    /// Steps at which or on the way to which the ego touches an obstacle, with its id, in order; where a risk score is the truth, steps of
    /// extreme risk.
    touches: Vec<(i64, i64)>,
    /// By step: ids of the obstacles whose centre is near the ego's.
    near: Vec<Vec<i64>>,
    /// By step: the ego's speed, m/s.
    speed: Vec<f64>,
}

impl Recording {
    /// Of a scene: obstacles whose centre is within `radius` metres of the ego's count as traffic.
    #[must_use]
    pub fn new(name: &str, case: &Labelled<'_>, radius: f64) -> Self {
        let scene = case.scene;
        let steps = scene.steps();
        let everyone: Vec<Participant<'_>> = scene.participants().collect();
        let touched = |step: i64| {
            let contacts = everyone
                .iter()
                .filter_map(move |other| Contact::at(scene, other, step));
            contacts.map(move |contact| (step, contact.obstacle))
        };
        let touches = steps.clone().flat_map(touched).collect();
        let contact = match case.label {
            Label::Collision(_) => case.contact.or(Some(steps.end - 1)),
            Label::Safe => None,
        };
        Self::with(name, scene, (case.label, contact, touches), radius)
    }

    /// Of a scene in which other moments than contacts are dangerous: steps and ids of obstacles, by step.
    #[must_use]
    pub fn of_moments(name: &str, scene: &Scene, moments: Vec<(i64, i64)>, radius: f64) -> Self {
        let first = moments.first().copied();
        let label = first.map_or(Label::Safe, |(_, id)| Label::Collision(Some(id)));
        let first = first.map(|(step, _)| step);
        Self::with(name, scene, (label, first, moments), radius)
    }

    fn with(
        name: &str,
        scene: &Scene,
        (label, contact, touches): (Label, Option<i64>, Vec<(i64, i64)>),
        radius: f64,
    ) -> Self {
        let everyone: Vec<Participant<'_>> = scene.participants().collect();
        let steps = scene.steps();
        Self {
            name: name.into(),
            label,
            dt: scene.scenario.dt(),
            contact,
            touches,
            near: steps
                .clone()
                .map(|step| near(scene, &everyone, step, radius))
                .collect(),
            speed: steps.clone().map(|step| speed_at(scene, step)).collect(),
            steps,
        }
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether it is a collision in truth.
    #[must_use]
    pub fn collides(&self) -> bool {
        self.label.collides()
    }

    /// Random numbers that depend on its name alone.
    pub(super) fn random(&self) -> fastrand::Rng {
        // FNV-1a: G. Fowler, L. C. Noll, P. Vo, "The FNV Non-Cryptographic Hash Algorithm".
        let hash = self
            .name
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
                (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
            });
        fastrand::Rng::with_seed(hash)
    }

    /// The dangerous window of a collision; `None` for safe recordings and where the recording begins later.
    pub(super) fn dangerous_window(&self, moment: Moment, history: usize) -> Option<Window> {
        let contact = self.contact?;
        let last = match moment {
            Moment::Before(Lead::Paper) => self.steps.end - 1 - Window::AFTER_SAFETY,
            Moment::Before(Lead::Seconds(lead)) => contact - (lead / self.dt).round() as i64,
            Moment::Contact => {
                // That the contact is always at the end would be a hint where to look.
                let most = (history as i64 / 2).min(self.steps.end - 1 - contact);
                contact + self.random().i64(0..=most.max(0))
            }
        };
        // A window before the contact does not hold it, however small the lead is.
        let is_before = match moment {
            Moment::Before(Lead::Seconds(_)) => last < contact,
            _ => true,
        };
        (is_before && self.steps.contains(&last)).then(|| self.window(last, history))
    }

    /// So many steps that end at `last`, cut to the recording.
    pub(super) fn window(&self, last: i64, steps: usize) -> Window {
        Window::within(&self.steps, last, steps)
    }

    /// Last steps of safe windows of so many steps: nothing is touched in them, within the horizon after them and for
    /// [`CLEAR`] more, and the recording goes on for the whole horizon.
    pub(super) fn safe_ends(&self, steps: usize, horizon: f64) -> Vec<i64> {
        let after = (horizon / self.dt).round() as i64;
        let clear = after + (CLEAR / self.dt).round() as i64;
        let before = i64::try_from(steps.max(1) - 1).unwrap_or(i64::MAX);
        // A label that says collision speaks of the end where no bodies touch.
        let supposed = self.contact.filter(|_| self.touches.is_empty());
        let touches = self.touches.iter().map(|(step, _)| *step).chain(supposed);
        let touches: Vec<i64> = touches.collect();
        let quiet = |last: &i64| {
            let span = last - before..=last + clear;
            !touches.iter().any(|step| span.contains(step))
        };
        let first = self.steps.start.saturating_add(before);
        (first..self.steps.end - after).filter(quiet).collect()
    }

    /// Obstacles that the ego touches at one of these steps, the first one first.
    fn touched(&self, steps: &std::ops::RangeInclusive<i64>) -> Vec<i64> {
        let mut seen = BTreeSet::new();
        let touches = self.touches.iter();
        let within = touches.filter(|(step, _)| steps.contains(step));
        within
            .map(|(_, id)| *id)
            .filter(|id| seen.insert(*id))
            .collect()
    }

    /// What is true of a window at this moment, and whom the ego touches.
    #[must_use]
    pub fn truth(&self, moment: Moment, window: &Window, horizon: f64) -> (Label, Vec<i64>) {
        let after = (horizon / self.dt).round() as i64;
        let span = match moment {
            Moment::Before(_) => window.last() + 1..=window.last().saturating_add(after),
            Moment::Contact => window.steps(),
        };
        let supposed = self.contact.filter(|_| self.touches.is_empty());
        let critical = self.touched(&span);
        let dangerous = !critical.is_empty() || supposed.is_some_and(|step| span.contains(&step));
        if dangerous && self.collides() {
            self.named(critical)
        } else {
            (Label::Safe, Vec::new())
        }
    }

    /// What is true of the whole recording, and whom the ego touches in it.
    pub(super) fn truth_of_all(&self) -> (Label, Vec<i64>) {
        self.named(self.touched(&(self.steps.start..=self.steps.end - 1)))
    }

    /// The label of a dangerous window and its critical obstacles: those touched, or where the truth names another one,
    /// that.
    fn named(&self, touched: Vec<i64>) -> (Label, Vec<i64>) {
        match self.label {
            Label::Collision(Some(id)) if !touched.contains(&id) => {
                (Label::Collision(Some(id)), vec![id])
            }
            Label::Collision(Some(id)) => (Label::Collision(Some(id)), touched),
            _ => (Label::Collision(touched.first().copied()), touched),
        }
    }

    /// What a window is matched on.
    pub(super) fn candidate(&self, window: &Window) -> Candidate {
        let place = |step: i64| usize::try_from(step - self.steps.start).unwrap_or(0);
        let near = &self.near[place(window.first())..=place(window.last())];
        let distinct: BTreeSet<i64> = near.iter().flatten().copied().collect();
        Candidate {
            last: window.last(),
            steps: near.len(),
            obstacles: distinct.len(),
            rows: near.iter().map(Vec::len).sum(),
            speed: self.speed[place(window.last())],
        }
    }
}

/// What can be seen of a window without looking at how the obstacles move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Traffic {
    /// Obstacles near the ego at one of its steps.
    pub obstacles: usize,
    /// The ego's speed at its end, m/s.
    pub speed: f64,
}

impl Traffic {
    /// In a window; obstacles are near whose centre is within `radius` metres of the ego's.
    #[must_use]
    pub fn in_window(scene: &Scene, window: &Window, radius: f64) -> Self {
        let everyone: Vec<Participant<'_>> = scene.participants().collect();
        let near = |step| near(scene, &everyone, step, radius);
        let distinct: BTreeSet<i64> = window.steps().flat_map(near).collect();
        Self {
            obstacles: distinct.len(),
            speed: speed_at(scene, window.last()),
        }
    }
}

fn speed_at(scene: &Scene, step: i64) -> f64 {
    scene.ego.track.at(step).map_or(0.0, |ego| ego.velocity)
}

/// Ids of the obstacles whose centre is within `radius` metres of the ego's.
fn near(scene: &Scene, everyone: &[Participant<'_>], step: i64, radius: f64) -> Vec<i64> {
    let Some(ego) = scene.ego.track.at(step) else {
        return Vec::new();
    };
    let is_near = |other: &&Participant<'_>| {
        other
            .at(step)
            .is_some_and(|motion| (motion.pose.position - ego.pose.position).norm() <= radius)
    };
    let near = everyone.iter().filter(is_near);
    near.map(|other| other.obstacle.id).collect()
}
