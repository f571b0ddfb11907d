//! Points and shapes as JSON.

use serde_json::{Value, json};

use super::document::all;
use crate::geometry::{Point, Shape, Truck};

pub fn point(p: &Point) -> [f64; 2] {
    [p.x, p.y]
}

pub fn points(points: &[Point]) -> Vec<[f64; 2]> {
    points.iter().map(point).collect()
}

pub fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Rectangle {
            length,
            width,
            center,
            orientation,
            origin_x_shift,
        } => json!({
            "kind": "rectangle", "length": length, "width": width,
            "center": point(center), "orientation": orientation, "origin_x_shift": origin_x_shift,
        }),
        Shape::Truck(t) => truck(t),
        Shape::SemiTrailerTruck {
            tractor,
            trailer,
            hitch_angle,
        } => json!({
            "kind": "semi_trailer_truck", "tractor": truck(tractor), "hitch_angle": hitch_angle,
            "trailer": {
                "length": trailer.length, "width": trailer.width, "wheelbase": trailer.wheelbase,
                "front_to_hitch": trailer.front_to_hitch,
            },
        }),
        Shape::Circle { radius, center } => {
            json!({ "kind": "circle", "radius": radius, "center": point(center) })
        }
        Shape::Polygon { vertices } => json!({ "kind": "polygon", "vertices": points(vertices) }),
        Shape::Group(members) => {
            json!({ "kind": "group", "shapes": all(members, self::shape) })
        }
    }
}

fn truck(truck: &Truck) -> Value {
    json!({
        "kind": "truck", "length": truck.length, "width": truck.width, "wheelbase": truck.wheelbase,
        "rear_to_rear_axle": truck.rear_to_rear_axle, "cabin_length": truck.cabin_length,
        "rear_axle_to_hitch": truck.rear_axle_to_hitch, "origin_x_shift": truck.origin_x_shift,
    })
}
