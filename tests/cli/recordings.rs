//! Recordings of other data sets in commands: named by file, folder and part.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::support::program::Home;

#[path = "../hostile/recordings/nuplan_file.rs"]
#[allow(dead_code, clippy::unwrap_used)]
mod nuplan_file;

/// Floating car data of 40 s: `7` comes up behind `8`, which stands, and stops short of it.
fn written(home: &Home) -> PathBuf {
    let folder = home.files().join("recorded");
    std::fs::create_dir(&folder).expect("made");
    let mut xml = String::from("<fcd-export>\n");
    for step in 0..=400 {
        let t = f64::from(step) * 0.1;
        let x = if t < 20.0 { 10.0 * t } else { 200.0 };
        let row = |id: i64, x: f64, speed: f64| {
            format!(
                "<vehicle id='{id}' x='{x:.2}' y='0' angle='90' type='DEFAULT_VEHTYPE' speed='{speed}'/>"
            )
        };
        let (a, b) = (
            row(7, x, if t < 20.0 { 10.0 } else { 0.0 }),
            row(8, 210.0, 0.0),
        );
        let _ = writeln!(xml, "<timestep time='{t:.1}'>{a}{b}</timestep>");
    }
    std::fs::write(folder.join("fcd.xml"), xml + "</fcd-export>\n").expect("written");
    folder
}

#[test]
fn windows_are_found_inspected_measured_and_converted() {
    let home = Home::new();
    let folder = written(&home);
    let text = |path: &PathBuf| path.display().to_string();
    let lines = home
        .run(&["inspect", &text(&folder), "--format=json"])
        .status(0)
        .json_lines();
    let files: Vec<&str> = lines.iter().filter_map(|l| l["file"].as_str()).collect();
    assert!(
        files == [folder.join("fcd.xml#track=7@12.8s").display().to_string()],
        "{files:?}"
    );
    assert_eq!(lines[0]["ego"], 7, "{lines:?}");
    let ended = home.run(&["inspect", files[0]]).status(0);
    assert!(
        ended.stdout.contains("SUMO") && ended.stdout.contains("no net"),
        "{}",
        ended.stdout
    );
    let ended = home.run(&["metrics", files[0]]).status(0);
    assert!(ended.stdout.lines().count() > 90, "{}", ended.stdout);
    let into = home.files().join("converted");
    std::fs::create_dir(&into).expect("made");
    home.run(&["convert", &text(&folder), "-o", &text(&into)])
        .status(0);
    let written = into.read_dir().expect("read").flatten();
    let mut written: Vec<PathBuf> = written.map(|file| file.path()).collect();
    written.sort();
    // The ego lies beside the scenario.
    assert_eq!(written.len(), 2 * files.len(), "{written:?}");
    let again = home.run(&["inspect", &text(&written[1])]).status(0);
    for said in ["CommonRoad 2020a", "7, recorded in"] {
        assert!(again.stdout.contains(said), "{}", again.stdout);
    }
    assert!(!again.stdout.contains("no size"), "{}", again.stdout);
    home.run(&["convert", files[0]])
        .status(0)
        .says(&["the ego is left out", "-o FILE.xml"]);
}

/// nuPlan: a log among the folders of its data set is found, and what is written of it measures the same.
#[test]
fn what_is_written_of_a_log_measures_the_same() {
    let home = Home::new();
    let logs = home.files().join("data/nuplan-v1.1/splits/mini");
    let maps = home
        .files()
        .join("data/maps/us-nv-las-vegas-strip/9.15.1915");
    for folder in [&logs, &maps] {
        std::fs::create_dir_all(folder).expect("made");
    }
    let log = nuplan_file::Log {
        seconds: 40.0,
        starts: 20.0,
        ..nuplan_file::Log::default()
    };
    nuplan_file::write_log(&logs.join("a.db"), &log);
    nuplan_file::write_map(&maps.join("map.gpkg"));
    let data = home.files().join("data").display().to_string();
    let lines = home
        .run(&["inspect", &data, "--format=json"])
        .status(0)
        .json_lines();
    let files: Vec<&str> = lines.iter().filter_map(|l| l["file"].as_str()).collect();
    assert!(files[0].contains("a.db#track=ego@"), "{files:?}");
    let ended = home.run(&["inspect", files[0]]).status(0);
    for said in ["nuPlan, 0.05 s per step", "9 lanelets", "map.gpkg"] {
        assert!(ended.stdout.contains(said), "{}", ended.stdout);
    }
    let long = logs.join("a.db").display().to_string();
    home.run(&["describe", &long])
        .status(2)
        .says(&["longer than 30 s", "a.db#track=ego@0.0s"]);
    let listed = home.run(&["inspect", &long]).status(0);
    assert!(
        listed.stdout.contains("a.db#track=ego@"),
        "{}",
        listed.stdout
    );
    let into = home.files().join("written.xml").display().to_string();
    home.run(&["convert", files[0], "-o", &into]).status(0);
    let measures = |path: &str| home.run(&["metrics", path]).status(0).measures();
    let (before, after) = (measures(files[0]), measures(&into));
    assert!(before.len() > 1000, "{}", before.len());
    assert_eq!(before, after);
    let scenario = home.files().join("written.xosc").display().to_string();
    home.run(&["convert", files[0], "-o", &scenario]).status(0);
    for ending in ["-wal", "-shm", "-journal"] {
        assert!(!logs.join(format!("a.db{ending}")).exists());
    }
}

#[test]
fn a_part_that_is_not_there_is_named() {
    let home = Home::new();
    let folder = written(&home);
    let file = folder.join("fcd.xml").display().to_string();
    home.run(&["inspect", &format!("{file}#track=9")])
        .status(2)
        .says(&["no vehicle `9`; it has 7, 8"]);
    home.run(&["describe", &file])
        .status(2)
        .says(&["longer than 30 s", "#track=7@"]);
    let listed = home.run(&["inspect", &file]).status(0);
    assert!(listed.stdout.contains("#track=7@"), "{}", listed.stdout);
    home.run(&["inspect", &format!("{file}x#1")])
        .status(2)
        .says(&["no such file"]);
}

#[test]
fn damaged_files_are_named_as_what_they_are() {
    let home = Home::new();
    home.write("scenario_1.parquet", "PAR1 cut short");
    home.write("shard.tfrecord-00000-of-00001", "no record of twelve bytes");
    home.run(&["inspect", "scenario_1.parquet"])
        .status(2)
        .says(&["not a whole Parquet file"]);
    home.run(&["inspect", "shard.tfrecord-00000-of-00001"])
        .status(2)
        .says(&["the checksum of its length"]);
}

#[test]
fn maps_may_lie_elsewhere() {
    let home = Home::new();
    let folder = home.files().join("drone");
    let maps = home.files().join("elsewhere");
    for made in [&folder, &maps] {
        std::fs::create_dir(made).expect("made");
    }
    let mut rows = String::from(
        "recordingId,trackId,frame,xCenter,yCenter,heading,width,length,xVelocity,yVelocity\n",
    );
    for frame in 0..50 {
        let _ = writeln!(rows, "18,1,{frame},{},0,0,2,4,10,0", f64::from(frame) * 0.4);
    }
    let write = |path: PathBuf, text: &str| std::fs::write(path, text).expect("written");
    write(folder.join("18_tracks.csv"), &rows);
    write(
        folder.join("18_tracksMeta.csv"),
        "recordingId,trackId,initialFrame,finalFrame,numFrames,width,length,class\n18,1,0,49,50,2,4,car\n",
    );
    write(
        folder.join("18_recordingMeta.csv"),
        "recordingId,locationId,frameRate,xUtmOrigin,yUtmOrigin\n18,4,25,0,0\n",
    );
    let node = |id: i64, x: i64, y: i64| {
        format!(
            "<node id='{id}' lat='50' lon='6'><tag k='local_x' v='{x}'/><tag k='local_y' v='{y}'/></node>"
        )
    };
    let way =
        |id: i64, a: i64, b: i64| format!("<way id='{id}'><nd ref='{a}'/><nd ref='{b}'/></way>");
    let osm = format!(
        "<osm>{}{}{}{}{}{}<relation id='9'><member type='way' ref='5' role='left'/><member type='way' ref='6' role='right'/><tag k='type' v='lanelet'/></relation></osm>",
        node(1, -10, 2),
        node(2, 90, 2),
        node(3, -10, -2),
        node(4, 90, -2),
        way(5, 1, 2),
        way(6, 3, 4)
    );
    write(maps.join("location4.osm"), &osm);
    let file = folder.join("18_tracks.csv").display().to_string();
    let ended = home.run(&["inspect", &file]).status(0);
    let said = "no Lanelet2 file (.osm) of place 4 beside it";
    assert!(ended.stdout.contains(said), "{}", ended.stdout);
    let config = format!("maps = \"{}\"\n", maps.display());
    home.write(home.config().join("config.toml"), config);
    let ended = home.run(&["inspect", &file]).status(0);
    assert!(ended.stdout.contains("location4.osm"), "{}", ended.stdout);
    let ended = home.run(&["config", "print"]).status(0);
    assert!(ended.stdout.contains("maps"), "{}", ended.stdout);
}

/// Real samples, compared with what a script of its own reads in their files.
#[test]
fn the_samples_are_what_their_files_hold() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let Some(shared) = crate::support::recorded::shared("") else {
        return;
    };
    let python = std::env::var("NEARMISS_PYTHON").unwrap_or_else(|_| "python3".into());
    let script = root.join("tests/support/recordings.py");
    for (kind, below, end) in [
        ("waymo", "waymo-motion", "tfrecord"),
        ("argoverse", "argoverse2", "parquet"),
    ] {
        let Some(file) = first_file(&shared.join(below), end) else {
            crate::support::program::skipped(&format!("no .{end} below {}", shared.display()));
            continue;
        };
        let home = Home::new();
        let into = home.files().join("converted.xml").display().to_string();
        let shown = file.display().to_string();
        home.run(&["convert", &shown, "-o", &into]).status(0);
        let source = match kind {
            "argoverse" => file.parent().expect("in a folder").to_path_buf(),
            _ => file,
        };
        let mut command = Command::new(&python);
        let Ok(ended) = command
            .arg(&script)
            .arg(kind)
            .arg(source)
            .arg(into)
            .output()
        else {
            crate::support::program::skipped(&format!("no {python}; set NEARMISS_PYTHON"));
            return;
        };
        let said = String::from_utf8_lossy(&ended.stdout).into_owned();
        match ended.status.code() {
            Some(0) => println!("{kind}: {said}"),
            // As the script says.
            Some(3) => crate::support::program::skipped(&format!("{kind}: {said}")),
            _ => panic!("{kind}: {said}{}", String::from_utf8_lossy(&ended.stderr)),
        }
    }
}

/// The first file whose name ends so, in a folder or below.
fn first_file(folder: &Path, end: &str) -> Option<PathBuf> {
    let mut paths: Vec<PathBuf> = { folder.read_dir().ok()?.flatten() }
        .map(|f| f.path())
        .collect();
    paths.sort();
    paths.into_iter().find_map(|path| {
        if path.is_dir() {
            first_file(&path, end)
        } else {
            path.extension().is_some_and(|e| e == end).then_some(path)
        }
    })
}
