//! Bodies that are no boxes, as a property beside the box around them: `circle RADIUS X Y`, `polygon X Y …`, or
//! `rectangle LENGTH WIDTH X Y ORIENTATION` for a box that is turned.

use nearmiss_base::geometry::{Point, Shape};
use nearmiss_scene::scenario::plausibility::limits::refused_coordinate;

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
