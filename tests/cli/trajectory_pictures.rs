//! The picture beside the words of the trajectory frame: their times, and one obstacle.

use super::CUT_IN;
use super::pictures::drawn;
use super::support::program::Home;

#[test]
fn the_picture_has_the_times_of_its_words_and_one_obstacle() {
    let home = Home::new();
    let asked = |more: &[&'static str]| {
        let one = ["--frame", "trajectory+picture", "--obstacle", "301"];
        [&one[..], more].concat()
    };
    // No radius hides the obstacle, and the step in the recording is told.
    let usual = drawn(&home, CUT_IN, &asked(&["--at", "30"]));
    assert!(usual == drawn(&home, CUT_IN, &asked(&["--at", "30", "--set=radius=1"])));
    assert!(usual != drawn(&home, CUT_IN, &asked(&["--at", "31"])));
    let words = home
        .run(&[&["prompt", "describe", CUT_IN][..], &asked(&["--at", "30"])].concat())
        .status(0);
    for part in [
        "t = 2.20, 2.40, 2.60, 2.80, 3.00 s; the last panel",
        "shows only this one, with its id",
        "x axis of the map",
    ] {
        assert!(words.stdout.contains(part), "{part}: {}", words.stdout);
    }
    home.run(&[
        "prompt",
        "describe",
        CUT_IN,
        "--frame",
        "trajectory+picture",
    ])
    .status(2)
    .says(&["--obstacle"]);
}

#[test]
fn the_task_for_a_motion_takes_the_picture_and_tasks_without_a_template_do_not() {
    let home = Home::new();
    let frame = ["--frame", "trajectory+picture", "--obstacle", "301"];
    let prompt = |task: &'static str| {
        let all = [&["prompt", "show", CUT_IN, "--task", task][..], &frame].concat();
        home.run(&all)
    };
    prompt("trajectory").status(0);
    prompt("collision").status(2);
}
