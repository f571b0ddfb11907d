//! Scenes made of a road and of functions of time, placed anywhere, turned and mirrored.

use std::sync::Arc;

use nearmiss::geometry::{Footprint, Point, Pose, Shape, Vector};
use nearmiss::scenario::{
    Bound, ContentHash, Ego, EgoSource, Header, Lanelet, LaneletNetwork, Obstacle, ObstacleParts,
    ObstacleRole, ObstacleType, Position, Prediction, Quantity, Sample, Scenario, Scene, State,
    Steps, Track,
};

pub const DT: f64 = 0.1;
pub const STEPS: i64 = 40;

/// Position and heading at a time in seconds.
pub type Motion = fn(f64) -> (f64, f64, f64);

pub struct Actor {
    pub id: i64,
    pub kind: ObstacleType,
    pub size: (f64, f64),
    pub parked: bool,
    pub motion: Motion,
}

pub fn car(id: i64, motion: Motion) -> Actor {
    Actor {
        id,
        kind: ObstacleType::Car,
        size: (4.5, 1.8),
        parked: false,
        motion,
    }
}

pub fn parked(id: i64, motion: Motion) -> Actor {
    Actor {
        kind: ObstacleType::ParkedVehicle,
        parked: true,
        ..car(id, motion)
    }
}

pub fn pedestrian(id: i64, motion: Motion) -> Actor {
    Actor {
        kind: ObstacleType::Pedestrian,
        size: (0.5, 0.5),
        ..car(id, motion)
    }
}

pub struct Stage {
    pub network: LaneletNetwork,
    pub ego: Motion,
    pub actors: Vec<Actor>,
}

/// Where a stage stands: mirrored at its x axis first, then turned, then moved.
#[derive(Clone, Copy)]
pub struct Stand {
    pub mirrored: bool,
    pub turn: f64,
    pub shift: (f64, f64),
}

pub const HERE: Stand = Stand {
    mirrored: false,
    turn: 0.0,
    shift: (0.0, 0.0),
};

impl Stand {
    fn pose(&self, (x, y, heading): (f64, f64, f64)) -> Pose {
        let side = if self.mirrored { -1.0 } else { 1.0 };
        let frame = Pose::new(self.shift.0, self.shift.1, self.turn);
        Pose {
            position: frame.to_world(&Point::new(x, side * y)),
            heading: side * heading + self.turn,
        }
    }

    fn lanelet(&self, lanelet: &Lanelet) -> Lanelet {
        let moved = |bound: &Bound| Bound {
            points: bound
                .points
                .iter()
                .map(|p| self.pose((p.x, p.y, 0.0)).position)
                .collect(),
            ..bound.clone()
        };
        let (left, right) = (moved(&lanelet.left), moved(&lanelet.right));
        let swap = self.mirrored;
        Lanelet {
            left: if swap { right.clone() } else { left.clone() },
            right: if swap { left } else { right },
            ..lanelet.clone()
        }
    }
}

impl Stage {
    pub fn at(&self, stand: Stand) -> Scene {
        self.changed_after(stand, STEPS, |_, pose| Some(pose))
    }

    /// The scene with all motion after `last` replaced; the ego has id 0. Nothing ends a track.
    pub fn changed_after(
        &self,
        stand: Stand,
        last: i64,
        change: impl Fn(i64, Pose) -> Option<Pose>,
    ) -> Scene {
        let poses = |id: i64, motion: Motion| -> Vec<(i64, Pose)> {
            let at = |step: i64| {
                let pose = stand.pose(motion(step as f64 * DT));
                let pose = if step > last { change(id, pose)? } else { pose };
                Some((step, pose))
            };
            (0..STEPS).map_while(at).collect()
        };
        let obstacles = self.actors.iter().map(|actor| {
            let mut states: Vec<State> = poses(actor.id, actor.motion)
                .into_iter()
                .map(|(step, pose)| state(step, &pose, actor.motion))
                .collect();
            if actor.parked {
                states.truncate(1);
            }
            let initial = states.remove(0);
            let parts = ObstacleParts {
                id: actor.id,
                role: if actor.parked {
                    ObstacleRole::Static
                } else {
                    ObstacleRole::Dynamic
                },
                kind: actor.kind,
                footprint: Some(body(actor.size)),
                initial: Some(initial),
                prediction: Prediction::Trajectory(states),
                signals: Vec::new(),
            };
            Obstacle::new(parts, DT)
        });
        let lanelets = self.network.lanelets.iter().map(|l| stand.lanelet(l));
        let scenario = Scenario {
            header: Header {
                other_format: None,
                time_step_size: DT,
                ..Header::default()
            },
            location: None,
            tags: Vec::new(),
            network: LaneletNetwork::new(lanelets.collect(), vec![], vec![], vec![]),
            obstacles: obstacles.collect(),
            planning_problems: Vec::new(),
            diagnostics: Vec::new(),
            recorded_ego: None,
            hash: ContentHash::digest(b"built"),
        };
        let samples = poses(0, self.ego).into_iter().map(|(step, pose)| Sample {
            step,
            position: pose.position,
            heading: Some(pose.heading),
            velocity: Some(speed(step, self.ego)),
            acceleration: Some(0.0),
        });
        let ego = Ego {
            id: 0,
            source: EgoSource::Recording("built".into()),
            footprint: body((4.5, 1.8)),
            track: Track::new(samples.collect(), DT, None),
            recorded: Vec::new(),
            diagnostics: Vec::new(),
        };
        Scene::new(Arc::new(scenario), ego)
    }
}

fn body((length, width): (f64, f64)) -> Footprint {
    Footprint::new(Shape::rectangle(length, width)).unwrap()
}

fn speed(step: i64, motion: Motion) -> f64 {
    let at = |t: f64| {
        let (x, y, _) = motion(t);
        Vector::new(x, y)
    };
    let t = step as f64 * DT;
    ((at(t + 1e-3) - at(t - 1e-3)) / 2e-3).norm()
}

fn state(step: i64, pose: &Pose, motion: Motion) -> State {
    let mut state = State::at(Steps::exact(step));
    state.position = Some(Position::Point(pose.position));
    state.orientation = Some(Quantity::Exact(pose.heading));
    state.velocity = Some(Quantity::Exact(speed(step, motion)));
    state
}
