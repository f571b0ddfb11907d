//! Tables of tracks in commands: options that apply, files that are never written over, names of egos, damaged files.

use std::fmt::Write;

use super::CUT_IN;
use super::support::program::Home;

/// Four seconds of `a` and `b`, one behind the other; `more` is a further column with its value.
fn table(more: Option<(&str, &str)>) -> String {
    let (name, value) = more.map_or(Default::default(), |(name, value)| {
        (format!(",{name}"), format!(",{value}"))
    });
    let mut text = format!("t,id,x,y{name}\n");
    for (id, ahead) in [("a", 0), ("b", 15)] {
        for step in 0..40 {
            let _ = writeln!(
                text,
                "{}.{},{id},{},0{value}",
                step / 10,
                step % 10,
                ahead + step
            );
        }
    }
    text
}

#[test]
fn options_for_tables_that_apply_to_nothing_are_refused() {
    let home = Home::new();
    home.write("t.csv", table(None));
    home.run(&["convert", CUT_IN, "-o", "s.xml"]).status(0);
    for option in ["--columns=time=t", "--rate=10", "--map=s.xml"] {
        let name = option.split('=').next().unwrap();
        for command in [
            &["inspect", "s.xml"][..],
            &["metrics", "s.xml"],
            &["describe", "s.xml"],
            &["inspect", CUT_IN],
        ] {
            let said = [name, "applies to tables of tracks", "leave it out"];
            home.run(&[command, &[option]].concat())
                .status(2)
                .says(&said);
        }
    }
    // To a table among others they apply.
    let both = ["inspect", "t.csv", "s.xml"];
    for option in ["--columns=time=t", "--map=s.xml"] {
        home.run(&[&both[..], &[option]].concat()).status(0);
    }
    home.write("cut.parquet", "PAR1 cut");
    home.run(&["inspect", "cut.parquet", "--rate=10"])
        .status(2)
        .says(&["the file is damaged"]);
    home.run(&["inspect", "missing.xml", "--map=s.xml"])
        .status(2)
        .says(&["no such file"]);
}

#[test]
fn no_recording_is_written_over() {
    let home = Home::new();
    let text = table(None);
    home.write("t.csv", &text);
    let onto_itself = ["-o", "./t.csv", "--overwrite"];
    for command in [
        &["convert", "t.csv"][..],
        &["convert", "t.csv", "--from=1s", "--to=2s"],
        &["metrics", "t.csv"],
        &["inspect", "t.csv"],
        &["inspect", "t.csv", CUT_IN, "--diff"],
        &["describe", "t.csv", "--story"],
        &["render", "t.csv", "--format=svg"],
    ] {
        home.run(&[command, &onto_itself].concat())
            .status(2)
            .says(&["t.csv: is one of the input scenarios"]);
    }
    let now = std::fs::read_to_string(home.files().join("t.csv")).unwrap();
    assert_eq!(now, text);
    // A part of a scenario of CommonRoad is another one.
    home.run(&["convert", CUT_IN, "-o", "s.xml"]).status(0);
    home.run(&["convert", "s.xml", "--to=1s", "-o", "s.xml", "--overwrite"])
        .status(2)
        .says(&["is one of the input scenarios"]);
}

#[test]
fn names_are_egos_where_all_rows_are_of_one_scenario() {
    let home = Home::new();
    home.write("t.csv", table(Some(("scenario", "one"))));
    for file in ["t.csv", "t.csv#one"] {
        let said = home.run(&["inspect", file, "--ego", "b"]).status(0).stdout;
        assert!(said.contains("obstacle 2 taken as ego"), "{said}");
    }
}

#[test]
fn maps_of_the_configuration_are_relative_to_its_file() {
    let home = Home::new();
    home.write("t.csv", table(None));
    home.run(&["convert", CUT_IN, "-o", "s.xml"]).status(0);
    std::fs::rename(home.files().join("s.xml"), home.config().join("s.xml")).unwrap();
    let config = "[tracks.own]\ncolumns = \"time=t,id=id,x=x,y=y\"\nmap = \"s.xml\"\n";
    home.write(home.config().join("config.toml"), config);
    let said = home.run(&["inspect", "t.csv"]).status(0).stdout;
    assert!(
        !said.contains("0 lanelets") && said.contains("s.xml"),
        "{said}"
    );
}

#[test]
fn a_damaged_parquet_file_is_called_damaged() {
    let home = Home::new();
    home.write("t.csv", table(None));
    home.run(&["convert", "t.csv", "-o", "t.parquet"]).status(0);
    let whole = std::fs::read(home.files().join("t.parquet")).unwrap();
    // Its end; a page of values; what it says of its columns.
    let cut = whole[..whole.len() / 2].to_vec();
    let with = |place: usize, count: usize| {
        let mut bytes = whole.clone();
        bytes[place..place + count]
            .iter_mut()
            .for_each(|byte| *byte ^= 0x5a);
        bytes
    };
    let footer = whole.len() - 200;
    for bytes in [cut, with(300, 100), with(footer, 50)] {
        home.write("damaged.parquet", bytes);
        let said = home.run(&["inspect", "damaged.parquet"]).status(2);
        said.says(&["the file is damaged"]);
    }
}

#[test]
fn each_road_user_may_have_a_file_of_its_own() {
    let home = Home::new();
    let whole = table(None);
    home.write("whole.csv", &whole);
    for name in ["a", "b"] {
        let mut own = String::from("t,x,y\n");
        for row in whole.lines().filter(|row| row.contains(name)) {
            let _ = writeln!(own, "{}", row.replace(&format!(",{name},"), ","));
        }
        home.write(format!("log/{name}.csv"), own);
    }
    home.write("log/about.csv", "what\nnothing\n");
    home.run(&["inspect", "log"])
        .status(2)
        .says(&["--columns id=file"]);
    let one = home.run(&["inspect", "log", "--columns=id=file", "--format=csv"]);
    let rows = one.status(0).stdout;
    assert_eq!(rows.lines().count(), 2, "a scenario: {rows}");
    let metrics = |of: &[&str]| {
        let all = [&["metrics", "--format=csv"], of].concat();
        let text = home.run(&all).status(0).stdout;
        let rows = text.lines().skip(1).map(|row| {
            let cells = row.split(',').skip(4);
            cells.map(str::to_string).collect::<Vec<_>>().join(",")
        });
        rows.collect::<Vec<_>>()
    };
    let of_files = metrics(&["log/b.csv", "--columns=id=file"]);
    assert!(of_files.len() > 1);
    assert_eq!(of_files, metrics(&["whole.csv"]));
}
