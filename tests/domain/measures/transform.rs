//! Moving whole scenes: map, obstacles, ego and plans turned, shifted, mirrored, and started at another time.

use std::sync::Arc;

use nearmiss::geometry::{Footprint, Point, Shape};
use nearmiss::scenario::*;

/// First mirrored at the x axis, if at all, then turned about the origin, then shifted.
#[derive(Debug, Clone, Copy)]
pub struct Move {
    pub mirror: bool,
    pub angle: f64,
    pub shift: (f64, f64),
    pub steps: i64,
}

impl Move {
    pub const NONE: Self = Self {
        mirror: false,
        angle: 0.0,
        shift: (0.0, 0.0),
        steps: 0,
    };

    fn point(&self, p: &Point) -> Point {
        let (x, y) = (p.x, self.side(p.y));
        let (sin, cos) = self.angle.sin_cos();
        Point::new(
            x * cos - y * sin + self.shift.0,
            x * sin + y * cos + self.shift.1,
        )
    }

    fn side(&self, value: f64) -> f64 {
        if self.mirror { -value } else { value }
    }

    fn heading(&self, heading: f64) -> f64 {
        self.side(heading) + self.angle
    }

    fn time(&self, steps: Steps) -> Steps {
        Steps {
            from: steps.from + self.steps,
            to: steps.to + self.steps,
        }
    }

    /// A shape in the frame of something that moves.
    fn body(&self, shape: &Shape) -> Shape {
        let point = |p: &Point| Point::new(p.x, self.side(p.y));
        match shape {
            Shape::Rectangle {
                length,
                width,
                center,
                orientation,
                origin_x_shift,
            } => Shape::Rectangle {
                length: *length,
                width: *width,
                center: point(center),
                orientation: self.side(*orientation),
                origin_x_shift: *origin_x_shift,
            },
            Shape::Circle { radius, center } => Shape::Circle {
                radius: *radius,
                center: point(center),
            },
            Shape::Polygon { vertices } => Shape::Polygon {
                vertices: vertices.iter().map(point).collect(),
            },
            Shape::Truck(truck) => Shape::Truck(*truck),
            Shape::SemiTrailerTruck {
                tractor,
                trailer,
                hitch_angle,
            } => Shape::SemiTrailerTruck {
                tractor: *tractor,
                trailer: *trailer,
                hitch_angle: self.side(*hitch_angle),
            },
            Shape::Group(members) => Shape::Group(members.iter().map(|m| self.body(m)).collect()),
        }
    }

    fn position(&self, position: &Position) -> Position {
        match position {
            Position::Point(p) => Position::Point(self.point(p)),
            Position::Lanelets(ids) => Position::Lanelets(ids.clone()),
            Position::Region(shape) => {
                let corners = shape.outlines().concat();
                Position::Region(Shape::Polygon {
                    vertices: corners.iter().map(|p| self.point(p)).collect(),
                })
            }
        }
    }

    fn angle(&self, quantity: Quantity) -> Quantity {
        match quantity {
            Quantity::Exact(angle) => Quantity::Exact(self.heading(angle)),
            Quantity::Interval(from, to) => {
                let (a, b) = (self.heading(from), self.heading(to));
                Quantity::Interval(a.min(b), a.max(b))
            }
        }
    }

    fn state(&self, state: &State) -> State {
        let mut moved = state.clone();
        moved.time = self.time(state.time);
        moved.position = state.position.as_ref().map(|p| self.position(p));
        moved.orientation = state.orientation.map(|q| self.angle(q));
        if let Some(vector) = state.point_mass_velocity() {
            // Its velocity is in the world's axes; as speed and heading it says the same.
            moved.velocity = Some(Quantity::Exact(vector.norm()));
            let heading = Quantity::Exact(self.heading(vector.y.atan2(vector.x)));
            moved.orientation = (vector.norm() > 1e-3).then_some(heading);
            moved
                .more
                .retain(|(field, _)| *field != StateField::VelocityY);
        }
        for (field, value) in &mut moved.more {
            if *field == StateField::HitchAngle {
                *value = Quantity::Exact(self.side(value.middle()));
            }
        }
        moved
    }

    fn obstacle(&self, obstacle: &Obstacle, dt: f64) -> Obstacle {
        let body = |f: &Footprint| Footprint::new(self.body(f.shape())).unwrap();
        let prediction = match &obstacle.prediction {
            Prediction::Trajectory(states) => {
                Prediction::Trajectory(states.iter().map(|s| self.state(s)).collect())
            }
            _ => Prediction::None,
        };
        let parts = ObstacleParts {
            id: obstacle.id,
            role: obstacle.role,
            kind: obstacle.kind,
            footprint: obstacle.footprint.as_ref().map(body),
            initial: obstacle.initial.as_ref().map(|s| self.state(s)),
            prediction,
            signals: Vec::new(),
        };
        Obstacle::new(parts, dt)
    }

    fn lanelet(&self, lanelet: &Lanelet) -> Lanelet {
        let mut moved = lanelet.clone();
        for bound in [&mut moved.left, &mut moved.right] {
            bound.points = bound.points.iter().map(|p| self.point(p)).collect();
        }
        moved.stop_line = None;
        if self.mirror {
            std::mem::swap(&mut moved.left, &mut moved.right);
            std::mem::swap(&mut moved.adjacent_left, &mut moved.adjacent_right);
        }
        moved
    }

    fn problem(&self, problem: &PlanningProblem) -> PlanningProblem {
        let goal = |goal: &Goal| Goal {
            time: self.time(goal.time),
            positions: goal.positions.iter().map(|p| self.position(p)).collect(),
            orientation: goal.orientation.map(|q| self.angle(q)),
            velocity: goal.velocity,
        };
        PlanningProblem {
            id: problem.id,
            initial: self.state(&problem.initial),
            goals: problem.goals.iter().map(goal).collect(),
        }
    }

    fn scenario(&self, scenario: &Scenario) -> Scenario {
        let mut moved = scenario.clone();
        let lanelets = scenario
            .network
            .lanelets
            .iter()
            .map(|l| self.lanelet(l))
            .collect();
        moved.network = LaneletNetwork::new(lanelets, Vec::new(), Vec::new(), Vec::new());
        let obstacles = scenario.obstacles.iter();
        moved.obstacles = obstacles.map(|o| self.obstacle(o, scenario.dt())).collect();
        let problems = scenario.planning_problems.iter();
        moved.planning_problems = problems.map(|p| self.problem(p)).collect();
        moved
    }

    /// The moved scene.
    pub fn scene(&self, scene: &Scene) -> Scene {
        let scenario = Arc::new(self.scenario(&scene.scenario));
        if let EgoSource::Obstacle(id) = scene.ego.source {
            return Scene::with_obstacle_as_ego(scenario, id).unwrap();
        }
        let sample = |(step, motion): (i64, &Motion)| Sample {
            step: step + self.steps,
            position: self.point(&motion.pose.position),
            heading: Some(self.heading(motion.pose.heading)),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        };
        let track = Track::new(
            scene.ego.track.iter().map(sample).collect(),
            scenario.dt(),
            None,
        );
        let ego = Ego {
            footprint: Footprint::new(self.body(scene.ego.footprint.shape())).unwrap(),
            track,
            ..scene.ego.clone()
        };
        Scene::new(scenario, ego)
    }
}
