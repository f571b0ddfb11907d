//! The token that clients over HTTP must show.

use sha2::{Digest, Sha256};

/// The variable that may hold it.
pub const VARIABLE: &str = "NEARMISS_MCP_TOKEN";

/// Fewest characters of a token.
const SHORTEST: usize = 16;

/// A token: that of the environment, or a random one that is printed.
pub struct Token {
    /// Two tokens take equally long to compare, whatever they have in common.
    hash: [u8; 32],
    /// The token itself, where it has to be printed.
    printed: Option<String>,
}

impl Token {
    /// The token of the environment, else a new one.
    ///
    /// # Errors
    /// In words: that of the environment is too short, or there are no random numbers.
    pub fn new(given: Option<&str>) -> Result<Self, String> {
        match given {
            Some(token) if token.len() >= SHORTEST => Ok(Self {
                hash: hash(token),
                printed: None,
            }),
            Some(_) => Err(format!(
                "{VARIABLE} is too short; use {SHORTEST} characters or more, or leave it out for a random token"
            )),
            None => random().map(|token| Self {
                hash: hash(&token),
                printed: Some(token),
            }),
        }
    }

    /// Whether a header `Authorization` shows it.
    pub fn is_in(&self, header: &str) -> bool {
        let mut words = header.splitn(2, ' ');
        let bearer = words
            .next()
            .is_some_and(|word| word.eq_ignore_ascii_case("bearer"));
        bearer && hash(words.next().unwrap_or_default().trim()) == self.hash
    }

    /// What clients have to send.
    pub fn words(&self) -> String {
        match &self.printed {
            Some(token) => {
                format!("nearmiss: clients send the header `Authorization: Bearer {token}`")
            }
            None => format!(
                "nearmiss: clients send the header `Authorization: Bearer …` with the token of {VARIABLE}"
            ),
        }
    }
}

fn hash(text: &str) -> [u8; 32] {
    Sha256::digest(text.as_bytes()).into()
}

/// 256 random bits in hexadecimal digits.
///
/// # Errors
/// In words: the system gives none.
pub fn random() -> Result<String, String> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes)
        .map_err(|why| format!("the system gives no random numbers: {why}"))?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_whole_token_is_taken() {
        let Ok(token) = Token::new(Some("0123456789abcdef")) else {
            panic!("long enough");
        };
        assert!(token.is_in("Bearer 0123456789abcdef") && token.is_in("bearer  0123456789abcdef"));
        for wrong in [
            "",
            "Bearer",
            "Bearer ",
            "0123456789abcdef",
            "Basic 0123456789abcdef",
            "Bearer 0123456789abcde",
        ] {
            assert!(!token.is_in(wrong), "{wrong}");
        }
        assert!(Token::new(Some("short")).is_err());
        assert!(Token::new(None).is_ok_and(|token| token.words().len() > 64));
        assert_ne!(random(), random());
    }
}
