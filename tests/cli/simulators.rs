//! `convert` for simulators: two files, the ego as asked for, nothing overwritten.

use super::support::program::Home;
use super::{CUT_IN, bundled_ego, bundled_xml};

#[test]
fn both_files_are_written_once_and_open_again() {
    let home = Home::new();
    let ended = home.run(&["convert", CUT_IN, "-o", "a.xosc"]).status(0);
    assert_eq!(ended.stdout, "");
    assert!(ended.stderr.contains("properties"), "{}", ended.stderr);
    home.run(&["convert", CUT_IN, "-o", "a.xosc"]).status(2);
    home.run(&["convert", CUT_IN, "-o", "a.xosc", "--overwrite"])
        .status(0);
    let shown = home.run(&["inspect", "a.xosc"]).status(0);
    assert!(shown.stdout.contains("format      OpenSCENARIO"));
    home.run(&["inspect", "a.xodr"]).status(0);
    home.run(&["metrics", "a.xosc"]).status(0);
    // Back in CommonRoad, with the ego beside it.
    home.run(&["convert", "a.xosc", "-o", "back.xml"]).status(0);
    let [before, after] = ["a.xosc", "back.xml"].map(|file| {
        let measured = home.run(&["metrics", file]).status(0).measures();
        // The obstacle's number is another one in the other format.
        let rows = measured
            .into_iter()
            .map(|row| [0, 2, 3].map(|column| row[column].clone()));
        rows.collect::<Vec<_>>()
    });
    assert_eq!(before, after);
    let checked = home.run(&["generate", CUT_IN, "--check", "a.xosc"]);
    let said = checked.status(1).stdout;
    assert!(said.contains("no obstacle moves differently"), "{said}");
    std::fs::remove_file(home.files().join("a.xodr")).unwrap();
    home.run(&["metrics", "a.xosc"]).says(&["no lanes"]);
}

#[test]
fn the_ending_of_the_file_decides_the_format() {
    let home = Home::new();
    let refused = |arguments: &[&str], said: &str| {
        let all = [&["convert", CUT_IN][..], arguments].concat();
        home.run(&all).status(2).says(&[said]);
    };
    refused(&["-o", "a.osc"], "no ending of a scenario");
    refused(&["-o", "missing"], "create the folder");
    refused(
        &["--format", "openscenario", "-o", "a.xml"],
        "writes .xosc files",
    );
    refused(
        &["--format", "commonroad", "-o", "a.xosc"],
        "writes .xml files",
    );
    refused(
        &["--schema", "-o", "a.xosc"],
        "--schema applies to CommonRoad",
    );
    home.run(&["convert", CUT_IN, "--format", "commonroad", "-o", "a.dat"])
        .status(0);
    let written = std::fs::read_to_string(home.files().join("a.dat")).unwrap();
    assert!(written.contains("<commonRoad"));
}

#[test]
fn the_ego_follows_a_plan_or_is_free_and_only_there() {
    let home = Home::new();
    home.run(&["convert", CUT_IN, "-o", "free.xosc", "--ego", "free"])
        .status(0);
    home.run(&["inspect", "free.xosc"]).status(0);
    home.run(&["convert", CUT_IN, "-o", "plan.xosc", "--ego", "planned"])
        .status(0);
    let refused = home.run(&["convert", CUT_IN, "--ego", "free"]).status(2);
    assert!(
        refused.stderr.contains("-o FILE.xosc"),
        "{}",
        refused.stderr
    );
    home.run(&["convert", CUT_IN, "-o", "a.xodr"]).status(2);
    home.run(&["convert", CUT_IN, "--format", "openscenario"])
        .status(2);
}

/// An interrupt between many scenarios: every file that is there is whole, and a run with --resume goes on.
#[cfg(unix)]
#[test]
fn an_interrupt_leaves_whole_files_and_resume_goes_on() {
    use super::long_jobs::interrupt;
    use super::support::program::Ended;
    use std::time::{Duration, Instant};
    let home = Home::new();
    let (xml, ego) = (bundled_xml(CUT_IN), bundled_ego(CUT_IN));
    for i in 0..12 {
        home.write(format!("all/s{i:03}.xml"), &xml);
        home.write(format!("all/s{i:03}.ego_trajectory.csv"), &ego);
    }
    let out = home.files().join("out");
    std::fs::create_dir(&out).unwrap();
    let arguments = [
        "convert",
        "all",
        "--format",
        "openscenario",
        "-o",
        "out",
        "--resume",
    ];
    let child = home.start(&arguments);
    let begun = Instant::now();
    while !out.join("s001.xosc").exists() {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "nothing was written"
        );
        std::thread::sleep(Duration::from_millis(2));
    }
    interrupt(&child);
    let ended = Ended::of(&child.wait_with_output().unwrap());
    ended.status(130).says(&["interrupted"]);
    let written = |ending: &str| {
        let all = std::fs::read_dir(&out).unwrap().flatten();
        let mut all: Vec<_> = all.map(|file| file.path()).collect();
        all.retain(|file| file.extension().is_some_and(|e| e == ending));
        all.sort();
        all
    };
    let (scenarios, roads) = (written("xosc"), written("xodr"));
    assert!(scenarios.len() < 12, "it ended before the interrupt");
    // Roads are written first.
    assert!(roads.len() - scenarios.len() <= 1);
    for file in scenarios.iter().chain(&roads) {
        let text = std::fs::read_to_string(file).unwrap();
        assert!(
            text.trim_end().ends_with("</OpenSCENARIO>")
                || text.trim_end().ends_with("</OpenDRIVE>")
        );
    }
    home.run(&arguments).status(0);
    assert_eq!(written("xosc").len(), 12);
}
