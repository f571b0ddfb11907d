//! `drivers`: the list of models, encounters judged by them; drivers beside a planner, and wished of attacks.

use std::collections::BTreeSet;

use serde_json::Value;

use super::plan::lines;
use super::support::program::Home;
use super::{BUNDLED, CUT_IN, bundled_ego, bundled_xml};

const IDS: [&str; 6] = ["cc", "r157", "rss", "fsm", "nieon", "ideal"];

#[test]
fn every_driver_is_listed_with_its_numbers() {
    let home = Home::new();
    let listed = lines(&home.run(&["drivers", "--format", "json"]).status(0));
    let ids: Vec<&str> = listed
        .iter()
        .map(|line| line["driver"].as_str().unwrap())
        .collect();
    assert_eq!(ids, IDS);
    let delay = |line: &Value| {
        let parameters = line["parameters"].as_array().unwrap();
        let found = parameters.iter().find(|p| p["symbol"] == "ρ");
        found.map(|p| p["value"].as_f64().unwrap())
    };
    let delays: Vec<Option<f64>> = listed.iter().map(delay).collect();
    assert_eq!(
        delays,
        [Some(0.75), Some(0.35), Some(0.75), Some(0.75), None, None]
    );
    let page = home.run(&["help", "preventability"]).status(0).stdout;
    assert!(
        page.contains("ρ = 0.35 s") && page.contains("not made for: pedestrians"),
        "{page}"
    );
    home.run(&["drivers", "--format", "csv"])
        .status(2)
        .says(&["name scenarios"]);
}

#[test]
fn encounters_are_judged_the_same_in_every_format() {
    let home = Home::new();
    let names: Vec<&str> = BUNDLED.iter().map(|(name, _)| *name).collect();
    let run = |format: &str| {
        let arguments = [&["drivers"], &names[..], &["--format", format]].concat();
        home.run(&arguments).status(0)
    };
    let rows = lines(&run("json"));
    let words = [
        "avoided",
        "mitigated",
        "not_avoided",
        "hit_from_behind",
        "not_made_for",
    ];
    let mut contacts = BTreeSet::new();
    for row in &rows {
        let results = IDS.map(|id| row[id].as_str().unwrap());
        assert!(results.iter().all(|result| words.contains(result)), "{row}");
        let avoided = results
            .iter()
            .filter(|result| **result == "avoided")
            .count();
        assert_eq!(row["avoided"], avoided, "{row}");
        // None is better than the ideal one.
        assert!(avoided == 0 || row["ideal"] == "avoided", "{row}");
        for id in IDS {
            let has_speed = row[format!("{id}_closing_speed")].is_number();
            assert_eq!(
                has_speed,
                !["avoided", "not_made_for"].contains(&row[id].as_str().unwrap()),
                "{row}"
            );
        }
        if row["encounter"] == "contact" {
            contacts.insert(row["scenario"].as_str().unwrap());
        }
    }
    let expected = BUNDLED.iter().filter(|(_, collides)| *collides);
    assert_eq!(contacts, expected.map(|(name, _)| *name).collect());
    assert_eq!(run("csv").stdout.lines().count(), rows.len() + 1);
    let text = run("table").stdout;
    assert!(
        rows.iter()
            .all(|row| text.contains(row["scenario"].as_str().unwrap())),
        "{text}"
    );
}

#[test]
fn steps_that_are_too_coarse_are_said() {
    let home = Home::new();
    let coarse = bundled_xml(CUT_IN).replace("timeStepSize=\"0.1\"", "timeStepSize=\"0.5\"");
    home.write("coarse.xml", coarse);
    home.write("coarse.ego_trajectory.csv", bundled_ego(CUT_IN));
    let words = "time steps of 0.5 s are too coarse";
    home.run(&["drivers", "coarse.xml"])
        .status(0)
        .says(&[words]);
    let fine = home.run(&["drivers", CUT_IN]).status(0);
    assert!(!fine.stderr.contains("coarse"), "{}", fine.stderr);
}

#[test]
fn a_story_ends_with_who_would_have_avoided_it() {
    let home = Home::new();
    let names: Vec<&str> = BUNDLED.iter().map(|(name, _)| *name).collect();
    let judged = home.run(&[&["drivers"], &names[..], &["--format", "json"]].concat());
    let rows = lines(&judged.status(0));
    let mut told = 0;
    for name in names {
        let story = ["describe", name, "--story"];
        let said = home
            .run(&[&story[..], &["--format", "json"]].concat())
            .json();
        let sentences = said["sentences"].as_array().unwrap().len();
        let text = home.run(&story).status(0).stdout;
        let all: Vec<&str> = text.lines().collect();
        assert_eq!(said["text"], all.join(" "));
        let found = &said["preventability"];
        let same = |row: &&Value| {
            row["scenario"] == name
                && row["obstacle"] == found["obstacle"]
                && row["step"] == found["step"]
        };
        let Some(row) = rows.iter().find(same) else {
            assert!(found.is_null(), "{name}: {found}");
            assert!(!rows.iter().any(|row| row["scenario"] == name), "{name}");
            assert_eq!(all.len(), sentences, "{text}");
            continue;
        };
        told += 1;
        assert_eq!(all.len(), sentences + 1, "{text}");
        let last = all[sentences];
        let undecided = ["not_made_for", "hit_from_behind"];
        let decides = |id: &&str| !undecided.contains(&row[*id].as_str().unwrap());
        let (people, closing) = (&IDS[..5], &row["closing_speed"]);
        let count = match (people.iter().any(decides), closing.is_null()) {
            (false, true) => "The ego avoids it; no model of a person decides".to_string(),
            (false, false) => "No model of a person decides; the ideal driver ".to_string(),
            (true, false) => format!("Preventable by {} of {}", row["avoided"], row["decided"]),
            (true, true) => {
                let (avoided, decided) = (&row["avoided"], &row["decided"]);
                format!("The ego avoids it; avoided by {avoided} of {decided}")
            }
        };
        assert!(last.starts_with(&count), "{last}");
        for id in IDS {
            let moment = row[format!("{id}_last_moment")].as_f64();
            let words = moment.map(|moment| format!("{moment:.1} s"));
            let is_told = words.is_some_and(|words| {
                last.contains(&format!("for {id} was {words} before"))
                    || last.contains(&format!("for {id} {words}"))
            });
            let avoids = row[id] == "avoided";
            assert_eq!(is_told, avoids && moment.is_some(), "{id}: {last}");
        }
        let page = home.run(&["render", name, "--format", "html"]).status(0);
        assert!(page.stdout.contains(&format!("{last}</p>")), "{last}");
    }
    assert!(told > 1 && told < BUNDLED.len(), "{told}");
}

#[test]
fn drivers_and_baselines_drive_beside_a_planner() {
    let home = Home::new();
    let ended = home.run(&["plan", CUT_IN, "--driver", "cc,fsm", "--format", "json"]);
    let said = lines(&ended);
    let (comparison, drives) = said.split_last().unwrap();
    let planners: Vec<&str> = drives
        .iter()
        .map(|drive| drive["planner"].as_str().unwrap())
        .collect();
    let all = [
        "nearmiss",
        "cc",
        "fsm",
        "constant-velocity",
        "lane-following",
        "idm",
    ];
    assert_eq!(planners, all);
    let standings = comparison["standings"].as_array().unwrap();
    for (standing, drive) in standings.iter().zip(drives) {
        assert_eq!(standing["planner"], drive["planner"]);
        let collides = usize::from(drive["outcome"] == "collision");
        assert_eq!(standing["collision"], collides, "{drive}");
        assert_eq!(
            drive["preventability"].is_object(),
            collides == 1,
            "{drive}"
        );
    }
    assert_eq!(drives[0]["outcome"], "goal");
    // The road bends.
    assert_eq!(drives[3]["outcome"], "off_road", "{}", drives[3]);
    home.run(&["plan", CUT_IN, "--driver", "ideal"])
        .status(2)
        .says(&["no rule"]);
    home.run(&["plan", CUT_IN, "--driver", "fms"])
        .status(2)
        .says(&["fsm"]);
}

#[test]
fn attacks_say_who_would_have_avoided_them() {
    let home = Home::new();
    let generate = |more: &[&str]| {
        let told = [
            "generate",
            CUT_IN,
            "--format",
            "json",
            "--candidates",
            "300",
        ];
        home.run(&[&told[..], more].concat()).json()
    };
    let any = generate(&[]);
    let judged = &any["preventability"];
    assert_eq!(
        judged["drivers"].as_array().unwrap().len(),
        IDS.len(),
        "{any}"
    );
    let wished = generate(&["--preventable-by", "fsm"]);
    assert!(
        wished["by"]
            .as_str()
            .unwrap()
            .contains("preventable-by:fsm"),
        "{wished}"
    );
    let refused = home.run(&["generate", CUT_IN, "--preventable-by", "nobody"]);
    refused.status(2).says(&["unknown driver"]);
}
