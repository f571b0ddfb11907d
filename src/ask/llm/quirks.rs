//! Differences between servers and models of one dialect, as registry data, such as the levels of reasoning effort.

use serde::{Deserialize, Deserializer};
use strum::{IntoStaticStr, VariantArray};

use super::dialect::Dialect;
use super::endpoint::Endpoint;
use super::error::Error;
use super::request::{ImageTokens, Request};
use Effort::{High, Low, Max, Medium, Minimal, Off, XHigh};

/// Parameters a model accepts, and how to send them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quirks {
    /// The limit of an answer is called `max_completion_tokens`.
    pub max_completion_tokens: bool,
    /// Whether a temperature is taken.
    pub temperature: Temperature,
    /// Whether a seed is taken.
    pub seed: bool,
    /// The model reasons only if reasoning is requested.
    pub reasoning: bool,
    /// Encoding of reasoning effort; `None` for the dialect's default.
    pub efforts: Option<Efforts>,
    /// The efforts that the model takes; `None` for those of the dialect.
    pub effort_levels: Option<EffortLevels>,
    /// Whether log probabilities are given.
    pub log_probabilities: LogProbabilities,
    /// The shortest beginning of a question that the server keeps in its cache where it is marked, tokens (Anthropic).
    pub cache_from: Option<u32>,
    /// Token limit of an answer, sent if the request sets none.
    pub max_tokens: Option<u32>,
    /// The limit of an answer does not count its reasoning, so that nothing bounds what it costs.
    pub reasoning_unlimited: bool,
    /// The context window that is asked for, tokens (Ollama); `None` makes it fit the question.
    pub context: Option<u32>,
    /// Only hosts that know every parameter are to be chosen (OpenRouter).
    pub require_parameters: bool,
    /// Whether the usage may be asked for with `stream_options`.
    pub stream_options: bool,
    /// Whether the model takes images; `None` where that is not known.
    pub images: Option<bool>,
    /// Whether the model calls tools; `None` where that is not known.
    pub tools: Option<bool>,
    /// The dialect that questions with tools are asked in, where it is another; see [`super::Endpoint::for_request`].
    pub tools_dialect: Option<Dialect>,
    /// How many tokens an image is.
    pub image_tokens: ImageTokens,
}

impl Default for Quirks {
    fn default() -> Self {
        Self {
            max_completion_tokens: false,
            temperature: Temperature::Taken,
            seed: true,
            reasoning: false,
            efforts: None,
            effort_levels: None,
            log_probabilities: LogProbabilities::Given,
            cache_from: None,
            max_tokens: None,
            reasoning_unlimited: false,
            context: None,
            require_parameters: false,
            stream_options: true,
            images: None,
            tools: None,
            tools_dialect: None,
            image_tokens: ImageTokens::default(),
        }
    }
}

/// Support for a temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Temperature {
    /// Any that the API takes.
    #[default]
    Taken,
    /// None but 1.
    Fixed,
    /// Only while it does not think.
    NotThinking,
}

/// Support for log probabilities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LogProbabilities {
    /// They are given.
    #[default]
    Given,
    /// Only while it does not think.
    NotThinking,
    /// They are not.
    Withheld,
}

/// How reasoning effort is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Efforts {
    /// As a level.
    Levels,
    /// As a budget of tokens (Gemini 2.5, older models of Anthropic).
    Budget,
    /// DeepSeek's switch with levels.
    #[serde(rename = "deepseek")]
    DeepSeek,
    /// OpenRouter's object.
    #[serde(rename = "openrouter")]
    OpenRouter,
    /// On or off, by an argument of the chat template (llama.cpp, vLLM) or a truth value (Ollama).
    Template,
    /// On or off, by a parameter of its own (Qwen).
    Switch,
    /// Not at all.
    Untaken,
}

/// Quirks as entries of the registry state them: what is `None` is left as it was.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StatedQuirks {
    /// See [`Quirks::max_completion_tokens`].
    pub max_completion_tokens: Option<bool>,
    /// See [`Quirks::temperature`].
    pub temperature: Option<Temperature>,
    /// See [`Quirks::seed`].
    pub seed: Option<bool>,
    /// See [`Quirks::reasoning`].
    pub reasoning: Option<bool>,
    /// See [`Quirks::efforts`].
    pub efforts: Option<Efforts>,
    /// See [`Quirks::effort_levels`].
    pub effort_levels: Option<EffortLevels>,
    /// See [`Quirks::log_probabilities`].
    pub log_probabilities: Option<LogProbabilities>,
    /// See [`Quirks::cache_from`].
    pub cache_from: Option<u32>,
    /// See [`Quirks::max_tokens`].
    pub max_tokens: Option<u32>,
    /// See [`Quirks::reasoning_unlimited`].
    pub reasoning_unlimited: Option<bool>,
    /// See [`Quirks::context`].
    pub context: Option<u32>,
    /// See [`Quirks::require_parameters`].
    pub require_parameters: Option<bool>,
    /// See [`Quirks::stream_options`].
    pub stream_options: Option<bool>,
    /// See [`Quirks::images`].
    pub images: Option<bool>,
    /// See [`Quirks::tools`].
    pub tools: Option<bool>,
    /// See [`Quirks::tools_dialect`].
    pub tools_dialect: Option<Dialect>,
    /// See [`Quirks::image_tokens`].
    pub image_tokens: Option<ImageTokens>,
}

impl StatedQuirks {
    /// These, and `other`'s where these say nothing.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            max_completion_tokens: self.max_completion_tokens.or(other.max_completion_tokens),
            temperature: self.temperature.or(other.temperature),
            seed: self.seed.or(other.seed),
            reasoning: self.reasoning.or(other.reasoning),
            efforts: self.efforts.or(other.efforts),
            effort_levels: self.effort_levels.or(other.effort_levels),
            log_probabilities: self.log_probabilities.or(other.log_probabilities),
            cache_from: self.cache_from.or(other.cache_from),
            max_tokens: self.max_tokens.or(other.max_tokens),
            reasoning_unlimited: self.reasoning_unlimited.or(other.reasoning_unlimited),
            context: self.context.or(other.context),
            require_parameters: self.require_parameters.or(other.require_parameters),
            stream_options: self.stream_options.or(other.stream_options),
            images: self.images.or(other.images),
            tools: self.tools.or(other.tools),
            tools_dialect: self.tools_dialect.or(other.tools_dialect),
            image_tokens: self.image_tokens.or(other.image_tokens),
        }
    }

    /// The defaults where nothing is stated.
    #[must_use]
    pub fn settled(self) -> Quirks {
        let default = Quirks::default();
        Quirks {
            max_completion_tokens: self
                .max_completion_tokens
                .unwrap_or(default.max_completion_tokens),
            temperature: self.temperature.unwrap_or(default.temperature),
            seed: self.seed.unwrap_or(default.seed),
            reasoning: self.reasoning.unwrap_or(default.reasoning),
            efforts: self.efforts,
            effort_levels: self.effort_levels,
            log_probabilities: self.log_probabilities.unwrap_or(default.log_probabilities),
            cache_from: self.cache_from,
            max_tokens: self.max_tokens,
            reasoning_unlimited: self
                .reasoning_unlimited
                .unwrap_or(default.reasoning_unlimited),
            context: self.context,
            require_parameters: self
                .require_parameters
                .unwrap_or(default.require_parameters),
            stream_options: self.stream_options.unwrap_or(default.stream_options),
            images: self.images,
            tools: self.tools,
            tools_dialect: self.tools_dialect,
            image_tokens: self.image_tokens.unwrap_or(default.image_tokens),
        }
    }
}

/// Reasoning effort, in the words of the providers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
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

nearmiss_record::named!(Effort, "effort");

impl Effort {
    /// All names, for people: `off, minimal, … or max`.
    #[must_use]
    pub fn names() -> String {
        EffortLevels::new(&Self::ALL).names()
    }
}

/// The efforts that a model takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EffortLevels(u8);

impl EffortLevels {
    /// These.
    #[must_use]
    pub const fn new(efforts: &[Effort]) -> Self {
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
        Vec::<Effort>::deserialize(source).map(|efforts| Self::new(&efforts))
    }
}

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
        (Efforts::Budget, _) => EffortLevels::new(&[Off, Low, Medium, High]),
        (Efforts::DeepSeek, _) => EffortLevels::new(&[Off, Low, High, Max]),
        (Efforts::OpenRouter, _) => EffortLevels::new(&[Off, Minimal, Low, Medium, High, XHigh]),
        (_, Dialect::Anthropic) => EffortLevels::new(&[Off, Low, Medium, High, XHigh, Max]),
        (_, Dialect::Gemini) => EffortLevels::new(&[Off, Minimal, Low, Medium, High]),
        (_, Dialect::Ollama) => EffortLevels::new(&[Off, Low, Medium, High, Max]),
        (_, Dialect::OpenAiChat | Dialect::OpenAiResponses) => EffortLevels::new(&Effort::ALL),
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
        assert_eq!(EffortLevels::new(&[Max, Low]).names(), "low or max");
        assert_eq!(EffortLevels::new(&[Low]).names(), "low");
    }
}
