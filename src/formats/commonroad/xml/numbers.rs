//! Numbers in elements and attributes: implausible ones are rejected with their place.

use super::{Element, Xml, short};
use crate::commonroad::builder;
use crate::commonroad::encoding::BYTE_ORDER_MARK;
use crate::commonroad::error::ReadError;
use nearmiss_scene::scenario::Severity;

impl<'a> Xml<'a> {
    /// The value of an attribute that must be a whole number.
    pub fn id_attribute(&self, element: Element<'a>, name: &str) -> Result<i64, ReadError> {
        let Some(value) = self.attribute(element, name) else {
            return Err(self.fail(
                element.at,
                format!("<{}> has no attribute `{name}`", element.name),
            ));
        };
        parse_id(&value).ok_or_else(|| {
            self.fail(
                element.at,
                format!("{name}=\"{}\" is not a whole number", short(&value)),
            )
        })
    }

    /// The text of the innermost open element as a finite number.
    pub fn number(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let text = self.text()?;
        let value = self.parsed(element, &text)?;
        builder::finite(&self.at(element), value, || short(&text))
    }

    /// The text of the innermost open element as a number, also one that is not finite.
    pub fn any_number(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let text = self.text()?;
        self.parsed(element, &text)
    }

    /// The text of the innermost open element as a time or a duration, steps.
    pub fn steps(&mut self, element: Element<'a>) -> Result<i64, ReadError> {
        let value = self.number(element)?;
        let step = self.times.step(value);
        step.map_err(|message| self.fail_in(element, message))
    }

    fn parsed(&self, element: Element<'a>, text: &str) -> Result<f64, ReadError> {
        if let Ok(value) = text.parse::<f64>() {
            return Ok(value);
        }
        let message = if text.is_empty() {
            "empty; expected a number".into()
        } else if text.contains(BYTE_ORDER_MARK) {
            format!(
                "`{}` is not a number: remove the byte order mark in it",
                short(&text.replace(BYTE_ORDER_MARK, "U+FEFF "))
            )
        } else {
            format!("`{}` is not a number", short(text))
        };
        Err(self.fail_in(element, message))
    }

    /// The text of the innermost open element as a coordinate, metres.
    pub fn coordinate(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let value = self.number(element)?;
        builder::coordinate(&self.at(element), value)
    }

    /// The text of the innermost open element as a length, width or radius, metres.
    pub fn size(&mut self, element: Element<'a>) -> Result<f64, ReadError> {
        let value = self.number(element)?;
        builder::size(&self.at(element), value)
    }

    /// The text of the innermost open element as a whole number; `3.0` is one.
    pub fn whole(&mut self, element: Element<'a>) -> Result<i64, ReadError> {
        let value = self.number(element)?;
        if value.fract() == 0.0 && value.abs() < 1e15 {
            Ok(value as i64)
        } else {
            Err(self.fail_in(element, format!("`{value}` is not a whole number")))
        }
    }

    /// The text of the innermost open element as a finite number; nothing, with a diagnostic, where it is none.
    pub fn optional_number(&mut self, element: Element<'a>) -> Result<Option<f64>, ReadError> {
        let text = self.text()?;
        let value = text.parse::<f64>().ok().filter(|v| v.is_finite());
        if value.is_none() {
            let message = format!("`{}` is not a number and was left out", short(&text));
            self.note(Severity::Warning, element, message);
        }
        Ok(value)
    }
}

/// A whole number, also where it is written as `3.0`.
fn parse_id(text: &str) -> Option<i64> {
    let text = text.trim();
    text.parse().ok().or_else(|| {
        let value: f64 = text.parse().ok()?;
        (value.fract() == 0.0 && value.abs() < 1e15).then_some(value as i64)
    })
}
