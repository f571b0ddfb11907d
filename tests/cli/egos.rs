//! `--ego` with every kind of file, solutions under `inspect`, and the files that are no ego.

use nearmiss::formats::bundled;
use nearmiss::formats::commonroad::{ProblemSolution, Solution, write_solution};
use nearmiss::scenario::{VehicleModel, VehicleType};

use super::support::program::Home;
use super::{CUT_IN, bundled_ego, bundled_xml};

/// The bundled ego of [`CUT_IN`] as a solution of `problems`, the first of which is its own.
pub fn solution(model: VehicleModel, problems: &[i64]) -> Vec<u8> {
    let entry = bundled().into_iter().find(|e| e.name == CUT_IN).unwrap();
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let of = |problem: i64| {
        let (dt, vehicle) = (scenario.dt(), VehicleType::Bmw320i);
        ProblemSolution::of_track(&ego.track, dt, problem, model, vehicle).unwrap()
    };
    let mut solved = vec![of(ego.id)];
    solved.extend(problems.iter().map(|p| of(*p)));
    write_solution(&Solution {
        scenario_id: CUT_IN.into(),
        version: "2020a".into(),
        date: None,
        computation_time: Some(1.5),
        processor: Some("a <fast> one".into()),
        problems: solved,
        diagnostics: Vec::new(),
    })
    .unwrap()
}

/// A log of Frenetix with the bundled ego, without plans.
fn log() -> String {
    let csv = bundled_ego(CUT_IN);
    let mut rows = csv.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let place = |name| header.iter().position(|h| *h == name).unwrap();
    let (step, x, y) = (place("timestep"), place("x_position"), place("y_position"));
    let mut text = "trajectory_number;x_position_vehicle_m;y_position_vehicle_m;theta_orientations_rad;velocities_mps"
        .to_string();
    for row in rows {
        let (heading, velocity) = (row[place("orientation")], row[place("velocity")]);
        text += &format!(
            "\n{};\"{}\";\"{}\";\"{heading},9\";\"{velocity},9\"",
            row[step], row[x], row[y]
        );
    }
    text
}

/// The distances of a table of measures.
fn distances(table: &str) -> Vec<f64> {
    let rows = table.lines().skip(1);
    let column = |row: &str| row.split(',').nth(5).unwrap().parse().unwrap();
    rows.map(column).collect()
}

#[test]
fn every_kind_of_ego_file_gives_the_same_distances() {
    let home = Home::new();
    home.write("recording.csv", bundled_ego(CUT_IN));
    home.write("a log without an ending", log());
    home.write("ks.xml", solution(VehicleModel::Ks, &[]));
    home.write("pm.xml", solution(VehicleModel::Pm, &[]));
    let expected = distances(&home.run(&["metrics", CUT_IN]).status(0).stdout);
    assert!(expected.len() > 100);
    for file in [
        "recording.csv",
        "a log without an ending",
        "ks.xml",
        "pm.xml",
    ] {
        let ended = home.run(&["metrics", CUT_IN, "--ego", file]).status(0);
        assert_eq!(
            ended.stderr.lines().count(),
            1,
            "provenance: {}",
            ended.stderr
        );
        let found = distances(&ended.stdout);
        assert_eq!(found.len(), expected.len(), "{file}");
        let most = found.iter().zip(&expected).map(|(a, b)| (a - b).abs());
        assert!(most.fold(0.0, f64::max) < 1e-2, "{file}");
        let collision = ["--task", "collision"];
        for (command, more) in [
            (&["prompt", "describe"][..], &[][..]),
            (&["prompt", "show"], &collision),
            (&["ask"], &collision),
        ] {
            let arguments = [command, &[CUT_IN, "--ego", file], more].concat();
            home.run(&arguments).status(0);
        }
    }
    // A number is still the id of an obstacle.
    let entry = bundled().into_iter().find(|e| e.name == CUT_IN).unwrap();
    let id = entry.read().unwrap().obstacles[0].id.to_string();
    home.write(&id, "no ego at all");
    home.run(&["prompt", "describe", CUT_IN, "--ego", &id])
        .status(0);
    let file = format!("./{id}");
    home.run(&["prompt", "describe", CUT_IN, "--ego", &file])
        .status(2)
        .says(&["unknown header in line 1"]);
}

#[test]
fn inspect_shows_what_a_solution_is() {
    let home = Home::new();
    home.write("s.xml", solution(VehicleModel::Ks, &[]));
    let shown = home.run(&["inspect", "s.xml"]).status(0).stdout;
    for words in [
        "KS2:SM1:ZAM_CutIn-1_1_T-1:2020a\n",
        "CommonRoad solution",
        "computed in 1.500 s, on a <fast> one",
        "model KS (kinematic single-track), vehicle BMW 320i (CommonRoad vehicle 2), 4.508 m × 1.61 m",
        "<ksState>, steps 0 to ",
        "seconds unknown",
        "  first       x ",
        "  last        x ",
        "steeringAngle",
        "diagnostics none",
    ] {
        assert!(shown.contains(words), "{words}: {shown}");
    }
    home.write(format!("{CUT_IN}.xml"), bundled_xml(CUT_IN));
    let shown = home.run(&["inspect", "s.xml"]).status(0).stdout;
    assert!(
        !shown.contains("seconds unknown") && shown.contains(" s\n"),
        "{shown}"
    );
    let document = home
        .run(&["inspect", "s.xml", "--format=json"])
        .status(0)
        .json();
    assert_eq!(document["benchmark_id"], "KS2:SM1:ZAM_CutIn-1_1_T-1:2020a");
    assert_eq!(document["problems"][0]["vehicle"]["length"], 4.508);
    let states = document["problems"][0]["states"].as_array().unwrap();
    assert_eq!(states[0]["time_step"], 0);
    assert!(states.len() > 50 && states[3]["orientation"].is_number());
}

#[test]
fn a_solution_is_not_a_scenario() {
    let home = Home::new();
    home.write("in/s.xml", solution(VehicleModel::Ks, &[]));
    let ended = home.run(&["metrics", "in/s.xml"]).status(2);
    ended.says(&["s.xml:2:1", "this is a solution", "inspect"]);
    home.run(&["prompt", "describe", "in/s.xml"])
        .status(2)
        .says(&["this is a solution", "--ego"]);
    home.run(&["metrics", "in"])
        .status(2)
        .says(&["no CommonRoad scenario"]);
    home.write(format!("in/{CUT_IN}.xml"), bundled_xml(CUT_IN));
    home.write("in/broken.csv", "timestep\n");
    let ended = home.run(&["metrics", "in"]).status(0);
    ended.says(&["no recorded ego", "the built-in planner drives", "--ego"]);
    // Named after the scenario it is found, and still not listed.
    let name = format!("in/solution_KS2_SM1_{CUT_IN}_2020a.xml");
    home.write(name, solution(VehicleModel::Ks, &[]));
    let table = home.run(&["metrics", "in"]).status(0);
    assert!(table.stdout.lines().skip(1).all(|l| l.starts_with(CUT_IN)));
    let shown = home
        .run(&["inspect", &format!("in/{CUT_IN}.xml")])
        .status(0)
        .stdout;
    assert!(
        shown.contains("solution KS2 of planning problem"),
        "{shown}"
    );
    assert!(shown.contains("note: no size given"), "{shown}");
}

#[test]
fn the_vehicle_of_a_cooperative_solution_is_chosen_by_its_problem() {
    let home = Home::new();
    home.write("two.xml", solution(VehicleModel::Ks, &[9000]));
    let ended = home.run(&["metrics", CUT_IN, "--ego", "two.xml"]).status(0);
    ended.says(&["nearmiss: ego solution KS2", "cooperative", "9000"]);
    let chosen = |problem: &str| {
        let ego = format!("two.xml#{problem}");
        home.run(&["metrics", CUT_IN, "--ego", &ego])
    };
    chosen("9000")
        .status(2)
        .says(&["planning problem 9000", CUT_IN, "the open scenario is"]);
    chosen("5")
        .status(2)
        .says(&["no ego for planning problem 5", "9000"]);
    let alone = ["metrics", CUT_IN, "--ego", "#5"];
    home.run(&alone).status(2).says(&["planning problem 5"]);
    // Beside the scenario it is chosen without being named.
    home.write("in/s.xml", bundled_xml(CUT_IN));
    home.write(
        "in/s.ego_trajectory.csv",
        solution(VehicleModel::Ks, &[9000]),
    );
    home.run(&["metrics", "in/s.xml", "--ego", "#5"])
        .status(2)
        .says(&["s.ego_trajectory.csv", "no ego for planning problem 5"]);
    let inspected = home
        .run(&["inspect", CUT_IN, "--format=json"])
        .status(0)
        .json();
    let own = inspected["ego"]["id"].to_string();
    home.run(&["metrics", "in/s.xml", "--ego", &format!("#{own}")])
        .status(0);
    let obstacle = ["metrics", CUT_IN, "--ego", "301#5"];
    home.run(&obstacle).status(2).says(&["301 is an obstacle"]);
}

#[test]
fn what_is_no_ego_is_named() {
    let home = Home::new();
    home.write("scenario.xml", bundled_xml(CUT_IN));
    home.write("page.xml", "<html></html>");
    home.write("notes.txt", "nothing\n\u{1b}[2J\n");
    home.write("cut.xml", &solution(VehicleModel::Ks, &[])[..2000]);
    home.write("columns.csv", "timestep,x_position\n0,1\n");
    home.write("log.csv", "trajectory_number;x_positions_m\n0;1\n");
    home.write("value.csv", log().replacen("\n3;\"", "\n3;\"x", 1));
    for (file, words) in [
        ("scenario.xml", vec!["scenario.xml", "this is a scenario"]),
        ("page.xml", vec!["page.xml:1:1", "<html>"]),
        (
            "notes.txt",
            vec![
                "notes.txt",
                "unknown header in line 1",
                "CommonRoad solution",
            ],
        ),
        (
            "cut.xml",
            vec!["cut.xml:", "<CommonRoadSolution/ksTrajectory", "before end"],
        ),
        ("columns.csv", vec!["line 1", "`y_position`"]),
        ("log.csv", vec!["line 1", "`y_positions_m`"]),
        ("value.csv", vec!["line 5", "`x_position_vehicle_m`", "`x"]),
        (
            "missing.csv",
            vec![
                "missing.csv",
                "id of an obstacle or its name in a table, a file, or planner",
            ],
        ),
        (".", vec!["."]),
    ] {
        let ended = home
            .run(&["prompt", "describe", CUT_IN, "--ego", file])
            .status(2);
        assert_eq!(ended.stdout, "", "{file}");
        ended.says(&words);
    }
}

#[test]
fn an_ego_that_does_not_fit_its_scenario_is_doubted() {
    let home = Home::new();
    let rows: Vec<String> = bundled_ego(CUT_IN).lines().map(String::from).collect();
    let change = |name: &str, column: usize, by: f64| {
        let mut text = rows[0].clone();
        for row in &rows[1..] {
            let mut cells: Vec<String> = row.split(',').map(String::from).collect();
            let value: f64 = cells[column].parse().unwrap();
            cells[column] = (value + by).to_string();
            text += &format!("\n{}", cells.join(","));
        }
        home.write(name, text)
    };
    let doubts = |file: &std::path::Path| {
        let ended = home.run(&[
            "prompt",
            "describe",
            CUT_IN,
            "--ego",
            file.to_str().unwrap(),
        ]);
        // The estimate of tokens is no doubt.
        let said = ended.status(0).stderr;
        let lines = said.lines().filter(|line| !line.ends_with("(estimated)"));
        lines.collect::<Vec<_>>().join("\n")
    };
    let later = doubts(&change("later.csv", 1, 1000.0));
    assert!(later.contains("no common step"), "{later}");
    let far = doubts(&change("far.csv", 2, 5e4));
    assert!(
        far.contains("50000.00 m from the start of planning problem"),
        "{far}"
    );
    let degrees = doubts(&change("degrees.csv", 4, 109.0));
    assert!(degrees.contains("is it in degrees?"), "{degrees}");
    let mut gap = rows.clone();
    gap.drain(60..70);
    let gap = home.write("gap.csv", gap.join("\n"));
    let gap = gap.to_str().unwrap();
    let ended = home
        .run(&[
            "prompt",
            "describe",
            CUT_IN,
            "--ego",
            gap,
            "--at",
            "62",
            "--set=form=prose",
        ])
        .status(0);
    assert!(
        ended.stderr.contains("no states from time step 59 to 68"),
        "{}",
        ended.stderr
    );
    assert!(
        ended
            .stdout
            .contains("The ego is not recorded at this time."),
        "{}",
        ended.stdout
    );
    assert_eq!(doubts(&home.write("good.csv", rows.join("\n"))), "");
    let tabs = home.write("tabs.csv", rows.join("\n").replace(',', "\t"));
    let ended = home
        .run(&[
            "prompt",
            "describe",
            CUT_IN,
            "--ego",
            tabs.to_str().unwrap(),
        ])
        .status(2);
    assert!(
        ended.stderr.contains("separated by tabs"),
        "{}",
        ended.stderr
    );
}

#[test]
fn a_solution_of_another_scenario_says_whose_it_is_and_what_to_do() {
    let home = Home::new();
    let other = "ZAM_Other-1_1_T-1";
    let text = String::from_utf8(solution(VehicleModel::Ks, &[])).unwrap();
    let foreign = text.replace(CUT_IN, other);
    home.write("same-id.xml", &foreign);
    let ended = home
        .run(&["metrics", CUT_IN, "--ego", "same-id.xml"])
        .status(0);
    ended.says(&[
        "a solution of scenario ZAM_Other-1_1_T-1",
        "the open scenario is ZAM_CutIn-1_1_T-1",
        "open ZAM_Other",
    ]);
    let id = |n: i64| format!("planningProblem=\"{n}\"");
    let own = (0..=9)
        .find(|n| foreign.contains(&id(*n)))
        .expect("the bundled ones are numbered from 1");
    home.write("foreign.xml", foreign.replace(&id(own), &id(777)));
    for command in [&["metrics"][..], &["prompt", "describe"], &["inspect"]] {
        home.run(&[command, &[CUT_IN, "--ego", "foreign.xml"]].concat())
            .status(2)
            .says(&[
                "foreign.xml",
                "planning problem 777 of ZAM_Other-1_1_T-1",
                "the open scenario is ZAM_CutIn-1_1_T-1",
                "open ZAM_Other-1_1_T-1, or use a solution of ZAM_CutIn-1_1_T-1",
            ]);
    }
    // Of the same scenario, where it was changed: there is no other to open.
    home.write("changed.xml", text.replace(&id(own), &id(777)));
    let ended = home
        .run(&["metrics", CUT_IN, "--ego", "changed.xml"])
        .status(2);
    ended.says(&[
        "planning problem 777 of ZAM_CutIn-1_1_T-1",
        "the scenario file that it was made for",
    ]);
}
