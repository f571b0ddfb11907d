//! Encodings and byte order marks: read as what they are, or refused in words; structure out of proportion.

use nearmiss::formats::commonroad::{Root, read, read_solution, root_of};
use nearmiss::formats::read_ego;
use nearmiss::scenario::Scenario;

use crate::implausible::{valid, xml};

const MARK: &str = "\u{feff}";

/// What is in a scenario without what depends on its bytes.
fn essence(mut scenario: Scenario) -> Scenario {
    scenario.hash = nearmiss::scenario::ContentHash::digest(b"");
    scenario.diagnostics.clear();
    scenario
}

#[test]
fn byte_order_marks_in_front_change_nothing_and_many_are_told() {
    let text = valid::scenario();
    let plain = xml(&text).unwrap();
    for marks in 0..5 {
        let marked = format!("{}{text}", MARK.repeat(marks));
        assert_eq!(root_of(marked.as_bytes()), Root::Scenario);
        let scenario = xml(&marked).unwrap();
        let told = scenario
            .diagnostics
            .iter()
            .any(|d| d.line == 1 && d.message.contains("byte order marks"));
        assert_eq!(told, marks > 1, "{marks}: {:?}", scenario.diagnostics);
        assert_eq!(essence(scenario), essence(plain.clone()));
    }
}

#[test]
fn byte_order_marks_anywhere_give_an_error_or_a_scenario() {
    let text = valid::scenario();
    let mut refused = 0;
    let places: Vec<usize> = text.char_indices().map(|(at, _)| at).step_by(37).collect();
    for at in places {
        for marks in [1, 2] {
            let (before, behind) = text.split_at(at);
            let marked = format!("{before}{}{behind}", MARK.repeat(marks));
            if let Err(error) = xml(&marked) {
                refused += 1;
                assert!(error.line > 0 && !error.message.is_empty(), "{error}");
            }
        }
    }
    assert!(refused > 20, "only {refused} were noticed");
    let marked = text.replacen("<x>50<", "<x>\u{feff}50<", 1);
    let error = xml(&marked).unwrap_err();
    assert!(error.message.contains("byte order mark"), "{error}");
}

#[test]
fn other_encodings_are_read_or_named() {
    let text = valid::scenario();
    let wide = |marked: &str, unit: fn(u16) -> [u8; 2]| -> Vec<u8> {
        marked.encode_utf16().flat_map(unit).collect()
    };
    let wider = |marked: &str, unit: fn(u32) -> [u8; 4]| -> Vec<u8> {
        marked.chars().flat_map(|c| unit(c as u32)).collect()
    };
    let plain = essence(xml(&text).unwrap());
    for marked in [text.clone(), format!("{MARK}{text}")] {
        for unit in [u16::to_le_bytes, u16::to_be_bytes] {
            let bytes = wide(&marked, unit);
            let same = read(&bytes, "wide.xml").unwrap();
            assert_eq!(same.hash, nearmiss::scenario::ContentHash::digest(&bytes));
            assert_eq!(essence(same), plain);
        }
    }
    let unmarked = wide(&format!(" \n{text}"), u16::to_le_bytes);
    assert!(
        read(&unmarked, "wide.xml")
            .unwrap_err()
            .message
            .contains("zero byte")
    );
    for marked in [text.clone(), format!("{MARK}{text}"), format!(" \n{text}")] {
        for bytes in [
            wider(&marked, u32::to_le_bytes),
            wider(&marked, u32::to_be_bytes),
        ] {
            let said = read(&bytes, "wide.xml").unwrap_err();
            let told = ["UTF-32", "zero byte", "no text"]
                .iter()
                .any(|words| said.message.contains(words));
            assert!(told && said.line > 0, "{said}");
        }
    }
    let latin = |declared: &str| -> Vec<u8> {
        let named = text.replacen("UTF-8", declared, 1).replacen(
            "author=\"a\"",
            "author=\"M\u{fc}ller\"",
            1,
        );
        named.chars().map(|c| c as u8).collect()
    };
    let declared = read(&latin("ISO-8859-1"), "latin.xml").unwrap();
    assert_eq!(declared.header.attributes["author"], "M\u{fc}ller");
    let said = read(&latin("UTF-8"), "latin.xml").unwrap_err();
    assert!(
        said.line == 2 && said.message.contains("0xfc is not UTF-8"),
        "{said}"
    );
    let named = text.replacen("UTF-8", "UTF-16", 1);
    let said = xml(&named).unwrap().diagnostics;
    assert!(
        said.iter()
            .any(|d| d.line == 1 && d.message.contains("`UTF-16`")),
        "{said:?}"
    );
}

#[test]
fn zero_bytes_are_refused_with_their_line() {
    let text = valid::scenario();
    // Beside the first character it would look like UTF-16.
    for (at, _) in text.char_indices().skip(2).step_by(211) {
        let (before, behind) = text.split_at(at);
        let line = 1 + before.matches('\n').count();
        let error = xml(&format!("{before}\0{behind}")).unwrap_err();
        assert!(
            error.message.contains("zero byte") && error.line == line,
            "{error}"
        );
    }
}

#[test]
fn recordings_and_solutions_with_many_marks_are_read() {
    let scenario = xml(&valid::scenario()).unwrap();
    let csv = "timestep,x_position,y_position\n0,5,6\n1,6,6\n2,7,6\n";
    let solution = "<CommonRoadSolution benchmark_id=\"KS2:SM1:ZAM_Untrue-1_1_T-1:2020a\">\n\
        <ksTrajectory planningProblem=\"60\">\n\
        <ksState><x>5</x><y>6</y><steeringAngle>0</steeringAngle><velocity>11</velocity><orientation>0</orientation><time>0</time></ksState>\n\
        <ksState><x>6.1</x><y>6</y><steeringAngle>0</steeringAngle><velocity>11</velocity><orientation>0</orientation><time>1</time></ksState>\n\
        </ksTrajectory>\n</CommonRoadSolution>\n";
    for marks in 0..4 {
        let marks = MARK.repeat(marks);
        let marked = format!("{marks}{csv}");
        let ego = read_ego(marked.as_bytes(), "e.csv", &scenario, None).unwrap();
        assert_eq!(ego.track.iter().count(), 3);
        let marked = format!("{marks}{solution}");
        read_solution(marked.as_bytes(), "s.xml").unwrap();
        let ego = read_ego(marked.as_bytes(), "s.xml", &scenario, None).unwrap();
        assert_eq!(ego.track.iter().count(), 2);
    }
}

#[test]
fn depth_and_attributes_are_bounded() {
    let open = "<commonRoad timeStepSize=\"0.1\">";
    let deep = format!("{open}{}{}", "<a>".repeat(5_000), "</a>".repeat(5_000));
    let error = xml(&deep).unwrap_err();
    assert!(error.message.contains("more than 100 deep"), "{error}");
    let fine = format!(
        "{open}{}{}</commonRoad>",
        "<a>".repeat(50),
        "</a>".repeat(50)
    );
    assert!(xml(&fine).is_ok());
    let long = format!(
        "<commonRoad author=\"{}\" timeStepSize=\"0.1\"/>",
        "a".repeat(70_000)
    );
    let error = xml(&long).unwrap_err();
    assert!(
        error
            .message
            .contains("attributes of <commonRoad> take 68 KiB"),
        "{error}"
    );
    let many: String = (0..20_000).map(|i| format!(" a{i}=\"1\"")).collect();
    let error = xml(&format!("{open}<lanelet id=\"1\"{many}/></commonRoad>")).unwrap_err();
    assert!(error.message.contains("at most 64 KiB"), "{error}");
}
