//! Checks what the program stands in: the terminal, model providers with their keys and servers, and programs of planners.

use std::path::Path;

use nearmiss_ask::llm::{
    Environment, KeyState, ProviderStatus, Reachability, Registry, RegistryError, reach,
};
use nearmiss_base::system::{Terminal, is_program};
use nearmiss_scene::judge;
use nearmiss_settings::{Config, Folders};

use super::Finding;
use crate::Failure;

const AREA: &str = "terminal";

pub fn check_terminal(terminal: &Terminal) -> Vec<Finding> {
    let said = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    let mut found = vec![
        kind(said("TERM")),
        size(terminal),
        colours(terminal, &said),
        locale(terminal, &said),
    ];
    if terminal.size.is_some() {
        found.push(background(terminal));
    }
    found.push(Finding::ok(
        AREA,
        "mouse and clipboard (OSC 52) support cannot be detected; click in the workbench, or copy something with y, to test; `mouse = false` in config.toml leaves the mouse to the terminal",
    ));
    found
}

fn kind(term: Option<String>) -> Finding {
    match term.as_deref() {
        Some("dumb") => Finding::problem(
            AREA,
            "TERM is `dumb`: the terminal cannot move its cursor",
            "the workbench cannot open; commands work",
        ),
        Some(term) => Finding::ok(AREA, format!("TERM is `{term}`")),
        None if cfg!(windows) => Finding::ok(AREA, "TERM is not set, which is usual here"),
        None => Finding::warning(
            AREA,
            "TERM is not set",
            "set it as your terminal's manual says",
        ),
    }
}

fn size(terminal: &Terminal) -> Finding {
    let (columns, rows) = terminal.least;
    match terminal.size {
        Some((c, r)) if c < columns || r < rows => Finding::problem(
            AREA,
            format!("{c} columns and {r} rows"),
            format!(
                "the workbench needs {columns} and {rows}: make the window larger or the font smaller"
            ),
        ),
        Some((c, r)) => Finding::ok(AREA, format!("{c} columns and {r} rows")),
        None => Finding::warning(
            AREA,
            "standard output is not a terminal: size and background unknown",
            "run `nearmiss doctor` in the terminal you use",
        ),
    }
}

fn colours(terminal: &Terminal, said: &dyn Fn(&str) -> Option<String>) -> Finding {
    let why = ["NO_COLOR", "COLORTERM", "TERM"]
        .iter()
        .find_map(|name| Some(format!("{name} is `{}`", said(name)?)))
        .unwrap_or_else(|| "no further hints".into());
    match terminal.colours {
        "true" => Finding::ok(AREA, format!("all colours ({why})")),
        "none" if said("NO_COLOR").is_some() => {
            Finding::ok(AREA, format!("colours disabled ({why})"))
        }
        "none" => Finding::warning(
            AREA,
            format!("no colours ({why})"),
            "everything works without colours; if the terminal has colours, set TERM accordingly",
        ),
        few => Finding::warning(
            AREA,
            format!("{few} colours ({why})"),
            "theme colours are rounded; if the terminal supports true colour, set COLORTERM=truecolor",
        ),
    }
}

fn locale(terminal: &Terminal, said: &dyn Fn(&str) -> Option<String>) -> Finding {
    let locale = ["LC_ALL", "LC_CTYPE", "LANG"]
        .iter()
        .find_map(|name| Some(format!("{name} is `{}`", said(name)?)))
        .unwrap_or_else(|| "no locale is set".into());
    if terminal.unicode {
        Finding::ok(AREA, format!("Unicode ({locale})"))
    } else {
        Finding::warning(
            AREA,
            format!("ASCII only ({locale})"),
            "set LANG to a UTF-8 locale, or `glyphs = \"unicode\"` in config.toml if the font has Braille",
        )
    }
}

fn background(terminal: &Terminal) -> Finding {
    match terminal.dark {
        Some(true) => Finding::ok(AREA, "the background is dark"),
        Some(false) => Finding::ok(AREA, "the background is light"),
        None => Finding::warning(
            AREA,
            "unknown background, assumed dark",
            "set `theme = \"light\"` in config.toml if it is light",
        ),
    }
}

const MODELS: &str = "models";

pub fn check_models(
    folders: &Folders,
    config: &Config,
    online: bool,
) -> Result<Vec<Finding>, Failure> {
    let chosen = config.model.as_deref().unwrap_or(judge::MODEL);
    let registry = match Registry::new(&config.provider) {
        Ok(registry) => registry,
        Err(error) => {
            let todo = "fix it; until then built-in providers are not used";
            return Ok(vec![Finding::problem(MODELS, error.to_string(), todo)]);
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
        found.push(Finding::problem(MODELS, message, todo));
    }
    if let Err(error) = registry.resolve(chosen, &environment)
        && chosen != judge::MODEL
    {
        found.push(Finding::problem(
            MODELS,
            error.to_string(),
            "change `model` in config.toml",
        ));
    }
    found.push(Finding::ok(
        MODELS,
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
                Finding::warning(MODELS, words, format!("set {names} to ask it"))
            } else {
                Finding::ok(MODELS, words)
            };
        }
    };
    let words = |what: &str| format!("{place}: {key}; {what}");
    match &reached.reach {
        Reachability::Serves(models) => {
            Finding::ok(MODELS, words(&format!("reachable, lists {models} models")))
        }
        Reachability::Refused(status) => Finding::problem(
            MODELS,
            words(&format!("rejects the key (status {status})")),
            "get a new key, or remove this one",
        ),
        Reachability::Answers(None) => Finding::ok(MODELS, words("reachable, lists no models")),
        Reachability::Answers(Some(status)) => Finding::warning(
            MODELS,
            words(&format!("cannot list its models: status {status}")),
            "check the address and the status of the service",
        ),
        Reachability::Silent(_) if here && !chosen => {
            Finding::ok(MODELS, words("nothing runs there"))
        }
        Reachability::Silent(why) if here => Finding::warning(
            MODELS,
            words(&format!("not running ({why})")),
            "start the server before you ask its models",
        ),
        Reachability::Silent(why) => Finding::warning(
            MODELS,
            words(&format!("unreachable: {why}")),
            "check network, address and proxy",
        ),
        Reachability::Wrong(why) => {
            Finding::problem(MODELS, why.clone(), "fix the address or the key")
        }
        Reachability::NotAsked if online => Finding::ok(MODELS, words("not asked")),
        Reachability::NotAsked => Finding::ok(MODELS, words("not checked; use --online")),
    }
}

const PLANNERS: &str = "planners";

pub fn check_planners(config: &Config) -> Vec<Finding> {
    let planners = config.external_planners().into_iter();
    let all = planners.map(|(name, options)| {
        let program = options.command.first().map_or("", String::as_str);
        if is_program(program) {
            Finding::ok(
                PLANNERS,
                format!(
                    "{name}: {}; `nearmiss plan SCENARIO --planner {name}` starts it",
                    options.command.join(" ")
                ),
            )
        } else {
            Finding::problem(
                PLANNERS,
                format!("{name}: no program {program}"),
                format!("install it, or set `command` of [planner.{name}] to where it is"),
            )
        }
    });
    all.collect()
}

#[cfg(test)]
mod tests {

    use super::super::State;
    use super::*;

    fn terminal() -> Terminal {
        Terminal {
            size: Some((80, 24)),
            least: (80, 24),
            colours: "true",
            unicode: true,
            dark: Some(true),
        }
    }

    #[test]
    fn what_does_not_do_is_said() {
        let none = |_: &str| None;
        assert_eq!(size(&terminal()).state, State::Ok);
        let small = Terminal {
            size: Some((79, 24)),
            ..terminal()
        };
        assert_eq!(size(&small).state, State::Problem);
        assert_eq!(kind(Some("dumb".into())).state, State::Problem);
        let few = Terminal {
            colours: "16",
            unicode: false,
            dark: None,
            ..terminal()
        };
        assert_eq!(colours(&few, &none).state, State::Warning);
        assert_eq!(locale(&few, &none).state, State::Warning);
        assert_eq!(background(&few).state, State::Warning);
        let wished = Terminal {
            colours: "none",
            ..terminal()
        };
        let no_color = |name: &str| (name == "NO_COLOR").then(|| "1".to_string());
        assert_eq!(colours(&wished, &no_color).state, State::Ok);
    }

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
