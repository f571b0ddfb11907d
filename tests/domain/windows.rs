//! Whether the questions of an evaluation are true, and give their answers away.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use crate::support;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use nearmiss::description::Frame;
use nearmiss::evaluation::batch::Experiment;
use nearmiss::evaluation::statistics::auc;
use nearmiss::evaluation::{Judge, Judges, SURFACE, leaks};
use nearmiss::formats::{EgoSelection, Entry, find};
use nearmiss::judge;
use nearmiss::metrics::{Encounter, Thresholds};
use nearmiss::planner::Cancel;
use nearmiss::prompts::{Library, Techniques};
use nearmiss::scenario::Scene;
use nearmiss::store::Store;
use nearmiss::verdict::Task;
use nearmiss::workflow::batch::BatchRequest;
use serde_json::Value;
use support::program::Home;

const LEADS: &str = "leads=0.2,0.5,1,1.5,2";

/// The questions of `evaluate … --dry-run=questions`.
fn questions(arguments: &[&str]) -> Vec<Value> {
    let mut all = vec!["evaluate"];
    all.extend(arguments);
    all.push("--dry-run=questions");
    let out = Home::new().run(&all);
    assert_eq!(out.status, Some(0), "{}", out.stderr);
    out.json_lines()
}

fn scene(entry: &Entry) -> Scene {
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    Scene::new(scenario, ego)
}

/// Ids of the obstacles that the ego touches from one step to another.
fn touched(scene: &Scene, steps: std::ops::RangeInclusive<i64>) -> Vec<i64> {
    let mut ids = Vec::new();
    for step in steps {
        for other in scene.participants() {
            let touch = Encounter::at(scene, &other, step).is_some_and(|e| e.distance() == 0.0);
            if touch && !ids.contains(&other.obstacle.id) {
                ids.push(other.obstacle.id);
            }
        }
    }
    ids
}

/// Every label is what the recording shows within two seconds, and every dangerous window has a safe one beside it.
fn are_true(questions: &[Value], entries: &[Entry]) {
    let scenes: BTreeMap<&str, Scene> = entries
        .iter()
        .map(|entry| (entry.name.as_str(), scene(entry)))
        .collect();
    let mut by_lead: BTreeMap<String, [u32; 2]> = BTreeMap::new();
    for question in questions {
        let scene = &scenes[question["scenario"].as_str().unwrap()];
        let (first, last) = (
            question["first_step"].as_i64().unwrap(),
            question["last_step"].as_i64().unwrap(),
        );
        let after = (2.0 / scene.scenario.dt()).round() as i64;
        let critical = touched(scene, last + 1..=last + after);
        let dangerous = question["label"] == "dangerous";
        assert_eq!(dangerous, !critical.is_empty(), "{question}");
        assert_eq!(
            serde_json::json!(critical),
            question["critical"],
            "{question}"
        );
        assert_eq!(
            touched(scene, first..=last),
            Vec::<i64>::new(),
            "{question}"
        );
        assert!(dangerous || last + after < scene.steps().end, "{question}");
        by_lead.entry(question["lead"].to_string()).or_default()[usize::from(dangerous)] += 1;
    }
    for (lead, [safe, dangerous]) in by_lead {
        assert!(
            dangerous > 0 && safe >= dangerous,
            "{lead}: {safe} safe, {dangerous} dangerous"
        );
    }
}

#[test]
fn bundled_questions_are_true_and_the_same_each_time() {
    let entries = nearmiss::formats::bundled();
    let names: Vec<&str> = entries.iter().map(|entry| entry.name.as_str()).collect();
    let mut arguments = names.clone();
    arguments.extend(["--set", "leads=0.5,1"]);
    let asked = questions(&arguments);
    are_true(&asked, &entries);
    let mut turned: Vec<&str> = names.into_iter().rev().collect();
    turned.extend(["--set", "leads=0.5,1"]);
    let key = |question: &Value| question.to_string();
    let (mut one, mut other): (Vec<String>, Vec<String>) = (
        asked.iter().map(key).collect(),
        questions(&turned).iter().map(key).collect(),
    );
    one.sort();
    other.sort();
    assert_eq!(one, other, "whatever the order of the scenarios");
}

/// A part of the surface of a question.
type Part = (&'static str, fn(&Value) -> f64);

#[test]
fn published_questions_are_true_and_give_nothing_away() {
    let Some(folder) = support::recorded::folder() else {
        return;
    };
    let path = folder.join("Scenarios").display().to_string();
    let asked = questions(&[&path, "--set", LEADS, "--truth", "auto"]);
    are_true(&asked, &find(&[folder.join("Scenarios")]).unwrap().entries);
    let surface: [Part; 4] = [
        ("position", |q| q["last_step"].as_f64().unwrap()),
        ("steps", |q| {
            (q["last_step"].as_i64().unwrap() - q["first_step"].as_i64().unwrap()) as f64
        }),
        ("obstacles", |q| q["obstacles"].as_f64().unwrap()),
        ("tokens", |q| q["tokens"].as_f64().unwrap()),
    ];
    for lead in LEADS["leads=".len()..].split(',').map(Some).chain([None]) {
        let lead: Option<f64> = lead.map(|lead| lead.parse().unwrap());
        let of = asked
            .iter()
            .filter(|q| lead.is_none_or(|lead| q["lead"] == lead));
        let of: Vec<&Value> = of.collect();
        for (name, value) in surface {
            let values: Vec<(f64, bool)> = of
                .iter()
                .map(|q| (value(q), q["label"] == "dangerous"))
                .collect();
            let area = auc(&values).unwrap();
            println!("lead {lead:?}, {name}: {area:.3}");
            assert!(
                (area - 0.5).abs() <= 0.05,
                "lead {lead:?}, {name}: {area:.3}"
            );
        }
    }
}

/// The workbench asks about every scenario that is marked: the windows that are left over may say little, too.
#[test]
fn where_every_published_scenario_is_asked_about_little_is_given_away() {
    let Some(folder) = support::recorded::folder() else {
        return;
    };
    let entries = find(&[folder.join("Scenarios")]).unwrap().entries;
    let scenarios = entries.len();
    let mut experiment = Experiment {
        tasks: vec![Task::Safety],
        frames: vec![Frame::Ego],
        techniques: vec![Techniques::ALL],
        models: vec![judge::MODEL.into()],
        every_scenario: true,
        ..Experiment::default()
    };
    experiment.draw_windows();
    let request = BatchRequest {
        experiment,
        entries,
        ego: EgoSelection::Beside,
        shard: None,
        drafts: BTreeMap::new(),
    };
    let thresholds = Arc::new(Thresholds::shipped().clone());
    let (library, cancel) = (Library::load(None), Cancel::default());
    let plan = request
        .plan(&library, &thresholds, &cancel, &mut |_| {})
        .unwrap()
        .unwrap();
    let judges = Judges::from([(judge::MODEL.to_string(), Judge::Reference)]);
    let store = Store::in_memory().unwrap();
    let dry_run = plan.dry_run(&judges, &store, &cancel, &mut |_| {});
    let items = dry_run.unwrap().unwrap().items;
    let asked: BTreeSet<&str> = items.iter().map(|item| item.scenario.as_str()).collect();
    assert_eq!(asked.len(), scenarios, "{:?}", plan.left_out);
    let all = &leaks(&items)[0];
    println!("{all:?}");
    // 30 dangerous and 38 safe windows: the 8 that are like no dangerous one have faster egos.
    for (area, (name, _)) in all.auc.iter().zip(SURFACE) {
        let (area, most) = (area.unwrap(), if name == "ego speed" { 0.15 } else { 0.1 });
        assert!((area - 0.5).abs() <= most, "{name}: {area:.3}");
    }
    assert!(all.model_auc.unwrap() <= 0.55, "{:?}", all.model_auc);
}

#[test]
fn a_lead_beyond_the_horizon_is_refused() {
    let arguments = [
        "evaluate",
        "ZAM_CutIn-1_1_T-1",
        "--set",
        "leads=3",
        "--dry-run=questions",
    ];
    let out = Home::new().run(&arguments);
    assert_eq!(out.status, Some(2), "{}", out.stderr);
    assert!(out.stderr.contains("within = 2 s"), "{}", out.stderr);
}
