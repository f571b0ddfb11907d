//! The fallback without a feasible candidate: the latest contact, or full braking along the path.

use nearmiss_base::geometry::{Pose, normalize_angle};

use super::evaluate::{Candidate, Rejection};
use super::state::place;
use super::traffic::EgoBox;
use super::{Limits, Plan, Planner, ReferenceTrack, Traffic, VehicleState};

/// Fallback when no candidate is feasible.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Emergency {
    /// The candidate that touches an obstacle's prediction last.
    LatestContact,
    /// Braking along the path: the mildest that touches no obstacle's prediction, or that which does so last.
    Braking,
}

/// Shares of the full braking that are tried in an emergency.
const BRAKING: [f64; 3] = [0.4, 0.7, 1.0];

impl Planner<'_> {
    /// The mildest braking without a predicted contact; if there is none, the one with the latest contact.
    pub(super) fn stop(
        &mut self,
        now: &VehicleState,
        traffic: &Traffic,
        wanted: f64,
        refinements: usize,
    ) -> Plan {
        self.last = None;
        let latest = self
            .candidates
            .iter()
            .filter_map(|c| match c.rejected {
                Some((step, Rejection::Contact(_))) => Some((step, c)),
                _ => None,
            })
            .max_by(|a, b| {
                let dearer = b.1.cost.total().total_cmp(&a.1.cost.total());
                a.0.cmp(&b.0).then(dearer)
            })
            .map(|(step, candidate)| (step, *candidate));
        // The mildest braking that touches no obstacle; if all do, the one that does so last.
        let mut braked: Option<(usize, Vec<VehicleState>)> = None;
        for share in BRAKING {
            let states = brake(
                now,
                self.guide,
                self.hint,
                &self.limits,
                share,
                self.dt,
                self.steps(),
            );
            let touched = first_contact(&states, traffic, &self.limits).unwrap_or(usize::MAX);
            if braked.as_ref().is_none_or(|(before, _)| touched > *before) {
                braked = Some((touched, states));
            }
            if touched == usize::MAX {
                break;
            }
        }
        let (touched, braking) = braked.unwrap_or_default();
        // A candidate is not driven beyond its contact: what it would do there does not count.
        let stays = |(step, candidate): &(usize, Candidate)| {
            let left = self.leaves_road(candidate);
            left.is_none_or(|left| left > *step)
        };
        match latest.filter(|l| touched < l.0 && stays(l)) {
            Some((step, candidate)) => Plan {
                states: self.braked_from(&candidate, step),
                cost: candidate.cost,
                ..self.summary(wanted, refinements, Some(Emergency::LatestContact))
            },
            None => Plan {
                states: braking,
                ..self.summary(wanted, refinements, Some(Emergency::Braking))
            },
        }
    }

    /// The state after one step of full braking along the path: what the friction circle leaves beside steering,
    /// 98 % of the vehicle's largest acceleration where it drives straight. The next cycle plans afresh from there.
    #[must_use]
    pub fn full_braking(&mut self, now: &VehicleState) -> VehicleState {
        self.last = None;
        // Before the first cycle the place on the path is not known yet.
        let place = place(self.guide, now, self.hint);
        self.hint = place.map(|(along, _)| along[0]).or(self.hint);
        let states = brake(now, self.guide, self.hint, &self.limits, 1.0, self.dt, 1);
        states.last().copied().unwrap_or(*now)
    }

    /// The states of a candidate up to `step`, beyond which it was not looked at, and full braking from there on.
    fn braked_from(&self, candidate: &Candidate, step: usize) -> Vec<VehicleState> {
        let mut states = self.states_of(candidate);
        states.truncate(step + 1);
        let left = self.steps().saturating_sub(step);
        if let Some(last) = states.last().copied() {
            let hint = self.arc_length_at(candidate, step);
            let stop = brake(&last, self.guide, hint, &self.limits, 1.0, self.dt, left);
            states.extend(stop.into_iter().skip(1));
        }
        states
    }
}

/// The first step at which an obstacle's predicted body is touched.
fn first_contact(states: &[VehicleState], traffic: &Traffic, limits: &Limits) -> Option<usize> {
    states.iter().enumerate().skip(1).find_map(|(step, state)| {
        let centre = state.centre(limits).pose;
        let (sin, cos) = centre.heading.sin_cos();
        let own = EgoBox {
            x: centre.position.x,
            y: centre.position.y,
            cos,
            sin,
            half_length: limits.length / 2.0,
            half_width: limits.width / 2.0,
        };
        let others = traffic.at(step).iter();
        let mut avoided = others.filter(|o| traffic.bodies[o.body].avoided);
        avoided.any(|o| o.separation(&own) < 0.0).then_some(step)
    })
}

/// Parts of a step in which the motion is integrated.
const PARTS: usize = 8;

/// How the wheels are turned back to the path: by the offset (1/m²) and by the heading (1/m).
const BY_OFFSET: f64 = 0.06;
const BY_HEADING: f64 = 0.4;

/// The share of the friction circle that braking may take where no steering is needed.
const SHARE: f64 = 0.98;

/// The states of an emergency stop from `now`, one a step of `dt` seconds, with `share` (0 to 1)
/// of what friction leaves for braking; inputs are constant within a step.
pub(super) fn brake(
    now: &VehicleState,
    guide: &ReferenceTrack,
    hint: Option<f64>,
    limits: &Limits,
    share: f64,
    dt: f64,
    steps: usize,
) -> Vec<VehicleState> {
    let mut states = vec![*now];
    let mut at = *now;
    let mut hint = hint;
    for _ in 0..steps {
        let wanted = wanted_curvature(&at, guide, &mut hint);
        at = step(&at, wanted, limits, share, dt);
        states.push(at);
    }
    states
}

/// The curvature that leads back to the path, 1/m; the present curvature beyond its end.
fn wanted_curvature(at: &VehicleState, guide: &ReferenceTrack, hint: &mut Option<f64>) -> f64 {
    let path = &guide.path;
    let near = hint.and_then(|s| path.project_near(&at.rear.position, s, 10.0).ok());
    let Some(on) = near else {
        return at.curvature;
    };
    *hint = Some(on.s);
    let point = path.at(on.s);
    let turn = normalize_angle(at.rear.heading - point.heading);
    point.curvature - BY_OFFSET * on.d - BY_HEADING * turn
}

fn step(at: &VehicleState, wanted: f64, limits: &Limits, share: f64, dt: f64) -> VehicleState {
    let v = at.velocity.max(0.0);
    // The curvature that friction allows at this speed, with a share left for braking.
    let most = (0.8 * limits.acceleration / (v * v).max(1.0)).min(limits.curvature());
    let (angle, wanted) = (
        limits.steering_of(at.curvature),
        limits.steering_of(wanted.clamp(-most, most)),
    );
    let rate = ((wanted - angle) / dt).clamp(-limits.steering_rate, limits.steering_rate);
    let end = (angle + rate * dt).tan() / limits.wheelbase;
    let across = v * v * at.curvature.abs().max(end.abs());
    let room = (SHARE * limits.acceleration).powi(2) - across * across;
    let braking = (room.max(0.0).sqrt() * share).min(v / dt);
    let part = dt / PARTS as f64;
    let (mut x, mut y, mut heading) = (at.rear.position.x, at.rear.position.y, at.rear.heading);
    for i in 0..PARTS {
        let t = (i as f64 + 0.5) * part;
        let speed = v - braking * t;
        let curvature = (angle + rate * t).tan() / limits.wheelbase;
        let middle = heading + speed * curvature * part / 2.0;
        x += speed * part * middle.cos();
        y += speed * part * middle.sin();
        heading += speed * curvature * part;
    }
    let velocity = (v - braking * dt).max(0.0);
    VehicleState {
        rear: Pose::new(x, y, normalize_angle(heading)),
        velocity,
        acceleration: if velocity > 0.0 { -braking } else { 0.0 },
        curvature: end,
    }
}
