//! SUMO: what its options and its folder say, and what is in degrees or in a table.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use nearmiss::geometry::Point;
use nearmiss::scenario::ObstacleType;

use super::*;

/// A vehicle at a time: seconds as written, its name, where its front is, and its speed.
type Row<'r> = (&'r str, &'r str, (f64, f64), f64);

fn fcd(header: &str, rows: &[Row<'_>]) -> String {
    let mut xml = format!("<?xml version=\"1.0\"?>\n<!-- {header} -->\n<fcd-export>\n");
    let mut last = "";
    for (time, name, (x, y), speed) in rows {
        if *time != last {
            if !last.is_empty() {
                xml += "</timestep>\n";
            }
            let _ = writeln!(xml, "<timestep time=\"{time}\">");
            last = time;
        }
        let _ = writeln!(
            xml,
            "<vehicle id=\"{name}\" x=\"{x}\" y=\"{y}\" angle=\"90.00\" type=\"DEFAULT_VEHTYPE\" speed=\"{speed}\" pos=\"5\" lane=\"e_0\" slope=\"0\"/>"
        );
    }
    xml + "</timestep>\n</fcd-export>\n"
}

/// A net of one edge called `e`, somewhere on the Earth.
fn net(location: &str) -> String {
    format!(
        "<net><location {location}/><edge id=\"e\" from=\"a\" to=\"b\"><lane id=\"e_0\" index=\"0\" speed=\"13.9\" length=\"447.69\" shape=\"0.12,-4.80 447.66,6.83\"/></edge></net>"
    )
}

/// The same places in the degrees and in the metres that SUMO 1.28 wrote for this net.
const UTM: &str = "netOffset=\"-649187.87,-5318235.61\" convBoundary=\"0.00,0.00,447.54,456.19\" origBoundary=\"11.000000,48.000000,11.006000,48.004000\" projParameter=\"+proj=utm +zone=32 +ellps=WGS84 +datum=WGS84 +units=m +no_defs\"";
const DEGREES: [(f64, f64); 3] = [
    (11.000_068, 47.999_957),
    (11.000_547, 47.999_957),
    (11.000_982, 47.999_957),
];
const METRES: [(f64, f64); 3] = [(5.22, -4.67), (40.93, -3.74), (73.41, -2.90)];

/// A centimetre in degrees is their last digit; and the middle of a car is 2.5 m behind its front.
const DIGIT: f64 = 0.12;

fn written(files: &[(&str, String)]) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let path = folder.path().join(files[0].0);
    (folder, path)
}

/// A car that drives through the places, one a second two and a half apart in time.
fn drive(places: [(f64, f64); 3]) -> Vec<Row<'static>> {
    let times = ["0.00", "2.50", "5.00"];
    let each = times.into_iter().zip(places);
    each.map(|(time, place)| (time, "car", place, 14.0))
        .collect()
}

fn fronts(path: &Path) -> Vec<Point> {
    let scenario = open(path);
    let car = &scenario.obstacles[0];
    let track = car.track();
    let all = track.steps().filter_map(|step| track.at(step));
    all.map(|at| at.pose.position + nearmiss::geometry::Vector::new(2.5, 0.0))
        .collect()
}

#[test]
fn cars_that_stand_in_degrees_are_not_in_each_other() {
    let rows = [
        ("0.00", "a", DEGREES[0], 0.0),
        ("0.00", "b", DEGREES[1], 0.0),
        ("1.00", "a", DEGREES[0], 0.0),
        ("1.00", "b", DEGREES[1], 0.0),
    ];
    let (_folder, path) = written(&[("fcd.xml", fcd("", &rows))]);
    let scenario = open(&path);
    let at = |place: usize| {
        scenario.obstacles[place]
            .motion_at(0)
            .unwrap()
            .pose
            .position
    };
    assert!(((at(0) - at(1)).norm() - 35.7).abs() < 0.5);
    let told = scenario.diagnostics.iter();
    assert!(
        told.clone()
            .any(|told| told.message.contains("positions are in degrees"))
    );
}

#[test]
fn degrees_come_onto_the_net_by_its_projection() {
    for (header, location, metres) in [
        ("", UTM, METRES),
        (
            "<fcd-output value=\"x\"/><fcd-output.geo value=\"true\"/>",
            UTM,
            METRES,
        ),
        (
            "",
            "netOffset=\"0.00,0.00\" projParameter=\"+proj=tmerc +lat_0=48 +lon_0=11 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs\"",
            [(5.10, -4.80), (40.82, -4.80), (73.31, -4.80)],
        ),
        (
            "",
            "netOffset=\"-819363.81,-5334528.00\" projParameter=\"-\"",
            [(5.77, -4.80), (41.4, -4.80), (73.8, -4.80)],
        ),
    ] {
        let files = [
            ("fcd.xml", fcd(header, &drive(DEGREES))),
            ("a.net.xml", net(location)),
        ];
        let (_folder, path) = written(&files);
        for (found, (x, y)) in fronts(&path).iter().zip(metres) {
            let off = (found - Point::new(x, y)).norm();
            assert!(off < DIGIT, "{found} is {off} m from {x}, {y}: {location}");
        }
        let scenario = open(&path);
        assert_eq!(scenario.network.lanelets.len(), 1);
        let said = messages(&scenario);
        assert!(
            said.contains("positions are in degrees; projected as the net is"),
            "{said}"
        );
    }
}

#[test]
fn degrees_without_a_net_or_with_a_projection_that_is_not_read_are_on_a_plane() {
    // Two cars of equal speed, 50 m apart.
    let at = |i: u32, ahead: f64| (11.0 + ahead + 0.000_134 * f64::from(i), 48.0);
    let names = ["0", "1", "2", "3"];
    let rows = |name| {
        let each = names.iter().zip(0..);
        each.flat_map(move |(time, i)| {
            [
                (*time, "a", at(i, 0.0), 10.0),
                (*time, name, at(i, 0.000_671), 10.0),
            ]
        })
    };
    let rows: Vec<Row<'_>> = rows("b").collect();
    let alone = [("fcd.xml", fcd("", &rows))];
    let other = [
        ("fcd.xml", fcd("", &rows)),
        (
            "a.net.xml",
            net("netOffset=\"0,0\" projParameter=\"+proj=lcc +lat_1=48\""),
        ),
    ];
    for (files, said) in [
        (&alone[..], "positions are in degrees; on a plane"),
        (
            &other[..],
            "the net's projection `+proj=lcc +lat_1=48` is not read, and its lanes are left out",
        ),
    ] {
        let (_folder, path) = written(files);
        let scenario = open(&path);
        for step in 0..4 {
            let [a, b] = [0, 1].map(|i| scenario.obstacles[i].track().at(step).unwrap());
            let apart = (b.pose.position - a.pose.position).norm();
            assert!((apart - 50.06).abs() < 0.1, "{apart}");
        }
        let all = messages(&scenario);
        assert!(
            all.contains(said) && scenario.network.lanelets.is_empty(),
            "{all}"
        );
    }
}

#[test]
fn metres_stay_metres_whatever_the_options_say() {
    // The net has no projection: SUMO then writes metres under the option, and warns.
    let geo = "<fcd-output value=\"x\"/><fcd-output.geo value=\"true\"/>";
    for header in ["", geo] {
        let plain = "netOffset=\"0.00,0.00\" convBoundary=\"0,-10,450,10\" origBoundary=\"0,-10,450,10\" projParameter=\"!\"";
        let files = [
            ("fcd.xml", fcd(header, &drive(METRES))),
            ("a.net.xml", net(plain)),
        ];
        let (_folder, path) = written(&files);
        for (found, (x, y)) in fronts(&path).iter().zip(METRES) {
            assert!((found - Point::new(x, y)).norm() < 1e-9, "{found}");
        }
        assert!(!messages(&open(&path)).contains("degrees"));
    }
    // Nobody moves: where the net lies tells it.
    let standing = |place: (f64, f64)| [("0", "a", place, 0.0), ("1", "a", place, 0.0)];
    for (place, is_degrees) in [((11.001, 48.001), true), ((11.0, -4.0), false)] {
        let files = [
            ("fcd.xml", fcd("", &standing(place))),
            ("a.net.xml", net(UTM)),
        ];
        let (_folder, path) = written(&files);
        assert_eq!(
            messages(&open(&path)).contains("degrees"),
            is_degrees,
            "{place:?}"
        );
    }
}

#[test]
fn times_are_of_a_clock_and_have_to_be_steps() {
    let rows = |times: [&'static str; 4]| -> Vec<Row<'static>> {
        let each = times.into_iter().zip(0..);
        each.map(|(time, i)| (time, "a", (10.0 * f64::from(i), 0.0), 10.0))
            .collect()
    };
    let clock = ["23:59:58", "23:59:59", "24:00:00", "1:00:00:01"];
    let (_folder, path) = written(&[("fcd.xml", fcd("", &rows(clock)))]);
    let scenario = open(&path);
    near(scenario.dt(), 1.0);
    assert_eq!(scenario.obstacles[0].track().steps(), 0..4);
    let (_folder, path) = written(&[("fcd.xml", fcd("", &rows(["0", "0.1", "0.2", "0.34"])))]);
    let error = refused(&path);
    assert!(
        error.contains("time 0.34 s is no step: most times are 0.1 s apart"),
        "{error}"
    );
    let (_folder, path) = written(&[("fcd.xml", fcd("", &rows(["0", "noon", "2", "3"])))]);
    assert!(
        refused(&path).contains("fcd.xml:7:")
            && refused(&path).contains("time=\"noon\" is not a time")
    );
}

#[test]
fn of_several_nets_the_right_one_is_read() {
    let rows = drive(METRES);
    let plain = "projParameter=\"!\"";
    let (own, other) = (net(plain), net(plain).replace("\"e\"", "\"f\""));
    let windows = "<net-file value=\"C:\\maps\\city\\own.net.xml\"/>";
    // Named under a path of Windows.
    let (_folder, path) = written(&[
        ("fcd.xml", fcd(windows, &rows)),
        ("a.net.xml", other.clone()),
        ("own.net.xml", own.clone()),
    ]);
    assert_eq!(open(&path).network.lanelets.len(), 1);
    // Not named: the only one with its edges.
    let (_folder, path) = written(&[
        ("fcd.xml", fcd("", &rows)),
        ("a.net.xml", other.clone()),
        ("b.net.xml", own.clone()),
        ("c.net.xml", "<net>".into()),
    ]);
    let scenario = open(&path);
    assert_eq!(scenario.network.lanelets.len(), 1);
    assert!(messages(&scenario).contains("the only one of 3 beside it that has its edges"));
    for (files, said) in [
        (
            vec![("a.net.xml", own.clone()), ("b.net.xml", own.clone())],
            "2 .net.xml files are beside it (a.net.xml, b.net.xml), and several of them have all its edges",
        ),
        (
            vec![("a.net.xml", other.clone()), ("b.net.xml", other.clone())],
            "none of them has all its edges",
        ),
        (
            vec![("a.net.xml", other.clone())],
            "a.net.xml, the only one beside it, has none of its edges, such as `e`",
        ),
        (
            vec![],
            "own.net.xml, which it was made with, is not beside it",
        ),
    ] {
        let mut all = vec![("fcd.xml", fcd(windows, &rows))];
        all.extend(files);
        let (_folder, path) = written(&all);
        let scenario = open(&path);
        let all = messages(&scenario);
        assert!(
            all.contains(said) && scenario.network.lanelets.is_empty(),
            "{all}"
        );
    }
}

#[test]
fn tables_are_read_like_xml() {
    let mut table = String::from(
        "timestep_time;vehicle_id;vehicle_x;vehicle_y;vehicle_angle;vehicle_type;vehicle_speed;vehicle_pos;vehicle_lane;vehicle_edge;vehicle_slope\n",
    );
    for (time, (x, y)) in ["0.00", "2.50", "5.00"].into_iter().zip(METRES) {
        let _ = writeln!(
            table,
            "{time};car;{x};{y};90.00;DEFAULT_VEHTYPE;14.00;5.10;e_0;;0.00"
        );
    }
    let (folder, path) = written(&[
        ("fcd.csv", table),
        ("a.net.xml", net("projParameter=\"!\"")),
    ]);
    assert_eq!(found(folder.path()), ["fcd.csv"]);
    for (found, (x, y)) in fronts(&path).iter().zip(METRES) {
        assert!((found - Point::new(x, y)).norm() < 1e-9, "{found}");
    }
    assert_eq!(open(&path).network.lanelets.len(), 1);
}

#[test]
fn classes_have_the_sizes_of_sumo() {
    let rows: Vec<Row<'_>> = ["0", "1"]
        .into_iter()
        .flat_map(|t| [(t, "a", (0.0, 0.0), 0.0), (t, "b", (90.0, 0.0), 0.0)])
        .collect();
    let xml = fcd("", &rows)
        .replace(
            "id=\"a\" x=\"0\" y=\"0\" angle=\"90.00\" type=\"DEFAULT_VEHTYPE\"",
            "id=\"a\" x=\"0\" y=\"0\" angle=\"90.00\" type=\"m\"",
        )
        .replace(
            "id=\"b\" x=\"90\" y=\"0\" angle=\"90.00\" type=\"DEFAULT_VEHTYPE\"",
            "id=\"b\" x=\"90\" y=\"0\" angle=\"90.00\" type=\"s\"",
        );
    let types =
        "<routes><vType id=\"m\" vClass=\"moped\"/><vType id=\"s\" vClass=\"subway\"/></routes>";
    let (_folder, path) = written(&[("fcd.xml", xml), ("a.rou.xml", types.into())]);
    let scenario = open(&path);
    for (kind, length, width) in [
        (ObstacleType::Motorcycle, 2.1, 0.78),
        (ObstacleType::Train, 109.5, 3.0),
    ] {
        let found = scenario.obstacles.iter().find(|o| o.kind == kind).unwrap();
        let size = found.footprint.as_ref().unwrap().shape().size();
        near(size.0, length);
        near(size.1, width);
    }
}

#[test]
fn a_vehicle_that_is_twice_at_a_step_is_told() {
    let mut rows = drive(METRES);
    rows.insert(1, ("0.00", "car", (1005.22, -4.67), 14.0));
    let (_folder, path) = written(&[("fcd.xml", fcd("", &rows))]);
    let said = messages(&open(&path));
    assert!(
        said.contains("vehicle `car`")
            && said.contains("1 rows are at a step that has one already, up to 1000.00 m"),
        "{said}"
    );
}
