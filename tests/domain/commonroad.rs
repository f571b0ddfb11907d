//! Reading and writing CommonRoad files: identity, damage, and real files where they are at hand.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod random;

use std::path::{Path, PathBuf};

use nearmiss::formats::commonroad::{conform, read, write};
use nearmiss::scenario::{ContentHash, Scenario};

/// What is compared: everything but the hash of the bytes and what was said about them.
fn essence(mut scenario: Scenario) -> Scenario {
    scenario.hash = ContentHash::digest(b"");
    scenario.diagnostics.clear();
    scenario.header.version = "2020a".into();
    // The schema has an order of the roles; files are read in any.
    scenario.obstacles.sort_by_key(|o| o.role);
    scenario
}

fn scenarios_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(scenarios_below(&path));
        } else if path.extension().is_some_and(|x| x == "xml") {
            found.push(path);
        }
    }
    found
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The first part in which two scenarios differ.
fn difference(a: &Scenario, b: &Scenario) -> Option<&'static str> {
    let parts = [
        ("header", a.header == b.header),
        ("location", a.location == b.location),
        ("tags", a.tags == b.tags),
        ("lanelets", a.network.lanelets == b.network.lanelets),
        ("signs", a.network.signs == b.network.signs),
        ("lights", a.network.lights == b.network.lights),
        (
            "intersections",
            a.network.intersections == b.network.intersections,
        ),
        ("obstacles", a.obstacles == b.obstacles),
        (
            "planning problems",
            a.planning_problems == b.planning_problems,
        ),
        ("all", a == b),
    ];
    parts
        .into_iter()
        .find(|(_, same)| !same)
        .map(|(part, _)| part)
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(256))]

    #[test]
    fn any_scenario_is_written_and_read_back_the_same(scenario in random::scenario()) {
        let written = write(&scenario).unwrap();
        let read = read(&written, "written").unwrap_or_else(|e| panic!("{e}"));
        let (before, after) = (essence(scenario), essence(read));
        if let Some(part) = difference(&before, &after) {
            panic!("{part}:\n{before:#?}\nbecame\n{after:#?}");
        }
        // What fits the schema once, fits it again without a change.
        let fitted = conform(&before);
        proptest::prop_assert_eq!(conform(&fitted.scenario).changes, Vec::<String>::new());
    }
}

fn is_kept(path: &Path) {
    let name = path.display().to_string();
    let Ok(first) = read(&std::fs::read(path).unwrap(), &name) else {
        return;
    };
    let written = write(&first).unwrap();
    let second = read(&written, &name).unwrap_or_else(|e| panic!("what was written: {e}"));
    let differs = difference(&essence(first), &essence(second.clone()));
    assert_eq!(differs, None, "{name} is not kept");
    assert!(
        write(&second).unwrap() == written,
        "{name}: the second writing differs"
    );
}

#[test]
fn reading_what_was_written_gives_the_same_scenario() {
    let bundled = scenarios_below(&root().join("scenarios"));
    assert_eq!(bundled.len(), 8);
    bundled.iter().for_each(|path| is_kept(path));
}

#[test]
fn real_files_are_kept_too() {
    let Some(shared) = crate::support::recorded::shared("") else {
        return;
    };
    let files = scenarios_below(&shared);
    assert!(!files.is_empty());
    let lost: Vec<_> = files
        .iter()
        .filter(|path| std::panic::catch_unwind(|| is_kept(path)).is_err())
        .collect();
    assert!(lost.is_empty(), "{lost:#?}");
}

/// A small generator, so that the places are the same every time.
struct Places(u64);

impl Places {
    fn next(&mut self, below: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % below
    }
}

#[test]
fn damage_gives_an_error_or_a_scenario_and_never_a_panic() {
    let path = root().join("scenarios/ZAM_CutIn-1_1_T-1.xml");
    let whole = std::fs::read(path).unwrap();
    let mut places = Places(7);
    let mut refused = 0;
    for _ in 0..250 {
        let cut = &whole[..places.next(whole.len() - 20)];
        let error = read(cut, "cut").expect_err("a file without its end is no scenario");
        assert!(error.line > 0 || cut.is_empty(), "{error}");
        let mut flipped = whole.clone();
        let at = places.next(flipped.len());
        flipped[at] ^= 1 << places.next(8);
        if let Err(error) = read(&flipped, "flipped") {
            refused += 1;
            assert!(error.line > 0 && !error.message.is_empty(), "{error}");
        }
    }
    assert!(refused > 25, "only {refused} flips were noticed");
}

#[test]
fn bombs_are_harmless() {
    let deep = format!("<commonRoad timeStepSize=\"0.1\">{}", "<a>".repeat(200_000));
    assert!(read(deep.as_bytes(), "deep").is_err());
    let groups = "<shapeGroup>".repeat(50_000);
    let nested =
        format!("<commonRoad timeStepSize=\"0.1\"><staticObstacle id=\"1\"><shape>{groups}");
    assert!(read(nested.as_bytes(), "nested").is_err());
    let entities = "<!DOCTYPE x [<!ENTITY a \"aaaa\"><!ENTITY b \"&a;&a;\">]><commonRoad timeStepSize=\"0.1\"><lanelet id=\"1\"><leftBound><point><x>&b;</x></point></leftBound></lanelet></commonRoad>";
    let error = read(entities.as_bytes(), "entities").unwrap_err();
    assert!(error.message.contains("entit"), "{error}");
    for number in ["NaN", "1e400", "-inf", "0x10", ""] {
        let text = format!(
            "<commonRoad timeStepSize=\"0.1\"><lanelet id=\"1\"><leftBound><point><x>{number}</x><y>0</y></point></leftBound></lanelet></commonRoad>"
        );
        let error = read(text.as_bytes(), "numbers").unwrap_err();
        assert!(error.element.ends_with("x"), "{number}: {error}");
    }
    // An element that begins and does not end, in UTF-16.
    let error = read(b"\xff\xfe<\0c\0", "utf16").unwrap_err();
    assert!(error.message.contains("truncated"), "{error}");
}

#[test]
fn version_2018b_and_what_refers_to_nothing() {
    let text = r#"<commonRoad timeStepSize="0.1" commonRoadVersion="2018b" benchmarkID="ZAM_test_0-1" tags="urban highway">
      <lanelet id="7">
        <leftBound><point><x>0</x><y>1</y></point><point><x>9</x><y>1</y></point></leftBound>
        <rightBound><point><x>0</x><y>0</y></point><point><x>9</x><y>0</y></point></rightBound>
        <successor ref="8"/><speedLimit>13.9</speedLimit>
      </lanelet>
      <obstacle id="9"><role>dynamic</role><type>car</type></obstacle>
      <intersection id="3"><incoming id="4"><incomingLanelet ref="6"/><isLeftOf ref="5"/></incoming></intersection>
    </commonRoad>"#;
    let scenario = read(text.as_bytes(), "old").unwrap();
    assert_eq!(scenario.tags, ["urban", "highway"]);
    let sign = &scenario.network.signs[0];
    assert_eq!(
        (sign.id, sign.elements[0].values[0].as_str()),
        (10_010, "13.9")
    );
    assert_eq!(scenario.network.lanelets[0].signs, [10_010]);
    for (line, element, what) in [
        (1, "commonRoad", "ZAM_test_0-1"),
        (5, "commonRoad/lanelet#7/successor", "refers to 8"),
        (5, "commonRoad/lanelet#7/speedLimit", "speed limit 13.9"),
        (
            8,
            "commonRoad/intersection#3/incoming#4/isLeftOf",
            "refers to 5",
        ),
        (
            8,
            "commonRoad/intersection#3/incoming#4/incomingLanelet",
            "refers to 6",
        ),
    ] {
        let mut said = scenario
            .diagnostics
            .iter()
            .filter(|d| d.message.contains(what));
        let said = said
            .next()
            .unwrap_or_else(|| panic!("{what}: {:#?}", scenario.diagnostics));
        assert_eq!((said.line, said.element.as_str()), (line, element));
    }
}

#[test]
fn names_that_cannot_be_written_are_left_out() {
    let text = "<commonRoad timeStepSize=\"0.1\" commonRoadVersion=\"2020a\" author=\"a\u{1}b\">\
        <scenarioTags><x<y/><urban/></scenarioTags></commonRoad>";
    let scenario = read(text.as_bytes(), "names").unwrap();
    assert_eq!(scenario.tags, ["urban"]);
    assert!(
        scenario
            .diagnostics
            .iter()
            .any(|d| d.message.contains("cannot be a tag"))
    );
    let written = String::from_utf8(write(&scenario).unwrap()).unwrap();
    assert!(written.contains("a\u{fffd}b") && read(written.as_bytes(), "written").is_ok());
}
