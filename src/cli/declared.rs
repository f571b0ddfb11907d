//! Options that declare which comparisons matter, shared by `report` and `evaluate`.

use std::collections::BTreeSet;

use super::Failure;
use nearmiss_study::evaluation::PromptConfig;
use nearmiss_study::evaluation::report::{Comparison, configuration_name};

/// Declared comparisons.
#[derive(Debug, Clone, clap::Args)]
pub struct Declared {
    /// The model or prompt configuration that all others are compared with, as tables name it (`lab/model`, or
    /// `ego · cp · lab/model`): only these comparisons are made, and corrected together.
    #[arg(long, value_name = "NAME")]
    baseline: Option<String>,
    /// The comparison that matters, as two names: it is not corrected for the others.
    #[arg(long, value_name = "A,B", value_parser = two_names)]
    compare: Option<(String, String)>,
}

/// Two names, separated by a comma.
fn two_names(text: &str) -> Result<(String, String), String> {
    let names = text.split_once(',').map(|(a, b)| (a.trim(), b.trim()));
    match names {
        Some((a, b)) if !a.is_empty() && !b.is_empty() && a != b => Ok((a.into(), b.into())),
        _ => Err("write two different names, separated by a comma".into()),
    }
}

impl Declared {
    /// Whether there are any.
    pub fn any(&self) -> bool {
        self.baseline.is_some() || self.compare.is_some()
    }

    /// The comparisons between ways that there are.
    pub fn comparison(&self, ways: &[&PromptConfig]) -> Result<Comparison, Failure> {
        let comparison = Comparison {
            baseline: self.baseline.clone(),
            primary: self.compare.clone(),
        };
        let Some(name) = comparison
            .unknown(ways)
            .first()
            .map(|name| (*name).to_string())
        else {
            return Ok(comparison);
        };
        let models: BTreeSet<&str> = ways.iter().map(|way| way.model.as_str()).collect();
        let models: Vec<&str> = models.into_iter().collect();
        let example = ways.iter().find(|way| way.frame.is_some()).or(ways.first());
        Err(Failure::input(format!(
            "{name}: no such model or prompt configuration; the models are {}; a prompt configuration is called as in \
             tables, such as `{}`",
            models.join(", "),
            example
                .map(|way| configuration_name(way))
                .unwrap_or_default()
        )))
    }
}
