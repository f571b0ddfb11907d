//! `convert` for simulators: two files, the ego as asked for, nothing overwritten.

use super::CUT_IN;
use super::support::program::Home;

#[test]
fn both_files_are_written_once_and_open_again() {
    let home = Home::new();
    let ended = home.run(&["convert", CUT_IN, "-o", "a.xosc"]).status(0);
    assert_eq!(ended.stdout, "");
    assert!(ended.stderr.contains("properties"), "{}", ended.stderr);
    home.run(&["convert", CUT_IN, "-o", "a.xosc"]).status(2);
    home.run(&["convert", CUT_IN, "-o", "a.xosc", "--overwrite"])
        .status(0);
    home.run(&["inspect", "a.xosc"]).status(0);
    home.run(&["inspect", "a.xodr"]).status(0);
    home.run(&["metrics", "a.xosc"]).status(0);
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
    home.run(&["convert", CUT_IN, "--to", "openscenario"])
        .status(2);
}
