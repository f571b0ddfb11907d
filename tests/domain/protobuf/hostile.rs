//! Damaged and hostile files: an error or a diagnostic with its place, never a panic, never much memory or time.

use std::time::{Duration, Instant};

use nearmiss::formats::commonroad::{ReadError, read, read_file};
use tempfile::tempdir;

use super::encode::wire::{Bytes, message, point};
use super::{rich, single, triple};

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

fn says_where(error: &ReadError) {
    assert!(
        !error.message.is_empty() && !error.file.is_empty(),
        "{error}"
    );
}

#[test]
fn a_damaged_single_message_gives_an_error_or_a_scenario() {
    let whole = single::encode(&rich());
    let mut places = Places(7);
    let (mut cuts, mut flips) = (0, 0);
    for _ in 0..500 {
        let cut = &whole[..places.next(whole.len())];
        if let Err(error) = read(cut, "cut.pb") {
            cuts += 1;
            says_where(&error);
        }
        let mut flipped = whole.clone();
        let at = places.next(flipped.len());
        flipped[at] ^= 1 << places.next(8);
        if let Err(error) = read(&flipped, "flipped.pb") {
            flips += 1;
            says_where(&error);
        }
    }
    // A cut between two elements leaves a whole message.
    assert!(cuts > 450, "only {cuts} of 500 cuts were noticed");
    assert!(flips > 100, "only {flips} of 500 flips were noticed");
}

#[test]
fn damage_in_any_of_the_three_files_gives_an_error_or_a_scenario() {
    let rich = rich();
    let (encoded, names) = (triple::encode(&rich), triple::names(&rich));
    let folder = tempdir().unwrap();
    let file = triple::write(folder.path(), &encoded, &names);
    let mut places = Places(11);
    let mut refused = 0;
    for (name, whole) in [
        (&names.map, &encoded.map),
        (&names.dynamic, &encoded.dynamic),
        (&names.scenario, &encoded.scenario),
    ] {
        let path = folder.path().join(format!("{name}.pb"));
        for i in 0..170 {
            let mut bytes = whole.clone();
            let at = places.next(bytes.len());
            if i % 2 == 0 {
                bytes.truncate(at);
            } else {
                bytes[at] ^= 1 << places.next(8);
            }
            std::fs::write(&path, bytes).unwrap();
            if let Err(error) = read_file(&file) {
                refused += 1;
                says_where(&error);
            }
        }
        std::fs::write(&path, whole).unwrap();
    }
    assert!(refused > 250, "only {refused} of 510 were noticed");
    assert!(read_file(&file).is_ok());
}

/// A single message with the least that is required, and `more`.
fn with(more: impl FnOnce(Bytes) -> Bytes) -> Result<nearmiss::scenario::Scenario, ReadError> {
    let date = message().whole(1, 2026).whole(2, 1).whole(3, 2);
    let information = message()
        .text(1, "2020a")
        .text(2, "ZAM_Test-1_1_T-1")
        .inner(3, date)
        .text(4, "")
        .text(5, "")
        .text(6, "")
        .double(7, 0.1);
    let location = message().whole(1, -999).double(2, 999.0).double(3, 999.0);
    let least = message()
        .inner(1, information)
        .inner(2, message())
        .inner(3, location);
    read(&more(least).0, "x.pb")
}

/// What is wrong with it.
fn fault(more: impl FnOnce(Bytes) -> Bytes) -> String {
    with(more).expect_err("it should be refused").to_string()
}

fn lanelet(left: Bytes, right: Bytes) -> Bytes {
    message().whole(1, 7).inner(2, left).inner(3, right)
}

fn bound(points: &[(f64, f64)]) -> Bytes {
    message().each(points, |out, (x, y)| out.inner(1, point(*x, *y)))
}

fn obstacle(state: Bytes, body: Bytes) -> Bytes {
    message()
        .whole(1, 9)
        .whole(2, 1)
        .inner(3, body)
        .inner(4, state)
}

fn circle() -> Bytes {
    message().inner(2, message().double(1, 1.0))
}

fn at_step(step: i64) -> Bytes {
    message()
        .inner(1, point(0.0, 0.0))
        .inner(39, message().whole(1, step))
}

#[test]
fn numbers_out_of_reason_are_named() {
    assert!(with(|out| out).is_ok());
    let good = [(0.0, 0.0), (1.0, 0.0)];
    for number in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let bad = bound(&[(0.0, 1.0), (number, 1.0)]);
        let fault = fault(|out| out.inner(4, lanelet(bad, bound(&good))));
        assert_eq!(
            fault,
            format!(
                "x.pb: in lanelets[0]/left_bound/points[1]/x: `{number}` is not a finite number"
            )
        );
    }
    let fault = |more: Bytes| fault(|out| out.inner(9, more));
    let late = fault(obstacle(at_step(2_000_000_000), circle()));
    assert!(
        late.contains("initial_state/time_step: time step 2000000000 is implausible"),
        "{late}"
    );
    let none = message().inner(2, message().double(1, -1.0));
    let negative = fault(obstacle(at_step(0), none));
    assert!(
        negative.contains("dynamic_obstacles[0]/shape: radius is -1"),
        "{negative}"
    );
    let backwards = message()
        .inner(1, point(0.0, 0.0))
        .inner(4, message().inner(2, point(3.0, 1.0)))
        .inner(39, message().whole(1, 0));
    let empty = fault(obstacle(backwards, circle()));
    assert!(
        empty.contains("initial_state/velocity: the interval from 3 to 1 is empty"),
        "{empty}"
    );
}

#[test]
fn what_is_required_and_missing_is_named() {
    let cases: [(u32, Bytes, &str); 6] = [
        (
            4,
            message().whole(1, 7),
            "in lanelets[0]: the required field `left_bound` is missing",
        ),
        (
            5,
            message(),
            "in traffic_signs[0]: the required field `traffic_sign_id` is missing",
        ),
        (
            9,
            message().whole(1, 7),
            "in dynamic_obstacles[0]: the required field `obstacle_type` is missing",
        ),
        (
            9,
            obstacle(message(), circle()),
            "initial_state: the required field `time_step` is missing",
        ),
        (
            11,
            message().whole(1, 7).inner(2, message()),
            "in phantom_obstacles[0]/prediction: the required field `initial_time_step`",
        ),
        (
            12,
            message(),
            "in planning_problems[0]: the required field `planning_problem_id` is missing",
        ),
    ];
    for (number, message, expected) in cases {
        let fault = fault(|out| out.inner(number, message));
        assert!(fault.contains(expected), "{expected}: {fault}");
    }
    let information = message().text(1, "2020a").text(2, "ZAM_Test-1");
    let error = read(&message().inner(1, information).0, "x.pb").unwrap_err();
    assert!(
        error
            .to_string()
            .contains("in information: the required field"),
        "{error}"
    );
}

#[test]
fn what_is_not_known_is_left_out_and_noted() {
    let known = with(|out| {
        let good = bound(&[(0.0, 0.0), (1.0, 0.0)]);
        let left = bound(&[(0.0, 3.0), (1.0, 3.0)]);
        out.inner(4, lanelet(left, good).whole(11, 77).text(99, "new"))
            .text(42, "new")
    });
    let said: Vec<_> = known
        .unwrap()
        .diagnostics
        .iter()
        .map(ToString::to_string)
        .collect();
    assert_eq!(said.len(), 3, "{said:#?}");
    assert!(
        said[0].starts_with("warning: lanelets[0]/lanelet_types[0]: unknown value 77"),
        "{}",
        said[0]
    );
    assert!(said[1].contains("field 42"), "{}", said[1]);
    assert!(
        said[2].contains("lanelets/unknown or repeated fields"),
        "{}",
        said[2]
    );
}

/// The fields of which it is said that characters in them were replaced.
fn replaced(scenario: &nearmiss::scenario::Scenario) -> Vec<&str> {
    let said = scenario
        .diagnostics
        .iter()
        .filter(|d| d.message.contains("U+FFFD"));
    said.map(|d| d.element.as_str()).collect()
}

#[test]
fn characters_that_xml_has_no_place_for_are_replaced_and_it_is_said_where() {
    let mut marked = rich();
    let author = marked.header.attributes.get_mut("author").unwrap();
    *author = " a\u{1b}b ".into();
    let location = marked.location.as_mut().unwrap();
    let place = location.transformation.as_mut().unwrap();
    place.reference = Some("\0+proj=utm\t+zone=32".into());
    let i = marked
        .network
        .signs
        .iter()
        .position(|s| !s.elements[0].values.is_empty())
        .unwrap();
    let values = &mut marked.network.signs[i].elements[0].values;
    values.push(" 5\u{7}0".into());
    let j = values.len() - 1;
    let check = |read: &nearmiss::scenario::Scenario| {
        assert_eq!(read.header.attributes["author"], "a\u{fffd}b");
        let place = read.location.as_ref().unwrap().transformation.as_ref();
        let reference = place.unwrap().reference.as_deref();
        assert_eq!(reference, Some("\u{fffd}+proj=utm\t+zone=32"));
        let signs = &read.network.signs;
        assert_eq!(signs[i].elements[0].values[j], "5\u{fffd}0");
    };
    let one = read(&single::encode(&marked), "x.pb").unwrap();
    check(&one);
    let value = format!("traffic_signs[{i}]/traffic_sign_elements[0]/additional_values[{j}]");
    assert_eq!(
        replaced(&one),
        [
            "information/author",
            "location/geo_transformation/geo_reference",
            &value
        ]
    );
    let folder = tempdir().unwrap();
    let names = triple::names(&marked);
    let file = triple::write(folder.path(), &triple::encode(&marked), &names);
    let three = read_file(&file).unwrap();
    check(&three);
    let said = replaced(&three);
    for field in [
        "scenario/scenario_meta_information/file_information/author",
        "dynamic/dynamic_meta_information/file_information/author",
        "map/map_meta_information/file_information/author",
        "map/location/geo_transformation/geo_reference",
    ] {
        assert!(said.contains(&field), "{field}: {said:#?}");
    }
    let value = |s: &&str| s.ends_with(&format!("/additional_values[{j}]"));
    assert!(said.iter().any(value), "{said:#?}");
}

#[test]
fn the_words_of_a_header_hold_no_control_characters() {
    let date = message().whole(1, 2026).whole(2, 1).whole(3, 2);
    let information = message()
        .text(1, "2020a\u{1}")
        .text(2, "ZAM_Test-1_1_T-1\u{2}")
        .inner(3, date)
        .text(4, "")
        .text(5, "b\u{3}")
        .text(6, "c\u{4}")
        .double(7, 0.1);
    let location = message().whole(1, -999).double(2, 999.0).double(3, 999.0);
    let file = message()
        .inner(1, information)
        .inner(2, message())
        .inner(3, location);
    let header = read(&file.0, "x.pb").unwrap();
    assert_eq!(header.header.benchmark_id, "ZAM_Test-1_1_T-1\u{fffd}");
    assert_eq!(
        replaced(&header),
        [
            "information/common_road_version",
            "information/benchmark_id",
            "information/affiliation",
            "information/source"
        ]
    );
}

#[test]
fn bombs_are_harmless() {
    let start = Instant::now();
    let nested = (0..20).fold(circle(), |inner, _| {
        message().inner(4, message().inner(1, inner))
    });
    let deep = fault(|out| out.inner(9, obstacle(at_step(0), nested)));
    assert!(deep.contains("nested deeper than 4"), "{deep}");
    let nested = (0..5_000).fold(circle(), |inner, _| {
        message().inner(4, message().inner(1, inner))
    });
    let deeper = fault(|out| out.inner(9, obstacle(at_step(0), nested)));
    assert!(deeper.contains("nested deeper than 4"), "{deeper}");
    // Two million empty states are four million bytes, and the first one is refused.
    let states = Bytes([0x12, 0x00].repeat(2_000_000));
    let trajectory = message().inner(1, Bytes([&[0x08, 0x01][..], &states.0].concat()));
    let many = obstacle(at_step(0), circle()).inner(5, trajectory.inner(2, circle()));
    let many = fault(|out| out.inner(9, many));
    assert!(
        many.contains("states[0]: the required field `time_step`"),
        "{many}"
    );
    let corners: Vec<_> = (0..2_000)
        .map(|i| (f64::from(i), f64::from(i % 2)))
        .collect();
    let polygon = message().inner(3, bound(&corners));
    let corners = fault(|out| out.inner(9, obstacle(at_step(0), polygon)));
    assert!(corners.contains("a polygon of 2000 corners"), "{corners}");
    let large = fault(|out| out.inner(4, Bytes(vec![0; 9 << 20])));
    assert!(large.contains("lanelets[0]: 9 MiB"), "{large}");
    assert!(
        start.elapsed() < Duration::from_secs(20),
        "{:?}",
        start.elapsed()
    );
}

#[test]
fn a_border_that_all_lanelets_share_does_not_fill_the_memory() {
    let id = message().text(1, "ZAM").text(2, "Test").whole(3, 1);
    let date = message().whole(1, 2026);
    let file = message()
        .text(1, "")
        .inner(3, date)
        .text(4, "")
        .text(5, "")
        .text(6, "");
    let map = message()
        .inner(1, message().inner(1, id).inner(2, file))
        .inner(2, message().whole(1, 0).double(2, 0.0).double(3, 0.0));
    let points: Vec<_> = (0..1000).map(|i| (f64::from(i), 0.0)).collect();
    let border = message()
        .whole(1, 5)
        .each(&points, |out, (x, y)| out.inner(2, point(*x, *y)));
    let map = map.inner(5, border);
    let lanelets = (1..).map(|i| message().whole(1, i).whole(2, 5).whole(3, 5));
    let few = map
        .clone()
        .each(lanelets.clone().take(32), |out, l| out.inner(3, l));
    assert_eq!(read(&few.0, "map.pb").unwrap().network.lanelets.len(), 32);
    let many = map.each(lanelets.take(50_000), |out, l| out.inner(3, l));
    let error = read(&many.0, "map.pb").unwrap_err();
    assert!(
        error.message.contains("boundary 5 borders more than 64"),
        "{error}"
    );
}
