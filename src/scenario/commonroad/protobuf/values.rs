//! Points, numbers, quantities and time steps out of messages.

use std::borrow::Cow;

use super::messages::{self, FloatExactOrInterval, IntegerExactOrInterval};
use super::report::{At, Report};
use crate::geometry::Point;
use crate::scenario::commonroad::ReadError;
use crate::scenario::commonroad::out::allowed;
use crate::scenario::commonroad::states::refused_step;
use crate::scenario::plausibility::limits::{
    LARGEST_NUMBER, LATEST_STEP, MOST_PARTS, is_tiny, refused_coordinate, refused_size,
};
use crate::scenario::{Quantity, Steps};

/// A text as XML gives it: trimmed, and with U+FFFD, and a diagnostic, for every character that no XML file can hold.
pub(super) fn text(report: &mut Report, at: &At<'_>, text: &str) -> String {
    let allowed = allowed(text.trim());
    if let Cow::Owned(_) = allowed {
        report.warn(
            at,
            "control characters, which have no place in XML, were replaced by U+FFFD",
        );
    }
    allowed.into_owned()
}

/// The texts of a repeated field; see [`text`].
pub(super) fn texts(report: &mut Report, at: &At<'_>, name: &str, texts: &[String]) -> Vec<String> {
    let numbered = texts.iter().enumerate();
    numbered
        .map(|(i, value)| text(report, &at.nth(name, i), value))
        .collect()
}

/// A number that the schema requires, finite.
pub(super) fn number(
    report: &Report,
    at: &At<'_>,
    name: &str,
    value: Option<f64>,
) -> Result<f64, ReadError> {
    finite(report, &at.field(name), report.need(at, name, value)?)
}

pub(super) fn finite(report: &Report, at: &At<'_>, value: f64) -> Result<f64, ReadError> {
    if is_tiny(value) {
        report.saw_tiny(at, value);
    }
    if value.abs() <= LARGEST_NUMBER {
        Ok(value)
    } else if value.is_finite() {
        Err(report.fail(at, format!("`{value}` is out of all reason")))
    } else {
        Err(report.fail(at, format!("`{value}` is not a finite number")))
    }
}

/// A length, width or radius that the schema requires, metres.
pub(super) fn size(
    report: &Report,
    at: &At<'_>,
    name: &str,
    value: Option<f64>,
) -> Result<f64, ReadError> {
    let value = number(report, at, name, value)?;
    match refused_size(value) {
        None => Ok(value),
        Some(message) => Err(report.fail(&at.field(name), message)),
    }
}

fn coordinate(
    report: &Report,
    at: &At<'_>,
    name: &str,
    value: Option<f64>,
) -> Result<f64, ReadError> {
    let value = number(report, at, name, value)?;
    match refused_coordinate(value) {
        None => Ok(value),
        Some(message) => Err(report.fail(&at.field(name), message)),
    }
}

/// A number that may be left out; one that is not finite is, with a diagnostic.
pub(super) fn optional(report: &mut Report, at: &At<'_>, value: Option<f64>) -> Option<f64> {
    let value = value?;
    if value.is_finite() {
        return Some(value);
    }
    report.warn(at, format!("`{value}` is not a number and was left out"));
    None
}

pub(super) fn point(
    report: &Report,
    at: &At<'_>,
    point: &messages::Point,
) -> Result<Point, ReadError> {
    let x = coordinate(report, at, "x", point.x)?;
    Ok(Point::new(x, coordinate(report, at, "y", point.y)?))
}

/// Points and, where every one has it, their heights.
pub(super) fn points(
    report: &Report,
    at: &At<'_>,
    all: &[messages::Point],
) -> Result<(Vec<Point>, Vec<f64>), ReadError> {
    if all.len() > MOST_PARTS {
        return Err(report.fail(at, format!("more than {MOST_PARTS} points in one place")));
    }
    let mut points = Vec::with_capacity(all.len());
    let mut heights = Vec::new();
    for (i, message) in all.iter().enumerate() {
        let at = at.nth("points", i);
        points.push(point(report, &at, message)?);
        if let Some(z) = message.z {
            heights.push(finite(report, &at.field("z"), z)?);
        }
    }
    if heights.len() != points.len() {
        heights.clear();
    }
    Ok((points, heights))
}

/// A number, exact or an interval; nothing, with a diagnostic, where it is neither.
pub(super) fn quantity(
    report: &mut Report,
    at: &At<'_>,
    value: &FloatExactOrInterval,
) -> Result<Option<Quantity>, ReadError> {
    if let Some(exact) = value.exact {
        return Ok(Some(Quantity::Exact(finite(report, at, exact)?)));
    }
    let Some(interval) = &value.interval else {
        report.warn(at, "it is empty and was left out");
        return Ok(None);
    };
    let from = number(report, at, "start", interval.start)?;
    let to = number(report, at, "end", interval.end)?;
    if from > to {
        return Err(report.fail(at, format!("the interval from {from} to {to} is empty")));
    }
    Ok(Some(Quantity::Interval(from, to)))
}

/// A time step or an interval of them.
pub(super) fn steps(
    report: &Report,
    at: &At<'_>,
    value: &IntegerExactOrInterval,
) -> Result<Steps, ReadError> {
    let steps = match (value.exact, &value.interval) {
        (Some(step), _) => Steps::exact(step.into()),
        (None, Some(interval)) => Steps {
            from: report.need(at, "start", interval.start)?.into(),
            to: report.need(at, "end", interval.end)?.into(),
        },
        (None, None) => return Err(report.fail(at, "no time step in it")),
    };
    if steps.from > steps.to {
        let message = format!("the interval from {} to {} is empty", steps.from, steps.to);
        return Err(report.fail(at, message));
    }
    if steps.from.abs() > LATEST_STEP || steps.to.abs() > LATEST_STEP {
        return Err(report.fail(at, refused_step(steps)));
    }
    Ok(steps)
}

pub(super) fn ids(values: &[u32]) -> Vec<i64> {
    values.iter().map(|id| i64::from(*id)).collect()
}
