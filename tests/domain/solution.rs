//! Reading and writing CommonRoad solutions: identity, damage, egos, and a real file where it is at hand.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeSet;

use nearmiss::formats::commonroad::{
    ProblemSolution, Solution, SolutionError, SolutionState, SolutionTrajectory, TrajectoryKind,
    read_solution, write_solution,
};
use nearmiss::scenario::{Severity, VehicleModel, VehicleType};
use proptest::prelude::*;

use crate::support::recorded::shared;

fn trajectory(kind: TrajectoryKind) -> impl Strategy<Value = SolutionTrajectory> {
    use proptest::num::f64::{NEGATIVE, NORMAL, POSITIVE, SUBNORMAL, ZERO};
    let number = NORMAL | SUBNORMAL | ZERO | POSITIVE | NEGATIVE;
    let number = number.prop_map(|n| if n.abs() > 2e7 { 1.0 / n } else { n });
    let values = proptest::collection::vec(number, kind.fields().len());
    let steps = proptest::collection::btree_set(-50i64..1000, 1..6);
    (steps, proptest::collection::vec(values, 6)).prop_map(move |(steps, values)| {
        let steps: BTreeSet<i64> = steps;
        let states = steps
            .into_iter()
            .zip(values)
            .map(|(step, values)| SolutionState { step, values });
        SolutionTrajectory::new(kind, states.collect()).unwrap()
    })
}

fn problem() -> impl Strategy<Value = ProblemSolution> {
    let kind = proptest::sample::select(TrajectoryKind::ALL);
    let model = kind.prop_flat_map(|kind| {
        let models: Vec<_> = VehicleModel::ALL
            .iter()
            .copied()
            .filter(|m| kind.fits(*m))
            .collect();
        (trajectory(kind), proptest::sample::select(models))
    });
    let vehicle = proptest::sample::select(VehicleType::ALL);
    (model, vehicle, "[A-Z]{2}[0-9]").prop_map(|((trajectory, model), vehicle, cost)| {
        ProblemSolution {
            planning_problem: 0,
            model,
            vehicle,
            cost,
            trajectory,
        }
    })
}

fn solution() -> impl Strategy<Value = Solution> {
    (
        proptest::collection::vec(problem(), 1..4),
        "(C-)?[A-Z]{3}_[A-Za-z0-9<&\"']{1,8}-[1-9]_1_T-1",
        proptest::option::of(1e-9..1e6f64),
        proptest::option::of("[ -~äß€]{0,20}"),
        proptest::option::of((1970i16..2100, 1i8..13, 1i8..29, 0i8..24, 0i8..60)),
    )
        .prop_map(
            |(mut problems, scenario_id, computation_time, processor, date)| {
                for (i, problem) in problems.iter_mut().enumerate() {
                    problem.planning_problem = i as i64 * 7 - 3;
                }
                // The schema's order; the order of the file is that of the benchmark id.
                problems.sort_by_key(|p| p.trajectory.kind());
                Solution {
                    scenario_id,
                    version: "2020a".into(),
                    date: date.map(|(y, m, d, h, s)| jiff::civil::datetime(y, m, d, h, 1, s, 0)),
                    computation_time,
                    processor,
                    problems,
                    diagnostics: Vec::new(),
                }
            },
        )
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_back(solution in solution()) {
        let bytes = write_solution(&solution).unwrap();
        let mut read = read_solution(&bytes, "written").unwrap();
        read.diagnostics.clear();
        prop_assert_eq!(&read, &solution);
        prop_assert_eq!(write_solution(&read).unwrap(), bytes);
    }
}

/// A solution by hand, with three kinds.
const COOPERATIVE: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<!-- vehicles stand in the order of the file, which is not the schema's -->
<CommonRoadSolution date="2024-05-06T07:08:09" benchmark_id="[ST1, PM3]:[SM1,JB1]:C-DEU_Test-1_1_T-1:2020a">
  <stTrajectory planningProblem="8">
    <stState>
      <time>1</time><yawRate>0.1</yawRate><slipAngle>0.5</slipAngle>
      <x>1</x><y>2.5e0</y><velocity>4</velocity><orientation>-1</orientation><steeringAngle>0</steeringAngle>
    </stState>
    <stState>
      <x>0</x><y>2</y><velocity>4</velocity><orientation>-1</orientation><steeringAngle>0</steeringAngle>
      <yawRate>0.1</yawRate><slipAngle>0</slipAngle><time>0</time><mood>bad</mood>
    </stState>
  </stTrajectory>
  <pmTrajectory planningProblem="7">
    <pmState><x>1</x><y>2</y><xVelocity>3</xVelocity><yVelocity>4</yVelocity><time>5</time></pmState>
  </pmTrajectory>
</CommonRoadSolution>
"#;

fn cooperative() -> Solution {
    read_solution(COOPERATIVE.as_bytes(), "by hand").unwrap()
}

#[test]
fn elements_and_states_come_in_any_order() {
    let read = cooperative();
    assert_eq!(
        read.benchmark_id(),
        "[ST1,PM3]:[SM1,JB1]:C-DEU_Test-1_1_T-1:2020a"
    );
    let st = read.problem(8).unwrap();
    let steps: Vec<_> = st.trajectory.states().iter().map(|s| s.step).collect();
    assert_eq!(steps, [0, 1]);
    let last = &st.trajectory.states()[1];
    assert_eq!(st.trajectory.value(last, "slipAngle"), Some(0.5));
    assert_eq!(st.trajectory.value(last, "y"), Some(2.5));
    assert_eq!(st.trajectory.value(last, "pitchRate"), None);
    let said: Vec<_> = read
        .diagnostics
        .iter()
        .map(|d| (d.severity, d.line))
        .collect();
    assert_eq!(
        said,
        [(Severity::Note, 9), (Severity::Unused, 11)],
        "{:?}",
        read.diagnostics
    );
    let written = String::from_utf8(write_solution(&read).unwrap()).unwrap();
    assert!(
        written.contains("[PM3,ST1]:[JB1,SM1]:C-DEU_Test-1_1_T-1:2020a"),
        "{written}"
    );
    assert!(written.find("<pmTrajectory").unwrap() < written.find("<stTrajectory").unwrap());
}

#[test]
fn mistakes_are_named_with_their_place() {
    for (from, to, place, words) in [
        (
            "CommonRoadSolution",
            "commonRoadSolution",
            ":3:1:",
            vec!["the root is <commonRoadSolution>"],
        ),
        ("benchmark_id", "benchmark", ":3:1:", vec!["benchmark_id"]),
        ("ST1", "ST7", ":3:1:", vec!["`ST7`", "KS2"]),
        (
            "[ST1, PM3]:[SM1,JB1]",
            "ST1:SM1",
            ":3:1:",
            vec!["1 vehicle", "2 trajectories"],
        ),
        (
            "[ST1, PM3]",
            "[KS1,PM3]",
            ":4:3:",
            vec!["model KS", "<stTrajectory>"],
        ),
        (
            "planningProblem=\"7\"",
            "planningProblem=\"8\"",
            ":14:3:",
            vec!["already solved"],
        ),
        (
            "planningProblem=\"7\"",
            "planningProblem=\"x\"",
            ":14:3:",
            vec!["not a whole number"],
        ),
        (
            "<x>1</x><y>2.5e0</y>",
            "<x>1</x>",
            ":5:5:",
            vec!["<y> is missing", "slipAngle, time"],
        ),
        (
            "<x>1</x><y>2.5e0</y>",
            "<x>one</x>",
            ":7:7:",
            vec!["`one` is not a number"],
        ),
        (
            "<x>1</x><y>2.5e0</y>",
            "<x>1e999</x>",
            ":7:7:",
            vec!["not a finite number"],
        ),
        (
            "<time>1</time>",
            "<time>0.5</time>",
            ":6:7:",
            vec!["not a whole number"],
        ),
        (
            "<time>1</time>",
            "<time>0</time>",
            ":9:5:",
            vec!["time step 0 is given twice"],
        ),
        (
            "<time>1</time>",
            "<time>9999999999</time>",
            ":6:7:",
            vec!["implausible"],
        ),
        ("<time>1</time>", "", ":5:5:", vec!["<time> is missing"]),
        (
            "<pmState>",
            "<ksState>",
            ":15:5:",
            vec!["<ksState> in a <pmTrajectory>", "<pmState>"],
        ),
        (
            "pmTrajectory",
            "carTrajectory",
            ":14:3:",
            vec!["<carTrajectory>", "ksTrajectory"],
        ),
    ] {
        let broken = COOPERATIVE.replace(from, to);
        assert_ne!(broken, COOPERATIVE, "{from}");
        let error = read_solution(broken.as_bytes(), "f.xml")
            .unwrap_err()
            .to_string();
        assert!(error.starts_with(&format!("f.xml{place}")), "{to}: {error}");
        for word in words {
            assert!(error.contains(word), "{to}: {error}");
        }
    }
}

#[test]
fn doubtful_attributes_are_left_out_and_said() {
    for (date, kept, said) in [
        ("2021-01-02", Some("2021-01-02T00:00:00"), 1),
        ("2021-01-02T03:04:05", Some("2021-01-02T03:04:05"), 0),
        ("2021-01-02T03:04:05.5", Some("2021-01-02T03:04:05"), 1),
        ("2021-01-02T03:04:05+01:00", Some("2021-01-02T02:04:05"), 1),
        ("2021-13-02T03:04:05", None, 1),
        ("soon", None, 1),
    ] {
        let text = COOPERATIVE.replace("2024-05-06T07:08:09", date);
        let read = read_solution(text.as_bytes(), "f").unwrap();
        assert_eq!(read.date.map(|d| d.to_string()).as_deref(), kept, "{date}");
        assert_eq!(
            read.diagnostics.len(),
            2 + said,
            "{date}: {:?}",
            read.diagnostics
        );
    }
    for time in ["-1", "0", "NaN", "fast"] {
        let text = COOPERATIVE.replace("date=", &format!("computation_time=\"{time}\" date="));
        let read = read_solution(text.as_bytes(), "f").unwrap();
        assert_eq!(read.computation_time, None);
        let warned = read
            .diagnostics
            .iter()
            .any(|d| d.message.contains("computation_time"));
        assert!(warned, "{:?}", read.diagnostics);
    }
}

#[test]
fn what_could_not_be_read_back_is_not_written() {
    let good = cooperative();
    let broken = |change: &dyn Fn(&mut Solution)| {
        let mut solution = good.clone();
        change(&mut solution);
        write_solution(&solution).unwrap_err()
    };
    assert_eq!(broken(&|s| s.problems.clear()), SolutionError::Empty);
    assert_eq!(
        broken(&|s| s.problems[1].planning_problem = 8),
        SolutionError::Twice(8)
    );
    for error in [
        broken(&|s| s.problems[0].model = VehicleModel::Ks),
        broken(&|s| s.problems[0].cost = "S,M".into()),
        broken(&|s| s.scenario_id = "a:b".into()),
        broken(&|s| s.version = String::new()),
        broken(&|s| s.computation_time = Some(f64::NAN)),
        broken(&|s| s.processor = Some("a\u{1}b".into())),
    ] {
        assert!(!error.to_string().is_empty());
    }
    let state = |step, values: &[f64]| SolutionState {
        step,
        values: values.to_vec(),
    };
    let made = |states| SolutionTrajectory::new(TrajectoryKind::PmInput, states).unwrap_err();
    assert_eq!(made(vec![]), SolutionError::NoStates);
    assert!(matches!(
        made(vec![state(0, &[1.0])]),
        SolutionError::Length {
            found: 1,
            expected: 2,
            ..
        }
    ));
    assert!(matches!(
        made(vec![state(0, &[1.0, f64::INFINITY])]),
        SolutionError::NotFinite { .. }
    ));
    let twice = vec![state(3, &[1.0, 1.0]), state(3, &[2.0, 1.0])];
    assert_eq!(made(twice), SolutionError::Repeated(3));
    assert_eq!(
        made(vec![state(i64::MIN, &[1.0, 1.0])]),
        SolutionError::Step(i64::MIN)
    );
}

#[test]
fn damaged_files_give_errors_or_solutions_never_panics() {
    let whole = write_solution(&cooperative()).unwrap();
    let end = whole.windows(2).rposition(|w| w == b"</").unwrap();
    for cut in 0..end {
        let error = read_solution(&whole[..cut], "cut").unwrap_err();
        assert_eq!(error.file, "cut");
        assert!(
            error.line > 0 && !error.message.is_empty(),
            "{cut}: {error}"
        );
    }
    for place in 0..whole.len() {
        for mask in [0x01, 0x08, 0x20, 0x80] {
            let mut flipped = whole.clone();
            flipped[place] ^= mask;
            if let Ok(read) = read_solution(&flipped, "flipped") {
                // Whatever can be read can be written.
                let again = write_solution(&read).unwrap();
                assert_eq!(
                    read_solution(&again, "again").unwrap().problems.len(),
                    read.problems.len()
                );
            }
        }
    }
    let deep = format!(
        "<CommonRoadSolution benchmark_id='KS1:SM1:X:1'><ksTrajectory planningProblem='1'><ksState>{}",
        "<a>".repeat(100_000)
    );
    assert!(read_solution(deep.as_bytes(), "deep").is_err());
}

#[test]
fn a_real_solution_survives() {
    let Some(shared) = shared("commonroad-io") else {
        return;
    };
    let name = "solution_KS2_SM1_DEU_Ibbenbueren-10_2_T-1_2020a.xml";
    let bytes = std::fs::read(shared.join(name)).unwrap();
    let mut read = read_solution(&bytes, name).unwrap();
    assert_eq!(
        read.benchmark_id(),
        "KS2:SM1:DEU_Ibbenbueren-10_2_T-1:2020a"
    );
    let solved = read.problem(1).unwrap();
    assert_eq!(
        (solved.model, solved.vehicle),
        (VehicleModel::Ks, VehicleType::Bmw320i)
    );
    assert_eq!(solved.trajectory.states().len(), 34);
    assert_eq!(
        solved.trajectory.states()[0].values,
        [622.20064, 950.48436, 0.0, 8.0, -0.233851]
    );
    assert_eq!(read.computation_time, Some(27.66874265500519));
    assert_eq!(
        read.diagnostics.len(),
        1,
        "the date has no time: {:?}",
        read.diagnostics
    );
    let again = write_solution(&read).unwrap();
    read.diagnostics.clear();
    assert_eq!(read_solution(&again, "again").unwrap(), read);
}
