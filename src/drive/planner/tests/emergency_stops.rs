//! Tests that emergency stops are drivable, and end at a standstill.

use proptest::prelude::*;

use super::guide;
use crate::planner::emergency::brake;
use crate::planner::{Feasibility, Limits, ReferenceTrack, Settings, VehicleState};
use nearmiss_base::geometry::Pose;

/// On the path's start with this much beside it, turned from it and steered, the latter two as shares of what is
/// allowed.
fn state(
    guide: &ReferenceTrack,
    velocity: f64,
    d: f64,
    turn: f64,
    steer: f64,
    limits: &Limits,
) -> VehicleState {
    let on = guide.path.pose_at(guide.start);
    let forward = on.forward();
    let most = (0.9 * limits.acceleration / (velocity * velocity).max(1.0)).min(limits.curvature());
    VehicleState {
        rear: Pose::new(
            on.position.x - forward.y * d,
            on.position.y + forward.x * d,
            on.heading + turn,
        ),
        velocity,
        acceleration: 0.0,
        curvature: steer * most,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn an_emergency_stop_can_be_driven(
        velocity in 0.0..45.0_f64,
        d in -2.0..2.0_f64,
        turn in -0.6..0.6_f64,
        steer in -1.0..1.0_f64,
        lost in any::<bool>(),
    ) {
        let (guide, dt) = guide("HardBraking");
        let settings = Settings::default();
        let limits = settings.limits();
        let now = state(&guide, velocity, d, turn, steer, &limits);
        let hint = (!lost).then_some(guide.start);
        let states = brake(&now, &guide, hint, &limits, 1.0, dt, 70);
        prop_assert_eq!(states.len(), 71);
        prop_assert_eq!(states[0], now);
        prop_assert_eq!(states[70].velocity, 0.0);
        prop_assert!(states.windows(2).all(|w| w[1].velocity <= w[0].velocity));
        let check = Feasibility::new(Limits::for_vehicle(settings.vehicle), dt);
        let passed = check.states(0, &states);
        prop_assert!(passed.is_ok(), "{}", passed.unwrap_err());
    }
}

#[test]
fn braking_straight_on_is_as_hard_as_it_may_be() {
    let (guide, dt) = guide("HardBraking");
    let limits = Settings::default().limits();
    let now = state(&guide, 20.0, 0.0, 0.0, 0.0, &limits);
    let states = brake(&now, &guide, None, &limits, 1.0, dt, 40);
    let way = (states[40].rear.position - now.rear.position).norm();
    let shortest = 20.0 * 20.0 / (2.0 * limits.acceleration);
    assert!(
        way > shortest - 1e-6 && way < 1.05 * shortest,
        "{way} {shortest}"
    );
}
