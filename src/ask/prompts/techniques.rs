//! The paper's three prompting techniques, switched on and off separately.

use serde::{Deserialize, Serialize};

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
