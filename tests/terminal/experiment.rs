//! An experiment that is run in the workbench: the command line goes on with the same batch, and the other way round.

use super::Session;
use super::support::program::Home;

const TEXT: &str = "title = \"Is the judge right?\"\nscenarios = [\"ZAM_CutIn-1_1_T-1\", \"ZAM_RedLight-1_1_T-1\"]\n\
    models = [\"reference/geometry\"]\nleads = [0.5, 1]\ntruth = [\"labels.csv\"]\n";

/// The workbench on a file of the home.
fn workbench(home: &Home, file: &str) -> Session {
    let (config, data) = (home.config(), home.data());
    let environment = [
        ("NEARMISS_CONFIG", config.to_str().unwrap()),
        ("NEARMISS_DATA", data.to_str().unwrap()),
    ];
    let file = home.files().join(file);
    Session::start_with(120, 40, &environment, &[file.to_str().unwrap()])
}

fn labels(home: &Home) {
    let text = "scenario,collision\nZAM_CutIn-1_1_T-1,yes\nZAM_RedLight-1_1_T-1,no\n";
    home.write("labels.csv", text);
}

#[test]
fn workbench_and_command_line_ask_the_same_of_one_file() {
    let home = Home::new();
    labels(&home);
    home.write("e.toml", TEXT);
    let mut session = workbench(&home, "e.toml");
    session.see("Is the judge right?");
    session.see("new: not run yet");
    session.press("r");
    session.see("y begins a new batch");
    session.press("y");
    session.see("b1: every question has its answer");
    session.press("qq");
    assert_eq!(session.end(), 0);
    let again = home.run(&["evaluate", "e.toml", "--format=json"]).status(0);
    again.says(&["going on with b1, which asks what e.toml says"]);
    // And the other way round.
    home.write("f.toml", TEXT.replace("[0.5, 1]", "[1]"));
    let first = home.run(&["evaluate", "f.toml", "--format=json"]).status(0);
    assert!(!first.stderr.contains("going on"), "{}", first.stderr);
    let mut session = workbench(&home, "f.toml");
    session.see("b2: every question has its answer");
    session.press("qq");
    assert_eq!(session.end(), 0);
    let list = home.run(&["evaluate", "list"]).status(0).stdout;
    assert!(list.contains("b2 ") && !list.contains("b3 "), "{list}");
}

#[test]
fn a_file_with_mistakes_opens_the_workbench_and_says_them() {
    let home = Home::new();
    home.write("e.toml", "scenarios = [\"ZAM_CutIn-1_1_T-1\"]\nmodel = 3\n");
    let mut session = workbench(&home, "e.toml");
    session.see("cannot be asked");
    session.see("e.toml:2: unknown key `model`; did you mean `models`?");
    session.press("qq");
    assert_eq!(session.end(), 0);
    // Beside scenarios, and without a terminal, it is refused.
    home.run(&["e.toml", "ZAM_CutIn-1_1_T-1"])
        .status(2)
        .says(&["e.toml: an experiment file names its scenarios; give it alone"]);
    home.run(&["e.toml"])
        .status(2)
        .says(&["nearmiss evaluate", "e.toml --dry-run"]);
}
