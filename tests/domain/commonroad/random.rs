//! Random scenarios with everything that the format can hold, in the form that reading gives.

use std::collections::BTreeMap;

use nearmiss::geometry::{Footprint, Point, SemiTrailer, Shape, Truck};
use nearmiss::scenario::*;
use proptest::collection::vec;
use proptest::option;
use proptest::prelude::*;
use proptest::sample::select;

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        -1e6..1e6,
        -1.0..1.0,
        select(vec![0.0, 1e-17, -2.4e7, 5e-324, 0.1 + 0.2]),
    ]
}

fn size() -> impl Strategy<Value = f64> {
    0.01..50.0
}

fn point() -> impl Strategy<Value = Point> {
    (number(), number()).prop_map(|(x, y)| Point::new(x, y))
}

fn ids() -> impl Strategy<Value = Vec<i64>> {
    vec(1_i64..1000, 0..3)
}

fn text() -> impl Strategy<Value = String> {
    "[a-zA-Z0-9<>&\"'ü§€]{1,12}( [a-z&]{1,8})?"
}

fn one_of<T: Copy + std::fmt::Debug + 'static>(all: &'static [T]) -> impl Strategy<Value = T> {
    select(all)
}

fn truck() -> impl Strategy<Value = Truck> {
    (size(), size(), size(), size(), size(), number(), number()).prop_map(
        |(length, width, wheelbase, rear, cabin, hitch, shift)| Truck {
            length,
            width,
            wheelbase,
            rear_to_rear_axle: rear,
            cabin_length: cabin,
            rear_axle_to_hitch: hitch,
            origin_x_shift: shift,
        },
    )
}

fn simple_shape() -> BoxedStrategy<Shape> {
    prop_oneof![
        (size(), size(), point(), number(), number()).prop_map(
            |(length, width, center, orientation, origin_x_shift)| Shape::Rectangle {
                length,
                width,
                center,
                orientation,
                origin_x_shift,
            }
        ),
        (size(), point()).prop_map(|(radius, center)| Shape::Circle { radius, center }),
        // Near enough for its corners to stay apart.
        (-1e5..1e5, -1e5..1e5, size(), size()).prop_map(|(x, y, w, h)| Shape::Polygon {
            vertices: [(0.0, 0.0), (w, 0.0), (w / 2.0, h)]
                .map(|(dx, dy)| Point::new(x + dx, y + dy))
                .to_vec(),
        }),
    ]
    .boxed()
}

/// Shapes as obstacles have them; regions have no trucks.
fn body() -> BoxedStrategy<Shape> {
    prop_oneof![
        4 => simple_shape(),
        1 => truck().prop_map(Shape::Truck),
        1 => (truck(), size(), size(), size(), size()).prop_map(
            |(tractor, length, width, wheelbase, front_to_hitch)| Shape::SemiTrailerTruck {
                tractor,
                trailer: SemiTrailer { length, width, wheelbase, front_to_hitch },
                hitch_angle: 0.0,
            }
        ),
        1 => vec(simple_shape(), 2..4).prop_map(Shape::Group),
    ]
    .boxed()
}

fn region() -> BoxedStrategy<Shape> {
    prop_oneof![
        3 => simple_shape(),
        1 => vec(simple_shape(), 2..4).prop_map(Shape::Group),
    ]
    .boxed()
}

fn quantity() -> impl Strategy<Value = Quantity> {
    prop_oneof![
        number().prop_map(Quantity::Exact),
        (number(), size()).prop_map(|(from, wide)| Quantity::Interval(from, from + wide)),
    ]
}

fn steps(first: i64) -> impl Strategy<Value = Steps> {
    (first..first + 50, 0_i64..9).prop_map(|(from, more)| Steps {
        from,
        to: from + more,
    })
}

fn position() -> BoxedStrategy<Position> {
    prop_oneof![
        4 => point().prop_map(Position::Point),
        1 => region().prop_map(Position::Region),
        1 => vec(1_i64..1000, 1..3).prop_map(Position::Lanelets),
    ]
    .boxed()
}

prop_compose! {
    fn state(time: Steps)(
        position in option::of(position()),
        orientation in option::of(quantity()),
        velocity in option::of(quantity()),
        acceleration in option::of(quantity()),
        more in vec((one_of(&StateField::ALL[3..]), quantity()), 0..4),
    ) -> State {
        let mut kept: BTreeMap<StateField, Quantity> = BTreeMap::new();
        kept.extend(more);
        State {
            time, position, orientation, velocity, acceleration,
            more: kept.into_iter().collect(),
        }
    }
}

prop_compose! {
    fn bound()(
        points in vec(point(), 2..6), height in option::of(number()),
        marking in one_of(&LineMarking::ALL),
    ) -> Bound {
        let heights = height.map(|h| vec![h; points.len()]).unwrap_or_default();
        Bound { points, heights, marking }
    }
}

fn adjacent() -> impl Strategy<Value = Option<Adjacent>> {
    let one = (1_i64..1000, any::<bool>());
    option::of(one.prop_map(|(id, same_direction)| Adjacent { id, same_direction }))
}

prop_compose! {
    fn stop_line()(
        points in option::of((point(), point())), marking in one_of(&LineMarking::ALL),
        signs in ids(), lights in ids(),
    ) -> StopLine {
        StopLine { points, marking, signs, lights }
    }
}

prop_compose! {
    fn lanelet(id: i64)(
        bounds in (bound().boxed(), bound().boxed()), ends in (ids(), ids()), sides in (adjacent(), adjacent()),
        stop_line in option::of(stop_line().boxed()), types in vec(one_of(&LaneletType::ALL), 0..3),
        users in (vec(one_of(&RoadUser::ALL), 0..3), vec(one_of(&RoadUser::ALL), 0..3)),
        references in (ids(), ids()),
    ) -> Lanelet {
        Lanelet {
            id, left: bounds.0, right: bounds.1, predecessors: ends.0, successors: ends.1,
            adjacent_left: sides.0, adjacent_right: sides.1, stop_line, types,
            users_one_way: users.0, users_bidirectional: users.1,
            signs: references.0, lights: references.1,
        }
    }
}

prop_compose! {
    fn sign(id: i64)(
        elements in vec((text(), vec(text(), 0..2)), 0..3), position in option::of(point()),
        is_virtual in any::<bool>(),
    ) -> Sign {
        let elements = elements.into_iter().map(|(id, values)| SignElement { id, values });
        Sign { id, elements: elements.collect(), position, is_virtual }
    }
}

prop_compose! {
    fn light(id: i64)(
        cycle in vec((1_i64..99, one_of(&SignalColor::ALL)), 0..4), offset in 0_i64..9,
        position in option::of(point()), direction in option::of(one_of(&TrafficDirection::ALL)),
        active in any::<bool>(),
    ) -> TrafficLight {
        let phase = |(duration, color)| LightPhase { duration, color };
        TrafficLight {
            id, cycle: cycle.into_iter().map(phase).collect(), offset, position, direction, active,
        }
    }
}

prop_compose! {
    fn intersection(id: i64)(
        roads in vec((ids(), ids(), ids(), ids(), option::of(1_i64..99)), 0..3), crossings in ids(),
    ) -> Intersection {
        let road = |(place, (lanelets, right, straight, left, is_left_of))| Incoming {
            id: id + 1 + place as i64, lanelets, right, straight, left, is_left_of,
        };
        Intersection { id, incomings: roads.into_iter().enumerate().map(road).collect(), crossings }
    }
}

fn signal_states() -> impl Strategy<Value = Vec<SignalState>> {
    let on = |signals: Vec<(Signal, bool)>| signals.into_iter().collect::<BTreeMap<_, _>>();
    let signals = vec((one_of(&Signal::ALL), any::<bool>()), 0..4).prop_map(on);
    let one = (steps(0), signals).prop_map(|(time, signals)| SignalState {
        time,
        signals: signals.into_iter().collect(),
    });
    vec(one, 0..3)
}

fn prediction() -> BoxedStrategy<Prediction> {
    let state = steps(1).prop_flat_map(|time| state(time).boxed());
    let occupancy = (steps(1), region()).prop_map(|(time, region)| Occupancy { time, region });
    prop_oneof![
        Just(Prediction::None),
        vec(state, 1..5).prop_map(Prediction::Trajectory),
        vec(occupancy, 1..4).prop_map(Prediction::Occupancies),
    ]
    .boxed()
}

prop_compose! {
    fn obstacle(id: i64)(
        role in one_of(&ObstacleRole::ALL), kind in one_of(&ObstacleType::ALL),
        shape in option::of(body()), initial in option::of(state(Steps::exact(0)).boxed()),
        prediction in prediction(), signals in signal_states(),
    ) -> Obstacle {
        // The kind of a phantom is nowhere in the file.
        let kind = if role == ObstacleRole::Phantom { ObstacleType::Unknown } else { kind };
        let footprint = shape.and_then(|shape| Footprint::new(shape).ok());
        Obstacle::new(
            ObstacleParts { id, role, kind, footprint, initial, prediction, signals },
            0.1,
        )
    }
}

prop_compose! {
    fn problem(id: i64)(
        initial in state(Steps::exact(0)).boxed(),
        goals in vec((
            steps(1), vec(position(), 0..3), option::of(quantity()), option::of(quantity()),
        ), 0..3),
    ) -> PlanningProblem {
        let goal = |(time, positions, orientation, velocity)| Goal {
            time, positions, orientation, velocity,
        };
        PlanningProblem { id, initial, goals: goals.into_iter().map(goal).collect() }
    }
}

prop_compose! {
    fn location()(
        geo_name_id in option::of(0_i64..9_999_999), latitude in option::of(-90.0..90.0),
        longitude in option::of(-180.0..180.0), reference in option::of(text()),
        numbers in option::of((number(), number(), number(), number())),
        words in option::of((text(), option::of(text()))),
    ) -> Location {
        let transformation = numbers.map(|(x, y, rotation, scaling)| GeoTransformation {
            reference, x: Some(x), y: Some(y), rotation: Some(rotation), scaling: Some(scaling),
        });
        let environment = words.map(|(weather, time)| Environment {
            time, weather: Some(weather), ..Environment::default()
        });
        Location { geo_name_id, latitude, longitude, transformation, environment }
    }
}

/// Boxed, as the strategies nest too deep for the stack of a test otherwise.
fn each<T: std::fmt::Debug + 'static, S: Strategy<Value = T> + 'static>(
    base: i64,
    most: usize,
    one: fn(i64) -> S,
) -> BoxedStrategy<Vec<T>> {
    (0..most)
        .prop_flat_map(move |count| {
            (0..count)
                .map(|i| one(base + 10 * i as i64).boxed())
                .collect::<Vec<_>>()
        })
        .boxed()
}

prop_compose! {
    /// Any scenario.
    pub fn scenario()(
        name in text(), attributes in (text(), text()), location in option::of(location().boxed()),
        tags in vec("[a-z_]{1,12}", 0..4),
        lanelets in each(100, 4, lanelet), signs in each(200, 3, sign),
        lights in each(300, 3, light), intersections in each(400, 3, intersection),
        obstacles in each(500, 5, obstacle), planning_problems in each(600, 3, problem),
    ) -> Scenario {
        let attributes = [("author", attributes.0), ("source", attributes.1)];
        Scenario {
            header: Header {
                other_format: None,
                benchmark_id: name,
                version: "2020a".into(),
                time_step_size: 0.1,
                attributes: attributes.map(|(name, text)| (name.to_string(), text)).into(),
            },
            location,
            tags,
            network: LaneletNetwork::new(lanelets, signs, lights, intersections),
            obstacles,
            planning_problems,
            diagnostics: Vec::new(),
            recorded_ego: None,
            hash: ContentHash::digest(b""),
        }
    }
}
