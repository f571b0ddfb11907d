//! Shards of a batch for several machines: each scenario belongs to one, by its name alone.

use sha2::{Digest, Sha256};

/// The part of a batch that one machine asks: its number from 1, and how many there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    number: u32,
    of: u32,
}

impl Shard {
    /// Whether a scenario belongs to this part. It depends on the scenario's name alone, so that every machine comes to
    /// the same, whatever lies where.
    #[must_use]
    pub fn has(&self, scenario: &str) -> bool {
        let digest = Sha256::digest(scenario.as_bytes());
        let first = digest.iter().take(8);
        let hash = first.fold(0_u64, |hash, byte| hash << 8 | u64::from(*byte));
        hash % u64::from(self.of) == u64::from(self.number - 1)
    }
}

impl std::fmt::Display for Shard {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl std::str::FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/');
        let parts = parts.and_then(|(n, of)| Some((n.parse().ok()?, of.parse().ok()?)));
        match parts {
            Some((number, of)) if (1..=of).contains(&number) => Ok(Self { number, of }),
            _ => {
                Err("a part and how many there are is needed, from 1/N to N/N, such as 2/8".into())
            }
        }
    }
}
