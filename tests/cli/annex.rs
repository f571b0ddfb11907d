//! `annex`: planners held to a requirement, its files, and its exit status.

use std::fs;

use serde_json::Value;

use super::support::program::Home;
use super::{bundled_ego, bundled_xml};

const OVERTAKING: &str = "ZAM_Overtaking-1_1_T-1";

const FILE: &str = "\
id = \"A-1\"
title = \"Contacts <& others>\"
text = \"What a careful driver avoids is avoided.\"
source = \"A contract, section 3\"
odd = \"Dry roads\"
scenarios = [\"ZAM_Overtaking-1_1_T-1\", \"ZAM_CutIn-1_1_T-1\"]
";

/// The objects of a list in an annex.
fn list<'a>(annex: &'a Value, key: &str) -> &'a [Value] {
    annex[key].as_array().unwrap()
}

#[test]
fn an_annex_is_the_same_in_every_form() {
    let home = Home::new();
    let file = home.files().join("a.toml");
    fs::write(
        &file,
        format!("{FILE}planners = [\"lane-following\", \"idm\"]\n"),
    )
    .unwrap();
    let [file, html, tex, json] = ["a.toml", "a.html", "a.tex", "a.json"]
        .map(|name| home.files().join(name).display().to_string());
    let run = home
        .run(&["annex", &file, "-o", &html, "-o", &tex, "-o", &json])
        .status(1);
    // The lane follower runs into what it overtakes, and `cc` in its seat does not.
    run.says(&["A-1 not met by lane-following"]);
    let annex: Value = serde_json::from_slice(&fs::read(&json).unwrap()).unwrap();
    let planners = list(&annex, "planners");
    let of = |name: &str| planners.iter().find(|one| one["planner"] == name).unwrap();
    assert_eq!(of("lane-following")["met"], false);
    assert_eq!(
        (&of("cc")["role"], &of("constant-velocity")["role"]),
        (&"driver".into(), &"baseline".into())
    );
    for planner in planners {
        let findings = [
            "no_contact",
            "unpreventable",
            "harder",
            "preventable",
            "open",
        ];
        let sum: i64 = findings
            .iter()
            .map(|key| planner[*key].as_i64().unwrap())
            .sum();
        assert_eq!((sum, planner["drives"].as_i64()), (2, Some(2)), "{planner}");
    }
    let drives = list(&annex, "drives");
    assert_eq!(drives.len(), 2 * planners.len());
    let against = { drives.iter() }
        .find(|drive| drive["planner"] == "lane-following" && drive["finding"] == "preventable");
    let against = against.unwrap();
    assert_eq!(against["scenario"], "ZAM_Overtaking-1_1_T-1");
    assert_eq!(against["driver_closing_speed"], Value::Null, "it avoids it");
    // `plan` says the same of the drive.
    let alone = home
        .run(&[
            "plan",
            "ZAM_Overtaking-1_1_T-1",
            "--planner",
            "lane-following",
            "--format",
            "json",
        ])
        .status(1);
    let alone: Value = serde_json::from_str(alone.stdout.lines().next().unwrap()).unwrap();
    assert_eq!(alone["collision_with"], against["obstacle"]);
    let cc = {
        alone["preventability"]["drivers"]
            .as_array()
            .unwrap()
            .iter()
    }
    .find(|one| one["driver"] == "cc");
    assert_eq!(cc.unwrap()["result"], "avoided");
    let doubtful = { drives.iter() }.find(|drive| {
        drive["planner"] == "lane-following" && drive["scenario"] == "ZAM_CutIn-1_1_T-1"
    });
    let doubtful = doubtful.unwrap();
    assert_eq!(
        (&doubtful["outcome"], &doubtful["finding"]),
        (&"collision".into(), &"open".into())
    );
    assert!(
        doubtful["why_open"]
            .as_str()
            .unwrap()
            .contains("from the start"),
        "{doubtful}"
    );
    let [html, tex] = [html, tex].map(|file| fs::read_to_string(file).unwrap());
    for part in [
        "Contacts &lt;&amp; others&gt;",
        "What it does not show",
        "<svg",
        "not met",
        "A contract, section 3",
    ] {
        assert!(html.contains(part), "{part}");
    }
    for part in [
        "\\begin{document}",
        "Contacts $<$\\& others$>$",
        "\\section*{Test environment}",
        "lane-following: not met",
    ] {
        assert!(tex.contains(part), "{part}");
    }
    let hash = list(&annex, "scenarios")[0]["sha256"].as_str().unwrap();
    assert!(hash.len() == 64 && html.contains(hash) && tex.contains(hash));
    assert!(html.contains(annex["file_sha256"].as_str().unwrap()));
    // Nothing is replaced unasked, and nothing is driven for it.
    home.run(&["annex", &file, "-o", &json])
        .status(2)
        .says(&["a.json"]);
}

#[test]
fn mistakes_are_told_with_their_place() {
    let home = Home::new();
    let file = home.files().join("a.toml");
    let shown = file.display().to_string();
    for (more, says) in [
        ("planners = [\"idmm\"]\n", "did you mean"),
        ("driver = \"ccc\"\n", ":7: driver"),
        ("limits = 3\n", ":7: unknown key"),
        ("planning = { trafic = \"reactive\" }\n", ":7: planning"),
        (
            "select = \"tag:none_has_this\"\n",
            "select: the filter lets none",
        ),
        ("index = \"nowhere\"\n", "index: "),
    ] {
        fs::write(&file, format!("{FILE}{more}")).unwrap();
        home.run(&["annex", &shown])
            .status(2)
            .says(&["a.toml", says]);
    }
    fs::write(&file, FILE.replace("ZAM_CutIn-1_1_T-1", "missing")).unwrap();
    home.run(&["annex", &shown])
        .status(2)
        .says(&["a.toml: scenarios: ", "missing"]);
    fs::write(&file, FILE).unwrap();
    home.run(&["annex", &shown, "-o", "a.pdf"])
        .status(2)
        .says(&["a.pdf: unknown file extension"]);
    home.run(&["annex", &shown, "-o", &shown, "--overwrite"])
        .status(2)
        .says(&["unknown file extension"]);
    home.run(&["annex", &shown, "-o", "b.html", "-o", "b.html"])
        .status(2)
        .says(&["b.html: named twice"]);
    let schema = home
        .run(&["help", "requirements", "--schema", "requirement"])
        .status(0)
        .stdout;
    let schema: Value = serde_json::from_str(&schema).unwrap();
    assert!(
        schema["properties"]["planning"]["properties"]["traffic"].is_object(),
        "{schema}"
    );
}

/// One scenario that cannot be driven keeps the requirement from being met as a whole.
#[test]
fn what_is_not_driven_leaves_the_result_open() {
    let home = Home::new();
    let (xml, ego) = (bundled_xml(OVERTAKING), bundled_ego(OVERTAKING));
    let (from, to) = ("<planningProblem", "</planningProblem>");
    let problem = xml.find(from).unwrap()..xml.find(to).unwrap() + to.len();
    home.write("all/without.xml", xml.replace(&xml[problem], ""));
    home.write("all/whole.xml", &xml);
    home.write("all/whole.ego_trajectory.csv", ego);
    let file = |scenarios: &str| {
        let text = format!("{FILE}planners = [\"idm\"]\n");
        text.replace(
            "\"ZAM_Overtaking-1_1_T-1\", \"ZAM_CutIn-1_1_T-1\"",
            scenarios,
        )
    };
    home.write("a.toml", file("\"all/whole.xml\""));
    home.run(&["annex", "a.toml"]).status(0);
    home.write("a.toml", file("\"all\""));
    let run = home.run(&["annex", "a.toml", "--format", "json"]).status(1);
    let run = run.says(&["without.xml", "1 scenario not driven"]);
    let annex: Value = serde_json::from_str(&run.stdout).unwrap();
    let idm = list(&annex, "planners")
        .iter()
        .find(|one| one["planner"] == "idm")
        .unwrap();
    assert_eq!((&idm["met"], &idm["no_contact"]), (&Value::Null, &1.into()));
    assert_eq!(annex["missed"].as_array().unwrap().len(), 1);
}

/// A file counts once under all its names, and a recording that ends early shows nothing.
#[test]
fn copies_count_once_and_cut_recordings_are_open() {
    let home = Home::new();
    let (xml, ego) = (bundled_xml(OVERTAKING), bundled_ego(OVERTAKING));
    for name in ["one", "two"] {
        home.write(format!("all/{name}.xml"), &xml);
        home.write(format!("all/{name}.ego_trajectory.csv"), &ego);
    }
    let begin: Vec<&str> = ego.lines().take(12).collect();
    home.write("cut/s.xml", &xml);
    home.write("cut/s.ego_trajectory.csv", begin.join("\n"));
    let run = |folder: &str| {
        let text = format!("{FILE}planners = [\"recorded\"]\n");
        let file = text.replace(
            "\"ZAM_Overtaking-1_1_T-1\", \"ZAM_CutIn-1_1_T-1\"",
            &format!("\"{folder}\""),
        );
        home.write("a.toml", file);
        home.run(&["annex", "a.toml", "--format", "json"])
    };
    let whole = run("all");
    let whole = whole.says(&["two: left out, the content of"]);
    let annex: Value = serde_json::from_str(&whole.stdout).unwrap();
    assert_eq!(annex["copies"], serde_json::json!(["two"]));
    assert_eq!(list(&annex, "scenarios").len(), 1);
    let cut: Value = serde_json::from_str(&run("cut").stdout).unwrap();
    let drives = list(&cut, "drives").iter();
    let drive = { drives }
        .find(|drive| drive["planner"] == "recorded")
        .unwrap();
    assert_eq!(drive["finding"], "open", "{drive}");
    let why = drive["why_open"].as_str().unwrap();
    assert!(why.contains("the recording ends at step 10"), "{why}");
}
