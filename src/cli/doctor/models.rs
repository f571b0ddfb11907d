//! Checks model providers: keys, servers on this machine, and on request whether others are reachable.

use std::path::Path;

use super::Finding;
use crate::Failure;
use nearmiss_ask::llm::{
    Environment, KeyState, ProviderStatus, Reachability, Registry, RegistryError, reach,
};
use nearmiss_scene::judge;
use nearmiss_settings::{Config, Folders};

const AREA: &str = "models";

pub fn look(folders: &Folders, config: &Config, online: bool) -> Result<Vec<Finding>, Failure> {
    let chosen = config.model.as_deref().unwrap_or(judge::MODEL);
    let registry = match Registry::new(&config.provider) {
        Ok(registry) => registry,
        Err(error) => {
            let todo = "fix it; until then built-in providers are not used";
            return Ok(vec![Finding::problem(AREA, error.to_string(), todo)]);
        }
    };
    let environment = Environment::with_files(&[Path::new("."), &folders.config]);
    let mut found: Vec<Finding> = environment
        .problems
        .iter()
        .map(|problem| Finding::problem("keys", problem, "fix that line"))
        .collect();
    if let Err(RegistryError::Prices { message }) =
        registry.clone().lay_prices(&folders.config_file())
    {
        let todo = "write it anew with `nearmiss models --update`, or delete it";
        found.push(Finding::problem(AREA, message, todo));
    }
    if let Err(error) = registry.resolve(chosen, &environment)
        && chosen != judge::MODEL
    {
        found.push(Finding::problem(
            AREA,
            error.to_string(),
            "change `model` in config.toml",
        ));
    }
    found.push(Finding::ok(
        AREA,
        format!("{}: built in, needs nothing", judge::MODEL),
    ));
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(Failure::input)?;
    let reached = runtime.block_on(reach(&registry, &environment, online));
    let provider = chosen.split('/').next();
    let lines = reached.iter();
    found.extend(lines.map(|reached| line(reached, provider == Some(&reached.provider), online)));
    Ok(found)
}

/// What is to be said of a provider; more where its model is asked first.
fn line(reached: &ProviderStatus, chosen: bool, online: bool) -> Finding {
    let (place, here) = (&reached.place, reached.here);
    let wanted = chosen || reached.key_wanted;
    let key = match &reached.key {
        KeyState::NotNeeded => "no key needed".to_string(),
        KeyState::Present(source) => format!("key in {source}"),
        KeyState::Command(command) => format!("key from {command} (not run)"),
        KeyState::Missing(names) => {
            let words = format!("{place}: no key in {names}");
            return if wanted {
                Finding::warning(AREA, words, format!("set {names} to ask it"))
            } else {
                Finding::ok(AREA, words)
            };
        }
    };
    let words = |what: &str| format!("{place}: {key}; {what}");
    match &reached.reach {
        Reachability::Serves(models) => {
            Finding::ok(AREA, words(&format!("reachable, lists {models} models")))
        }
        Reachability::Refused(status) => Finding::problem(
            AREA,
            words(&format!("rejects the key (status {status})")),
            "get a new key, or remove this one",
        ),
        Reachability::Answers(None) => Finding::ok(AREA, words("reachable, lists no models")),
        Reachability::Answers(Some(status)) => Finding::warning(
            AREA,
            words(&format!("cannot list its models: status {status}")),
            "check the address and the status of the service",
        ),
        Reachability::Silent(_) if here && !chosen => {
            Finding::ok(AREA, words("nothing runs there"))
        }
        Reachability::Silent(why) if here => Finding::warning(
            AREA,
            words(&format!("not running ({why})")),
            "start the server before you ask its models",
        ),
        Reachability::Silent(why) => Finding::warning(
            AREA,
            words(&format!("unreachable: {why}")),
            "check network, address and proxy",
        ),
        Reachability::Wrong(why) => {
            Finding::problem(AREA, why.clone(), "fix the address or the key")
        }
        Reachability::NotAsked if online => Finding::ok(AREA, words("not asked")),
        Reachability::NotAsked => Finding::ok(AREA, words("not checked; use --online")),
    }
}

#[cfg(test)]
mod tests {
    use super::super::State;
    use super::*;

    #[test]
    fn what_is_asked_first_is_missed_and_the_rest_is_not() {
        let reached = |key: KeyState, here: bool, reach: Reachability| ProviderStatus {
            provider: "lab".into(),
            place: "lab (http://x)".into(),
            here,
            key,
            key_wanted: false,
            reach,
        };
        let missing = reached(
            KeyState::Missing("LAB_KEY".into()),
            false,
            Reachability::NotAsked,
        );
        let silent = reached(
            KeyState::NotNeeded,
            true,
            Reachability::Silent("refused".into()),
        );
        for one in [&missing, &silent] {
            assert_eq!(line(one, false, false).state, State::Ok);
            assert_eq!(line(one, true, false).state, State::Warning);
        }
        let key = || KeyState::Present("LAB_KEY".into());
        let refused = reached(key(), false, Reachability::Refused(401));
        assert_eq!(line(&refused, false, true).state, State::Problem);
        let serves = reached(key(), false, Reachability::Serves(3));
        let said = line(&serves, false, true).line();
        assert!(
            said.contains("key in LAB_KEY") && said.contains("3 models"),
            "{said}"
        );
    }
}
