//! Which API a server speaks, and how it is given the key.

use serde::Deserialize;

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
