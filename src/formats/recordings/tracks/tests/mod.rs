//! The same scene in tables of many shapes.

#![allow(clippy::unwrap_used)]

use std::fmt::Write;
use std::path::Path;

use nearmiss_base::geometry::angle_between;
use nearmiss_scene::scenario::{Obstacle, Scenario, Severity};

use super::*;

mod odd;

/// Someone of the scene at a moment.
struct Moment {
    step: i64,
    x: f64,
    y: f64,
    heading: f64,
    speed: f64,
}

/// Someone of the scene: metres.
struct Body {
    id: i64,
    class: String,
    size: (f64, f64),
    moments: Vec<Moment>,
}

const DT: f64 = 0.1;

/// The moving road users of a bundled scenario.
fn scene(name: &str) -> Vec<Body> {
    let entry = crate::bundled().into_iter().find(|e| e.name.contains(name));
    let scenario = entry.unwrap().read().unwrap();
    assert!((scenario.dt() - DT).abs() < 1e-9);
    let of = |obstacle: &Obstacle| {
        let moments = obstacle.track().iter().map(|(step, motion)| Moment {
            step,
            x: motion.pose.position.x,
            y: motion.pose.position.y,
            heading: motion.pose.heading,
            speed: motion.velocity,
        });
        let size = size_of(obstacle);
        Body {
            id: obstacle.id,
            class: obstacle.kind.name().to_string(),
            size,
            moments: moments.collect(),
        }
    };
    let all = scenario.obstacles.iter().map(of);
    all.filter(|body| body.moments.len() > 5).collect()
}

/// Length and width, metres.
fn size_of(obstacle: &Obstacle) -> (f64, f64) {
    let along = |angle: f64| {
        let axis = nearmiss_base::geometry::Vector::new(angle.cos(), angle.sin());
        let at = obstacle
            .footprint
            .as_ref()
            .unwrap()
            .at(nearmiss_base::geometry::Pose::new(0.0, 0.0, 0.0));
        let (low, high) = at.extent(&nearmiss_base::geometry::Point::origin(), &axis);
        high - low
    };
    (along(0.0), along(std::f64::consts::FRAC_PI_2))
}

/// A table of a scene: its header, and a row for each moment in order of time or of tracks.
fn table(
    bodies: &[Body],
    header: &str,
    by_time: bool,
    row: impl Fn(&Body, &Moment) -> String,
) -> String {
    let mut rows: Vec<(i64, String)> = Vec::new();
    for body in bodies {
        rows.extend(body.moments.iter().map(|m| (m.step, row(body, m))));
    }
    if by_time {
        rows.sort_by_key(|row| row.0);
    }
    let mut text = String::from(header);
    for (_, row) in rows {
        write!(text, "\n{row}").unwrap();
    }
    text.push('\n');
    text
}

fn opened(path: &Path, options: &TableOptions) -> Result<Scenario, ReadError> {
    let report = Report::about("t");
    let plan = Plan::of_file(path, options, &report, Role::is_of_recordings)?
        .ok_or_else(|| report.fail("no table"))?;
    plan.check(&report)?;
    let table = Table::read(plan, &[path], options, &report)?;
    table.open(path, None, report)
}

fn read(text: &[u8], options: &TableOptions) -> Result<Scenario, ReadError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    std::fs::write(&path, text).unwrap();
    opened(&path, options)
}

fn with(columns: &str, rate: Option<f64>) -> TableOptions {
    TableOptions {
        columns: (!columns.is_empty()).then(|| columns.parse().unwrap()),
        rate,
        ..TableOptions::default()
    }
}

/// How much may be off: metres, radians, m/s, metres of sizes.
struct Tolerance(f64, f64, f64, f64);

const EXACT: Tolerance = Tolerance(1e-3, 1e-4, 1e-3, 1e-3);

fn compare(bodies: &[Body], read: &Scenario, tolerance: &Tolerance, shape: &str) {
    assert_eq!(read.obstacles.len(), bodies.len(), "{shape}");
    assert!((read.dt() - DT).abs() < 1e-9, "{shape}: {}", read.dt());
    let start = bodies.iter().map(|b| b.moments[0].step).min().unwrap();
    for body in bodies {
        let found = read.obstacle(body.id).unwrap();
        let size = size_of(found);
        assert!(
            (size.0 - body.size.0).abs() <= tolerance.3,
            "{shape}: {size:?} {:?}",
            body.size
        );
        assert!(
            (size.1 - body.size.1).abs() <= tolerance.3,
            "{shape}: {size:?} {:?}",
            body.size
        );
        for moment in &body.moments {
            let at = found.track().at(moment.step - start).unwrap();
            let (x, y) = (at.pose.position.x - moment.x, at.pose.position.y - moment.y);
            assert!(
                x.hypot(y) <= tolerance.0,
                "{shape}: {} at {}: {x} {y}",
                body.id,
                moment.step
            );
            let off = angle_between(at.pose.heading, moment.heading).abs();
            assert!(
                off <= tolerance.1 || moment.speed.abs() < 1.0 && tolerance.1 > 1e-3,
                "{shape}: heading of {} at {}: {off}",
                body.id,
                moment.step
            );
            let off = (at.velocity - moment.speed).abs();
            assert!(
                off <= tolerance.2,
                "{shape}: speed of {} at {}: {off}",
                body.id,
                moment.step
            );
        }
    }
}

fn notes(scenario: &Scenario) -> String {
    let all = scenario.diagnostics.iter().map(|d| d.message.clone());
    all.collect::<Vec<_>>().join("; ")
}

/// Names of scenes with straight roads, turns and pedestrians.
const SCENES: [&str; 3] = ["RightTurn", "CutIn", "Pedestrian"];

#[test]
fn the_same_scene_is_read_from_every_shape() {
    for name in SCENES {
        let bodies = scene(name);
        let none = TableOptions::default();
        let seconds = |m: &Moment| m.step as f64 * DT;
        let plain = table(
            &bodies,
            "t,id,x,y,heading,speed,length,width,type",
            true,
            |b, m| {
                format!(
                    "{:.1},{},{:.4},{:.4},{:.6},{:.4},{},{},{}",
                    seconds(m),
                    b.id,
                    m.x,
                    m.y,
                    m.heading,
                    m.speed,
                    b.size.0,
                    b.size.1,
                    b.class
                )
            },
        );
        compare(
            &bodies,
            &read(plain.as_bytes(), &none).unwrap(),
            &EXACT,
            "plain",
        );
        // As people in Europe save it, in order of tracks, degrees, km/h and milliseconds.
        let european = table(
            &bodies,
            "Zeit_ms;track id;pos x [m];pos y [m];yaw [deg];speed (km/h);length;width;class",
            false,
            |b, m| {
                format!(
                    "{};{};{:.4};{:.4};{:.5};{:.4};{};{};{}",
                    m.step * 100,
                    b.id,
                    m.x,
                    m.y,
                    m.heading.to_degrees(),
                    m.speed * 3.6,
                    b.size.0,
                    b.size.1,
                    b.class
                )
                .replace('.', ",")
            },
        );
        let options = with("time=Zeit_ms[ms]", None);
        compare(
            &bodies,
            &read(european.as_bytes(), &options).unwrap(),
            &EXACT,
            "european",
        );
        // Nothing of units is said.
        let silent = table(
            &bodies,
            "timestamp\ttrack_id\tx\ty\tyaw\tvelocity\tlength\twidth\tagent_type",
            true,
            |b, m| {
                format!(
                    "{}\t{}\t{:.4}\t{:.4}\t{:.5}\t{:.4}\t{}\t{}\t{}",
                    1_700_000_000_000_000_000_i64 + m.step * 100_000_000,
                    b.id,
                    m.x,
                    m.y,
                    (90.0 - m.heading.to_degrees()).rem_euclid(360.0),
                    m.speed * 3.6,
                    b.size.0,
                    b.size.1,
                    b.class
                )
            },
        );
        let found = read(silent.as_bytes(), &none).unwrap();
        compare(&bodies, &found, &EXACT, "silent");
        let said = notes(&found);
        for word in ["nanoseconds", "degrees, clockwise from north", "km/h"] {
            assert!(said.contains(word), "{word}: {said}");
        }
        // Frames, and JSON lines with velocities in the plane.
        let frames = table(&bodies, "", true, |b, m| {
            format!(
                "{{\"frame\":{},\"object\":{{\"id\":\"{}\"}},\"position\":{{\"x\":{:.4},\"y\":{:.4}}},\"velocity\":[{:.5},{:.5}],\"yaw\":{:.6},\"length\":{},\"width\":{},\"label\":\"{}\"}}",
                m.step,
                b.id,
                m.x,
                m.y,
                m.speed * m.heading.cos(),
                m.speed * m.heading.sin(),
                m.heading,
                b.size.0,
                b.size.1,
                b.class
            )
        });
        let found = read(
            frames.trim_start().as_bytes(),
            &with("id=object.id", Some(10.0)),
        )
        .unwrap();
        compare(&bodies, &found, &EXACT, "JSON lines");
        // Frames whose rate is found by the speeds.
        let rated = plain.replace("t,id", "frame,id");
        let rated: String = rated
            .lines()
            .map(|line| match line.split_once(',') {
                Some((time, rest)) if !time.starts_with('f') => {
                    format!("{},{rest}\n", (time.parse::<f64>().unwrap() * 10.0).round())
                }
                _ => format!("{line}\n"),
            })
            .collect();
        let found = read(rated.as_bytes(), &none).unwrap();
        assert!(
            notes(&found).contains("counts frames, 10 a second"),
            "{}",
            notes(&found)
        );
        compare(&bodies, &found, &EXACT, "frames");
        // The front, upside down, in feet.
        let front = table(&bodies, "t id px py dir v len wid", true, |b, m| {
            let (x, y) = (
                m.x + b.size.0 / 2.0 * m.heading.cos(),
                m.y + b.size.0 / 2.0 * m.heading.sin(),
            );
            let feet = |v: f64| v / 0.3048;
            format!(
                "{:.1} {} {:.5} {:.5} {:.6} {:.5} {:.4} {:.4}",
                seconds(m),
                b.id,
                feet(x),
                -feet(y),
                -m.heading,
                feet(m.speed),
                feet(b.size.0),
                feet(b.size.1)
            )
        });
        let options = with(
            "x=px[ft front],y=py[ft down],heading=dir[rad],speed=v[ft/s],length=len[ft],width=wid[ft]",
            None,
        );
        compare(
            &bodies,
            &read(front.as_bytes(), &options).unwrap(),
            &EXACT,
            "front",
        );
    }
}

#[test]
fn tables_of_data_sets_are_known_by_their_columns() {
    let bodies = scene("CutIn");
    let none = TableOptions::default();
    let ms = |m: &Moment| m.step * 100;
    let ngsim = table(
        &bodies,
        "Vehicle_ID,Frame_ID,Total_Frames,Global_Time,Local_X,Local_Y,Global_X,Global_Y,v_Length,v_Width,v_Class,v_Vel,v_Acc,Lane_ID,Preceding,Following,Space_Headway,Time_Headway",
        false,
        |b, m| {
            let (x, y) = (
                m.x + b.size.0 / 2.0 * m.heading.cos(),
                m.y + b.size.0 / 2.0 * m.heading.sin(),
            );
            let feet = |v: f64| v / 0.3048;
            format!(
                "{},{},0,{},{:.5},{:.5},0,0,{:.5},{:.5},2,{:.5},0,1,0,0,0,0",
                b.id,
                m.step,
                1_118_846_980_200_i64 + ms(m),
                feet(x),
                feet(y),
                feet(b.size.0),
                feet(b.size.1),
                feet(m.speed)
            )
        },
    );
    let found = read(ngsim.as_bytes(), &none).unwrap();
    assert_eq!(found.header.other_format, Some("NGSIM"));
    // Headings are those of the front, which moves otherwise than the middle.
    compare(&bodies, &found, &Tolerance(0.2, 0.05, 0.01, 1e-3), "NGSIM");
    let interaction = table(
        &bodies,
        "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy,psi_rad,length,width",
        false,
        |b, m| {
            format!(
                "{},{},{},car,{:.4},{:.4},{:.5},{:.5},{:.6},{},{}",
                b.id,
                m.step + 1,
                ms(m) + 100,
                m.x,
                m.y,
                m.speed * m.heading.cos(),
                m.speed * m.heading.sin(),
                m.heading,
                b.size.0,
                b.size.1
            )
        },
    );
    compare(
        &bodies,
        &read(interaction.as_bytes(), &none).unwrap(),
        &EXACT,
        "INTERACTION",
    );
    let argoverse = table(
        &bodies,
        "TIMESTAMP,TRACK_ID,OBJECT_TYPE,X,Y,CITY_NAME",
        true,
        |b, m| {
            let kind = if b.id == bodies[0].id { "AV" } else { "OTHERS" };
            // Its clock is not even.
            let jitter = (m.step * 7 % 5) as f64 * 0.002;
            format!(
                "{:.4},{},{kind},{:.4},{:.4},MIA",
                315_968_000.0 + m.step as f64 * DT + jitter,
                b.id,
                m.x,
                m.y
            )
        },
    );
    let found = read(argoverse.as_bytes(), &none).unwrap();
    assert_eq!(
        found.recorded_ego.as_ref().unwrap().obstacle.id,
        bodies[0].id
    );
    assert_eq!(found.obstacles.len(), bodies.len() - 1);
}

#[test]
fn headings_and_speeds_come_from_the_motion() {
    for name in SCENES {
        let bodies = scene(name);
        let bare = table(&bodies, "time,id,x,y,length,width", true, |b, m| {
            format!(
                "{:.2},{},{:.3},{:.3},{},{}",
                m.step as f64 * DT,
                b.id,
                m.x,
                m.y,
                b.size.0,
                b.size.1
            )
        });
        let found = read(bare.as_bytes(), &TableOptions::default()).unwrap();
        let degree = 1.0_f64.to_radians();
        compare(&bodies, &found, &Tolerance(1e-3, degree, 0.35, 1e-3), name);
        assert!(notes(&found).contains("headings from the motion"));
    }
}

#[test]
fn damage_has_a_line() {
    let good = "t,id,x,y\n0.0,1,0,0\n0.1,1,1,0\n0.2,1,2,0\n0.0,2,0,5\n0.1,2,1,5\n0.2,2,2,5\n";
    let none = TableOptions::default();
    assert!(read(good.as_bytes(), &none).is_ok());
    let error = |text: &str| read(text.as_bytes(), &none).unwrap_err().to_string();
    let said = error(&good.replace("0.1,1,1,0", "0.1,1,one,0"));
    assert!(
        said.contains(":3") && said.contains("column x: `one` is not a number"),
        "{said}"
    );
    assert!(error(&good.replace("0.1,2,1,5", "0.1,2,1,5,9")).contains(":6"));
    assert!(error(&good.replace("0.1,2,1,5", "0.1,2,1e12,5")).contains(":6"));
    assert!(error("t,id,x,y\n").contains("no track"));
    assert!(error("frame,id,x,y\n1,1,0,0\n2,1,1,0\n3,1,2,0\n").contains("--rate HZ"));
    let warned = |text: &str| -> Vec<(usize, String)> {
        let scenario = read(text.as_bytes(), &none).unwrap();
        let all = scenario.diagnostics.into_iter();
        all.filter(|d| d.severity == Severity::Warning && d.line > 0)
            .map(|d| (d.line, d.message))
            .collect()
    };
    let empty = warned(&good.replace("0.1,2,1,5", "0.1,2,,5"));
    assert!(
        empty
            .iter()
            .any(|(line, said)| *line == 6 && said.contains("lack an id")),
        "{empty:?}"
    );
    let twice = warned(&format!("{good}0.2,2,2,5\n"));
    assert!(
        twice
            .iter()
            .any(|(line, said)| *line == 8 && said.contains("already")),
        "{twice:?}"
    );
    let jump = warned(&good.replace("0.2,2,2,5", "0.2,2,90,5"));
    assert!(
        jump.iter()
            .any(|(line, said)| *line == 7 && said.contains("jumps")),
        "{jump:?}"
    );
    let options = with("time=tt", None);
    let said = read(good.as_bytes(), &options).unwrap_err().to_string();
    assert!(
        said.contains("no column `tt`") && said.contains("`t`"),
        "{said}"
    );
}

#[test]
fn a_place_needs_both_of_its_numbers_in_one_unit() {
    for header in ["time,id,x,lat", "time,id,lon,y"] {
        let text = format!("{header}\n0,1,5,48\n0.1,1,6,48\n");
        assert!(
            read(text.as_bytes(), &TableOptions::default()).is_err(),
            "{header}"
        );
    }
}

#[test]
fn windows_begin_at_unix_times() {
    let report = Report::about("t.csv");
    let window = super::super::windows::WindowRequest::parse("track=1@1714564800.5s", &report);
    let window = window.unwrap();
    assert_eq!(
        (window.track.as_str(), window.start),
        ("1", Some(1_714_564_800.5))
    );
}

#[test]
fn a_map_of_any_format_lies_beside_the_tracks() {
    let bodies = scene("RightTurn");
    let plain = table(&bodies, "t,id,x,y,yaw,v", true, |b, m| {
        format!(
            "{:.1},{},{:.4},{:.4},{:.6},{:.4}",
            m.step as f64 * DT,
            b.id,
            m.x,
            m.y,
            m.heading,
            m.speed
        )
    });
    let entry = crate::bundled()
        .into_iter()
        .find(|e| e.name.contains("RightTurn"))
        .unwrap();
    let original = entry.read().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let map = folder.path().join("map.xml");
    std::fs::write(&map, entry.source().unwrap()).unwrap();
    let with_map = |map: &Path| TableOptions {
        map: Some(map.to_path_buf()),
        ..TableOptions::default()
    };
    let found = read(plain.as_bytes(), &with_map(&map)).unwrap();
    assert_eq!(
        found.network.lanelets.len(),
        original.network.lanelets.len()
    );
    assert_eq!(
        found.network.lanelets[0].left.points,
        original.network.lanelets[0].left.points
    );
    // Ids of tracks stay; lanes that have the same get others.
    let lane = original.network.lanelets[0].id;
    let clash = plain.replace(&format!(",{},", bodies[0].id), &format!(",{lane},"));
    let found = read(clash.as_bytes(), &with_map(&map)).unwrap();
    assert!(found.obstacle(lane).is_some() && found.network.lanelet(lane).is_none());
    assert!(found.network.lanelets.iter().all(|l| {
        l.successors
            .iter()
            .all(|s| found.network.lanelet(*s).is_some())
    }));
    let error = read(plain.as_bytes(), &with_map(&folder.path().join("none.osm"))).unwrap_err();
    assert!(error.to_string().contains("none.osm"), "{error}");
    std::fs::write(&map, "<html/>").unwrap();
    let error = read(plain.as_bytes(), &with_map(&map)).unwrap_err();
    assert!(error.to_string().contains("no map; Lanelet2"), "{error}");
}
