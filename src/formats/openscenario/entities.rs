//! Entities as OpenSCENARIO describes them: categories, boxes, axles, and bodies that are no boxes.

use nearmiss_base::geometry::{Point, Shape};
use nearmiss_scene::scenario::ObstacleType;
use nearmiss_scene::scenario::plausibility::refused_coordinate;

use super::actor::Actor;
use crate::commonroad::WriteError;
use crate::commonroad::writer::{XmlWriter, number};

/// The element of an entity and its category.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Category {
    /// A vehicle.
    Vehicle(&'static str),
    /// A pedestrian.
    Pedestrian,
    /// Anything else.
    Misc(&'static str),
}

/// The category of a kind of obstacle.
pub(super) fn category(kind: ObstacleType) -> Category {
    match kind {
        ObstacleType::Car
        | ObstacleType::Taxi
        | ObstacleType::PriorityVehicle
        | ObstacleType::ParkedVehicle => Category::Vehicle("car"),
        ObstacleType::Truck => Category::Vehicle("truck"),
        ObstacleType::Bus => Category::Vehicle("bus"),
        ObstacleType::Bicycle => Category::Vehicle("bicycle"),
        ObstacleType::Motorcycle => Category::Vehicle("motorbike"),
        ObstacleType::Train => Category::Vehicle("train"),
        ObstacleType::Pedestrian => Category::Pedestrian,
        ObstacleType::ConstructionZone => Category::Misc("obstacle"),
        ObstacleType::RoadBoundary => Category::Misc("barrier"),
        ObstacleType::Building => Category::Misc("building"),
        ObstacleType::Pillar => Category::Misc("pole"),
        ObstacleType::MedianStrip => Category::Misc("trafficIsland"),
        ObstacleType::Unknown => Category::Misc("none"),
    }
}

/// Usual heights, metres: files of CommonRoad have none.
fn height(kind: ObstacleType) -> f64 {
    match kind {
        ObstacleType::Truck | ObstacleType::Bus | ObstacleType::Train => 3.5,
        ObstacleType::Pedestrian | ObstacleType::Bicycle | ObstacleType::Motorcycle => 1.8,
        ObstacleType::Building | ObstacleType::Pillar => 4.0,
        _ => 1.5,
    }
}

/// The most of speed (m/s), acceleration and deceleration (m/s²) that players are told of.
const PERFORMANCE: [(&str, f64); 3] = [
    ("maxSpeed", 70.0),
    ("maxAcceleration", 12.0),
    ("maxDeceleration", 12.0),
];

/// One entity.
pub(super) fn entity(out: &mut XmlWriter, actor: &Actor) -> Result<(), WriteError> {
    let name = [("name", actor.name.clone())];
    out.element("ScenarioObject", &name, |out| {
        let word = |word: &str| ("name", format!("{word} {}", actor.kind.name()));
        // No picture is meant: an empty name keeps players from looking for one of their own.
        let model = ("model3d", String::new());
        match category(actor.kind) {
            Category::Vehicle(category) => {
                let mut attributes =
                    vec![word("vehicle"), ("vehicleCategory", category.into()), model];
                if actor.kind == ObstacleType::PriorityVehicle {
                    attributes.push(("role", "police".into()));
                }
                out.element("Vehicle", &attributes, |out| {
                    bounding_box(out, actor)?;
                    let performance = PERFORMANCE.map(|(name, most)| (name, number(most)));
                    out.empty("Performance", &performance)?;
                    axles(out, actor)?;
                    properties(out, actor)
                })
            }
            Category::Pedestrian => {
                let attributes = [
                    word("person"),
                    ("mass", "80.0".into()),
                    ("pedestrianCategory", "pedestrian".into()),
                    model,
                ];
                out.element("Pedestrian", &attributes, |out| {
                    bounding_box(out, actor)?;
                    properties(out, actor)
                })
            }
            Category::Misc(category) => {
                let attributes = [
                    word("object"),
                    ("mass", "500.0".into()),
                    ("miscObjectCategory", category.into()),
                    model,
                ];
                out.element("MiscObject", &attributes, |out| {
                    bounding_box(out, actor)?;
                    properties(out, actor)
                })
            }
        }
    })
}

fn bounding_box(out: &mut XmlWriter, actor: &Actor) -> Result<(), WriteError> {
    let height = height(actor.kind);
    let body = actor.body;
    let center = [
        ("x", number(body.center.x)),
        ("y", number(body.center.y)),
        ("z", number(height / 2.0)),
    ];
    let dimensions = [
        ("length", number(body.length)),
        ("width", number(body.width)),
        ("height", number(height)),
    ];
    out.element("BoundingBox", &[], |out| {
        out.empty("Center", &center)?;
        out.empty("Dimensions", &dimensions)
    })
}

/// Axles. The rear axle is told to be at the entity's position, which is the middle of its body: players that take the
/// position for that of the rear axle would move the body otherwise.
fn axles(out: &mut XmlWriter, actor: &Actor) -> Result<(), WriteError> {
    let axle = |x: f64, steering: f64| {
        [
            ("maxSteering", number(steering)),
            ("wheelDiameter", "0.6".into()),
            ("trackWidth", number(actor.body.width)),
            ("positionX", number(x)),
            ("positionZ", "0.3".into()),
        ]
    };
    out.element("Axles", &[], |out| {
        out.empty("FrontAxle", &axle(0.6 * actor.body.length, 0.6))?;
        out.empty("RearAxle", &axle(0.0, 0.0))
    })
}

fn properties(out: &mut XmlWriter, actor: &Actor) -> Result<(), WriteError> {
    out.element("Properties", &[], |out| {
        // Between two vertices the heading changes evenly, also in players that would turn at corners.
        let own = [("plineInterpolation".to_string(), "segment".to_string())];
        own.iter()
            .chain(&actor.properties)
            .try_for_each(|(name, value)| {
                out.empty(
                    "Property",
                    &[("name", name.clone()), ("value", value.clone())],
                )
            })
    })
}

/// The property.
pub const BODY: &str = "commonroad_body";

/// A shape in words; nothing for those that have no words: trucks with trailers, and groups.
pub fn written(shape: &Shape) -> Option<String> {
    let numbers = |word: &str, all: &[f64]| {
        let all: Vec<String> = all.iter().map(f64::to_string).collect();
        format!("{word} {}", all.join(" "))
    };
    Some(match shape {
        Shape::Circle { radius, center } => numbers("circle", &[*radius, center.x, center.y]),
        Shape::Polygon { vertices } => {
            let all: Vec<f64> = vertices.iter().flat_map(|p| [p.x, p.y]).collect();
            numbers("polygon", &all)
        }
        Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift: 0.0,
        } => numbers(
            "rectangle",
            &[*length, *width, center.x, center.y, *orientation],
        ),
        _ => return None,
    })
}

/// The shape that words tell; nothing where they tell none.
pub fn read(text: &str) -> Option<Shape> {
    let mut words = text.split_whitespace();
    let kind = words.next()?;
    let number = |word: &str| {
        let value = word.parse::<f64>().ok().filter(|v| v.is_finite());
        value.filter(|v| refused_coordinate(*v).is_none())
    };
    let numbers: Vec<f64> = words.map(number).collect::<Option<_>>()?;
    match (kind, &numbers[..]) {
        ("circle", [radius, x, y]) => Some(Shape::Circle {
            radius: *radius,
            center: Point::new(*x, *y),
        }),
        ("polygon", all) if all.len() % 2 == 0 => Some(Shape::Polygon {
            vertices: all.chunks(2).map(|p| Point::new(p[0], p[1])).collect(),
        }),
        ("rectangle", [length, width, x, y, orientation]) => Some(Shape::Rectangle {
            length: *length,
            width: *width,
            center: Point::new(*x, *y),
            orientation: *orientation,
            origin_x_shift: 0.0,
        }),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_is_read_as_it_was_written() {
        let shapes = [
            Shape::Circle {
                radius: 0.3,
                center: Point::new(0.1, -1.0 / 3.0),
            },
            Shape::Polygon {
                vertices: [(0.0, 0.0), (1.5, 0.2), (1.0, 2.0)]
                    .map(|(x, y)| Point::new(x, y))
                    .to_vec(),
            },
            Shape::Rectangle {
                length: 4.0,
                width: 2.0,
                center: Point::new(1.0, 0.0),
                orientation: 0.4,
                origin_x_shift: 0.0,
            },
        ];
        for shape in shapes {
            assert_eq!(read(&written(&shape).unwrap_or_default()), Some(shape));
        }
        assert_eq!(written(&Shape::Group(Vec::new())), None);
        for text in [
            "",
            "circle 1",
            "circle 1 2 nan",
            "polygon 1 2 3",
            "sphere 1",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}
