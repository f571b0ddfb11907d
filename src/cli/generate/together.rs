//! How many obstacles attack together, and which may.

use super::{GenerateArguments, SEARCH};
use nearmiss_drive::generation::MOST_ATTACKERS;
use nearmiss_settings::Config;

/// A number of attackers.
pub fn parse(word: &str) -> Result<usize, String> {
    match word.parse() {
        Ok(n) if (1..=MOST_ATTACKERS).contains(&n) => Ok(n),
        _ => Err(format!("expected a number from 1 to {MOST_ATTACKERS}")),
    }
}

/// The obstacles that may attack, each once: their order makes no difference.
pub fn named(ids: &[i64]) -> Vec<i64> {
    let mut ids = ids.to_vec();
    ids.sort_unstable();
    ids.dedup();
    ids
}

/// How many obstacles attack together at most.
///
/// # Errors
/// More than are named, or more than one where a language model writes the attack.
pub fn attackers(arguments: &GenerateArguments, config: &Config) -> Result<usize, String> {
    let ids = named(&arguments.attacker).len();
    if arguments.model != SEARCH {
        let several = match (arguments.attackers, ids) {
            (Some(n @ 2..), _) => format!("--attackers {n}"),
            (_, n @ 2..) => format!("--attacker with {n} ids"),
            // The configuration is about searches.
            _ => return Ok(1),
        };
        return Err(format!(
            "{several}: a language model writes the motion of one attacker; several attack with --model {SEARCH}"
        ));
    }
    match (arguments.attackers, ids) {
        (Some(n), ids) if ids > 0 && n > ids => Err(format!(
            "--attackers {n}: --attacker names {}; name at least {n}, or none",
            if ids == 1 {
                "1 obstacle".into()
            } else {
                format!("{ids} obstacles")
            }
        )),
        (Some(n), _) => Ok(n),
        (None, 0) => Ok(config.attackers.unwrap_or(1)),
        (None, ids) => Ok(ids.min(MOST_ATTACKERS)),
    }
}
