//! Reasoning effort: its levels, and which of them a model takes.

use serde::{Deserialize, Deserializer, Serialize};

use super::dialect::Dialect;
use super::endpoint::Endpoint;
use super::error::Error;
use super::quirks::Efforts;
use super::request::Request;

/// Reasoning effort, in the words of the providers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Effort {
    /// Not at all; `none` in OpenAI's words.
    Off,
    /// As little as the model can.
    Minimal,
    /// A little.
    Low,
    /// As usual.
    Medium,
    /// A lot.
    High,
    /// More than a lot.
    XHigh,
    /// Without a bound.
    Max,
}

impl Effort {
    /// Every effort, the least first.
    pub const ALL: [Self; 7] = [
        Self::Off,
        Self::Minimal,
        Self::Low,
        Self::Medium,
        Self::High,
        Self::XHigh,
        Self::Max,
    ];

    /// The word for it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Minimal => "minimal",
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
            Self::XHigh => "xhigh",
            Self::Max => "max",
        }
    }

    /// The effort with this name.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|effort| effort.name() == name)
    }

    /// All names, for people: `off, minimal, … or max`.
    #[must_use]
    pub fn names() -> String {
        EffortLevels::of(&Self::ALL).names()
    }
}

/// The efforts that a model takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EffortLevels(u8);

impl EffortLevels {
    /// These.
    #[must_use]
    pub const fn of(efforts: &[Effort]) -> Self {
        let (mut bits, mut i) = (0, 0);
        while i < efforts.len() {
            bits |= 1 << efforts[i] as u8;
            i += 1;
        }
        Self(bits)
    }

    /// Whether an effort is among them.
    #[must_use]
    pub fn has(self, effort: Effort) -> bool {
        self.0 & (1 << effort as u8) != 0
    }

    /// Their names, the least first, for people.
    #[must_use]
    pub fn names(self) -> String {
        let taken = Effort::ALL.into_iter().filter(|effort| self.has(*effort));
        let names: Vec<&str> = taken.map(Effort::name).collect();
        match names.split_last() {
            Some((last, [])) => (*last).to_owned(),
            Some((last, before)) => format!("{} or {last}", before.join(", ")),
            None => String::new(),
        }
    }
}

impl<'de> Deserialize<'de> for EffortLevels {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        Vec::<Effort>::deserialize(source).map(|efforts| Self::of(&efforts))
    }
}

use Effort::{High, Low, Max, Medium, Minimal, Off, XHigh};

/// The efforts that the model of an endpoint takes, as its provider documents them; `None` where reasoning can only be
/// switched, or not even that. Of servers that forward to any model, the server decides.
fn levels(endpoint: &Endpoint) -> Option<EffortLevels> {
    let style = endpoint.quirks.efforts.unwrap_or(Efforts::Levels);
    if matches!(
        style,
        Efforts::Template | Efforts::Switch | Efforts::Untaken
    ) {
        return None;
    }
    let usual = match (style, endpoint.dialect) {
        (Efforts::Budget, _) => EffortLevels::of(&[Off, Low, Medium, High]),
        (Efforts::DeepSeek, _) => EffortLevels::of(&[Off, Low, High, Max]),
        (Efforts::OpenRouter, _) => EffortLevels::of(&[Off, Minimal, Low, Medium, High, XHigh]),
        (_, Dialect::Anthropic) => EffortLevels::of(&[Off, Low, Medium, High, XHigh, Max]),
        (_, Dialect::Gemini) => EffortLevels::of(&[Off, Minimal, Low, Medium, High]),
        (_, Dialect::Ollama) => EffortLevels::of(&[Off, Low, Medium, High, Max]),
        (_, Dialect::OpenAiChat | Dialect::OpenAiResponses) => EffortLevels::of(&Effort::ALL),
    };
    Some(endpoint.quirks.effort_levels.unwrap_or(usual))
}

/// Whether the model takes the effort that a request asks for.
///
/// # Errors
/// [`Error::Setup`] that names the efforts it takes.
pub(super) fn check(endpoint: &Endpoint, request: &Request) -> Result<(), Error> {
    let (Some(effort), Some(levels)) = (request.parameters.effort, levels(endpoint)) else {
        return Ok(());
    };
    if levels.has(effort) {
        return Ok(());
    }
    Err(Error::Setup {
        place: endpoint.place(),
        why: format!(
            "{} does not take effort {}; it takes {} (`effort` in config.toml, --set effort=…)",
            request.model,
            effort.name(),
            levels.names()
        ),
    })
}

nearmiss_record::word!(Effort, "effort");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_back() {
        for effort in Effort::ALL {
            assert_eq!(Effort::parse(effort.name()), Some(effort));
        }
        assert_eq!(
            Effort::names(),
            "off, minimal, low, medium, high, xhigh or max"
        );
        assert_eq!(EffortLevels::of(&[Max, Low]).names(), "low or max");
        assert_eq!(EffortLevels::of(&[Low]).names(), "low");
    }
}
