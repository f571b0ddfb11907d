//! Tests of proposals and scores, on the bundled scenarios.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::sync::Arc;

use super::candidate::{Candidate, check};
use super::prepare::{TunePlan, tune_request};
use super::*;
use crate::batch::BatchModels;
use crate::{ExperimentContext, find_scenarios, read_experiment};
use nearmiss_ask::llm::Environment;
use nearmiss_ask::prompts::{Library, Template};
use nearmiss_drive::planner::Cancel;
use nearmiss_scene::metrics::Thresholds;
use nearmiss_store::Store;
use nearmiss_study::evaluation::validate;

const TEXT: &str = r#"
scenarios = ["ZAM_HardBraking-1_1_T-1", "ZAM_CutIn-1_1_T-1", "ZAM_RedLight-1_1_T-1", "ZAM_Overtaking-1_1_T-1",
    "ZAM_Pedestrian-1_1_T-1", "ZAM_Merge-1_1_T-1", "ZAM_RightTurn-1_1_T-1", "ZAM_JamTail-1_1_T-1"]
models = ["local/default"]
tasks = ["collision"]
split = { test = 0.2, seed = 6 }
"#;

fn plan() -> TunePlan {
    let folder = tempfile::tempdir().unwrap();
    let store = Store::open(&folder.path().join("runs.sqlite")).unwrap();
    let library = validate(Library::load(None));
    let thresholds = Arc::new(Thresholds::shipped().clone());
    let context = ExperimentContext {
        library: &library,
        thresholds: &thresholds,
        store: &store,
    };
    let file = Path::new("e.toml");
    let experiment = read_experiment(TEXT, file, &library).unwrap();
    let found = find_scenarios(&experiment).unwrap().entries;
    let request = tune_request(&experiment, file, found, context).unwrap();
    assert_eq!(request.test_scenarios, 1);
    let batch = request
        .plan(context, &Cancel::default(), &mut |_| {})
        .unwrap()
        .unwrap();
    let models = BatchModels {
        providers: &toml::Table::new(),
        config_file: file,
        environment: Environment::from_lookup(|_| None),
        budget: None,
        concurrency: None,
        today: jiff::civil::date(2026, 1, 1),
    };
    let judges = models
        .judges(&batch.models(), &batch.spec, &mut |_| {})
        .unwrap();
    let dry_run = batch.dry_run(&judges, &store, &Cancel::default(), &mut |_| {});
    TunePlan::new(&batch, &dry_run.unwrap().unwrap(), &library, 1).unwrap()
}

fn base(plan: &TunePlan) -> Candidate {
    Candidate {
        number: 0,
        parent: None,
        round: 0,
        change: String::new(),
        diagnosis: String::new(),
        source: plan.template.source.clone(),
        hash: plan.hash.clone(),
        score: Score::default(),
        on_front: true,
        gain: None,
    }
}

#[test]
fn a_proposal_keeps_what_the_answer_needs_and_copies_nothing() {
    let plan = plan();
    assert!(plan.scenarios.len() >= 4, "{:?}", plan.scenarios);
    assert!(!plan.scenarios.contains(&"ZAM_Overtaking-1_1_T-1".into()));
    let base = base(&plan);
    let text = plan.template.body().to_string();
    let checked = |text: &str| check(&plan, text, &base, std::slice::from_ref(&base));
    let why = |text: &str| checked(text).err().unwrap_or_default();
    let with = |words: &str| {
        text.replacen(
            "{% block user -%}",
            &format!("{{% block user -%}}\n{words}"),
            1,
        )
    };
    assert_ne!(with("x"), text);
    for (proposal, refused) in [
        (text.clone(), "it is the base template"),
        (with("{% if %}"), "collision-ego.md:"),
        (with("{{ speed_of_light }}"), "it cannot be filled"),
        (
            text.replace("{% block user", "{% block users"),
            "no `{% block user %}`",
        ),
        (
            text.replace("{{ description }}", ""),
            "keep {{ description }}",
        ),
        (
            text.replace("{% include \"_answer.md\" %}", ""),
            "does not include \"_answer.md\"",
        ),
        (with("This is {{ scenario }}."), "name of the scenario"),
        (
            with(&format!("As in {}.", plan.scenarios[0])),
            "names a scenario",
        ),
        (with("Mind car 301."), "names obstacle 301"),
    ] {
        assert!(
            why(&proposal).contains(refused),
            "{refused}: {}",
            why(&proposal)
        );
    }
    let described = &plan.questions[0].question.description;
    let copied: Vec<&str> = described.lines().rev().take(3).collect();
    assert!(
        why(&with(&copied.join("\n"))).starts_with("it "),
        "{copied:?}"
    );
    // With front matter or without, that of the base stays.
    let better = with("Look twice at gaps below 2.50 m.");
    let made = checked(&better).unwrap_or_else(|why| panic!("{why}"));
    let other = plan
        .template
        .source
        .replace("frame = \"ego\"", "frame = \"cartesian\"");
    let other = Template::read(&other).unwrap().with_body(&better);
    let again = checked(&other).unwrap_or_else(|why| panic!("{why}"));
    assert_eq!(made.source, again.source);
    assert!(made.source.contains("frame = \"ego\""));
    assert_eq!(made.questions.len(), plan.questions.len());
    for (question, before) in made.questions.iter().zip(&plan.questions) {
        assert!(question.prompt.user.contains("Look twice"));
        assert_eq!(question.template_hash, made.hash);
        assert_eq!(question.description, before.question.description);
    }
}
