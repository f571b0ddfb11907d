//! `corpus sample --hard`: scenarios that no baseline solves and a drive proves solvable.

use super::index::indexed;
use super::support::program::Home;
use super::{BUNDLED, bundled_ego, bundled_xml};

const PEDESTRIAN: &str = "ZAM_Pedestrian-1_1_T-1";

#[test]
fn hard_scenarios_are_drawn_once_each_with_who_solves_them() {
    let home = Home::new();
    indexed(&home);
    let sample =
        |more: &[&str]| home.run(&[&["corpus", "sample", "index", "--hard"], more].concat());
    let all = sample(&["--format=json"]).status(0);
    let tried = format!(
        "driven {}, a baseline hit from behind 0, baselines off the road 0, baselines fail 2, solvable 2",
        BUNDLED.len()
    );
    let all = all.says(&[&tried, "all scenarios of the index were tried"]);
    let lines = all.json_lines();
    let solver = |name: &str| {
        let mut of = lines.iter().filter(|line| line["scenario"] == name);
        let line = of.next().unwrap();
        assert!(of.next().is_none(), "{name} twice");
        let ends = line["baselines"].as_array().unwrap();
        assert_eq!(ends.len(), 3);
        assert!(ends.iter().all(|end| end != "goal" && end != "timeout"));
        assert!(line["reason"].as_str().unwrap().contains("solved by "));
        line["solved_by"].as_str().unwrap().to_string()
    };
    assert_eq!(lines.len(), 2);
    assert_eq!(solver(PEDESTRIAN), "recorded_ego");
    assert_eq!(solver("ZAM_RedLight-1_1_T-1"), "certificate");
    assert_eq!(all.stdout, sample(&["--format=json"]).status(0).stdout);
    // No more is driven than has to be.
    let one = sample(&["-n", "1", "--seed", "3"]).status(0);
    assert_eq!(one.stdout.lines().count(), 2, "{}", one.stdout);
    assert!(one.stdout.contains("; solved by "));
    assert!(!one.stderr.contains("all scenarios"), "{}", one.stderr);
    let toml = sample(&["--format", "toml"]).status(0).stdout;
    assert!(toml.contains(" --hard`") && toml.contains("# 1 window drawn, solved by recorded ego"));
    let paths = sample(&["--format", "paths"]).status(0).stdout;
    assert_eq!(paths.lines().count(), 2);
}

#[test]
fn what_cannot_be_driven_is_counted() {
    let home = Home::new();
    let xml = bundled_xml(PEDESTRIAN);
    let (from, to) = ("<planningProblem", "</planningProblem>");
    let problem = xml.find(from).unwrap()..xml.find(to).unwrap() + to.len();
    let without = xml.replace(&xml[problem], "");
    home.write("all/without.xml", &without);
    home.write("all/gone.xml", &xml);
    home.write("all/whole.xml", &xml);
    home.write("all/whole.ego_trajectory.csv", bundled_ego(PEDESTRIAN));
    home.run(&["corpus", "index", "all", "-o", "index"])
        .status(0);
    std::fs::remove_file(home.files().join("all/gone.xml")).unwrap();
    let drawn = home.run(&["corpus", "sample", "index", "--hard", "--format", "paths"]);
    let drawn = drawn.status(0).says(&[
        "gone.xml",
        "driven 1, a baseline hit from behind 0, baselines off the road 0, baselines fail 1, solvable 1",
        "not driven: 1 without a problem that can be planned, 1 failed",
    ]);
    assert_eq!(drawn.stdout.trim(), "all/whole.xml");
    std::fs::remove_file(home.files().join("all/whole.xml")).unwrap();
    home.run(&["corpus", "sample", "index", "--hard"])
        .status(2)
        .says(&["no scenario of the index could be driven"]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_was_found() {
    use std::io::{BufRead, BufReader};

    let home = Home::new();
    let (xml, ego) = (bundled_xml(PEDESTRIAN), bundled_ego(PEDESTRIAN));
    for i in 0..30 {
        // Copies would not count.
        home.write(format!("all/s{i:02}.xml"), format!("{xml}<!-- {i} -->"));
        home.write(format!("all/s{i:02}.ego_trajectory.csv"), &ego);
    }
    // One that cannot be read any more is said when its turn comes: then those before it are found.
    let index = ["corpus", "index", "all", "-o", "index", "--stride", "9"];
    home.run(&index).status(0);
    let sample = ["corpus", "sample", "index", "--hard", "--format", "paths"];
    let first = |number: &str| {
        let drawn = home.run(&[&sample[..], &["-n", number]].concat()).status(0);
        let files = drawn.stdout.lines().map(String::from);
        files.collect::<Vec<_>>()
    };
    let (first, four) = (first("1"), first("4"));
    let later = four.iter().find(|file| !first.contains(file)).unwrap();
    std::fs::remove_file(home.files().join(later)).unwrap();
    let mut child = home.start(&sample);
    let mut told = String::new();
    let mut stderr = BufReader::new(child.stderr.take().unwrap());
    stderr.read_line(&mut told).unwrap();
    super::long_jobs::interrupt(&child);
    let mut rest = String::new();
    std::io::Read::read_to_string(&mut stderr, &mut rest).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130), "{told}{rest}");
    assert!(
        rest.contains("those found until then are written"),
        "{told}{rest}"
    );
    let found = String::from_utf8(ended.stdout).unwrap();
    assert!((1..29).contains(&found.lines().count()), "{found}");
}
