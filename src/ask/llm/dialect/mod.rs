//! The wire protocols: each is a file with its [`WireProtocol`] and a row of the table of [`Dialect`].

mod anthropic;
mod gemini;
mod ollama;
mod openai_chat;
mod openai_responses;
mod protocol;

pub(super) use protocol::{AnswerReader, Framing, Notes, WireProtocol};
pub use protocol::{body, gives_log_probabilities, notes, sends_form};

use serde::Deserialize;

use protocol::{
    count, function_tools, given, is_anthropic_model, names_in, openai_models, openai_version,
    string,
};

/// The dialects, a row each: variant, name in configuration files, implementation.
macro_rules! dialects {
    ($make:ident) => {
        $make! {
                /// OpenAI's chat completions, which most servers speak.
                #[default]
                OpenAiChat = "openai_chat": openai_chat::Protocol;
                /// OpenAI's Responses API.
                OpenAiResponses = "openai_responses": openai_responses::Protocol;
                /// Google's `generateContent`.
                Gemini = "gemini": gemini::Protocol;
                /// Anthropic's messages.
                Anthropic = "anthropic": anthropic::Protocol;
                /// Ollama's own `/api/chat`.
                Ollama = "ollama": ollama::Protocol;
        }
    };
}

macro_rules! protocols {
    ($($(#[$meta:meta])* $variant:ident = $name:literal: $protocol:path;)*) => {
        impl Dialect {
            pub(super) fn protocol(self) -> &'static dyn WireProtocol {
                match self {
                    $(Self::$variant => &$protocol,)*
                }
            }
        }
    };
}

dialects!(protocols);

impl Dialect {
    /// How its official clients send the key.
    #[must_use]
    pub fn auth(self) -> Auth {
        self.protocol().auth()
    }
}

/// Makes [`Dialect`] of the table.
macro_rules! kinds {
    ($($(#[$meta:meta])* $variant:ident = $name:literal: $protocol:path;)*) => {
        /// An API that models are served over.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord, Deserialize)]
        pub enum Dialect {
            $($(#[$meta])* #[serde(rename = $name)] $variant,)*
        }

        impl Dialect {
            /// Every dialect.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The word for it in configuration files.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

dialects!(kinds);

/// The header that carries the key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum Auth {
    /// `Authorization: Bearer …`.
    #[serde(rename = "bearer")]
    Bearer,
    /// `x-api-key`, Anthropic's.
    #[serde(rename = "x-api-key")]
    ApiKey,
    /// `x-goog-api-key`, Google's.
    #[serde(rename = "x-goog-api-key")]
    GoogleApiKey,
}

impl Auth {
    /// Name of the header, and the word before the key.
    pub(in crate::llm) fn header(self) -> (&'static str, &'static str) {
        match self {
            Self::Bearer => ("authorization", "Bearer "),
            Self::ApiKey => ("x-api-key", ""),
            Self::GoogleApiKey => ("x-goog-api-key", ""),
        }
    }
}

#[cfg(test)]
mod tests;
