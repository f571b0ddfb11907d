//! Families of cases on the command line: tables in all formats, the boundary of preventability, and its figure.

use std::collections::BTreeMap;

use super::support::program::Home;

type Case = BTreeMap<String, String>;

fn cases(home: &Home, arguments: &[&str]) -> Vec<Case> {
    let csv = ["drivers", "--format", "csv", "--family"];
    let ended = home.run(&[&csv[..], arguments].concat()).status(0);
    let mut reader = csv::Reader::from_reader(ended.stdout.as_bytes());
    reader.deserialize().map(Result::unwrap).collect()
}

fn number(case: &Case, column: &str) -> f64 {
    case[column].parse().unwrap()
}

/// The cases that differ in one parameter alone, in its order.
fn lines<'a>(cases: &'a [Case], others: &[&str]) -> Vec<Vec<&'a Case>> {
    let mut lines: BTreeMap<Vec<&str>, Vec<&Case>> = BTreeMap::new();
    for case in cases {
        let key = others.iter().map(|other| case[*other].as_str()).collect();
        lines.entry(key).or_default().push(case);
    }
    lines.into_values().collect()
}

#[test]
fn a_larger_gap_is_not_worse() {
    let home = Home::new();
    let cut_in = cases(&home, &["cut-in", "--speed", "50,110"]);
    assert_eq!(cut_in.len(), 4 * 59 * 18 + 4 * 60 * 18);
    let mut boundaries = 0;
    for driver in ["cc", "rss", "fsm"] {
        for line in lines(&cut_in, &["ego_speed", "other_speed", "lateral_speed"]) {
            let contacts = line.iter().map(|case| case[driver] == "not_avoided");
            let contacts: Vec<bool> = contacts.collect();
            let Some(first) = contacts.iter().position(|contact| *contact) else {
                continue;
            };
            let last = contacts.iter().rposition(|contact| *contact).unwrap();
            boundaries += usize::from(last + 1 < contacts.len());
            let is_one = contacts[first..=last].iter().all(|contact| *contact);
            assert!(is_one, "{driver} {:?}", line[0]);
            // Who avoids a smaller gap is past, with both lengths of 4.3 m, when the other has come 1.6 m over, or a step later.
            if let Some(passed) = first.checked_sub(1) {
                let case = line[passed];
                let closing = number(case, "ego_speed") - number(case, "other_speed");
                let past = (number(case, "gap") + 2.0 * 4.3) / closing;
                let over = 1.6 / number(case, "lateral_speed");
                assert!(past <= over + 0.1, "{driver} {case:?}");
            }
        }
    }
    assert!(boundaries > 200, "{boundaries}");
    let cut_out = cases(&home, &["cut-out", "--speed", "60,130"]);
    for driver in ["cc", "rss", "fsm"] {
        for line in lines(&cut_out, &["ego_speed", "lateral_speed"]) {
            let avoided = line.iter().map(|case| case[driver] == "avoided");
            assert!(avoided.is_sorted(), "{driver} {:?}", line[0]);
        }
    }
    for case in cut_in.iter().chain(&cut_out) {
        for driver in ["cc", "r157", "rss", "fsm", "nieon"] {
            let closing = &case[&format!("{driver}_closing_speed")];
            let is_contact = case[driver] == "not_avoided";
            assert_eq!(is_contact, !closing.is_empty(), "{case:?}");
        }
        assert!(case["ideal"].is_empty());
    }
    let ruled = |case: &Case| !case["r157"].is_empty() || !case["nieon"].is_empty();
    assert!(cut_in.iter().all(ruled) && !cut_out.iter().any(ruled));
}

/// At 50 and 30 km/h and 1.6 m/s to the side, bodies overlap after 1 s, 5.56 m nearer. `cc` then closes 4.30 m in 0.8 s with no
/// foot on a pedal, and 2.61 m more until it is as slow: 12.47 m, and up to a step at 5.56 m/s.
#[test]
fn a_boundary_is_where_it_is_by_hand() {
    let home = Home::new();
    let found = cases(&home, &["cut-in", "--speed", "50"]);
    let at = |gap: f64, driver: &str| {
        let wanted = [
            ("other_speed", 30.0 / 3.6),
            ("lateral_speed", 1.6),
            ("gap", gap),
        ];
        let is_it = |case: &&Case| {
            let mut parts = wanted.iter();
            parts.all(|(column, value)| (number(case, column) - value).abs() < 1e-5)
        };
        found.iter().find(is_it).unwrap()[driver].clone()
    };
    assert_eq!([at(12.0, "cc"), at(14.0, "cc")], ["not_avoided", "avoided"]);
    // Who knows the lane sees it after 1.095 m: 0.32 s and 1.75 m earlier.
    let lanes = [at(10.0, "cc_lanes"), at(12.0, "cc_lanes")];
    assert_eq!(lanes, ["not_avoided", "avoided"]);
    let is_straight = |case: &&Case| number(case, "lateral_speed") == 0.0;
    let straight: Vec<&Case> = found.iter().filter(is_straight).collect();
    assert_eq!(straight.len(), 4 * 59);
    assert!(straight.iter().all(|case| case["rss"] == "avoided"));
    let text = home.run(&["drivers", "--family", "cut-in", "--speed", "50"]);
    let text = text.status(0).stdout;
    // Of 1.5 m/s, where the same sum gives 12.84 to 13.39 m.
    assert!(
        text.contains("      50          30          1.5    14 "),
        "{text}"
    );
}

#[test]
fn every_format_has_the_same_cases() {
    let home = Home::new();
    let braking = ["braking", "--speed", "20,120"];
    let csv = cases(&home, &braking);
    assert_eq!(csv.len(), 2 * 19);
    let all = [&["drivers", "--family"][..], &braking].concat();
    let json = home.run(&[&all[..], &["--format", "json"]].concat());
    let json = json.status(0).json_lines();
    assert_eq!(json.len(), csv.len());
    for (json, csv) in json.iter().zip(&csv) {
        assert_eq!(json["rss"], csv["rss"].as_str());
        let deceleration = json["deceleration"].as_f64();
        assert_eq!(deceleration, Some(number(csv, "deceleration")));
        assert!(json["r157"].is_null());
    }
    for (name, begin) in [
        ("a.parquet", &b"PAR1"[..]),
        ("a.arrow", b"\xff\xff\xff\xff"),
    ] {
        home.run(&[&all[..], &["-o", name]].concat()).status(0);
        let bytes = std::fs::read(home.files().join(name)).unwrap();
        assert!(bytes.starts_with(begin), "{name}");
    }
    let text = home.run(&all).status(0).stdout;
    assert!(
        text.contains(" 120      9.3       8.3       9.3\n"),
        "{text}"
    );
}

#[test]
fn the_figure_names_its_drivers_and_mistakes_are_said() {
    let home = Home::new();
    let drive = |more: &[&str]| home.run(&[&["drivers", "--family"], more].concat());
    drive(&["cut-in", "--speed", "50", "-o", "a.svg"]).status(0);
    let svg = std::fs::read_to_string(home.files().join("a.svg")).unwrap();
    for words in [
        "cc",
        "cc_lanes",
        "r157",
        "nieon",
        "50 km/h, other 40",
        "gap (m)",
    ] {
        assert!(svg.contains(&format!(">{words}<")), "{words}");
    }
    assert!(!svg.contains(">ideal<"));
    assert_eq!(svg.matches(r#"class="panel""#).count(), 4);
    drive(&["cut-out", "-o", "a.png"]).status(0);
    let png = std::fs::read(home.files().join("a.png")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    let again = drive(&["cut-out", "-o", "a.png"]).status(2);
    again.says(&["a.png", "--overwrite"]);
    let none = drive(&["cut-out", "--speed", "55"]).status(2);
    none.says(&["no case with 55 km/h, but 10, 20"]);
    drive(&["cutin"])
        .status(2)
        .says(&["did you mean `cut-in`?"]);
    let both = drive(&["braking", super::CUT_IN]).status(2);
    both.says(&["cannot be used with"]);
}

fn bundled(name: &str) -> String {
    format!("ZAM_{name}-1_1_T-1")
}

/// Gaps and closing speeds of the bundled cut-in: closing faster takes a larger gap.
#[test]
fn a_scenario_has_a_family_in_every_format() {
    let home = Home::new();
    let cut_in = bundled("CutIn");
    let vary = |more: &[&str]| {
        let told = ["drivers", &cut_in, "--vary", "gap=2..12,closing=4..8:2"];
        home.run(&[&told[..], more].concat())
    };
    let csv = vary(&["--format", "csv"]).status(0).stdout;
    let mut reader = csv::Reader::from_reader(csv.as_bytes());
    let cases: Vec<Case> = reader.deserialize().map(Result::unwrap).collect();
    assert_eq!(cases.len(), 21 * 3);
    let smallest = |driver: &str| -> Vec<f64> {
        let lines = lines(&cases, &["closing"]);
        let avoided = |line: Vec<&Case>| {
            let last = line.iter().rposition(|case| case[driver] != "avoided");
            last.map_or(0.0, |last| number(line[last], "gap"))
        };
        lines.into_iter().map(avoided).collect()
    };
    for driver in ["cc", "r157", "rss", "nieon"] {
        let limits = smallest(driver);
        assert!(
            limits.is_sorted() && limits[0] < limits[2],
            "{driver} {limits:?}"
        );
    }
    assert!(smallest("ideal").iter().all(|gap| *gap == 0.0));
    assert!(cases.iter().all(|case| case["invalid"].is_empty()));
    let json = vary(&["--format", "json"]).status(0).json_lines();
    for (json, csv) in json.iter().zip(&cases) {
        assert_eq!(json["cc"], csv["cc"].as_str());
        assert_eq!(json["gap"].as_f64(), Some(number(csv, "gap")));
    }
    let text = vary(&[]).status(0).stdout;
    let told = [
        "closing m/s",
        "conflict with 301 at 4.4 s, cut_in at 3.9 s: gap 5.04 m, closing 6.23 m/s",
        "63 cases",
    ];
    assert!(told.iter().all(|words| text.contains(words)), "{text}");
    vary(&["-o", "a.svg"]).status(0);
    let svg = std::fs::read_to_string(home.files().join("a.svg")).unwrap();
    for words in ["cc", "ideal", "gap (m)", "closing (m/s)"] {
        assert!(svg.contains(&format!(">{words}<")), "{words}");
    }
    assert!(!svg.contains(">impossible<"));
    assert_eq!(svg.matches(r#"class="recorded""#).count(), 1, "its ring");
    vary(&["-o", "a.parquet"]).status(0);
}

/// The case of a value is what drivers make of the file that was written with it.
#[test]
fn drivers_judge_a_written_case_as_in_its_family() {
    let home = Home::new();
    let cut_in = bundled("CutIn");
    let told = [
        "drivers",
        &cut_in,
        "--vary",
        "gap=8..8,lateral_speed=1.8..1.8",
    ];
    let case = home.run(&[&told[..], &["--format", "json"]].concat());
    let case = case.status(0).json_lines().remove(0);
    home.run(&[&told[..], &["-o", "a.xosc"]].concat()).status(0);
    let path = home.files().join("a.xosc");
    let mut text = std::fs::read_to_string(&path).unwrap();
    for (name, value) in [("gap", "8"), ("lateral_speed", "1.8")] {
        let named = format!(r#"name="{name}" parameterType="double" value=""#);
        let (before, after) = text.split_once(&named).unwrap();
        let (_, after) = after.split_once('"').unwrap();
        text = format!("{before}{named}{value}\"{after}");
        assert!(text.contains(r#"<ValueConstraint rule="lessOrEqual""#));
    }
    std::fs::write(&path, text).unwrap();
    let judged = home.run(&["drivers", "a.xosc", "--format", "json"]);
    let judged = judged.status(0).json_lines().remove(0);
    for driver in ["cc", "r157", "rss", "fsm", "nieon", "ideal"] {
        assert_eq!(case[driver], judged[driver], "{driver}");
    }
    let again = home.run(&[&told[..], &["-o", "a.xosc"]].concat());
    again.status(2).says(&["a.xosc", "--overwrite"]);
}

#[test]
fn what_cannot_be_varied_says_why() {
    let home = Home::new();
    let refused = |name: &str, vary: &str, more: &[&str], says: &[&str]| {
        let told = ["drivers", &bundled(name), "--vary", vary];
        home.run(&[&told[..], more].concat()).status(2).says(says);
    };
    refused(
        "RedLight",
        "gap",
        &[],
        &["301 does not cut in", "vary start"],
    );
    refused(
        "HardBraking",
        "lateral_speed",
        &[],
        &["brakes ahead", "vary gap"],
    );
    refused("Merge", "gap", &[], &["no contact, conflict or near miss"]);
    refused("CutIn", "speed", &[], &["unknown parameter `speed`"]);
    refused(
        "CutIn",
        "gap=2-20",
        &[],
        &["gap: `2-20` is no range", "2..20"],
    );
    refused("CutIn", "gap=20..2", &[], &["ends before it begins"]);
    refused("CutIn", "gap=2..20:0", &[], &["is not above 0"]);
    refused("CutIn", "gap,gap=2..3", &[], &["gap is named twice"]);
    refused("CutIn", "lateral_speed=0..1", &[], &["above 0"]);
    refused("CutIn", "start=0..1:0.25", &[], &["time steps of 0.1 s"]);
    refused(
        "CutIn",
        "gap,closing,lateral_speed,start",
        &[],
        &["three parameters"],
    );
    refused(
        "CutIn",
        "gap=0..9:0.001,closing=0..9:1",
        &[],
        &["at most 20000"],
    );
    refused("CutIn", "gap", &["-o", "a.svg"], &["two axes"]);
    refused(
        "CutIn",
        "gap",
        &["-o", "a.zip"],
        &["unknown file extension"],
    );
    refused("CutIn", "gap", &[&bundled("Merge")], &["one scenario", "2"]);
    refused(
        "CutIn",
        "gap",
        &["--family", "cut-in"],
        &["cannot be used with"],
    );
    home.run(&["drivers", "--vary", "gap"]).status(2);
}
