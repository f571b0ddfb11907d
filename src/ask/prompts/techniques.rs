//! The paper's three prompting techniques, switched on and off separately.

use serde::{Deserialize, Serialize};
use strum::{IntoStaticStr, VariantArray};

/// Techniques a prompt uses.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Serialize, Deserialize,
)]
pub struct Techniques {
    /// Contextual prompting: definitions of the measures and their thresholds.
    pub cp: bool,
    /// Chain of thought: intermediate steps are asked for.
    pub cot: bool,
    /// In-context learning: worked examples.
    pub icl: bool,
}

impl Techniques {
    /// All three.
    pub const ALL: Self = Self {
        cp: true,
        cot: true,
        icl: true,
    };

    /// Reads `base`, `all`, or a list such as `cp,cot`.
    ///
    /// # Errors
    /// A word that is none of these.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut techniques = Self::default();
        for word in text.split([',', '+']).map(str::trim) {
            match word {
                "" | "base" | "none" => {}
                "all" => techniques = Self::ALL,
                "cp" => techniques.cp = true,
                "cot" => techniques.cot = true,
                "icl" => techniques.icl = true,
                _ => {
                    return Err(format!(
                        "unknown technique `{word}`; expected cp, cot, icl, base or all"
                    ));
                }
            }
        }
        Ok(techniques)
    }
}

impl std::fmt::Display for Techniques {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names = [(self.cp, "cp"), (self.cot, "cot"), (self.icl, "icl")];
        let on: Vec<&str> = names
            .iter()
            .filter(|(on, _)| *on)
            .map(|(_, name)| *name)
            .collect();
        f.write_str(
            if on.is_empty() {
                "base".to_string()
            } else {
                on.join("+")
            }
            .as_str(),
        )
    }
}

impl nearmiss_record::fields::Word for Techniques {
    fn of_word(word: &str) -> Result<Self, String> {
        Self::parse(word)
    }

    fn word(&self) -> String {
        self.to_string()
    }
}

/// A file that comes with the program.
#[derive(Debug, Clone, Copy)]
pub struct Shipped {
    /// File name.
    pub file: &'static str,
    /// Its text.
    pub source: &'static str,
}

/// Files of `prompts/`, by name.
macro_rules! shipped {
    ($($file:literal),+ $(,)?) => {
        &[$(Shipped {
            file: $file,
            source: include_str!(concat!("../../../prompts/", $file)),
        }),+]
    };
}

/// Every file, by name.
pub(super) const SHIPPED: &[Shipped] = shipped![
    "_answer.md",
    "_cartesian.md",
    "_critical.md",
    "_ego.md",
    "_horizon.md",
    "_metrics.md",
    "_paper-answer.md",
    "_paper-risk.md",
    "_picture.md",
    "_recording.md",
    "_risk.md",
    "_scene.md",
    "attacker-ego.md",
    "attacker-metrics.md",
    "attacker-picture.md",
    "collision-cartesian.md",
    "collision-ego.md",
    "collision-metrics.md",
    "collision-picture.md",
    "paper-collision-cartesian.md",
    "paper-collision-ego.md",
    "paper-safety-cartesian.md",
    "paper-safety-ego.md",
    "recording-ego.md",
    "recording-metrics.md",
    "safety-cartesian.md",
    "safety-ego.md",
    "safety-metrics.md",
    "safety-picture.md",
    "trajectory.md",
];

/// A set of templates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, IntoStaticStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Pack {
    /// The program's own way of asking.
    #[default]
    Standard,
    /// The way of "From Words to Collisions": its parts, thresholds and JSON keys.
    Paper,
}

nearmiss_record::named!(Pack, "pack");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_and_back() {
        assert_eq!(Techniques::parse("all"), Ok(Techniques::ALL));
        assert_eq!(
            Techniques::parse("cp, icl").map(|t| t.to_string()),
            Ok("cp+icl".into())
        );
        assert_eq!(
            Techniques::parse("base").map(|t| t.to_string()),
            Ok("base".into())
        );
        assert!(Techniques::parse("cpp").is_err());
    }
}
