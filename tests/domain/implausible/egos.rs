//! Egos that cannot be true, beside a true scenario: told with their lines, or refused.

use nearmiss::formats::commonroad::read_solution;
use nearmiss::formats::{EgoError, read_ego};
use nearmiss::scenario::Ego;

use crate::implausible::{valid, xml};

/// A drive along lane 2 at 11 m/s, a row a step.
fn rows() -> Vec<[String; 6]> {
    (0..=20)
        .map(|step| {
            let x = 5.0 + 1.1 * f64::from(step);
            [
                step.to_string(),
                x.to_string(),
                "6".into(),
                "0".into(),
                "11".into(),
                "0".into(),
            ]
        })
        .collect()
}

fn read(rows: &[[String; 6]]) -> Result<Ego, EgoError> {
    let scenario = xml(&valid::scenario()).unwrap();
    let mut text =
        String::from("timestep,x_position,y_position,orientation,velocity,acceleration\n");
    for row in rows {
        text += &row.join(",");
        text.push('\n');
    }
    read_ego(text.as_bytes(), "ego.csv", &scenario, None)
}

/// What is said with a line.
fn told(ego: &Ego) -> Vec<(usize, &str)> {
    let with_line = ego.diagnostics.iter().filter(|d| d.line > 0);
    with_line.map(|d| (d.line, d.message.as_str())).collect()
}

#[test]
fn of_a_true_drive_nothing_is_said() {
    let ego = read(&rows()).unwrap();
    assert_eq!(told(&ego), []);
    assert_eq!(ego.diagnostics.len(), 1, "its size: {:?}", ego.diagnostics);
}

#[test]
fn each_untruth_is_told_with_its_line() {
    // Row, column, value; row 5 stands in line 7.
    for (row, column, value, line, words) in [
        (5, 1, "500", 7, "jumps"),
        (5, 4, "1e6", 7, "1000000 m/s is faster"),
        (5, 4, "90", 7, "changes from 11 to 90 m/s"),
        (5, 3, "90", 7, "is it in degrees?"),
        (5, 3, "3", 7, "turns by 172°"),
        (5, 5, "9000", 7, "is more than any vehicle can do"),
        (5, 2, "6000", 7, "m from every lanelet"),
        (5, 5, "1e-320", 7, "close to 0"),
        (20, 0, "900000", 22, "were left out"),
        (20, 0, "40", 22, "no states from time step 20 to 39"),
        (5, 0, "25", 8, "not in time order"),
    ] {
        let mut rows = rows();
        rows[row][column] = value.into();
        let ego = read(&rows).unwrap();
        let told = told(&ego);
        assert!(
            told.iter()
                .any(|(at, said)| *at == line && said.contains(words)),
            "{value}: {told:?}"
        );
    }
    let mut back = rows();
    back.reverse();
    let ego = read(&back).unwrap();
    assert!(told(&ego).contains(&(3, "the rows run backwards in time and were sorted")));
    let mut sparse = rows();
    for row in &mut sparse {
        row[0].push_str("00");
    }
    let ego = read(&sparse).unwrap();
    let told = told(&ego);
    assert!(
        told.iter()
            .any(|(_, said)| said.contains("only one state every 100 time steps")),
        "{told:?}"
    );
}

#[test]
fn what_nothing_follows_from_is_refused_with_its_line() {
    for (column, value, words) in [
        (1, "1e9", "coordinates are limited"),
        (2, "-3e7", "coordinates are limited"),
        (4, "1e12", "implausible"),
        (3, "1e300", "implausible"),
        (1, "inf", "expected a finite number"),
        (0, "1000000000", "at most 10000000"),
        (0, "nan", "column `timestep`"),
    ] {
        let mut rows = rows();
        rows[5][column] = value.into();
        let said = read(&rows).unwrap_err().to_string();
        assert!(
            said.contains(words) && said.contains("line 7"),
            "{value}: {said}"
        );
    }
}

#[test]
fn solutions_are_held_to_the_same() {
    let solution = |from: &str, to: &str| {
        let mut text = String::from(
            "<CommonRoadSolution benchmark_id=\"KS2:SM1:ZAM_Untrue-1_1_T-1:2020a\">\n\
             <ksTrajectory planningProblem=\"60\">\n",
        );
        for step in 0..=9 {
            let x = 5.0 + 1.1 * f64::from(step);
            text += &format!(
                "<ksState>\n<x>{x}</x><y>6</y><steeringAngle>0</steeringAngle><velocity>11</velocity>\
                 <orientation>0</orientation>\n<time>{step}</time></ksState>\n"
            );
        }
        text += "</ksTrajectory>\n</CommonRoadSolution>\n";
        assert!(text.contains(from));
        text.replacen(from, to, 1)
    };
    let read = |text: &str| read_solution(text.as_bytes(), "s.xml");
    assert_eq!(read(&solution("", "")).unwrap().diagnostics, []);
    for (from, to, line, words) in [
        ("<velocity>11<", "<velocity>900<", 4, "velocity is 900 m/s"),
        (
            "<orientation>0<",
            "<orientation>90<",
            4,
            "is it in degrees?",
        ),
        (
            "<steeringAngle>0<",
            "<steeringAngle>30<",
            4,
            "steeringAngle is 30 rad",
        ),
        (
            "<time>9<",
            "<time>19<",
            30,
            "no states from time step 9 to 18",
        ),
        ("<time>5<", "<time>0.5<", 0, "not a whole number"),
        ("<x>5<", "<x>5e8<", 0, "coordinates are limited"),
        ("<time>9<", "<time>1000000000<", 0, "implausible"),
    ] {
        match read(&solution(from, to)) {
            Ok(solution) => {
                let said = &solution.diagnostics;
                let hit = said
                    .iter()
                    .any(|d| d.line == line && d.message.contains(words));
                assert!(line > 0 && hit, "{to}: {said:#?}");
            }
            Err(error) => {
                assert!(line == 0 && error.message.contains(words), "{to}: {error}");
                assert!(error.line > 3, "{error}");
            }
        }
    }
}
