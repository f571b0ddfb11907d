//! Logs of Frenetix: rows as its logger writes them, made from a bundled ego.

use super::*;
use nearmiss::scenario::Motion;

/// How many steps a plan has.
const HORIZON: usize = 31;

/// One plan from step `i` of the motions, as the logger's lists; the rear axle is 1.4227 m behind the centre.
fn lists(motions: &[Motion], i: usize, length: usize) -> [String; 5] {
    let plan = motions[i..].iter().take(length);
    let rear = VehicleType::Bmw320i.to_rear_axle();
    let list = |value: &dyn Fn(&Motion) -> f64| {
        let values: Vec<String> = plan.clone().map(|m| value(m).to_string()).collect();
        format!("\"{}\"", values.join(","))
    };
    [
        list(&|m| m.pose.position.x - rear * m.pose.heading.cos()),
        list(&|m| m.pose.position.y - rear * m.pose.heading.sin()),
        list(&|m| m.pose.heading),
        list(&|m| m.velocity),
        list(&|m| m.acceleration),
    ]
}

const HEADER: &str = "trajectory_number;calculation_time_s;x_position_vehicle_m;y_position_vehicle_m;optimal_trajectory;\
                      x_positions_m;y_positions_m;theta_orientations_rad;velocities_mps;accelerations_mps2;costs";

/// A row: number, centre, plan.
fn row(number: usize, motions: &[Motion], i: usize, length: usize) -> String {
    let [x, y, heading, velocity, acceleration] = lists(motions, i, length);
    let at = motions[i].pose.position;
    format!(
        "\n{number};\"0.02\";\"{}\";\"{}\";True;{x};{y};{heading};{velocity};{acceleration};\"3.0\"",
        at.x, at.y
    )
}

fn driven() -> (Arc<Scenario>, Vec<Motion>, Ego) {
    let (scenario, ego) = recorded(CUT_IN);
    let motions = ego.track.iter().map(|(_, m)| *m).collect();
    (scenario, motions, ego)
}

#[test]
fn a_row_a_step_is_what_was_driven() {
    let (scenario, motions, ego) = driven();
    // Every third step is planned anew; in between the rest of the plan is logged.
    let rows = (0..motions.len()).map(|i| row(i, &motions, i, HORIZON - i % 3));
    let text: String = std::iter::once(HEADER.to_string()).chain(rows).collect();
    let read = read_ego(text.as_bytes(), "logs.csv", &scenario, None).unwrap();
    assert_eq!(read.source, EgoSource::Log("logs.csv".into()));
    assert_eq!(read.id, ego.id);
    assert_eq!(warnings(&read), [""; 0]);
    assert_eq!(apart(&ego.track, &read.track), (0.0, 0.0, 0.0));
    assert_eq!(read.footprint, VehicleType::Bmw320i.footprint());
}

#[test]
fn the_centre_is_worked_out_where_it_is_not_logged() {
    let (scenario, motions, ego) = driven();
    let header = HEADER
        .replace("x_position_vehicle_m", "a")
        .replace("y_position_vehicle_m", "b");
    let rows = (0..motions.len()).map(|i| row(i, &motions, i, HORIZON));
    let text: String = std::iter::once(header).chain(rows).collect();
    let read = read_ego(text.as_bytes(), "logs.csv", &scenario, None).unwrap();
    assert!(apart(&ego.track, &read.track).0 < 1e-9);
}

#[test]
fn steps_without_rows_are_those_of_the_plan() {
    let (scenario, motions, ego) = driven();
    let last = (motions.len() - 1) / 4 * 4;
    // Numbered by step: the gaps show. Numbered by plan: only the plans do.
    for by_plan in [false, true] {
        let rows = (0..=last).step_by(4).map(|i| {
            let number = if by_plan { i / 4 } else { i };
            row(number, &motions, i, HORIZON)
        });
        let text: String = std::iter::once(HEADER.to_string()).chain(rows).collect();
        let read = read_ego(text.as_bytes(), "logs.csv", &scenario, None).unwrap();
        assert_eq!(read.track.steps().end, last as i64 + 1);
        for (step, motion) in read.track.iter() {
            let gap = motion.pose.position - ego.track.at(step).unwrap().pose.position;
            assert!(gap.norm() < 1e-9, "{step}");
        }
        assert_eq!(read.track.iter().count(), last + 1);
        let said = warnings(&read);
        if by_plan {
            assert!(
                said.len() == 1 && said[0].contains("rows count plans"),
                "{said:?}"
            );
        } else {
            assert_eq!(said, [""; 0]);
        }
        let filled = format!("{} steps without their own row", last / 4 * 3);
        assert!(
            read.diagnostics.iter().any(|d| d.message.contains(&filled)),
            "{:?}",
            read.diagnostics
        );
    }
}

#[test]
fn what_is_doubtful_in_a_log_is_said_with_its_line() {
    let (scenario, motions, _) = driven();
    let jump: String = std::iter::once(HEADER.to_string())
        .chain((0..5).map(|i| row(i, &motions, if i < 3 { i } else { i + 20 }, HORIZON)))
        .collect();
    let read = read_ego(jump.as_bytes(), "f", &scenario, None).unwrap();
    let doubt = read
        .diagnostics
        .iter()
        .find(|d| d.severity == Severity::Warning)
        .unwrap();
    assert!(
        doubt.line == 5 && doubt.message.contains("do not start where"),
        "{doubt:?}"
    );
    assert_eq!(read.track.iter().count(), 5);
    let planless = format!(
        "{HEADER}{}\n1;\"0.1\";False;\"0.0\";None;None",
        row(0, &motions, 0, 3)
    );
    let read = read_ego(planless.as_bytes(), "f", &scenario, None).unwrap();
    let doubt = read
        .diagnostics
        .iter()
        .find(|d| d.severity == Severity::Warning)
        .unwrap();
    assert!(
        doubt.line == 3 && doubt.message.contains("without a trajectory"),
        "{doubt:?}"
    );
    let mut later = (*scenario).clone();
    later.planning_problems[0].initial.time = nearmiss::scenario::Steps::exact(4);
    let read = read_ego(planless.as_bytes(), "f", &later, None).unwrap();
    assert!(
        warnings(&read)
            .iter()
            .any(|w| w.contains("planning problem at step 4"))
    );
}

#[test]
fn mistakes_in_a_log_are_named_with_line_column_and_value() {
    let (scenario, motions, _) = driven();
    let good = format!(
        "{HEADER}{}{}",
        row(0, &motions, 0, 3),
        row(1, &motions, 1, 3)
    );
    let y = motions[1].pose.position.y.to_string();
    // Either the centre or the plan's positions are enough.
    for (from, to, words) in [
        (";x_positions_m", ";x", vec![]),
        ("x_position_vehicle_m", "x", vec![]),
        ("\n1;", "\nx;", vec!["line 3", "`trajectory_number`", "`x`"]),
        ("\n1;", "\n0;", vec!["line 3", "time step 0 is given twice"]),
        ("\n1;", "\n1.5;", vec!["line 3", "`1.5`"]),
        (&y, "nan", vec!["line 3", "`y_position_vehicle_m`", "`nan`"]),
    ] {
        let broken = good.replacen(from, to, 1);
        assert_ne!(broken, good);
        match read_ego(broken.as_bytes(), "f", &scenario, None) {
            Ok(_) => assert!(words.is_empty(), "{from}"),
            Err(error) => {
                let said = error.to_string();
                assert!(
                    !words.is_empty() && words.iter().all(|w| said.contains(w)),
                    "{said}"
                );
            }
        }
    }
    let both = good
        .replace("x_position_vehicle_m", "x")
        .replace(";x_positions_m", ";X");
    assert!(error(&both, &scenario).contains("`x_positions_m`"));
    assert!(error(HEADER, &scenario).contains("no rows"));
    let short = format!("{HEADER}\n0;\"0.1\";\"1.0\";\"2.0\"");
    let said = error(&short, &scenario);
    assert!(
        said.contains("line 2 has 4 fields") && said.contains("`optimal_trajectory` is missing"),
        "{said}"
    );
    let far = format!(
        "{HEADER}{}{}",
        row(0, &motions, 0, 3),
        row(10_000_000, &motions, 1, 3)
    );
    assert!(
        read_ego(far.as_bytes(), "f", &scenario, None).is_ok(),
        "and in no time"
    );
    let middle = format!(
        "{HEADER}\n0;\"0.1\";\"1.0\";\"2.0\"{}",
        row(1, &motions, 1, 3)
    );
    let said = error(&middle, &scenario);
    assert!(
        said.contains("line 2 has 4 fields") && said.contains("`x_positions_m` is missing"),
        "{said}"
    );
    let open = good.replacen("\"3.0\"", "\"3.0", 1);
    let said = error(&open, &scenario);
    assert!(said.contains("line 2: unclosed quote"), "{said}");
}

#[test]
fn a_log_that_is_cut_off_is_read_to_its_last_whole_row() {
    let (scenario, motions, _) = driven();
    let whole: String = std::iter::once(HEADER.to_string())
        .chain((0..3).map(|i| row(i, &motions, i, 4)))
        .collect();
    let last = whole.rfind('\n').unwrap();
    let rows = |cut: usize| {
        let read = read_ego(&whole.as_bytes()[..cut], "cut", &scenario, None).unwrap();
        let count = read.track.iter().count();
        let said = read.diagnostics.into_iter();
        let said: Vec<_> = said
            .filter(|d| d.severity == Severity::Warning && d.message.contains("truncated"))
            .collect();
        (count, said)
    };
    // Within the quotes of the last column a cut shows; behind its last digit nothing is missing.
    for cut in last + 2..whole.len() {
        let (count, said) = rows(cut);
        assert_eq!(count, 2, "{cut}");
        assert!(said.len() == 1 && said[0].line == 4, "{cut}: {said:?}");
    }
    for cut in [last, last + 1] {
        assert_eq!(rows(cut), (2, vec![]));
    }
    assert_eq!(rows(whole.len()), (3, vec![]));
    // No whole row is no ego.
    let first = HEADER.len() + 2..whole.len() - 2 * (whole.len() - last);
    for cut in (0..HEADER.len()).chain(first) {
        let error = read_ego(&whole.as_bytes()[..cut], "cut", &scenario, None).unwrap_err();
        assert!(error.to_string().starts_with("cut: "), "{error}");
    }
}

#[test]
fn published_logs_are_the_published_recordings() {
    let Some(root) = crate::support::recorded::shared("from-words-to-collisions/Generation") else {
        return;
    };
    for name in ["BEL_Antwerp-1_14_T-1", "BEL_Antwerp-1_14_T-1n"] {
        let path = root.join(name).join(format!("{name}.xml"));
        let scenario = read_file(&path).unwrap();
        let read = |path: PathBuf| {
            let bytes = std::fs::read(&path).unwrap();
            read_ego(&bytes, &path.display().to_string(), &scenario, None).unwrap()
        };
        let log = read(root.join(name).join("logs.csv"));
        let csv = read(find_recording(&path).unwrap());
        assert_eq!(warnings(&log), [""; 0], "{name}");
        // The recording was made of the log, rounded to tenths of millimetres; its velocities are those of the next
        // step.
        let (position, heading, _) = apart(&log.track, &csv.track);
        assert!(position < 1e-4, "{name}: {position}");
        // Its headings are directions of displacements of the centre, which swings out in a turn.
        assert!(heading < 0.15, "{name}: {heading}");
        assert_eq!(log.footprint, csv.footprint);
    }
}
