//! Declared comparisons: the one that matters, and the baseline that others are compared with.

use schemars::JsonSchema;
use serde::Serialize;

use super::super::PromptConfig;
use super::names;
use nearmiss_record::fields::Fields;
use nearmiss_scene::judge;

/// Which comparisons a report makes. Names are models, or ways as tables name them: `ego · cp+cot · lab/model`, with the
/// version of the template or without.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Comparison {
    /// What all others are compared with; `None` for every pair that differs in one thing.
    pub baseline: Option<String>,
    /// The two whose comparison was declared to be the one that matters.
    pub primary: Option<(String, String)>,
}

/// Comparisons that are corrected together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    /// The declared one; several where two models were declared that were asked in several ways.
    Declared,
    /// Those with the baseline.
    Baseline,
    /// Every pair that differs in one thing.
    Pairs,
}

impl Family {
    /// Every one, in the order of tables.
    pub const ALL: [Self; 3] = [Self::Declared, Self::Baseline, Self::Pairs];

    /// The word for it in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Declared => "declared",
            Self::Baseline => "baseline",
            Self::Pairs => "pairs",
        }
    }
}

/// A pair to be compared, in its order.
pub(super) struct Compared {
    pub family: Family,
    /// Whether the second of the two stands first.
    pub turned: bool,
    /// In what they differ.
    pub differs: &'static str,
}

impl Comparison {
    /// The same in words: the baseline, and the comparison that matters; `None` without either.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        let baseline = self
            .baseline
            .as_ref()
            .map(|name| format!("the baseline {name}"));
        let primary = self
            .primary
            .as_ref()
            .map(|(a, b)| format!("the comparison of {a} with {b}"));
        let parts: Vec<String> = baseline.into_iter().chain(primary).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// The names that none of these ways has.
    pub fn unknown<'a>(&'a self, ways: &[&PromptConfig]) -> Vec<&'a str> {
        let primary = self.primary.iter().flat_map(|(a, b)| [a, b]);
        let all = primary.chain(&self.baseline).map(String::as_str);
        all.filter(|name| !ways.iter().any(|way| is_called(way, name)))
            .collect()
    }

    /// Whether two ways are compared, and as what.
    pub(super) fn of(&self, a: &PromptConfig, b: &PromptConfig) -> Option<Compared> {
        if a.task != b.task {
            return None;
        }
        let compared = |family, turned, differs| Compared {
            family,
            turned,
            differs,
        };
        if let Some((first, second)) = &self.primary {
            let fits = |a, b| is_called(a, first) && is_called(b, second);
            // Of models those that are asked in the same way; ways may differ in more than one thing.
            let models =
                *first == a.model && *second == b.model || *first == b.model && *second == a.model;
            let differs = if models {
                comparable(a, b)
            } else {
                Some(comparable(a, b).unwrap_or("several"))
            };
            if let Some(differs) = differs {
                if fits(a, b) {
                    return Some(compared(Family::Declared, false, differs));
                }
                if fits(b, a) {
                    return Some(compared(Family::Declared, true, differs));
                }
            }
        }
        let Some(baseline) = &self.baseline else {
            return Some(compared(Family::Pairs, false, difference(a, b)?));
        };
        let differs = comparable(a, b)?;
        match (is_called(a, baseline), is_called(b, baseline)) {
            (true, false) => Some(compared(Family::Baseline, true, differs)),
            (false, true) => Some(compared(Family::Baseline, false, differs)),
            _ => None,
        }
    }
}

/// Whether tables call a way by this name: its model, or the whole way, with the version of the template or without.
pub(crate) fn is_called(way: &PromptConfig, name: &str) -> bool {
    let bare = PromptConfig {
        template: None,
        ..way.clone()
    };
    way.model == name || names::way(way) == name || names::way(&bare) == name
}

/// The one thing in which two ways differ. The built-in judge, which has no prompt, differs from all others in the
/// model.
fn comparable(a: &PromptConfig, b: &PromptConfig) -> Option<&'static str> {
    let is_judge = |way: &PromptConfig| way.model == judge::MODEL;
    if is_judge(a) != is_judge(b) {
        Some("model")
    } else {
        difference(a, b)
    }
}

fn difference(a: &PromptConfig, b: &PromptConfig) -> Option<&'static str> {
    // A judge without a prompt differs from the others in frame and techniques at once.
    if a.task != b.task || a.frame.is_some() != b.frame.is_some() {
        return None;
    }
    let axes = a.settings.differences(&b.settings);
    let mut differ = [
        (a.frame != b.frame, "frame"),
        (a.techniques != b.techniques, "techniques"),
        (a.model != b.model, "model"),
        (a.template != b.template, "template"),
    ]
    .into_iter()
    .filter(|(differs, _)| *differs)
    .map(|(_, name)| name)
    .chain(axes);
    let name = differ.next()?;
    differ.next().is_none().then_some(name)
}
