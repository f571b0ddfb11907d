//! Differences between servers and models of one dialect, as registry data, such as the levels of reasoning effort.

use serde::{Deserialize, Deserializer};
use strum::{IntoStaticStr, VariantArray};

use super::dialect::Dialect;
use super::endpoint::Endpoint;
use super::error::Error;
use super::request::{ImageTokens, Request};
use Effort::{High, Low, Max, Medium, Minimal, Off, XHigh};

/// The quirks, each once: those that hold by default, and those of which nothing is known by default.
macro_rules! quirks {
    (
        settled { $($(#[doc = $of:literal])* $name:ident: $type:ty = $default:expr;)+ }
        unknown { $($(#[doc = $of_open:literal])* $open:ident: $open_type:ty;)+ }
    ) => {
        /// Each quirk by its key, and what it says.
        pub const QUIRKS: &[(&str, &str)] = &[
            $((stringify!($name), concat!($($of),*)),)+
            $((stringify!($open), concat!($($of_open),*)),)+
        ];

        /// Parameters a model accepts, and how to send them.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct Quirks {
            $($(#[doc = $of])* pub $name: $type,)+
            $($(#[doc = $of_open])* pub $open: Option<$open_type>,)+
        }

        impl Default for Quirks {
            fn default() -> Self {
                Self { $($name: $default,)+ $($open: None,)+ }
            }
        }

        /// Quirks as entries of the registry state them: what is `None` is left as it was.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct StatedQuirks {
            $($(#[doc = $of])* pub $name: Option<$type>,)+
            $($(#[doc = $of_open])* pub $open: Option<$open_type>,)+
        }

        impl StatedQuirks {
            /// These, and `other`'s where these say nothing.
            #[must_use]
            pub fn or(self, other: Self) -> Self {
                Self {
                    $($name: self.$name.or(other.$name),)+
                    $($open: self.$open.or(other.$open),)+
                }
            }

            /// The defaults where nothing is stated.
            #[must_use]
            pub fn settled(self) -> Quirks {
                let default = Quirks::default();
                Quirks {
                    $($name: self.$name.unwrap_or(default.$name),)+
                    $($open: self.$open,)+
                }
            }
        }
    };
}

quirks! {
    settled {
        /// The limit of an answer is called `max_completion_tokens`.
        max_completion_tokens: bool = false;
        /// Whether a temperature is taken.
        temperature: Temperature = Temperature::Taken;
        /// Whether a seed is taken.
        seed: bool = true;
        /// The model reasons only if reasoning is requested.
        reasoning: bool = false;
        /// Whether log probabilities are given.
        log_probabilities: LogProbabilities = LogProbabilities::Given;
        /// The limit of an answer does not count its reasoning, so that nothing bounds what it costs.
        reasoning_unlimited: bool = false;
        /// Only hosts that know every parameter are to be chosen (OpenRouter).
        require_parameters: bool = false;
        /// Whether the usage may be asked for with `stream_options`.
        stream_options: bool = true;
        /// How many tokens an image is.
        image_tokens: ImageTokens = ImageTokens::default();
    }
    unknown {
        /// Encoding of reasoning effort; `None` for the dialect's default.
        efforts: Efforts;
        /// The efforts that the model takes; `None` for those of the dialect.
        effort_levels: EffortLevels;
        /// The shortest beginning of a question that the server keeps in its cache where it is marked, tokens
        /// (Anthropic).
        cache_from: u32;
        /// Token limit of an answer, sent if the request sets none.
        max_tokens: u32;
        /// The context window that is asked for, tokens (Ollama); `None` makes it fit the question.
        context: u32;
        /// Whether the model takes images; `None` where that is not known.
        images: bool;
        /// Whether the model calls tools; `None` where that is not known.
        tools: bool;
        /// The dialect that questions with tools are asked in, where it is another; see
        /// [`super::Endpoint::for_request`].
        tools_dialect: Dialect;
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
