//! Small pieces that many elements share: points, shapes, references, truth values.

use super::error::ReadError;
use super::xml::{Element, Xml, short};
use crate::geometry::{Footprint, Point, Shape};
use crate::scenario::Severity;

/// Shape groups inside shape groups, deeper than any file needs.
const DEEPEST_GROUP: usize = 4;

/// `<point>` with x and y, and z if it is there.
pub(super) fn point<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<(Point, Option<f64>), ReadError> {
    let (mut x, mut y, mut z) = (None, None, None);
    while let Some(child) = xml.next()? {
        match child.name {
            "x" => x = Some(xml.number(child)?),
            "y" => y = Some(xml.number(child)?),
            "z" => z = Some(xml.number(child)?),
            _ => xml.skip_unknown(child)?,
        }
    }
    match (x, y) {
        (Some(x), Some(y)) => Ok((Point::new(x, y), z)),
        _ => Err(xml.fail_in(element, "a point needs <x> and <y>".into())),
    }
}

/// The `ref` attribute of an element without content.
pub(super) fn reference<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<i64, ReadError> {
    let id = xml.id_attribute(element, "ref")?;
    xml.skip()?;
    xml.refer(element, id);
    Ok(id)
}

/// Appends a reference; one that cannot be read is left out with a diagnostic.
pub(super) fn push_reference<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    into: &mut Vec<i64>,
) -> Result<(), ReadError> {
    into.push(reference(xml, element)?);
    Ok(())
}

/// A word of a known vocabulary; another word gives `fallback` and a diagnostic.
pub(super) fn word<'a, T: Copy + std::fmt::Display>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    parse: fn(&str) -> Option<T>,
    fallback: T,
) -> Result<T, ReadError> {
    let text = xml.text()?;
    if let Some(value) = parse(&text) {
        return Ok(value);
    }
    xml.note(
        Severity::Warning,
        element,
        format!(
            "`{}` is not a known <{}>; taken as {fallback}",
            short(&text),
            element.name
        ),
    );
    Ok(fallback)
}

/// `true` or `false`, in any case, or 1 or 0.
pub(super) fn truth<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
    fallback: bool,
) -> Result<bool, ReadError> {
    let text = xml.text()?;
    match text.to_ascii_lowercase().as_str() {
        "true" | "1" => Ok(true),
        "false" | "0" => Ok(false),
        _ => {
            xml.note(
                Severity::Warning,
                element,
                format!(
                    "`{}` is neither true nor false; taken as {fallback}",
                    short(&text)
                ),
            );
            Ok(fallback)
        }
    }
}

/// The shapes inside an element, as one; nothing where there is none.
pub(super) fn shape<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Shape>, ReadError> {
    let mut shapes = shapes(xml, 0)?;
    match shapes.len() {
        0 => {
            xml.note(
                Severity::Warning,
                element,
                "no shape in it; it covers nothing".into(),
            );
            Ok(None)
        }
        1 => Ok(shapes.pop()),
        _ => Ok(Some(Shape::Group(shapes))),
    }
}

/// The footprint of an obstacle; one that encloses nothing is an error of the file.
pub(super) fn footprint<'a>(
    xml: &mut Xml<'a>,
    element: Element<'a>,
) -> Result<Option<Footprint>, ReadError> {
    let Some(shape) = shape(xml, element)? else {
        return Ok(None);
    };
    let made = Footprint::new(shape);
    made.map(Some)
        .map_err(|e| xml.fail_in(element, e.to_string()))
}

fn shapes(xml: &mut Xml<'_>, depth: usize) -> Result<Vec<Shape>, ReadError> {
    let mut found = Vec::new();
    while let Some(child) = xml.next()? {
        match one_shape(xml, child, depth)? {
            Some(shape) => found.push(shape),
            None => xml.skip_unknown(child)?,
        }
    }
    Ok(found)
}

/// One shape if `child` opens one; otherwise nothing, and `child` is still open.
pub(super) fn one_shape<'a>(
    xml: &mut Xml<'a>,
    child: Element<'a>,
    depth: usize,
) -> Result<Option<Shape>, ReadError> {
    let shape = match child.name {
        "rectangle" => rectangle(xml, child)?,
        "circle" => circle(xml, child)?,
        "polygon" => Shape::Polygon {
            vertices: polygon(xml)?,
        },
        "shapeGroup" | "absoluteShapeGroup" if depth < DEEPEST_GROUP => {
            Shape::Group(shapes(xml, depth + 1)?)
        }
        _ => return Ok(None),
    };
    shape
        .check()
        .map_err(|e| xml.fail_in(child, e.to_string()))?;
    Ok(Some(shape))
}

fn rectangle<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Shape, ReadError> {
    let (mut length, mut width) = (None, None);
    let (mut center, mut orientation, mut shift) = (Point::origin(), 0.0, 0.0);
    while let Some(child) = xml.next()? {
        match child.name {
            "length" => length = Some(xml.number(child)?),
            "width" => width = Some(xml.number(child)?),
            "orientation" => orientation = xml.number(child)?,
            "center" => center = point(xml, child)?.0,
            "originXShift" => shift = xml.number(child)?,
            _ => xml.skip_unknown(child)?,
        }
    }
    match (length, width) {
        (Some(length), Some(width)) => Ok(Shape::Rectangle {
            length,
            width,
            // The shift says where the object's origin lies on the box, so the box moves the other way.
            center: Point::new(center.x - shift, center.y),
            orientation,
        }),
        _ => Err(xml.fail_in(element, "a rectangle needs <length> and <width>".into())),
    }
}

fn circle<'a>(xml: &mut Xml<'a>, element: Element<'a>) -> Result<Shape, ReadError> {
    let (mut radius, mut center) = (None, Point::origin());
    while let Some(child) = xml.next()? {
        match child.name {
            "radius" => radius = Some(xml.number(child)?),
            "center" => center = point(xml, child)?.0,
            _ => xml.skip_unknown(child)?,
        }
    }
    let radius = radius.ok_or_else(|| xml.fail_in(element, "a circle needs <radius>".into()))?;
    Ok(Shape::Circle { radius, center })
}

fn polygon(xml: &mut Xml<'_>) -> Result<Vec<Point>, ReadError> {
    let mut vertices = Vec::new();
    while let Some(child) = xml.next()? {
        match child.name {
            "point" => vertices.push(point(xml, child)?.0),
            _ => xml.skip_unknown(child)?,
        }
    }
    // Some files close the ring.
    if vertices.len() > 3 && vertices.first() == vertices.last() {
        vertices.pop();
    }
    Ok(vertices)
}
