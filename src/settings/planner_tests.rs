//! Tests of the keys of `[planner]`.
#![allow(clippy::unwrap_used)]
use super::*;

fn words(text: &str) -> Vec<String> {
    let section: Table = toml::from_str(text).unwrap();
    mistakes(&section)
        .into_iter()
        .map(|(_, words)| words)
        .collect()
}

#[test]
fn what_may_be_is_taken() {
    let text = "horizon = 3\nprediction = \"lane\"\nvehicle = 4\nshare = 1\n[sampling]\noffsets = 11\n\
        [weights]\nspeed = 0\nrisk = 2.5\n";
    assert_eq!(words(text), [""; 0]);
    let config = Config {
        planner: toml::from_str(text).unwrap(),
        ..Config::default()
    };
    let weights = config.planning().weights;
    let usual = Weights::default();
    assert_eq!(
        (weights.risk, weights.lateral_jerk),
        (2.5, usual.lateral_jerk)
    );
}

#[test]
fn what_may_not_be_is_named_with_what_is_needed() {
    for (text, said) in [
        (
            "horizon = 0",
            "planner.horizon = 0: expected a number from 0.5 to 20",
        ),
        ("horizon = nan", "planner.horizon = nan: expected a number"),
        (
            "horizon = \"4\"",
            "planner.horizon = \"4\": expected a number",
        ),
        (
            "replan = 1.5",
            "planner.replan = 1.5: expected a whole number from 1 to 1000",
        ),
        (
            "vehicle = 5",
            "planner.vehicle = 5: expected a whole number",
        ),
        (
            "prediction = \"oracle\"",
            "planner.prediction: unknown prediction `oracle`; available: recorded, constant-velocity, lane",
        ),
        (
            "horizn = 3",
            "unknown key `planner.horizn`; did you mean `horizon`?",
        ),
        (
            "sampling = 3",
            "planner.sampling = 3: expected a table of durations",
        ),
        (
            "[sampling]\noffsets = 4",
            "planner.sampling.offsets = 4: expected an odd number from 3 to 31",
        ),
        (
            "[weights]\nrisk = -1",
            "planner.weights.risk = -1: expected a number from 0 to 1000000",
        ),
        (
            "[weights]\nrisks = 1",
            "unknown key `planner.weights.risks`; did you mean `risk`?",
        ),
    ] {
        let found = words(text);
        assert!(found.len() == 1 && found[0].starts_with(said), "{found:?}");
    }
}

#[test]
fn settings_of_drives_are_the_same_by_key_and_back() {
    let usual = Settings::from(&Planning::default());
    assert_eq!(usual, nearmiss_study::evaluation::default_planning());
    let text = "horizon = 1.5\nreplan = 7\nprediction = \"recorded\"\ntraffic = \"reactive\"\nrules = \"off\"\n\
        vehicle = 4\nshare = 0.5\nlow_speed = 1\nmargin = 0.25\nbraking = 2\nreaction = 0.75\n\
        [sampling]\ndurations = 5\nspeeds = 6\noffsets = 7\nchanges = 3\nwidest = 2\nrefinements = 1\n\
        [weights]\nlongitudinal_jerk = 11\nlateral_jerk = 12\nacceleration = 13\nspeed = 14\noffset = 15\n\
        clearance = 16\nfollowing = 17\nrisk = 18\n";
    let planning = Planning::from_table(&toml::from_str(text).unwrap()).unwrap();
    let settings = Settings::from(&planning);
    assert_eq!(Planning::from(&settings), planning);
    assert_eq!(settings.planner.vehicle, VehicleType::Truck);
    assert_eq!(settings.traffic, TrafficMode::Reactive);
    let (values, before) = (Planning::values(&settings), Planning::values(&usual));
    assert_eq!(values.len(), 25);
    for (value, before) in values.iter().zip(before) {
        assert!(value.0 == before.0 && value.1 != before.1, "{value:?}");
    }
}

fn read(text: &str) -> Result<Config, String> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("config.toml");
    std::fs::write(&file, text).unwrap();
    Config::read(&file).map_err(|error| error.to_string())
}

#[test]
fn planners_stand_beside_the_keys_of_the_built_in_one() {
    let config = read(
        "[planner]\nhorizon = 3\n[planner.weights]\nspeed = 2\n\
         [planner.lab]\ncommand = \"python3 'my planner.py' --fast\"\ntimeout = 0.5\nhistory = 10\n\
         [planner.other]\ncommand = [\"./other\", \"a b\"]\nstart_timeout = 120\npredictions = true\n",
    );
    let planners = config.unwrap().external_planners();
    let names: Vec<&str> = planners.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["lab", "other"]);
    let (lab, other) = (&planners[0].1, &planners[1].1);
    assert_eq!(lab.command, ["python3", "my planner.py", "--fast"]);
    assert_eq!((lab.cycle, lab.history), (Duration::from_millis(500), 10));
    assert_eq!(lab.start, ExternalOptions::START);
    assert_eq!(other.command, ["./other", "a b"]);
    assert_eq!(
        (other.start, other.predictions),
        (Duration::from_secs(120), true)
    );
}

#[test]
fn what_a_planner_may_not_be_is_named_with_its_line() {
    for (text, said) in [
        ("timeout = 1", ":1: planner.lab: command is missing"),
        (
            "command = \"\"",
            ":2: planner.lab.command = \"\": expected a command",
        ),
        ("command = \"a 'b\"", ":2: planner.lab.command"),
        (
            "command = \"a\"\ntimeout = 0",
            ":3: planner.lab.timeout = 0: expected a number from 0.001",
        ),
        (
            "command = \"a\"\ntimout = 1",
            ":3: unknown key `planner.lab.timout`; did you mean `timeout`?",
        ),
        (
            "command = \"a\"\nhistory = 1.5",
            ":3: planner.lab.history = 1.5: expected a whole number",
        ),
        (
            "command = \"a\"\npredictions = 1",
            ":3: planner.lab.predictions = 1: expected true",
        ),
    ] {
        let error = read(&format!("[planner.lab]\n{text}\n")).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
    let error = read("[planner.wieghts]\nspeed = 1\n").unwrap_err();
    assert!(error.contains("did you mean `weights`?"), "{error}");
    let error = read("[planner.horizon]\ncommand = \"a\"\n").unwrap_err();
    assert!(
        error.contains("planner.horizon = a table: expected a number"),
        "{error}"
    );
}
