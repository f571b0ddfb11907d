//! Small networks for tests: lanelets around a centre line, joined and set side by side.

use std::f64::consts::PI;

use nearmiss::geometry::{Point, Polyline, Pose, Shape, Vector};
use nearmiss::scenario::{
    Adjacent, Bound, Goal, Lanelet, LaneletNetwork, LineMarking, PlanningProblem, Position,
    Quantity, RoadUser, State, Steps,
};

pub const WIDTH: f64 = 3.5;

/// A lanelet of the usual width around a line.
pub fn lanelet(id: i64, centre: &[(f64, f64)]) -> Lanelet {
    let points = centre.iter().map(|&(x, y)| Point::new(x, y));
    let line = Polyline::new(points).unwrap();
    let beside = |d: f64| {
        let at = |(p, s): (&Point, &f64)| {
            // At a corner the border follows the mean of both directions.
            let [a, b] = [s - 1e-6, s + 1e-6].map(|s| line.pose_at(s).forward());
            let along = (a + b).normalize();
            p + Vector::new(-along.y, along.x) * d
        };
        line.points()
            .iter()
            .zip(line.arc_lengths())
            .map(at)
            .collect()
    };
    between(id, beside(WIDTH / 2.0), beside(-WIDTH / 2.0))
}

/// A lanelet between two borders.
pub fn between(id: i64, left: Vec<Point>, right: Vec<Point>) -> Lanelet {
    let bound = |points: Vec<Point>| Bound {
        heights: Vec::new(),
        points,
        marking: LineMarking::Unknown,
    };
    Lanelet {
        id,
        left: bound(left),
        right: bound(right),
        predecessors: Vec::new(),
        successors: Vec::new(),
        adjacent_left: None,
        adjacent_right: None,
        stop_line: None,
        types: Vec::new(),
        users_one_way: Vec::new(),
        users_bidirectional: Vec::new(),
        signs: Vec::new(),
        lights: Vec::new(),
    }
}

/// Points of a circle around (x, y), by angle.
pub fn arc(x: f64, y: f64, radius: f64, from: f64, to: f64) -> Vec<(f64, f64)> {
    let angle = |i: i32| from + (to - from) * f64::from(i) / 24.0;
    (0..=24)
        .map(|i| (x + radius * angle(i).cos(), y + radius * angle(i).sin()))
        .collect()
}

pub fn network(
    mut lanelets: Vec<Lanelet>,
    on: &[(i64, i64)],
    beside: &[(i64, i64, bool)],
) -> LaneletNetwork {
    let place = |lanelets: &[Lanelet], id: i64| lanelets.iter().position(|l| l.id == id);
    for &(from, to) in on {
        if let Some(at) = place(&lanelets, from) {
            lanelets[at].successors.push(to);
        }
        if let Some(at) = place(&lanelets, to) {
            lanelets[at].predecessors.push(from);
        }
    }
    // (right, left, same direction)
    for &(right, left, same_direction) in beside {
        let at = place(&lanelets, right).unwrap();
        lanelets[at].adjacent_left = Some(Adjacent {
            id: left,
            same_direction,
        });
        if let Some(at) = place(&lanelets, left) {
            let back = Some(Adjacent {
                id: right,
                same_direction,
            });
            if same_direction {
                lanelets[at].adjacent_right = back;
            } else {
                lanelets[at].adjacent_left = back;
            }
        }
    }
    LaneletNetwork::new(lanelets, vec![], vec![], vec![])
}

pub fn bidirectional(mut lanelet: Lanelet) -> Lanelet {
    lanelet.users_bidirectional.push(RoadUser::Vehicle);
    lanelet
}

pub fn goal(positions: Vec<Position>) -> Goal {
    Goal {
        time: Steps { from: 0, to: 100 },
        positions,
        orientation: None,
        velocity: None,
    }
}

pub fn to_lanelet(id: i64) -> Goal {
    goal(vec![Position::Lanelets(vec![id])])
}

pub fn to_region(x: f64, y: f64) -> Goal {
    goal(vec![Position::Region(Shape::Rectangle {
        length: 4.0,
        width: 2.0,
        center: Point::new(x, y),
        orientation: 0.0,
        origin_x_shift: 0.0,
    })])
}

pub fn problem(start: Pose, goals: Vec<Goal>) -> PlanningProblem {
    let mut initial = State::at(Steps::exact(0));
    initial.position = Some(Position::Point(start.position));
    initial.orientation = Some(Quantity::Exact(start.heading));
    PlanningProblem {
        id: 1,
        initial,
        goals,
    }
}

/// Two lanes, 11 and 12 then 21 and 22, from x = 0 over 100 to 200; 12 and 22 on the left. Oncoming 31 beside 12.
pub fn two_lanes() -> LaneletNetwork {
    let lanelets = vec![
        lanelet(11, &[(0., 0.), (100., 0.)]),
        lanelet(12, &[(0., WIDTH), (100., WIDTH)]),
        lanelet(21, &[(100., 0.), (200., 0.)]),
        lanelet(22, &[(100., WIDTH), (200., WIDTH)]),
        lanelet(31, &[(100., 2. * WIDTH), (0., 2. * WIDTH)]),
    ];
    let beside = [(11, 12, true), (21, 22, true), (12, 31, false)];
    network(lanelets, &[(11, 21), (12, 22)], &beside)
}

/// A roundabout of four quarters, 1 to 4 from the east and counter-clockwise, with 9 leading in from the
/// south and 8 leading out to the north.
pub fn roundabout() -> LaneletNetwork {
    let quarter = |n: f64| arc(0.0, 0.0, 15.0, n * PI / 2.0, (n + 1.0) * PI / 2.0);
    let lanelets = vec![
        lanelet(1, &quarter(0.0)),
        lanelet(2, &quarter(1.0)),
        lanelet(3, &quarter(2.0)),
        lanelet(4, &quarter(3.0)),
        lanelet(9, &[(-40., -15.), (0., -15.)]),
        lanelet(8, &[(0., 15.), (-40., 15.)]),
    ];
    network(
        lanelets,
        &[(1, 2), (2, 3), (3, 4), (4, 1), (9, 4), (1, 8)],
        &[],
    )
}
