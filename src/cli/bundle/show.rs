//! `nearmiss runs import BUNDLE --dry-run`: what is in a bundle.

use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::super::output::{self, counted};
use super::super::{Failure, Outcome, json, time};
use nearmiss_workflow::{Manifest, read_manifest};

/// The manifest of a bundle.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(transparent)]
pub struct Document(Manifest);

impl json::Output for Document {
    const NAME: &'static str = "runs-import-dry-run";
    const TITLE: &'static str =
        "`runs import BUNDLE --dry-run --format json`: the manifest of a bundle";
}

/// Checks a bundle, and prints what is in it.
pub fn show(file: &Path, format: output::FormatOption) -> Outcome {
    let manifest = read_manifest(file).map_err(Failure::input)?;
    if format.is_json() {
        return output::document(&Document(manifest));
    }
    output::text(&output::visible(&words(&manifest)))
}

fn words(manifest: &Manifest) -> String {
    let included = manifest.scenarios.iter().filter(|one| one.included).count();
    let mut text = format!(
        "packed {}, format {}\n{}\n{}, {}, {}, {} ({included} included)\n\n",
        time::local(manifest.created_ms),
        manifest.nearmiss_bundle,
        manifest.provenance.summary(),
        counted(manifest.questions as usize, "question"),
        counted(manifest.runs as usize, "run"),
        counted(manifest.ratings as usize, "rating"),
        counted(manifest.scenarios.len(), "scenario"),
    );
    for member in &manifest.members {
        let start = member.sha256.get(..12).unwrap_or_default();
        text += &format!("{start} {:>10}  {}\n", member.bytes, member.name);
    }
    text
}
