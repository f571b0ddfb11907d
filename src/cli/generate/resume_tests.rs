//! Tests of which manifests are trusted, and for which scenario.
#![allow(clippy::unwrap_used)]

use serde_json::json;

use super::*;
use nearmiss_drive::generation::RefusalRecord;
use nearmiss_study::evaluation::generating::AuthoredRecord;

use nearmiss_workflow::variant::SearchSettings;

const XML: &[u8] = b"<commonRoad/>";

/// The settings of all variants here; the last digit of the number is one that a file may lose.
fn settings() -> GenerationSettings {
    GenerationSettings {
        problem: 1,
        planning: [("margin".to_string(), json!(0.1 + 0.2))].into(),
        attackers: 1,
        survive: 0.5,
        style: "limit".into(),
        ..GenerationSettings::default()
    }
}

fn line(scenario: &str) -> VariantLine {
    VariantLine {
        scenario: scenario.into(),
        file: "elsewhere.xml".into(),
        attacker: Some(7),
        outcome: OutcomeName::NearMiss,
        ..VariantLine::default()
    }
}

fn manifest(id: &str, scenario: &str) -> Value {
    let hashes = [(format!("{id}.xml"), XML), (format!("{id}.csv"), b"step")];
    let hashes = hashes.map(|(name, bytes)| (name, ContentHash::digest(bytes).to_string()));
    let mut manifest = Manifest {
        variant: format!("{id}.xml"),
        ego: format!("{id}.csv"),
        benchmark_id: id.into(),
        sha256: hashes.into(),
        rejected: vec![RefusalRecord {
            reason: "jerk".into(),
            ..RefusalRecord::default()
        }],
        made: Some(json!({"settings": settings(), "line": line(scenario)})),
        ..Manifest::default()
    };
    manifest.original.sha256 = ContentHash::digest(b"original").to_string();
    json!(manifest)
}

fn lay(folder: &Path, id: &str, manifest: &Value) {
    std::fs::write(folder.join(format!("{id}.xml")), XML).unwrap();
    std::fs::write(folder.join(format!("{id}.csv")), "step").unwrap();
    std::fs::write(folder.join(format!("{id}.json")), manifest.to_string()).unwrap();
}

fn entry(name: &str) -> Entry {
    Entry::of_file(Path::new(&format!("here/{name}.xml")))
}

#[test]
fn a_variant_of_the_same_content_made_with_the_same_settings_is_taken_over() {
    let folder = tempfile::tempdir().unwrap();
    lay(folder.path(), "A_T-2", &manifest("A_T-2", "other"));
    lay(folder.path(), "A_T-3", &manifest("A_T-3", "mine"));
    let report = json!({"scenarios": 2, "asked_for": 2});
    std::fs::write(folder.path().join("report.json"), report.to_string()).unwrap();
    let (past, doubts) = EarlierRun::read(folder.path()).unwrap();
    assert_eq!(doubts, Vec::<String>::new());
    let original = ContentHash::digest(b"original");
    let of = |name: &str| past.line_for(&entry(name), &original, &settings()).unwrap();
    let mine = of("mine");
    assert_eq!(mine.id.as_deref(), Some("A_T-3"));
    assert!(mine.taken_over);
    assert_eq!(mine.rejected.unwrap()[0].reason, "jerk");
    assert_eq!(mine.file, "here/mine.xml");
    let variant = folder.path().join("A_T-3.xml");
    assert_eq!(mine.variant.as_deref(), variant.to_str());
    // The content counts, and the name only chooses among several.
    let third = of("third");
    assert_eq!(third.id.as_deref(), Some("A_T-2"));
    assert_eq!(third.scenario, "third");
    let changed = ContentHash::digest(b"another original");
    assert!(
        past.line_for(&entry("mine"), &changed, &settings())
            .is_none()
    );
    let others = [
        GenerationSettings {
            survive: 1.0,
            ..settings()
        },
        GenerationSettings {
            style: "human".into(),
            ..settings()
        },
        GenerationSettings {
            attackers: 2,
            ..settings()
        },
        GenerationSettings {
            attacker: vec![7],
            ..settings()
        },
    ];
    for others in others {
        assert!(past.line_for(&entry("mine"), &original, &others).is_none());
    }
}

#[test]
fn what_differs_is_named_then_and_now() {
    let searching = |candidates: usize, rounds: usize| GenerationSettings {
        search: Some(SearchSettings {
            candidates,
            rounds,
            drives: 8,
            attackers: 6,
            seed: 1,
        }),
        ..settings()
    };
    let nothing: [String; 0] = [];
    assert_eq!(searching(90, 12).differences(&searching(90, 14)), nothing);
    let other = "search.candidates 90, now 600";
    assert_eq!(searching(90, 12).differences(&searching(600, 14)), [other]);
    let folder = tempfile::tempdir().unwrap();
    lay(folder.path(), "A_T-2", &manifest("A_T-2", "mine"));
    let (past, _) = EarlierRun::read(folder.path()).unwrap();
    let original = ContentHash::digest(b"original");
    let wanted = GenerationSettings {
        survive: 1.0,
        ..settings()
    };
    assert_eq!(
        past.why_not(&original, &wanted).unwrap(),
        "variant A_T-2 is not reused, its settings differ: survive 0.5, now 1.0; a new one is generated; with the options of that run it is reused"
    );
    assert_eq!(past.why_not(&ContentHash::digest(b"new"), &wanted), None);
}

/// As the last version without typed manifests wrote it.
#[test]
fn a_manifest_of_the_last_version_is_taken_over() {
    let text = include_str!("manifest_before.json");
    let earlier: Value = serde_json::from_str(text).unwrap();
    let manifest = Manifest::deserialize(&earlier).unwrap();
    let made = Made::deserialize(manifest.made.as_ref().unwrap()).unwrap();
    assert_eq!(made.settings.search.unwrap().seed, 1);
    assert_eq!(made.line.outcome, manifest.outcome);
}

#[test]
fn what_cannot_be_trusted_is_named_with_the_reason() {
    let of = |spoil: &dyn Fn(&Path, &mut Value)| {
        let folder = tempfile::tempdir().unwrap();
        let mut said = manifest("A", "a");
        lay(folder.path(), "A", &said);
        spoil(folder.path(), &mut said);
        std::fs::write(folder.path().join("A.json"), said.to_string()).unwrap();
        let (past, doubts) = EarlierRun::read(folder.path()).unwrap();
        assert!(past.variants.is_empty());
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
        let model = AuthoredRecord {
            stopped: Some("the budget is used up".into()),
            ..AuthoredRecord::default()
        };
        said["made"]["line"]["model"] = json!(model);
    });
    assert!(stopped.contains("the budget is used up"));
}

#[test]
fn a_file_that_is_no_manifest_is_named() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("half.json"), "{\"variant\": ").unwrap();
    std::fs::write(folder.path().join("list.json"), "[1, 2]").unwrap();
    std::fs::write(folder.path().join("notes.txt"), "nothing").unwrap();
    let (_, doubts) = EarlierRun::read(folder.path()).unwrap();
    assert_eq!(doubts.len(), 2, "{doubts:?}");
    assert!(doubts.iter().all(|doubt| doubt.contains("not a manifest")));
    assert!(is_report(&folder.path().join("half.json")).is_err());
}
