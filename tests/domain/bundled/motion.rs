//! Everything that moves obeys the same mechanics as read back from the files, four decimals and all.

use nearmiss::geometry::angle_between;
use nearmiss::scenario::{LaneletType, Motion, ObstacleRole, ObstacleType, Track};

use crate::bundled::{CASES, Case, none};

/// Adhesion of a vehicle on a dry road, m/s².
const GRIP: f64 = 8.0;

/// The fastest walk, m/s.
const BRISK: f64 = 2.2;

/// The tracks of a case: a name, what it is, its motion.
fn tracks(case: &Case) -> impl Iterator<Item = (String, ObstacleType, &Track)> {
    let name = case.made.name;
    let others = case.scene.scenario.obstacles.iter();
    let moving = others.filter(|o| o.role == ObstacleRole::Dynamic);
    let ego = (
        format!("{name}, ego"),
        ObstacleType::Car,
        &case.scene.ego.track,
    );
    moving
        .map(move |o| (format!("{name}, {}", o.id), o.kind, o.track()))
        .chain([ego])
}

/// Complaints about the steps of every track, as pairs of neighbours.
fn over_steps(check: impl Fn(ObstacleType, &Motion, &Motion, f64) -> Option<String>) {
    let mut complaints = Vec::new();
    for case in CASES.iter() {
        let dt = case.scene.scenario.dt();
        for (who, kind, track) in tracks(case) {
            let motions: Vec<_> = track.iter().collect();
            assert!(motions.len() >= 40, "{who}: {} steps", motions.len());
            complaints.extend(motions.windows(2).filter_map(|pair| {
                let [(step, a), (_, b)] = pair else {
                    return None;
                };
                Some(format!("{who} at {step}: {}", check(kind, a, b, dt)?))
            }));
        }
    }
    none(&complaints);
}

#[test]
fn positions_integrate_velocities() {
    over_steps(|_, a, b, dt| {
        let moved = (b.pose.position - a.pose.position).norm();
        let driven = f64::midpoint(a.velocity, b.velocity) * dt;
        ((moved - driven).abs() > 0.01).then(|| format!("moved {moved} m, driven {driven} m"))
    });
}

#[test]
fn velocities_integrate_accelerations() {
    over_steps(|_, a, b, dt| {
        let change = b.velocity - a.velocity;
        let meant = f64::midpoint(a.acceleration, b.acceleration) * dt;
        // Where a knot of the profile falls between steps, the middle is only near the mean.
        ((change - meant).abs() > 0.12).then(|| format!("{change} m/s instead of {meant}"))
    });
}

#[test]
fn bodies_point_where_they_go() {
    over_steps(|_, a, b, _| {
        let moved = b.pose.position - a.pose.position;
        // Rounding to tenths of millimetres turns short displacements.
        if moved.norm() < 0.05 {
            return None;
        }
        let along = moved.y.atan2(moved.x);
        let middle = a.pose.heading + angle_between(a.pose.heading, b.pose.heading) / 2.0;
        let off = angle_between(middle, along).abs();
        (off > 0.01 + 2e-4 / moved.norm()).then(|| format!("points {off} rad aside"))
    });
}

#[test]
fn nobody_exceeds_the_friction_circle() {
    over_steps(|kind, a, b, dt| {
        let yaw_rate = angle_between(a.pose.heading, b.pose.heading) / dt;
        let force = a.acceleration.hypot(a.velocity * yaw_rate);
        let grip = if kind == ObstacleType::Pedestrian {
            3.0
        } else {
            GRIP
        };
        (force > grip).then(|| format!("{force} m/s²"))
    });
}

#[test]
fn acceleration_builds_up() {
    over_steps(|_, a, b, dt| {
        let jerk = (b.acceleration - a.acceleration).abs() / dt;
        (jerk > 31.0).then(|| format!("jerk {jerk} m/s³"))
    });
}

#[test]
fn people_walk_and_nobody_reverses() {
    over_steps(|kind, a, _, _| {
        let fast = match kind {
            ObstacleType::Pedestrian => BRISK,
            ObstacleType::Bicycle => 9.0,
            ObstacleType::Truck | ObstacleType::Bus => 25.0,
            _ => 42.0,
        };
        (!(0.0..=fast).contains(&a.velocity)).then(|| format!("{} m/s", a.velocity))
    });
}

#[test]
fn everybody_is_on_a_lanelet_for_them() {
    let mut complaints = Vec::new();
    for case in CASES.iter() {
        let network = &case.scene.scenario.network;
        for (who, kind, track) in tracks(case) {
            let on_foot = kind == ObstacleType::Pedestrian;
            complaints.extend(track.iter().filter_map(|(step, motion)| {
                let here = network.lanelets_at(&motion.pose.position);
                let types = here
                    .iter()
                    .filter_map(|id| network.lanelet(*id))
                    .map(|l| &l.types);
                let walk = [LaneletType::Sidewalk, LaneletType::Crosswalk];
                let fits = |types: &Vec<LaneletType>| walk.contains(&types[0]) == on_foot;
                let on = types.clone().any(fits);
                (!on).then(|| format!("{who} at {step}: on {here:?}"))
            }));
        }
    }
    none(&complaints);
}
