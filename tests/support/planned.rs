//! A planning cycle of a chosen size: a bundled road, candidates and bodies as many as asked for.

use nearmiss::formats::bundled;
use nearmiss::geometry::{Footprint, Pose, Shape, Vector};
use nearmiss::planner::{
    Body, Limits, ReferenceTrack, Road, Sampling, Settings, Traffic, VehicleState,
};

/// Where a cycle is planned.
pub struct Place {
    pub guide: ReferenceTrack,
    pub road: Road,
    pub start: VehicleState,
    pub dt: f64,
}

/// m/s, of the planned vehicle and of the others.
const SPEED: f64 = 12.0;

/// The road of a bundled scenario whose route is long enough for the horizon.
pub fn place() -> Place {
    for entry in bundled() {
        let scenario = entry.read().expect("a bundled scenario");
        let graph = scenario.network.lane_graph(None);
        for problem in &scenario.planning_problems {
            let Ok(guide) = ReferenceTrack::for_problem(&scenario, &graph, problem) else {
                continue;
            };
            if guide.path.length() < guide.start + 120.0 {
                continue;
            }
            let limits = Limits::for_vehicle(Settings::default().vehicle);
            let start = VehicleState {
                rear: guide.path.pose_at(guide.start),
                velocity: SPEED,
                acceleration: 0.0,
                curvature: 0.0,
            };
            return Place {
                road: Road::new(&scenario.network, &limits),
                guide,
                start,
                dt: scenario.dt(),
            };
        }
    }
    panic!("no bundled scenario has a long route");
}

/// `bodies` cars to both sides of the path, as fast as the planned one, evenly spread around it.
pub fn traffic(place: &Place, steps: usize, bodies: usize) -> Traffic {
    let car = Footprint::new(Shape::rectangle(4.5, 1.8)).expect("a car");
    let mut traffic = Traffic::new(steps);
    for i in 0..bodies {
        let body = traffic.add(Body {
            id: 100 + i as i64,
            likelihood: 1.0,
            avoided: true,
        });
        let ahead = 100.0 * (i as f64 + 0.5) / bodies as f64 - 10.0;
        let side = if i % 2 == 0 { 7.0 } else { -7.0 };
        for step in 0..=steps {
            let s = place.guide.start + ahead + SPEED * step as f64 * place.dt;
            let on = place.guide.path.pose_at(s);
            let forward = on.forward();
            let pose = Pose {
                position: on.position + Vector::new(-forward.y, forward.x) * side,
                heading: on.heading,
            };
            traffic.occupy(body, step, &car, &pose, SPEED);
        }
    }
    traffic
}

/// The usual settings with other samples, refined never.
pub fn settings(sampling: Sampling) -> Settings {
    Settings {
        sampling: Sampling {
            refinements: 0,
            ..sampling
        },
        ..Settings::default()
    }
}
