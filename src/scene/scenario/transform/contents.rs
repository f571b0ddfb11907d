//! The road, obstacles, plans and the ego after a change of the plane or of their ids.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::plane::Plane;
use crate::scenario::{
    Adjacent, Bound, Ego, EgoSource, Goal, Incoming, Intersection, Lanelet, LaneletNetwork,
    LineMarking, Motion, Obstacle, ObstacleParts, Occupancy, PlanningProblem, Prediction, Quantity,
    Sample, Scenario, Scene, Sign, SignElement, Signal, SignalState, State, StopLine, Track,
    TrafficDirection, TrafficLight,
};

impl Plane {
    pub(super) fn obstacle(&self, obstacle: &Obstacle, dt: f64) -> Obstacle {
        let prediction = match &obstacle.prediction {
            Prediction::None => Prediction::None,
            Prediction::Trajectory(states) => {
                Prediction::Trajectory(states.iter().map(|s| self.state(s)).collect())
            }
            Prediction::Occupancies(all) => {
                let placed = |one: &Occupancy| Occupancy {
                    time: one.time,
                    region: self.region(&one.region),
                };
                Prediction::Occupancies(all.iter().map(placed).collect())
            }
        };
        let mut initial = obstacle.initial.as_ref().map(|s| self.state(s));
        if let Some(state) = &mut initial
            && self.angle != 0.0
            && points_nowhere(obstacle)
        {
            // It was drawn along the x axis for want of a heading, and turns with the rest.
            state.orientation = Some(Quantity::Exact(self.heading(0.0)));
        }
        let footprint = obstacle.footprint.as_ref();
        let parts = ObstacleParts {
            id: obstacle.id,
            role: obstacle.role,
            kind: obstacle.kind,
            // Without a state the shape says where in the world it is.
            footprint: match obstacle.initial {
                Some(_) => footprint.map(|f| self.footprint(f)),
                None => footprint.map(|f| self.standing(f)),
            },
            initial,
            prediction,
            signals: obstacle.signals.iter().map(|s| self.signals(s)).collect(),
        };
        Obstacle::new(parts, dt)
    }

    fn signals(&self, state: &SignalState) -> SignalState {
        let mut placed = state.clone();
        if self.mirrored {
            for (signal, _) in &mut placed.signals {
                *signal = match *signal {
                    Signal::IndicatorLeft => Signal::IndicatorRight,
                    Signal::IndicatorRight => Signal::IndicatorLeft,
                    other => other,
                };
            }
        }
        placed
    }

    pub(super) fn problem(&self, problem: &PlanningProblem) -> PlanningProblem {
        let goal = |goal: &Goal| Goal {
            time: goal.time,
            positions: goal.positions.iter().map(|p| self.position(p)).collect(),
            orientation: goal.orientation.map(|q| self.heading_of(q)),
            velocity: goal.velocity,
        };
        PlanningProblem {
            id: problem.id,
            initial: self.state(&problem.initial),
            goals: problem.goals.iter().map(goal).collect(),
        }
    }

    pub(super) fn ego(&self, ego: &Ego, dt: f64) -> Ego {
        let moved = |(step, motion): (i64, &Motion)| Sample {
            step,
            position: self.point(&motion.pose.position),
            heading: Some(self.heading(motion.pose.heading)),
            velocity: Some(motion.velocity),
            acceleration: Some(motion.acceleration),
        };
        let mut track = Track::new(ego.track.iter().map(moved).collect(), dt, None);
        // What was filled was filled before.
        track.derived = ego.track.derived;
        let recorded = |sample: &Sample| Sample {
            position: self.point(&sample.position),
            heading: sample.heading.map(|h| self.heading(h)),
            ..*sample
        };
        Ego {
            footprint: self.footprint(&ego.footprint),
            track,
            recorded: ego.recorded.iter().map(recorded).collect(),
            ..ego.clone()
        }
    }
}

/// Whether nothing says which way an obstacle points, not even its motion.
fn points_nowhere(obstacle: &Obstacle) -> bool {
    let says = |s: &State| s.orientation.is_some() || s.point_mass_velocity().is_some();
    !obstacle.states().any(says) && obstacle.track().iter().all(|(_, m)| m.pose.heading == 0.0)
}

impl Plane {
    pub(super) fn network(&self, network: &LaneletNetwork) -> LaneletNetwork {
        let mut placed = LaneletNetwork::new(
            network.lanelets.iter().map(|l| self.lanelet(l)).collect(),
            network.signs.iter().map(|s| self.sign(s)).collect(),
            network.lights.iter().map(|l| self.light(l)).collect(),
            if self.mirrored {
                network.intersections.iter().map(mirrored).collect()
            } else {
                network.intersections.clone()
            },
        );
        let ring = |ring: &Vec<_>| ring.iter().map(|p| self.point(p)).collect();
        placed.areas = network.areas.iter().map(ring).collect();
        placed
    }

    fn lanelet(&self, lanelet: &Lanelet) -> Lanelet {
        let (left, right) = self.sides(self.bound(&lanelet.left), self.bound(&lanelet.right));
        let (before_left, before_right) = (lanelet.adjacent_left, lanelet.adjacent_right);
        let (adjacent_left, adjacent_right): (Option<Adjacent>, Option<Adjacent>) =
            self.sides(before_left, before_right);
        Lanelet {
            left,
            right,
            adjacent_left,
            adjacent_right,
            stop_line: lanelet.stop_line.as_ref().map(|line| self.stop_line(line)),
            ..lanelet.clone()
        }
    }

    fn sides<T>(&self, left: T, right: T) -> (T, T) {
        if self.mirrored {
            (right, left)
        } else {
            (left, right)
        }
    }

    fn bound(&self, bound: &Bound) -> Bound {
        Bound {
            points: bound.points.iter().map(|p| self.point(p)).collect(),
            heights: bound.heights.clone(),
            marking: self.marking(bound.marking),
        }
    }

    /// Of double lines the left one is named first.
    fn marking(&self, marking: LineMarking) -> LineMarking {
        match marking {
            LineMarking::SolidDashed if self.mirrored => LineMarking::DashedSolid,
            LineMarking::DashedSolid if self.mirrored => LineMarking::SolidDashed,
            other => other,
        }
    }

    /// Its ends stay in their order, from the left to the right.
    fn stop_line(&self, line: &StopLine) -> StopLine {
        let ends = |(a, b)| self.sides(self.point(&a), self.point(&b));
        StopLine {
            points: line.points.map(ends),
            marking: self.marking(line.marking),
            ..line.clone()
        }
    }

    fn sign(&self, sign: &Sign) -> Sign {
        let mut placed = sign.clone();
        placed.position = sign.position.map(|p| self.point(&p));
        if self.mirrored {
            placed.elements.iter_mut().for_each(mirror_element);
        }
        placed
    }

    fn light(&self, light: &TrafficLight) -> TrafficLight {
        use TrafficDirection as D;
        let direction = |direction| match direction {
            D::Right => D::Left,
            D::Left => D::Right,
            D::LeftStraight => D::StraightRight,
            D::StraightRight => D::LeftStraight,
            D::Straight | D::LeftRight | D::All => direction,
        };
        TrafficLight {
            position: light.position.map(|p| self.point(&p)),
            direction: if self.mirrored {
                light.direction.map(direction)
            } else {
                light.direction
            },
            ..light.clone()
        }
    }
}

/// Signs that tell left from right by their number: to the left, to the right.
const SIDED: &[(&str, &str)] = &[
    ("103-10", "103-20"),
    ("209-10", "209-20"),
    ("211-10", "211-20"),
    ("220-10", "220-20"),
    ("222-10", "222-20"),
    ("R3-5L", "R3-5R"),
    ("R6-1L", "R6-1R"),
];

fn mirror_element(element: &mut SignElement) {
    let id = element.id.as_str();
    let image = SIDED.iter().find_map(|(left, right)| match id {
        _ if id == *left => Some(*right),
        _ if id == *right => Some(*left),
        _ => None,
    });
    if let Some(image) = image {
        element.id = image.to_string();
    }
}

/// Left and right turns are swapped, and so are neighbours on the left and right.
fn mirrored(crossing: &Intersection) -> Intersection {
    let has_on_its_left = |id: i64| {
        let mut all = crossing.incomings.iter();
        all.find(|other| other.is_left_of == Some(id)).map(|o| o.id)
    };
    let incoming = |incoming: &Incoming| Incoming {
        right: incoming.left.clone(),
        left: incoming.right.clone(),
        is_left_of: has_on_its_left(incoming.id),
        ..incoming.clone()
    };
    Intersection {
        incomings: crossing.incomings.iter().map(incoming).collect(),
        ..crossing.clone()
    }
}

/// From new ids to old ones. Several obstacles pass theirs round in one cycle, so that none keeps its own (Sattolo,
/// *An algorithm to generate a random cyclic permutation*, Information Processing Letters 22, 1986); one alone gets
/// an id that nothing in the scenario has.
pub(super) fn ids(scenario: &Scenario, seed: u64) -> BTreeMap<i64, i64> {
    let mut old: Vec<i64> = scenario.obstacles.iter().map(|o| o.id).collect();
    old.sort_unstable();
    old.dedup();
    if let [only] = old[..] {
        return BTreeMap::from([(free(scenario, seed), only)]);
    }
    let mut new = old.clone();
    let mut random = Random(seed);
    for last in (1..new.len()).rev() {
        new.swap(last, random.below(last));
    }
    new.into_iter().zip(old).collect()
}

/// An id above all others, at most 1000 above.
fn free(scenario: &Scenario, seed: u64) -> i64 {
    let network = &scenario.network;
    let crossings = network.intersections.iter();
    let highest = scenario
        .obstacles
        .iter()
        .map(|o| o.id)
        .chain(scenario.planning_problems.iter().map(|p| p.id))
        .chain(network.lanelets.iter().map(|l| l.id))
        .chain(network.signs.iter().map(|s| s.id))
        .chain(network.lights.iter().map(|l| l.id))
        .chain(crossings.flat_map(|c| c.incomings.iter().map(|i| i.id).chain([c.id])))
        .max();
    let above = 1 + Random(seed).below(1000) as i64;
    highest.unwrap_or(0).saturating_add(above)
}

/// The scene with new ids, by a map from new to old.
pub(super) fn renumbered(scene: &Scene, ids: &BTreeMap<i64, i64>) -> Scene {
    let new: BTreeMap<i64, i64> = ids.iter().map(|(new, old)| (*old, *new)).collect();
    let new = |id: i64| new.get(&id).copied().unwrap_or(id);
    let dt = scene.scenario.dt();
    let obstacle = |o: &Obstacle| {
        let parts = ObstacleParts {
            id: new(o.id),
            ..o.parts()
        };
        Obstacle::new(parts, dt)
    };
    let mut scenario = (*scene.scenario).clone();
    scenario.obstacles = scene.scenario.obstacles.iter().map(obstacle).collect();
    let mut ego = scene.ego.clone();
    if let EgoSource::Obstacle(id) = ego.source {
        ego.id = new(id);
        ego.source = EgoSource::Obstacle(new(id));
    }
    Scene::new(Arc::new(scenario), ego)
}

/// Numbers that look random and are the same everywhere: SplitMix64 (Steele, Lea and Flood, *Fast splittable
/// pseudorandom number generators*, OOPSLA 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end.max(1) as u64) as usize
    }
}
