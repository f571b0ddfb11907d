//! Entities as OpenSCENARIO describes them: categories, boxes, axles.

use super::actor::Actor;
use crate::commonroad::WriteError;
use crate::commonroad::xml_writer::{XmlWriter, number};
use nearmiss_scene::scenario::ObstacleType;

/// The element of an entity and its category.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    /// A vehicle.
    Vehicle(&'static str),
    /// A pedestrian.
    Pedestrian,
    /// Anything else.
    Misc(&'static str),
}

/// The category of a kind of obstacle.
pub fn category(kind: ObstacleType) -> Category {
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
pub fn entity(out: &mut XmlWriter, actor: &Actor) -> Result<(), WriteError> {
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
