//! Tests of which manifests are trusted, and for which scenario.
#![allow(clippy::unwrap_used)]

use serde_json::json;

use super::*;

const XML: &[u8] = b"<commonRoad/>";

/// The settings of all papers here, as versions wrote them that knew no style; the last digit of the number is one that a
/// file may lose.
fn written() -> Value {
    json!({"problem": 1, "survive": 0.5, "planning": {"margin": 0.1 + 0.2}})
}

/// The same as they are asked for.
fn settings() -> Value {
    let mut settings = written();
    settings["planning"]["rules"] = "off".into();
    settings["style"] = "limit".into();
    settings["attackers"] = 1.into();
    settings["attacker"] = json!([]);
    settings
}

fn line(scenario: &str) -> Value {
    json!({
        "variant": null, "ego": null, "attacker": 7, "outcome": "near_miss", "min_risk_before": 4, "min_risk_after": 1,
        "avoidable": {"0.0": true, "0.5": false}, "candidates": 9, "rejected": null, "scenario": scenario,
        "file": "elsewhere.xml", "id": null, "manoeuvre": "cut-in", "note": null, "safe_before": true, "drive": "goal",
        "refused": {"jerk": 2}, "taken_over": false, "model": null, "seconds": 1.5,
    })
}

fn papers(id: &str, scenario: &str) -> Value {
    json!({
        "variant": format!("{id}.xml"), "ego": format!("{id}.csv"), "benchmark_id": id,
        "sha256": {
            format!("{id}.xml"): ContentHash::digest(XML).to_string(),
            format!("{id}.csv"): ContentHash::digest(b"step").to_string(),
        },
        "original": {"sha256": ContentHash::digest(b"original").to_string()},
        "rejected": [{"reason": "jerk"}], "made": {"settings": written(), "line": line(scenario)},
    })
}

fn lay(folder: &Path, id: &str, papers: &Value) {
    std::fs::write(folder.join(format!("{id}.xml")), XML).unwrap();
    std::fs::write(folder.join(format!("{id}.csv")), "step").unwrap();
    std::fs::write(folder.join(format!("{id}.json")), papers.to_string()).unwrap();
}

fn entry(name: &str) -> Entry {
    Entry::of_file(Path::new(&format!("here/{name}.xml")))
}

#[test]
fn what_an_earlier_version_found_by_default_is_taken_over() {
    let search = |candidates: usize, rounds: usize| json!({"search": {"candidates": candidates, "rounds": rounds, "drives": 8, "attackers": 6, "seed": 1}});
    let apart = |then: &Value, now: &Value| {
        let mut found = Vec::new();
        differences("", then, now, &mut found);
        found
    };
    let today = nearmiss_drive::generation::Effort::default().candidates;
    let nothing: [String; 0] = [];
    assert_eq!(apart(&search(600, 12), &search(today, 14)), nothing);
    for before in [1500, 3000] {
        assert_eq!(apart(&search(before, 14), &search(today, 14)), nothing);
    }
    assert_eq!(apart(&search(600, 12), &search(600, 14)), nothing);
    assert_eq!(apart(&search(90, 12), &search(90, 14)), nothing);
    let other = format!("search.candidates 90, now {today}");
    assert_eq!(apart(&search(90, 12), &search(today, 14)), [other]);
    assert_eq!(apart(&search(today, 14), &search(600, 14)).len(), 1);
}

#[test]
fn a_variant_of_the_same_content_made_with_the_same_settings_is_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    lay(folder.path(), "A_T-2", &papers("A_T-2", "other"));
    lay(folder.path(), "A_T-3", &papers("A_T-3", "mine"));
    let report = json!({"scenarios": 2, "asked_for": 2});
    std::fs::write(folder.path().join("report.json"), report.to_string()).unwrap();
    let (past, doubts) = EarlierRun::read(folder.path()).unwrap();
    assert_eq!(doubts, Vec::<String>::new());
    let original = ContentHash::digest(b"original");
    let of = |name: &str| past.line_for(&entry(name), &original, &settings()).unwrap();
    let mine = of("mine");
    assert_eq!(mine.figures.id.as_deref(), Some("A_T-3"));
    assert!(mine.figures.taken_over && mine.document["taken_over"] == true);
    assert_eq!(mine.document["rejected"], json!([{"reason": "jerk"}]));
    assert_eq!(mine.document["file"], "here/mine.xml");
    let variant = folder.path().join("A_T-3.xml");
    assert_eq!(mine.document["variant"], variant.to_str().unwrap());
    // The content counts, and the name only chooses among several.
    let third = of("third");
    assert_eq!(third.figures.id.as_deref(), Some("A_T-2"));
    assert_eq!(third.document["scenario"], "third");
    let changed = ContentHash::digest(b"another original");
    assert!(
        past.line_for(&entry("mine"), &changed, &settings())
            .is_none()
    );
    let others = [
        ("survive", json!(1.0)),
        ("style", json!("human")),
        ("attackers", json!(2)),
        ("attacker", json!([7])),
    ];
    for (key, other) in others {
        let mut others = settings();
        others[key] = other;
        assert!(past.line_for(&entry("mine"), &original, &others).is_none());
    }
}

#[test]
fn an_attacker_that_an_older_version_named_is_the_only_one() {
    let mut old = written();
    old["attacker"] = 7.into();
    let mut today = settings();
    today["attacker"] = json!([7]);
    assert_eq!(as_today(old), today);
    assert_eq!(as_today(today.clone()), today);
}

#[test]
fn what_cannot_be_trusted_is_named_with_the_reason() {
    let of = |spoil: &dyn Fn(&Path, &mut Value)| {
        let folder = tempfile::tempdir().unwrap();
        let mut said = papers("A", "a");
        lay(folder.path(), "A", &said);
        spoil(folder.path(), &mut said);
        std::fs::write(folder.path().join("A.json"), said.to_string()).unwrap();
        let (past, doubts) = EarlierRun::read(folder.path()).unwrap();
        assert!(past.papers.is_empty());
        let [doubt] = &doubts[..] else {
            panic!("{doubts:?}")
        };
        assert!(doubt.contains("A.json: not reused: "), "{doubt}");
        doubt.clone()
    };
    let no_settings = of(&|_, said| said["made"] = Value::Null);
    assert!(no_settings.contains("its settings are missing"));
    let missing = of(&|folder, _| std::fs::remove_file(folder.join("A.xml")).unwrap());
    assert!(missing.contains("A.xml: "), "{missing}");
    let changed = of(&|folder, _| std::fs::write(folder.join("A.xml"), "<other/>").unwrap());
    assert!(changed.contains("changed after generation"));
    let no_ego = of(&|folder, _| std::fs::remove_file(folder.join("A.csv")).unwrap());
    assert!(no_ego.contains("A.csv: "), "{no_ego}");
    let other_ego = of(&|folder, _| std::fs::write(folder.join("A.csv"), "steps").unwrap());
    assert!(
        other_ego.contains("A.csv: it was changed after generation"),
        "{other_ego}"
    );
    let no_way_out = of(&|_, said| said["sha256"]["A.avoid-0.5.csv"] = "0123".into());
    assert!(no_way_out.contains("A.avoid-0.5.csv: "), "{no_way_out}");
    let no_hash = of(&|_, said| said["sha256"] = json!({}));
    assert!(no_hash.contains("sha256 lacks its files"));
    let away = of(&|_, said| said["variant"] = "../A.xml".into());
    assert!(away.contains("not a file name"));
    let odd = of(&|_, said| said["made"]["line"]["outcome"] = "splendid".into());
    assert!(odd.contains("not a manifest") && odd.contains("splendid"));
    let stopped = of(&|_, said| {
        said["made"]["line"]["model"] = json!({
            "requests": 1, "input_tokens": 1, "output_tokens": 1, "cost_usd": 0.1, "unpriced": 0,
            "stopped": "the budget is used up",
        });
    });
    assert!(stopped.contains("the budget is used up"));
}

#[test]
fn a_file_that_is_no_papers_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("half.json"), "{\"variant\": ").unwrap();
    std::fs::write(folder.path().join("list.json"), "[1, 2]").unwrap();
    std::fs::write(folder.path().join("notes.txt"), "nothing").unwrap();
    let (_, doubts) = EarlierRun::read(folder.path()).unwrap();
    assert_eq!(doubts.len(), 2, "{doubts:?}");
    assert!(doubts.iter().all(|doubt| doubt.contains("not a manifest")));
    assert!(is_report(&folder.path().join("half.json")).is_err());
}

#[test]
fn a_models_variant_of_a_version_without_votes_is_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    let mut old = papers("A_T-2", "mine");
    let model = json!({"id": "lab/tiny", "samples": 5, "retries": 2, "obey": false});
    old["made"]["settings"]["model"] = model;
    // As such a version wrote it.
    old["made"]["line"]["model"] = json!({
        "attacker_by": "model", "requests": 7, "from_store": 0, "input_tokens": 10, "output_tokens": 5,
        "cost_usd": 0.1, "unpriced": 0, "stopped": null,
    });
    lay(folder.path(), "A_T-2", &old);
    let (past, doubts) = EarlierRun::read(folder.path()).unwrap();
    assert_eq!(doubts, Vec::<String>::new());
    let original = ContentHash::digest(b"original");
    let mut wanted = settings();
    wanted["model"] = json!({
        "id": "lab/tiny", "obey": false,
        "method": {
            "votes": 1, "within": 30.0, "samples": 5, "retries": 2, "feedback": false, "grades": false,
            "rank": "exact",
        },
    });
    let line = past.line_for(&entry("mine"), &original, &wanted).unwrap();
    let consumed = line.figures.model.unwrap();
    assert!(consumed.requests == 7 && consumed.tries.is_none() && consumed.agreement.is_none());
    // With votes it is another way of asking.
    wanted["model"]["method"]["votes"] = 3.into();
    assert!(past.line_for(&entry("mine"), &original, &wanted).is_none());
    let why = past.why_not(&original, &wanted).unwrap();
    assert_eq!(
        why,
        "variant A_T-2 is not reused, its settings differ: model.method.votes 1, now 3; a new one is generated; with the options of that run it is reused"
    );
    wanted["model"]["templates"] = json!({"trajectory.md": "abc"});
    let why = past.why_not(&original, &wanted).unwrap();
    assert!(why.contains("model.templates, another version"), "{why}");
    assert!(
        why.ends_with("keep it as it is in another folder, or drop it"),
        "{why}"
    );
    assert_eq!(past.why_not(&ContentHash::digest(b"new"), &wanted), None);
}
