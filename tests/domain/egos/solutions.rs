//! Egos of solutions, and solutions of egos.

use super::*;
use nearmiss::formats::commonroad::{read_solution, write};

fn solution(scenario: &Scenario, problems: Vec<ProblemSolution>) -> Solution {
    Solution {
        scenario_id: scenario.header.benchmark_id.clone(),
        version: "2020a".into(),
        date: None,
        computation_time: None,
        processor: None,
        problems,
        diagnostics: Vec::new(),
    }
}

fn solved(scenario: &Scenario, ego: &Ego, model: VehicleModel) -> ProblemSolution {
    let (dt, vehicle) = (scenario.dt(), VehicleType::VwVanagon);
    ProblemSolution::of_track(&ego.track, dt, ego.id, model, vehicle).unwrap()
}

#[test]
fn an_ego_becomes_a_solution_and_comes_back() {
    for entry in bundled() {
        let (scenario, ego) = recorded(&entry.name);
        for model in [VehicleModel::Ks, VehicleModel::Pm] {
            let bytes = write_solution(&solution(&scenario, vec![solved(&scenario, &ego, model)]));
            let again = read_ego(&bytes.unwrap(), "s.xml", &scenario, None).unwrap();
            assert_eq!(again.id, ego.id);
            assert_eq!(
                again.source.to_string(),
                format!("solution {model}3 of planning problem {} in s.xml", ego.id)
            );
            assert_eq!(again.footprint, VehicleType::VwVanagon.footprint());
            assert_eq!(warnings(&again), [""; 0]);
            let (position, heading, velocity) = apart(&ego.track, &again.track);
            assert!(
                position == 0.0 && velocity < 1e-9,
                "{}: {velocity}",
                entry.name
            );
            // A point mass that stands has no direction of its own.
            let turn = if model == VehicleModel::Pm {
                1e-2
            } else {
                1e-12
            };
            assert!(heading < turn, "{} {model}: {heading}", entry.name);
        }
    }
    let (scenario, ego) = recorded(CUT_IN);
    for model in [VehicleModel::St, VehicleModel::Mb, VehicleModel::Kst] {
        let made = ProblemSolution::of_track(&ego.track, 0.1, 1, model, VehicleType::Bmw320i);
        assert!(made.unwrap_err().to_string().contains(model.name()));
    }
    let none = ProblemSolution::of_track(
        &Track::default(),
        scenario.dt(),
        1,
        VehicleModel::Pm,
        VehicleType::Bmw320i,
    );
    assert!(none.unwrap_err().to_string().contains("without states"));
}

#[test]
fn the_steering_angle_is_the_one_of_the_circle() {
    let (radius, speed, dt) = (20.0, 5.0, 0.1);
    let csv: String = (0..50)
        .map(|i| {
            let turned = f64::from(i) * speed * dt / radius;
            let (x, y) = (radius * turned.sin(), -radius * turned.cos());
            format!("{i},{x},{y},{turned},{speed}\n")
        })
        .collect();
    let (scenario, _) = recorded(CUT_IN);
    let csv = format!("timestep,x_position,y_position,orientation,velocity\n{csv}");
    let ego = read_ego(csv.as_bytes(), "circle", &scenario, None).unwrap();
    let (model, vehicle) = (VehicleModel::Ks, VehicleType::Bmw320i);
    let made = ProblemSolution::of_track(&ego.track, dt, 1, model, vehicle).unwrap();
    let expected = (vehicle.wheelbase() / radius).atan();
    for state in made.trajectory.states() {
        let angle = made.trajectory.value(state, "steeringAngle").unwrap();
        assert!((angle - expected).abs() < 1e-9, "{angle} {expected}");
    }
}

/// A solution with one state of a kind, of the planning problem of the scenario.
fn of_states(scenario: &Scenario, id: &str, body: &str) -> Result<Ego, EgoError> {
    let problem = scenario.planning_problems[0].id;
    let body = body.replace("PROBLEM", &problem.to_string());
    let name = &scenario.header.benchmark_id;
    let text =
        format!("<CommonRoadSolution benchmark_id='{id}:{name}:2020a'>{body}</CommonRoadSolution>");
    read_ego(text.as_bytes(), "f", scenario, None)
}

#[test]
fn velocities_are_along_the_heading() {
    let (scenario, _) = recorded(CUT_IN);
    let ego = of_states(
        &scenario,
        "ST1:SM1",
        "<stTrajectory planningProblem='PROBLEM'><stState><x>1</x><y>2</y><steeringAngle>0</steeringAngle>\
         <velocity>10</velocity><orientation>0.5</orientation><yawRate>0</yawRate><slipAngle>0.2</slipAngle>\
         <time>3</time></stState></stTrajectory>",
    )
    .unwrap();
    let motion = ego.track.at(3).unwrap();
    assert!((motion.velocity - 10.0 * 0.2f64.cos()).abs() < 1e-12);
    assert_eq!((motion.pose.position.x, motion.pose.heading), (1.0, 0.5));
    assert_eq!(ego.footprint, VehicleType::FordEscort.footprint());
    assert!(warnings(&ego)[0].contains("from the start of its planning problem"));
    let ego = of_states(
        &scenario,
        "PM2:JB1",
        "<pmTrajectory planningProblem='PROBLEM'><pmState><x>0</x><y>0</y><xVelocity>-3</xVelocity>\
         <yVelocity>4</yVelocity><time>0</time></pmState></pmTrajectory>",
    )
    .unwrap();
    let motion = ego.track.at(0).unwrap();
    assert_eq!(motion.velocity, 5.0);
    assert!((motion.pose.heading - 4.0f64.atan2(-3.0)).abs() < 1e-12);
    let ego = of_states(
        &scenario,
        "KST4:SM1",
        "<kstTrajectory planningProblem='PROBLEM'><kstState><x>0</x><y>0</y><steeringAngle>0</steeringAngle>\
         <velocity>1</velocity><orientation>0</orientation><hitchAngle>0.1</hitchAngle><time>0</time></kstState>\
         </kstTrajectory>",
    );
    assert!(warnings(&ego.unwrap())[0].contains("the trailer is ignored"));
}

#[test]
fn inputs_are_no_ego() {
    let (scenario, _) = recorded(CUT_IN);
    let inputs = "<inputVector planningProblem='PROBLEM'><input><steeringAngleSpeed>0</steeringAngleSpeed>\
                  <acceleration>1</acceleration><time>0</time></input></inputVector>";
    let error = of_states(&scenario, "KS2:SM1", inputs)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("<inputVector>") && error.contains("without positions"),
        "{error}"
    );
}

#[test]
fn the_vehicle_of_a_cooperative_solution_is_chosen() {
    let (scenario, ego) = recorded(CUT_IN);
    let mut two = solution(
        &scenario,
        vec![solved(&scenario, &ego, VehicleModel::Ks); 2],
    );
    two.problems[0].planning_problem = 77;
    two.problems[0].vehicle = VehicleType::FordEscort;
    let bytes = write_solution(&two).unwrap();
    let read = |scenario: &Scenario, problem| read_ego(&bytes, "two.xml", scenario, problem);
    let first = read(&scenario, None).unwrap();
    assert_eq!(first.id, ego.id);
    assert!(
        warnings(&first)[0].contains(&format!("problems 77, {}", ego.id)),
        "{:?}",
        first.diagnostics
    );
    assert_eq!(warnings(&read(&scenario, Some(ego.id)).unwrap()), [""; 0]);
    let other = read(&scenario, Some(77)).unwrap_err().to_string();
    assert!(
        other.contains("planning problem 77 of ZAM_CutIn-1_1_T-1"),
        "{other}"
    );
    let neither = read(&scenario, Some(5)).unwrap_err().to_string();
    assert!(neither.contains("available: 77, "), "{neither}");
    let mut without = (*scenario).clone();
    without.planning_problems.clear();
    assert!(matches!(
        read(&without, None),
        Err(EgoError::Several { .. })
    ));
    let chosen = read(&without, Some(77)).unwrap();
    assert_eq!(chosen.footprint, VehicleType::FordEscort.footprint());
    // The same in a file of the scenario's own.
    let xml = write(&without).unwrap();
    assert!(read_solution(&xml, "x").is_err());
}

#[test]
fn a_solution_of_another_scenario_is_said() {
    let (scenario, ego) = recorded(CUT_IN);
    let mut of = solution(&scenario, vec![solved(&scenario, &ego, VehicleModel::Ks)]);
    of.scenario_id = "DEU_Other-1_1_T-1".into();
    let bytes = write_solution(&of).unwrap();
    let read = read_ego(&bytes, "f", &scenario, None).unwrap();
    assert_eq!(warnings(&read).len(), 1);
    assert!(warnings(&read)[0].contains("DEU_Other-1_1_T-1"));
    of.problems[0].planning_problem += 1;
    let said = read_ego(&write_solution(&of).unwrap(), "f", &scenario, None).unwrap_err();
    assert!(matches!(said, EgoError::Foreign { .. }), "{said}");
}
