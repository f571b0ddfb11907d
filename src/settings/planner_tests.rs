//! Tests of the keys of `[planner]`.
#![allow(clippy::unwrap_used)]
use super::*;

fn words(text: &str) -> Vec<String> {
    let section: Table = toml::from_str(text).unwrap();
    wrong(&section)
        .into_iter()
        .map(|(_, words)| words)
        .collect()
}

#[test]
fn what_may_be_is_taken() {
    let text = "horizon = 3\nprediction = \"lane\"\nvehicle = 4\nshare = 1\n[sampling]\noffsets = 11\n\
        [weights]\nspeed = 0\nrisk = 2.5\n";
    assert_eq!(words(text), [""; 0]);
    let section: Table = toml::from_str(text).unwrap();
    let risk = PlannerKey::named("weights.risk").unwrap();
    assert_eq!(stated_value(&section, risk), Some(&Value::Float(2.5)));
    let jerk = PlannerKey::named("weights.lateral_jerk").unwrap();
    assert_eq!(stated_value(&section, jerk), None);
}

#[test]
fn what_may_not_be_is_named_with_what_is_needed() {
    for (text, said) in [
        (
            "horizon = 0",
            "planner.horizon = 0: expected a number from 0.5 to 20 s",
        ),
        ("horizon = nan", "planner.horizon = nan: expected a number"),
        (
            "horizon = \"4\"",
            "planner.horizon = \"4\": expected a number",
        ),
        (
            "replan = 1.5",
            "planner.replan = 1.5: expected a whole number from 1 to 1000 steps",
        ),
        (
            "vehicle = 5",
            "planner.vehicle = 5: expected a whole number",
        ),
        (
            "prediction = \"oracle\"",
            "planner.prediction = \"oracle\": expected \"recorded\", \"constant-velocity\" or \"lane\"",
        ),
        (
            "horizn = 3",
            "unknown key `planner.horizn`; did you mean `horizon`?",
        ),
        (
            "sampling = 3",
            "planner.sampling = 3: expected a table: [planner.sampling]",
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
            "unknown key `planner.weights.risks`; did you mean `weights.risk`?",
        ),
    ] {
        let found = words(text);
        assert!(found.len() == 1 && found[0].starts_with(said), "{found:?}");
    }
}

#[test]
fn every_key_is_a_setting_of_its_own() {
    let mut settings = nearmiss_study::evaluation::default_planning();
    let number = |value: Value| value.as_float().or(value.as_integer().map(|n| n as f64));
    let knobs = || {
        PlannerKey::ALL
            .iter()
            .filter(|key| !["prediction", "traffic", "rules", "vehicle"].contains(&key.id))
    };
    for key in PlannerKey::ALL {
        assert!(key.allows(&key.value(&settings)), "{}", key.id);
    }
    for (place, key) in knobs().enumerate() {
        (key.set)(&mut settings, &Value::Integer(1000 + place as i64));
    }
    for (place, key) in knobs().enumerate() {
        assert_eq!(
            number(key.value(&settings)),
            Some(1000.0 + place as f64),
            "{}",
            key.id
        );
    }
    let mut set =
        |id: &str, value: Value| PlannerKey::named(id).unwrap().set(&mut settings, &value);
    assert_eq!(set("vehicle", Value::Integer(4)), Ok(()));
    assert_eq!(set("prediction", "recorded".into()), Ok(()));
    assert_eq!(set("traffic", "reactive".into()), Ok(()));
    assert_eq!(set("rules", "off".into()), Ok(()));
    for (id, value) in [
        ("vehicle", Value::Integer(7)),
        ("prediction", "oracle".into()),
        ("horizon", "4".into()),
    ] {
        assert!(set(id, value).is_err(), "{id}");
    }
    assert_eq!(settings.planner.vehicle, VehicleType::Truck);
    assert_eq!(settings.forecast, Forecast::Recorded);
    assert_eq!(settings.traffic, TrafficMode::Reactive);
    assert_eq!(settings.planner.rules, RuleMode::Off);
}
