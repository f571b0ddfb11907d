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

/// A scenario whose ego drives on by itself, which only a player works out.
const DRIVES_ON: &str = r#"<?xml version="1.0"?>
<OpenSCENARIO><FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>
<RoadNetwork/>
<Entities>
  <ScenarioObject name="Ego"><Vehicle name="car" vehicleCategory="car"/></ScenarioObject>
  <ScenarioObject name="other"><Vehicle name="car" vehicleCategory="car"/></ScenarioObject>
</Entities>
<Storyboard><Init><Actions>
  <Private entityRef="other">
    <PrivateAction><TeleportAction><Position><WorldPosition x="0" y="0"/></Position></TeleportAction></PrivateAction>
    <PrivateAction><LongitudinalAction><SpeedAction><SpeedActionTarget><AbsoluteTargetSpeed value="9"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>
  </Private>
</Actions></Init></Storyboard>
</OpenSCENARIO>
"#;

/// A log of so many steps of 0.1 s: the ego drives at 10 m/s, its middle 1 m ahead of its place, and one before it at 5 m/s.
fn log(steps: u32) -> String {
    let mut text = String::from(
        "esmini GIT TAG: v9.9\nIndex [-], TimeStamp [s], #1 Entity_Name [-], #1 Entity_ID [-], #1 Current_Speed [m/s], #1 bb_x [m], #1 bb_y [m], #1 bb_length [m], #1 bb_width [m], #1 World_Position_X [m], #1 World_Position_Y [m], #1 World_Heading_Angle [rad], #1 collision_ids, #2 Entity_Name [-],\n",
    );
    for i in 0..steps {
        let x = f64::from(i);
        text += &format!(
            "{i}, {:.6}, Ego, 0, 10.0, 1.0, 0.0, 6.0, 2.0, {x:.6}, 3.0, 0.0, , other, 1, 5.0, 1.0, 0.0, 5.0, 2.0, {:.6}, 3.0, 0.0, , \n",
            0.1 * x,
            20.0 + x / 2.0
        );
    }
    text
}

/// Puts a program into the configuration that does what a script says, where `$out` is to be its recording.
#[cfg(unix)]
fn set_player(home: &Home, script: &str) {
    use std::os::unix::fs::PermissionsExt;
    let program = home.config().join("player.sh");
    let text = format!(
        "#!/bin/sh\nhome='{}'\nwhile [ $# -gt 0 ]; do case $1 in --csv_logger) out=$2;; esac; shift; done\n{script}\n",
        home.files().display()
    );
    std::fs::write(&program, text).unwrap();
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    let setting = format!("esmini = \"{}\"\n", program.display());
    std::fs::write(home.config().join("config.toml"), setting).unwrap();
}

#[cfg(unix)]
#[test]
fn what_only_a_player_works_out_is_played_where_there_is_one() {
    let home = Home::new();
    home.write("a/x.xosc", DRIVES_ON);
    home.write("log.txt", log(20));
    let refused = |words: &[&str]| {
        let ended = home.run_with(&["inspect", "a/x.xosc"], &[("PATH", "/no/such")]);
        let said = ended.status(2).says(words);
        assert_eq!(said.stderr.lines().count(), 1, "{}", said.stderr);
    };
    let config = |text: &str| std::fs::write(home.config().join("config.toml"), text).unwrap();
    refused(&["drives on by itself", "install esmini", "a/x.csv"]);
    config("esmini = \"off\"\n");
    refused(&["\"off\" in config.toml"]);
    config("esmini = \"/no/such/esmini\"\n");
    refused(&["esmini = \"/no/such/esmini\" is no program"]);
    set_player(
        &home,
        "echo '[2.0] [error] the road is closed' > log.txt; exit 255",
    );
    refused(&[
        "drives on by itself",
        "exit status 255",
        "the road is closed",
    ]);
    set_player(&home, "echo . >> $home/played; cp $home/log.txt $out");
    let shown = home.run(&["inspect", "a/x.xosc"]).status(0).stdout;
    assert!(shown.contains("motion as esmini v9.9 played it"), "{shown}");
    home.run(&["inspect", "a"]).status(0);
    home.run(&["convert", "a/x.xosc", "-o", "x.xml"]).status(0);
    let written = std::fs::read_to_string(home.files().join("x.xml")).unwrap();
    assert!(written.contains("OpenSCENARIO, played by esmini v9.9"));
    let played = std::fs::read_to_string(home.files().join("played")).unwrap();
    assert_eq!(played.lines().count(), 1);
    // Another one's recording beside it is taken first.
    home.write("a/x.csv", log(10));
    let shown = home.run(&["inspect", "a/x.xosc"]).status(0).stdout;
    assert!(shown.contains("as a player recorded it in"), "{shown}");
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_the_player() {
    use super::long_jobs::interrupt;
    use super::support::program::Ended;
    use std::time::{Duration, Instant};
    let home = Home::new();
    home.write("x.xosc", DRIVES_ON);
    set_player(
        &home,
        "pwd > $home/where; echo $$ > $home/player; exec sleep 600",
    );
    let child = home.start(&["inspect", "x.xosc"]);
    let begun = Instant::now();
    let player = home.files().join("player");
    while std::fs::read_to_string(&player)
        .unwrap_or_default()
        .is_empty()
    {
        assert!(
            begun.elapsed() < Duration::from_secs(60),
            "nothing is played"
        );
        std::thread::sleep(Duration::from_millis(5));
    }
    interrupt(&child);
    Ended::of(&child.wait_with_output().unwrap()).status(130);
    let text = |path: &std::path::Path| std::fs::read_to_string(path).unwrap().trim().to_string();
    let status = std::path::Path::new("/proc")
        .join(text(&player))
        .join("status");
    let runs = || std::fs::read_to_string(&status).is_ok_and(|s| !s.contains("State:\tZ"));
    while runs() {
        assert!(begun.elapsed() < Duration::from_secs(60), "it plays on");
        std::thread::sleep(Duration::from_millis(5));
    }
    let own = text(&home.files().join("where"));
    assert!(!std::path::Path::new(&own).exists(), "{own}");
}

#[test]
fn a_log_of_esmini_opens_alone() {
    let home = Home::new();
    home.write("logs/short.csv", log(20));
    home.write("logs/long.csv", log(400));
    home.write("logs/beside.csv", log(20));
    home.write("logs/beside.xosc", DRIVES_ON);
    let shown = home.run(&["inspect", "logs/short.csv"]).status(0).stdout;
    assert!(
        shown.contains("recorded by esmini v9.9") && shown.contains("no map"),
        "{shown}"
    );
    home.run(&["metrics", "logs/short.csv"]).status(0);
    let roads = home.run(&["convert", CUT_IN, "-o", "map.xosc"]);
    roads.status(0);
    let shown = home.run(&["inspect", "logs/short.csv", "--map", "map.xodr"]);
    assert!(shown.status(0).stdout.contains("map map.xodr"));
    home.run(&["describe", "logs/long.csv"])
        .status(2)
        .says(&["longer than 30 s", "#track=other@0.0s"]);
    let listed = home.run(&["inspect", "logs/long.csv"]).status(0).stdout;
    assert!(listed.contains("long.csv#track="), "{listed}");
    home.run(&["inspect", "logs/long.csv#track=Ego@5.0s"])
        .status(0);
    let listed = home.run(&["inspect", "logs"]).stdout;
    assert!(listed.contains("long.csv#track="), "{listed}");
    let is_listed = |file: &str| listed.lines().any(|line| line.starts_with(file));
    assert!(!is_listed("logs/beside.csv"), "{listed}");
    let broken = log(20).replace("13.000000", "thirteen");
    home.write("broken.csv", broken);
    home.run(&["inspect", "broken.csv"])
        .status(2)
        .says(&["broken.csv:16:", "`thirteen` is not a number"]);
}
