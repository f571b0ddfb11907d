//! The wire protocols: each is a file with its [`WireProtocol`] and a row of the table of [`Dialect`].

mod anthropic;
mod gemini;
mod ollama;
mod openai_chat;
mod openai_responses;
mod protocol;

pub(super) use protocol::{AnswerReader, Framing, Notes, WireProtocol};
pub use protocol::{body, gives_log_probabilities, notes, sends_form};

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

mod kind;

pub use kind::{Auth, Dialect};

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

#[cfg(test)]
mod tests;
