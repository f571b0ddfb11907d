//! The cost limit of an answer and its source: `--budget`, else `budget` in `config.toml`.

use crate::Failure;
use nearmiss_base::system::KeyLines;
use nearmiss_settings::{Config, Folders, TextFile};
use nearmiss_study::evaluation::AskError;

/// The most that an answer may cost.
pub struct Bound {
    /// US dollars.
    pub usd: f64,
    /// Where the configuration says it; `None` if the command line does.
    said: Option<String>,
}

/// The bound that holds, if there is one: the option wins.
pub fn resolve(option: Option<f64>, config: &Config, folders: &Folders) -> Option<Bound> {
    if let Some(usd) = option {
        return Some(Bound { usd, said: None });
    }
    let (usd, path) = (config.budget?, folders.config_file());
    // It was read a moment ago; where it is gone by now, its name says enough.
    let text = TextFile::read_if_there(&path).ok().flatten();
    let line = text.and_then(|file| KeyLines::new(&file.text).line(&["budget"]));
    let line = line.map_or(String::new(), |line| format!(":{line}"));
    let said = Some(format!("{}{line}: budget = {usd}", path.display()));
    Some(Bound { usd, said })
}

/// Why nothing was asked; of money, where the bound is from and what to do about it here.
pub fn refused(error: AskError, bound: Option<&Bound>) -> Failure {
    let said = bound.and_then(|bound| bound.said.as_ref());
    match (&error, said) {
        (AskError::OverBudget(_), Some(said)) => Failure::input(format!(
            "{error} (the budget is that of {said}; --budget USD sets another for this answer, --set max_tokens=N a limit)"
        )),
        _ => Failure::input(error),
    }
}
