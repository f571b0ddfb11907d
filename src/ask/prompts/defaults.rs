//! Defaults of a template, used unless the user overrides them.

use std::num::NonZeroUsize;

use serde::{Deserialize, Deserializer, de::Error};

use super::Techniques;

/// Defaults of a template; what it does not say, the program decides.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Defaults {
    /// Steps in the window.
    pub history: Option<NonZeroUsize>,
    /// Every so many steps are described.
    pub stride: Option<NonZeroUsize>,
    /// At most so many times are described: in a longer window the stride grows.
    pub times: Option<NonZeroUsize>,
    /// Whether everyone is told that would be described at any step, and in the ego frame the nearest moment of each.
    pub nearest: Option<bool>,
    /// Obstacles within this distance of the ego are described, metres, and farther away those that can reach it soon.
    #[serde(deserialize_with = "radius")]
    pub radius: Option<f64>,
    /// Decimals of metres, m/s and m/s².
    #[serde(deserialize_with = "precision")]
    pub precision: Option<usize>,
    /// How the scene is written.
    pub form: Option<Wording>,
    /// Whether it is said that bodies touch.
    pub contact: Option<bool>,
    /// Whether the road near the ego is described too, in the Cartesian frame.
    pub road: Option<bool>,
    /// What the ego frame measures along and across.
    pub axes: Option<AxesOfEgo>,
    /// Ids of the measures of the metrics frame.
    pub measures: Option<Vec<String>>,
    /// Which techniques are on.
    #[serde(deserialize_with = "techniques")]
    pub techniques: Option<Techniques>,
    /// Sampling temperature, 0 to 2.
    #[serde(deserialize_with = "temperature")]
    pub temperature: Option<f64>,
}

/// Style of a description.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Wording {
    /// Sentences.
    Prose,
    /// A table.
    Compact,
}

/// The axes of the ego frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxesOfEgo {
    /// Along and across the ego's heading.
    Heading,
    /// Along and across the ego's lane.
    Lane,
    /// Along and across the ego's heading, from centre to centre, without distances and gaps.
    Centre,
}

/// More decimals than any recording has.
pub const MOST_DECIMALS: usize = 9;

fn radius<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    let metres = f64::deserialize(from)?;
    if metres.is_finite() && metres > 0.0 {
        return Ok(Some(metres));
    }
    Err(D::Error::custom(
        "radius must be a positive number of metres",
    ))
}

fn precision<'de, D: Deserializer<'de>>(from: D) -> Result<Option<usize>, D::Error> {
    let decimals = i64::deserialize(from)?;
    let decimals = usize::try_from(decimals).ok();
    match decimals.filter(|d| *d <= MOST_DECIMALS) {
        Some(decimals) => Ok(Some(decimals)),
        None => Err(D::Error::custom(format!(
            "precision must be 0 to {MOST_DECIMALS} decimals"
        ))),
    }
}

fn techniques<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Techniques>, D::Error> {
    let words = String::deserialize(from)?;
    Techniques::parse(&words)
        .map(Some)
        .map_err(D::Error::custom)
}

fn temperature<'de, D: Deserializer<'de>>(from: D) -> Result<Option<f64>, D::Error> {
    let value = f64::deserialize(from)?;
    if (0.0..=2.0).contains(&value) {
        return Ok(Some(value));
    }
    Err(D::Error::custom("temperature must be from 0 to 2"))
}
