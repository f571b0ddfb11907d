//! Provider outages: errors that the next question would most likely meet too.

use super::error::{Error, TimeoutKind};

/// An obstacle between a server and every question to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProviderOutage {
    /// No response: no connection, or one on which nothing ever came. It may pass.
    Silence,
    /// The server forbids it (403): mostly the key may not do this, with some servers the question was blocked.
    Forbidden,
    /// The server takes no question to this model as things stand: wrong key, unknown model, used-up quota, another
    /// address.
    Refused,
}

impl Error {
    /// The obstacle to every other question, too; `None` if the error concerns this one alone. Silence counts only if
    /// nothing of an answer had arrived.
    #[must_use]
    pub fn barrier(&self) -> Option<ProviderOutage> {
        match self {
            Self::Refused { .. } | Self::Unreachable { .. } | Self::Tls { .. } => {
                Some(ProviderOutage::Silence)
            }
            Self::Timeout { which, .. } => match which {
                TimeoutKind::Connect | TimeoutKind::Idle => Some(ProviderOutage::Silence),
                // A model may need longer for one question than for another.
                TimeoutKind::Total => None,
            },
            Self::Truncated { received: 0, .. } => Some(ProviderOutage::Silence),
            Self::Unauthorized { status: 403, .. } => Some(ProviderOutage::Forbidden),
            Self::Unauthorized { .. } | Self::NotFound { .. } | Self::Redirected { .. } => {
                Some(ProviderOutage::Refused)
            }
            Self::RateLimited { exhausted, .. } => exhausted.then_some(ProviderOutage::Refused),
            Self::Setup { .. }
            | Self::BadRequest { .. }
            | Self::Server { .. }
            | Self::Truncated { .. }
            | Self::Malformed { .. }
            | Self::Budget { .. }
            | Self::Provider { .. } => None,
        }
    }
}
