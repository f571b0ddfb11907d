//! Rules that drive instead of a planner: the drivers, and three baselines that a planner has to beat.

use std::collections::HashMap;

use nearmiss_base::geometry::{Pose, angle_between, normalize_angle};
use nearmiss_scene::metrics::DrivenPath;
use nearmiss_scene::scenario::{HumanLimits, Motion, ObstacleRole, ObstacleType, Scenario};

use super::Driver as Simulation;
use super::traffic::Idm;
use crate::driver::{DRIVERS, Driver, DriverModel, Lookout, Now, Seen, driver};
use crate::planner::{Road, VehicleState};

/// Who drives by a rule.
#[derive(Debug, Clone, Copy)]
pub enum Policy {
    /// Straight on at the speed of the start, whatever comes.
    ConstantVelocity,
    /// Along the lane at the wanted speed, with the emergency braking of UN Regulation 157's last second.
    LaneFollowing,
    /// Along the lane with the Intelligent Driver Model.
    Idm,
    /// Like the one before, but it brakes gently until something makes this driver react.
    Driver(&'static DriverModel),
}

impl PartialEq for Policy {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name()
    }
}

impl Policy {
    /// Those that any planner has to beat.
    pub const BASELINES: [Self; 3] = [Self::ConstantVelocity, Self::LaneFollowing, Self::Idm];

    /// Its name on the command line and in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ConstantVelocity => "constant-velocity",
            Self::LaneFollowing => "lane-following",
            Self::Idm => "idm",
            Self::Driver(driver) => driver.id,
        }
    }

    /// All that have a rule: the ideal driver has none.
    pub fn all() -> impl Iterator<Item = Self> {
        let drivers = DRIVERS.iter().filter(|driver| driver.begin.is_some());
        Self::BASELINES.into_iter().chain(drivers.map(Self::Driver))
    }

    /// The one with this name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|policy| policy.name() == name)
    }

    fn reacting(self) -> Option<&'static DriverModel> {
        match self {
            Self::ConstantVelocity | Self::Idm => None,
            Self::LaneFollowing => driver("r157").ok(),
            Self::Driver(driver) => Some(driver),
        }
    }
}

/// A policy in a drive.
pub(super) struct Seat<'a> {
    policy: Policy,
    simulation: &'a Simulation,
    lookout: Lookout,
    driver: Option<Box<dyn Driver>>,
    /// Where on the path each obstacle was looked for last.
    hints: HashMap<i64, Option<usize>>,
    /// The rear axle along the path of the guide, metres.
    s: f64,
    start: Start,
    acceleration: f64,
    seen: Vec<Seen>,
}

/// Where a drive begins beside the path, and how it comes to it: offset y(s) = (y₀ + (y₀/f + y₀′) s) e^(−s/f) over the way s.
#[derive(Debug, Clone, Copy)]
struct Start {
    /// Arc length, metres.
    s: f64,
    /// Offset to the left, metres.
    offset: f64,
    /// Its change over the way.
    slope: f64,
    /// The way f over which both fade, metres.
    fading: f64,
}

impl Start {
    /// Offset (m), its change over the way, and the change of that (1/m), at an arc length.
    fn beside(&self, s: f64) -> (f64, f64, f64) {
        let (s, f) = (s - self.s, self.fading);
        let (y, c, e) = (self.offset, self.offset / f + self.slope, (-s / f).exp());
        let offset = (y + c * s) * e;
        let slope = c * e - offset / f;
        (offset, slope, -(c * e + slope) / f)
    }
}

/// Offset and angle of the start fade over the way of so many seconds, and over so many metres at least.
const FADING: (f64, f64) = (1.5, 8.0);

/// The tangent of the angle to the path from which it is come to.
const STEEPEST: f64 = 1.0;

/// The path is looked along by this, metres.
const SPACING: f64 = 1.0;

/// How soon the wanted speed is driven, seconds, and the accelerations for it, m/s².
const SOON: f64 = 1.0;
const ORDINARY: (f64, f64) = (-2.0, 1.5);

impl<'a> Seat<'a> {
    pub fn new(policy: Policy, simulation: &'a Simulation, start: &VehicleState) -> Self {
        let path = &simulation.guide().path;
        let near = path.project_near(&start.rear.position, simulation.guide().start, 20.0);
        let (s, d) = near.map_or((simulation.guide().start, 0.0), |at| (at.s, at.d));
        let turned = angle_between(path.at(s).heading, start.rear.heading);
        let motion = |pose: Pose| Motion {
            pose,
            velocity: 1.0,
            acceleration: 0.0,
        };
        let pieces = (path.length() / SPACING).ceil().max(1.0) as i64;
        let poses = (0..=pieces).map(|i| {
            (
                i,
                motion(path.pose_at(path.length() * i as f64 / pieces as f64)),
            )
        });
        let lookout = Lookout::new(
            DrivenPath::from_motions(poses),
            &Road::body_of(simulation.limits()),
            simulation.dt(),
        );
        Self {
            policy,
            simulation,
            lookout,
            driver: policy.reacting().and_then(|model| Some(model.begin?())),
            hints: HashMap::new(),
            s,
            start: Start {
                s,
                offset: d,
                slope: turned.tan().clamp(-STEEPEST, STEEPEST),
                fading: (FADING.0 * start.velocity).max(FADING.1),
            },
            acceleration: start.acceleration,
            seen: Vec::new(),
        }
    }

    /// The state a step later, with the others of `scenario` at `step`.
    pub fn step(&mut self, scenario: &Scenario, step: i64, state: &VehicleState) -> VehicleState {
        let dt = self.simulation.dt();
        let limits = self.simulation.limits();
        if matches!(self.policy, Policy::ConstantVelocity) {
            let way = state.rear.forward() * state.velocity * dt;
            let position = state.rear.position + way;
            let rear = Pose {
                position,
                ..state.rear
            };
            return VehicleState {
                rear,
                acceleration: 0.0,
                curvature: 0.0,
                ..*state
            };
        }
        let v = state.velocity.max(0.0);
        let centre = self.s + limits.rear_to_centre;
        self.look(scenario, step, centre);
        let reaction = self.driver.as_mut().and_then(|driver| {
            driver.react(&Now {
                dt,
                speed: v,
                acceleration: self.acceleration,
                others: &self.seen,
                alarmed: false,
            })
        });
        let ordinary = self.ordinary(v, centre, step);
        // A reaction never speeds up.
        let wanted = reaction.map_or(ordinary, |reaction| reaction.min(ordinary));
        let most = limits.acceleration;
        let acceleration = wanted
            .clamp(-most, most.min(limits.forward(v)))
            .max(-v / dt);
        let next = (v + acceleration * dt).max(0.0);
        self.s += f64::midpoint(v, next) * dt;
        self.acceleration = acceleration;
        VehicleState {
            velocity: next,
            acceleration,
            ..self.place()
        }
    }

    /// Where the rear axle is, and how the wheels stand there.
    fn place(&self) -> VehicleState {
        let path = &self.simulation.guide().path;
        let at = path.at(self.s);
        let (offset, slope, bend) = self.start.beside(self.s);
        let pose = path.pose_at(self.s);
        let most = self.simulation.limits().curvature();
        VehicleState {
            rear: Pose {
                position: at.position + pose.left() * offset,
                heading: normalize_angle(at.heading + slope.atan2(1.0 - at.curvature * offset)),
            },
            velocity: 0.0,
            acceleration: 0.0,
            curvature: (at.curvature + bend).clamp(-most, most),
        }
    }

    /// What is to be seen from an arc length at a step.
    fn look(&mut self, scenario: &Scenario, step: i64, s: f64) {
        let without = self.simulation.settings().without;
        let lookout = &self.lookout;
        let bodies = scenario.obstacles.iter().filter(|o| {
            matches!(o.role, ObstacleRole::Static | ObstacleRole::Dynamic)
                && Some(o.id) != without
                && !o.is_set_based()
        });
        let places = bodies.map(|obstacle| {
            let hint = self.hints.entry(obstacle.id).or_default();
            Lookout::LOOKS.map(|ago| {
                let then = match ago {
                    0.0 => step,
                    ago => step - lookout.steps(ago) as i64,
                };
                let motion = obstacle.motion_at(then)?;
                let is_known = obstacle.track().motion_known_at(then) <= step;
                lookout.place(obstacle.footprint_at(then)?, motion, is_known, hint)
            })
        });
        let places: Vec<_> = places.collect();
        lookout.see(s, places.into_iter(), &mut self.seen);
    }

    /// The acceleration of ordinary driving, m/s².
    fn ordinary(&self, v: f64, s: f64, step: i64) -> f64 {
        let guide = self.simulation.guide();
        let dt = self.simulation.dt();
        let legal = guide
            .legal
            .as_ref()
            .map_or(f64::INFINITY, |legal| legal.ahead(s, v));
        let wanted = guide
            .wanted(s, v, step, dt)
            .min(guide.bends.speed(s))
            .min(legal);
        if matches!(self.policy, Policy::LaneFollowing) {
            return ((wanted - v) / SOON).clamp(ORDINARY.0, ORDINARY.1);
        }
        let idm = Idm::for_kind(ObstacleType::Car);
        let ahead = self
            .seen
            .iter()
            .filter(|o| o.ahead > 0.0 && o.gap_lat <= 0.0);
        let leader = ahead.min_by(|a, b| a.gap_long.total_cmp(&b.gap_long));
        let free = idm.free(v, wanted);
        let wanted = leader.map_or(free, |leader| {
            free - idm.interaction(v, leader.gap_long, leader.speed.max(0.0))
        });
        // No more than people brake, as traffic that reacts; a driver brakes harder only as its rule says.
        wanted.max(match self.policy {
            Policy::Driver(_) => ORDINARY.0,
            _ => -HumanLimits::for_kind(ObstacleType::Car).braking,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Start;

    #[test]
    fn a_start_beside_the_path_comes_to_it_as_it_heads() {
        let start = Start {
            s: 10.0,
            offset: 0.8,
            slope: -0.1,
            fading: 12.0,
        };
        let (offset, slope, _) = start.beside(10.0);
        assert!((offset - 0.8).abs() < 1e-12 && (slope + 0.1).abs() < 1e-12);
        let far = start.beside(130.0);
        assert!(far.0.abs() < 1e-3 && far.1.abs() < 1e-3, "{far:?}");
        // Slope and bend are the changes of what stands before them.
        let step = 1e-5;
        for s in [10.5, 14.0, 40.0] {
            let (a, b) = (start.beside(s - step), start.beside(s + step));
            let (_, slope, bend) = start.beside(s);
            assert!(((b.0 - a.0) / (2.0 * step) - slope).abs() < 1e-8);
            assert!(((b.1 - a.1) / (2.0 * step) - bend).abs() < 1e-8);
        }
    }
}
