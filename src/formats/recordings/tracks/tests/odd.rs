//! Tables as people have them: small ones, each with what is odd about it.

use super::*;

#[test]
fn the_second_table_of_a_recording_may_lack_columns() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    let vehicles = file(
        "vehicle_tracks_000.csv",
        "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy,psi_rad,length,width\n\
         1,1,100,car,100,50,10,0,0,4.5,1.8\n1,2,200,car,101,50,10,0,0,4.5,1.8\n",
    );
    let pedestrians = file(
        "pedestrian_tracks_000.csv",
        "track_id,frame_id,timestamp_ms,agent_type,x,y,vx,vy\n\
         P1,1,100,pedestrian/bicycle,115,50,0,1\nP1,2,200,pedestrian/bicycle,115,50.1,0,1\n",
    );
    let found = super::super::read(&vehicles).unwrap();
    let scenario = found.open(&vehicles, None, Report::about("t")).unwrap();
    assert_eq!(scenario.obstacles.len(), 2);
    let is_found = |path: &Path| Tables.is_found(path, &std::fs::read(path).unwrap());
    assert!(is_found(&vehicles) && !is_found(&pedestrians));
}

/// x, y, heading and speed at a time.
type Drive = dyn Fn(f64) -> [f64; 4];

/// Rows of tracks: each a name and, at ten moments a second, x, y, heading and speed, as a line of a table says them.
fn lines(
    header: &str,
    tracks: &[(&str, &Drive)],
    count: u32,
    row: impl Fn(f64, &str, [f64; 4]) -> String,
) -> String {
    let mut text = format!("{header}\n");
    for (name, motion) in tracks {
        for i in 0..count {
            let time = f64::from(i) * 0.1;
            writeln!(text, "{}", row(time, name, motion(time))).unwrap();
        }
    }
    text
}

/// On a circle of radius 20 m at 8 m/s, counterclockwise from its lowest point.
fn circle(time: f64) -> [f64; 4] {
    let angle = time * 8.0 / 20.0;
    [20.0 * angle.sin(), -20.0 * angle.cos(), angle, 8.0]
}

/// Northwest until it stands after two seconds.
fn stops(time: f64) -> [f64; 4] {
    let driven = time.min(2.0) * 4.0;
    let heading: f64 = 2.3;
    let speed = if time < 1.95 { 4.0 } else { 0.0 };
    [
        30.0 + driven * heading.cos(),
        driven * heading.sin(),
        heading,
        speed,
    ]
}

fn plain(time: f64, name: &str, [x, y, heading, speed]: [f64; 4]) -> String {
    format!("{time:.1},{name},{x:.4},{y:.4},{heading:.5},{speed:.3}")
}

const PLAIN: &str = "time,id,x,y,heading,speed";

fn heading_of(scenario: &Scenario, id: i64, step: i64) -> f64 {
    let track = scenario.obstacle(id).unwrap().track();
    track.at(step).unwrap().pose.heading
}

/// Whether each state is where a motion is; by how much it may be off, metres, radians and m/s.
fn follows(scenario: &Scenario, id: i64, motion: impl Fn(f64) -> [f64; 4], most: [f64; 3]) {
    let track = scenario.obstacle(id).unwrap().track();
    for (step, at) in track.iter() {
        let [x, y, heading, speed] = motion(step as f64 * scenario.dt());
        let place = (at.pose.position.x - x).hypot(at.pose.position.y - y);
        let off = angle_between(at.pose.heading, heading).abs();
        assert!(place <= most[0], "{id} at {step}: {place} m");
        assert!(off <= most[1], "{id} at {step}: {}°", off.to_degrees());
        assert!(
            (at.velocity - speed).abs() <= most[2],
            "{id} at {step}: {}",
            at.velocity
        );
    }
}

const CLOSE: [f64; 3] = [1e-3, 1e-3, 1e-3];

#[test]
fn headings_that_standstill_has_none_of_are_held() {
    let none = TableOptions::default();
    for scale in [1.0, 0.1] {
        // `arctan2(vy, vx)` is 0 at standstill.
        let zero = |time: f64| {
            let [x, y, heading, speed] = stops(time);
            [x, y, if speed == 0.0 { 0.0 } else { heading }, speed]
        };
        let text = lines(PLAIN, &[("1", &zero), ("2", &circle)], 40, |t, n, at| {
            let [x, y, heading, speed] = at;
            format!(
                "{:.2},{n},{x:.4},{y:.4},{heading:.5},{:.3}",
                t * scale,
                speed / scale
            )
        });
        let found = read(text.as_bytes(), &none).unwrap();
        assert!((heading_of(&found, 1, 39) - 2.3).abs() < 1e-3);
        assert!(
            notes(&found).contains("standstill has none of; held there (rows: 20)"),
            "{}",
            notes(&found)
        );
    }
    // One that never moves keeps what is written.
    let stands = |_: f64| [0.0, 0.0, 0.0, 0.0];
    let text = lines(PLAIN, &[("1", &stands), ("2", &circle)], 40, plain);
    let found = read(text.as_bytes(), &none).unwrap();
    assert!(heading_of(&found, 1, 39).abs() < 1e-9 && !notes(&found).contains("standstill"));
}

#[test]
fn our_own_columns_in_other_units_are_found_out() {
    let none = TableOptions::default();
    let header = crate::tables::OWN_COLUMNS.join(",");
    let own = |time: f64, length: f64, speed: f64, heading: &dyn Fn(f64) -> f64, down: f64| {
        lines(
            &header,
            &[("1", &circle), ("2", &stops)],
            40,
            |t, name, [x, y, h, v]| {
                let (x, y, v) = (x / length, y / length * down, v / speed);
                let (l, w) = (4.5 / length, 1.8 / length);
                format!(
                    "{},{name},{x:.5},{y:.5},{},{v:.4},0,{l},{w},car,False",
                    (t * 10.0).round() / 10.0 * time,
                    heading(h)
                )
            },
        )
    };
    let radians = |h: f64| h;
    for (text, said) in [
        (own(1.0, 1.0, 1.0, &radians, 1.0), ""),
        (own(1000.0, 1.0, 1.0, &radians, 1.0), "milliseconds"),
        (
            own(10.0, 1.0, 1.0, &radians, 1.0),
            "counts frames, 10 a second",
        ),
        (
            own(1.0, 0.3048, 0.3048, &radians, 1.0),
            "speeds are in ft/s",
        ),
        (own(1.0, 1.0, 1.0 / 3.6, &radians, 1.0), "km/h"),
        (own(1.0, 1.0, 1.0, &f64::to_degrees, 1.0), "in degrees"),
        (
            own(1.0, 1.0, 1.0, &|h| 90.0 - h.to_degrees(), 1.0),
            "clockwise from north",
        ),
        (own(1.0, 1.0, 1.0, &radians, -1.0), "y grows downwards"),
    ] {
        let found = read(text.as_bytes(), &none).unwrap();
        assert!(notes(&found).contains(said), "{said}: {}", notes(&found));
        follows(&found, 1, circle, CLOSE);
    }
    // Whole seconds are what `convert` may write.
    let slow = |time: f64| circle(time * 10.0);
    let text = lines(&header, &[("1", &slow)], 30, |t, name, [x, y, h, v]| {
        format!(
            "{},{name},{x:.5},{y:.5},{h},{v},0,4.5,1.8,car,False",
            (t * 10.0).round()
        )
    });
    let found = read(text.as_bytes(), &none).unwrap();
    assert!((found.dt() - 1.0).abs() < 1e-9);
}

#[test]
fn velocities_follow_y_and_need_no_body() {
    let row = |t: f64, name: &str, [x, y, h, v]: [f64; 4]| {
        let (vx, vy) = (v * h.cos(), v * h.sin());
        format!(
            "{t:.1},{name},{x:.4},{:.4},{:.4},{vx:.4},{:.4}",
            -y,
            -h.to_degrees(),
            -vy
        )
    };
    let header = "time,id,x,y,yaw,velocity_x,velocity_y";
    let text = lines(header, &[("1", &circle), ("2", &stops)], 60, row);
    let found = read(text.as_bytes(), &with("y=y[down],heading=yaw[deg]", None)).unwrap();
    assert!(
        !notes(&found).contains("along and across"),
        "{}",
        notes(&found)
    );
    follows(&found, 1, circle, CLOSE);
    // Along the axes with y upwards beside places with y downwards.
    let mixed = lines(header, &[("1", &circle)], 60, |t, name, [x, y, h, v]| {
        let (vx, vy) = (v * h.cos(), v * h.sin());
        format!(
            "{t:.1},{name},{x:.4},{:.4},{:.4},{vx:.4},{vy:.4}",
            -y,
            -h.to_degrees()
        )
    });
    let found = read(mixed.as_bytes(), &with("y=y[down]", None)).unwrap();
    follows(&found, 1, circle, CLOSE);
}

#[test]
fn uneven_times_are_interpolated_and_lose_no_row() {
    let none = TableOptions::default();
    for (jitter, tracks) in [(0.004, 1.0), (0.02, 1.0), (0.03, 0.0)] {
        let mut text = format!("{PLAIN}\n");
        for step in 0..100_u32 {
            for (track, motion) in [(1, &circle as &Drive), (2, &stops)] {
                // One clock, or one each.
                let seed = f64::from(step) * 37.7 + f64::from(track) * (1.0 - tracks) * 11.3;
                let time = 5.0 + f64::from(step) * 0.1 + jitter * seed.sin();
                let [x, y, heading, speed] = motion(time - 5.0);
                writeln!(
                    text,
                    "{time:.6},{track},{x:.5},{y:.5},{heading:.5},{speed:.4}"
                )
                .unwrap();
            }
        }
        let found = read(text.as_bytes(), &none).unwrap();
        assert!((found.dt() - 0.1).abs() < 1e-9);
        assert!(
            notes(&found).contains("interpolated at steps of 0.1 s"),
            "{}",
            notes(&found)
        );
        assert!(!notes(&found).contains("already"), "{}", notes(&found));
        assert!(found.obstacle(1).unwrap().track().steps().count() >= 99);
        // Of a circle, an arc of a tenth of a second is off its chord by 4 mm.
        follows(&found, 1, circle, [6e-3, 1e-3, 1e-3]);
    }
    // Times that are rounded are even.
    let text = lines(
        "time,id,x,y",
        &[("1", &circle)],
        60,
        |t, name, [x, y, ..]| format!("{:.3},{name},{x:.4},{y:.4}", t / 3.0),
    );
    let found = read(text.as_bytes(), &none).unwrap();
    assert!((found.dt() - 1.0 / 30.0).abs() < 1e-5 && !notes(&found).contains("interpolated"));
}

#[test]
fn fronts_and_rear_axles_without_headings_have_those_of_the_body() {
    for (convention, ahead, most) in [("rear-axle", -0.28, 0.01), ("front", 0.5, 0.03)] {
        // The rear axle rolls along the circle.
        let text = lines(
            "time,id,x,y,length,width",
            &[("1", &circle)],
            90,
            |t, name, [x, y, h, _]| {
                let ahead = 4.5 * (ahead + 0.28);
                let (x, y) = (x + ahead * h.cos(), y + ahead * h.sin());
                format!("{t:.1},{name},{x:.4},{y:.4},4.5,1.8")
            },
        );
        let options = with(&format!("x=x[{convention}]"), None);
        let found = read(text.as_bytes(), &options).unwrap();
        let middle = |time: f64| {
            let [x, y, heading, _] = circle(time);
            let ahead = 4.5 * 0.28;
            let speed = 8.0 * f64::hypot(20.0, ahead) / 20.0;
            [
                x + ahead * heading.cos(),
                y + ahead * heading.sin(),
                heading,
                speed,
            ]
        };
        follows(&found, 1, middle, [0.06, most, 0.2]);
    }
}

#[test]
fn a_rate_is_of_frames_only() {
    let seconds = lines(PLAIN, &[("1", &circle)], 20, plain);
    let error = |text: &str, rate| {
        read(text.as_bytes(), &with("", Some(rate)))
            .unwrap_err()
            .to_string()
    };
    let said = error(&seconds, 10.0);
    assert!(
        said.contains("`time` counts no frames: 0.1") && said.contains("leave --rate out"),
        "{said}"
    );
    let ms = lines(PLAIN, &[("1", &circle)], 20, |t, name, at| {
        plain(0.0, name, at).replacen("0.0", &(t * 1000.0).round().to_string(), 1)
    });
    assert!(error(&ms, 10.0).contains("counts no frames"));
    // Every fifth one is, too, where the column says that it counts them.
    let frames = ms.replace("00,1", ",1").replace("time", "frame");
    let found = read(frames.as_bytes(), &with("", Some(10.0))).unwrap();
    follows(&found, 1, circle, CLOSE);
}

#[test]
fn a_map_in_degrees_and_metres_lies_under_tracks_in_degrees() {
    let folder = tempfile::tempdir().unwrap();
    let mut map = String::from("<osm>");
    let places = [
        (48.0, 11.0),
        (48.0, 11.001),
        (48.0001, 11.0),
        (48.0001, 11.001),
    ];
    for (id, (lat, lon)) in (1..).zip(places) {
        write!(
            map,
            "<node id='{id}' lat='{lat}' lon='{lon}'><tag k='local_x' v='{id}'/><tag k='local_y' v='{id}'/></node>"
        )
        .unwrap();
    }
    map.push_str(
        "<way id='5'><nd ref='3'/><nd ref='4'/></way><way id='6'><nd ref='1'/><nd ref='2'/></way>\
         <relation id='7'><member type='way' ref='5' role='left'/><member type='way' ref='6' role='right'/>\
         <tag k='type' v='lanelet'/></relation></osm>",
    );
    let path = folder.path().join("map.osm");
    std::fs::write(&path, map).unwrap();
    let text =
        "t,id,lat,lon\n0.0,1,48.00005,11.0002\n0.1,1,48.00005,11.00021\n0.2,1,48.00005,11.00022\n";
    let options = TableOptions {
        map: Some(path),
        ..TableOptions::default()
    };
    let found = read(text.as_bytes(), &options).unwrap();
    let right = &found.network.lanelets[0].right.points;
    let plane = crate::recordings::utm::TransverseMercator::around(48.0, 11.0);
    let (east, north) = plane.forward(48.0, 11.001);
    assert!(
        (right[1].x - east).abs() < 1e-6 && (right[1].y - north).abs() < 1e-6,
        "{right:?}"
    );
    assert!(
        !notes(&found).contains("no track is on the map"),
        "{}",
        notes(&found)
    );
}

#[test]
fn names_of_other_programs_are_known() {
    let none = TableOptions::default();
    // Quaternions and stamps of ROS.
    let quaternion = |t: f64, name: &str, [x, y, h, v]: [f64; 4]| {
        let tenths = (t * 10.0).round();
        let (secs, nsecs) = (
            1_714_557_600.0 + (tenths / 10.0).floor(),
            tenths % 10.0 * 1e8,
        );
        let (z, w) = ((h / 2.0).sin(), (h / 2.0).cos());
        format!("{secs},{nsecs},{name},{x:.4},{y:.4},0,0,{z:.7},{w:.7},{v:.3}")
    };
    let header = "header.stamp.secs,header.stamp.nsecs,id,pose.pose.position.x,pose.pose.position.y,\
                  pose.pose.orientation.x,pose.pose.orientation.y,pose.pose.orientation.z,pose.pose.orientation.w,v";
    let ros = lines(header, &[("1", &circle), ("2", &stops)], 40, quaternion);
    let found = read(ros.as_bytes(), &none).unwrap();
    assert!((found.dt() - 0.1).abs() < 1e-9, "{}", found.dt());
    follows(&found, 1, circle, [1e-3, 1e-3, 0.01]);
    assert!(!notes(&found).contains("headings"), "{}", notes(&found));
    // Without one of the four there is no heading; the user may drop it, too.
    let three = ros.replace("orientation.w", "other");
    for (text, columns) in [(&three, ""), (&ros, "heading=none")] {
        let found = read(text.as_bytes(), &with(columns, None)).unwrap();
        assert!(
            notes(&found).contains("headings from the motion"),
            "{columns}"
        );
    }
    // CARLA and esmini tell the ego by name.
    let carla = lines(
        "timestamp,frame,actor_id,type_id,role_name,location.x,location.y,rotation.yaw,size.length,size.width",
        &[("7", &circle), ("8", &stops)],
        20,
        |t, name, [x, y, h, _]| {
            let role = if name == "7" { "hero" } else { "autopilot" };
            format!(
                "{t:.1},{},{name},vehicle.bus.x,{role},{x},{y},{},9,2.5",
                t * 20.0,
                h.to_degrees()
            )
        },
    );
    let found = read(carla.as_bytes(), &none).unwrap();
    let ego = found.recorded_ego.as_ref().unwrap();
    assert_eq!((ego.obstacle.id, ego.obstacle.kind.name()), (7, "bus"));
    assert!((size_of(&ego.obstacle).0 - 9.0).abs() < 1e-9);
    let dat = lines(
        "time, id, name, x, y, z, h, p, r, speed",
        &[("1", &circle), ("2", &stops)],
        20,
        |t, name, [x, y, h, v]| {
            format!(
                "{t:.3}, {name}, {}, {x:.6}, {y:.6}, 0, {h:.6}, 0, 0, {v:.6}",
                if name == "2" { "Ego" } else { "veh" }
            )
        },
    );
    let found = read(dat.as_bytes(), &none).unwrap();
    assert_eq!(found.recorded_ego.as_ref().unwrap().obstacle.id, 2);
    follows(&found, 1, circle, CLOSE);
    // A height is no heading.
    let heights = Columns::by_name(&["x", "y", "l", "w", "h"].map(String::from));
    assert!(!heights.of.contains_key(&Role::Heading));
}

#[test]
fn files_that_were_put_together_are_one_table() {
    let none = TableOptions::default();
    let one = |name: &str| lines(PLAIN, &[(name, &circle)], 20, plain);
    let text = format!("{}{}{}", one("1"), one("2"), one("3"));
    let found = read(text.as_bytes(), &none).unwrap();
    assert_eq!(found.obstacles.len(), 3);
    assert!(
        notes(&found).contains("header lines between rows: 2; skipped"),
        "{}",
        notes(&found)
    );
    // NumPy's ids, and a header that is a comment.
    let numpy = lines(
        "# time id x y",
        &[("1", &circle), ("30600", &stops)],
        20,
        |t, name, [x, y, ..]| {
            let name: f64 = name.parse().unwrap();
            let e = |v: f64| {
                let digits = format!("{v:.18e}");
                digits.replace('e', "e+").replace("e+-", "e-")
            };
            format!("{} {} {} {}", e(t), e(name), e(x), e(y))
        },
    );
    let found = read(numpy.as_bytes(), &none).unwrap();
    assert!(found.obstacle(30600).is_some(), "{}", notes(&found));
    // An array, as pandas writes it.
    let rows: Vec<String> = (0..20)
        .map(|i| {
            format!(
                "{{\"time\":{:.1},\"id\":1,\"x\":{i}.0,\"y\":0.0}}",
                f64::from(i) * 0.1
            )
        })
        .collect();
    let found = read(format!("[{}]", rows.join(",")).as_bytes(), &none).unwrap();
    assert_eq!(found.obstacle(1).unwrap().track().steps().count(), 20);
}

#[test]
fn a_table_that_lacks_columns_says_which() {
    let refused = |text: &str| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).unwrap();
        crate::dispatch::open(&path).unwrap_err().to_string()
    };
    let many: Vec<String> = (0..28).map(|i| format!("c{i}")).collect();
    let said = refused(&format!("x,y,{}\n1,2\n", many.join(",")));
    for words in [
        "`c27`",
        "found: x = x, y = y; missing: time or frame, id",
        "--columns time=COLUMN,id=COLUMN",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let said = refused("time,x,y,heading\n0,1,2,3\n");
    assert!(
        said.contains("missing: id;") && said.contains("--columns id=file"),
        "{said}"
    );
    let said = refused("time,a.x,a.y,b.x,b.y\n0,1,2,3,4\n");
    assert!(said.contains("side by side (`a.x`, `b.x`)"), "{said}");
    let said = refused("0.0 1 2.5 3.5 a\n0.1 1 2.6 3.6 a\n");
    assert!(
        said.contains("5 columns without a header") && said.contains("x=3"),
        "{said}"
    );
    let said = refused("{\"t\":0,\"who\":{\"key\":\"a\"},\"pose\":{\"x\":1,\"y\":2}}\n");
    assert!(
        said.contains("`who.key`") && said.contains("missing: id"),
        "{said}"
    );
    let said = refused("time,id,x,y\n");
    assert!(said.contains("it has no rows"), "{said}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    std::fs::write(&path, b"Zeit,Fahrzeug,x,y,L\xe4nge\n0,1,2,3,4\n").unwrap();
    let said = crate::dispatch::open(&path).unwrap_err().to_string();
    assert!(
        said.contains("not UTF-8 text; save the file as UTF-8"),
        "{said}"
    );
    assert!(
        refused("{\"time\":{\"0\":1,\"1\":2},\"x\":{\"0\":1}}")
            .contains("orient='records', lines=True")
    );
    assert!(
        refused("PK\u{3}\u{4}..[Content_Types].xml")
            .contains("Excel workbook; save it as CSV UTF-8")
    );
    assert!(refused("").contains("the file is empty"), "{}", refused(""));
    let utf16: Vec<u8> = "\u{feff}time,id,x,y\n"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    std::fs::write(&path, utf16).unwrap();
    let said = crate::dispatch::open(&path).unwrap_err().to_string();
    assert!(said.contains("UTF-16; save it as UTF-8"), "{said}");
}

#[test]
fn road_users_keep_the_numbers_of_their_names_and_the_ego_its_class() {
    let ids = |names: &[&str]| numbers(names.iter().map(|name| ("", *name)));
    assert_eq!(ids(&["veh_358", "veh_7", "ego"]), [358, 7, 359]);
    // Of two with the same number neither is meant.
    assert_eq!(ids(&["car_1", "truck_1", "2", "bus_2"]), [3, 4, 2, 5]);
    assert_eq!(ids(&["a1700000000000000001", "b"]), [1, 2]);
    // Of names of the same number only the one that is written so has it.
    assert_eq!(ids(&["012", "12", "+12"]), [13, 12, 14]);
    assert_eq!(ids(&["007", "veh_8"]), [7, 8]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.csv");
    let text = lines(
        "time,id,x,y,heading,speed,class",
        &[("veh_358", &circle), ("ego", &stops)],
        30,
        |t, name, at| {
            format!(
                "{},{}",
                plain(t, name, at),
                if name == "ego" { "truck" } else { "bus" }
            )
        },
    );
    std::fs::write(&path, text).unwrap();
    let entry = crate::Entry::of_argument(&path);
    let scenario = entry.read().unwrap();
    let named = |name: &str| crate::EgoSelection::File {
        path: name.into(),
        planning_problem: None,
    };
    let ego = named("veh_358")
        .resolve(&entry, &scenario)
        .unwrap()
        .unwrap();
    assert_eq!(ego.id, 358);
    assert!(named("veh_359").resolve(&entry, &scenario).is_err());
    let own = entry.recorded_ego(&scenario).unwrap().unwrap();
    let shape = crate::TableShape::Tracks(nearmiss_record::Format::Csv);
    let written = crate::write_tables(shape, &scenario, Some(&own)).unwrap();
    let text = String::from_utf8(written.files[0].1.clone()).unwrap();
    assert!(
        text.contains("truck,true") && text.contains("bus,false"),
        "{text}"
    );
}

#[test]
fn the_hash_tells_units_and_conventions() {
    let text = lines(PLAIN, &[("1", &circle)], 30, plain);
    let hash = |columns: &str| {
        let said = with(columns, None);
        read(text.as_bytes(), &said).unwrap().hash
    };
    let all = ["x=x", "x=x[m]", "x=x[ft]", "x=x[front]", "y=y[down]"].map(hash);
    for (i, one) in all.iter().enumerate() {
        assert!(!all[..i].contains(one), "{i}");
    }
}

#[test]
fn headings_beyond_a_turn_stay_radians() {
    let text = lines(PLAIN, &[("1", &circle)], 250, plain);
    let found = read(text.as_bytes(), &TableOptions::default()).unwrap();
    follows(&found, 1, circle, CLOSE);
    assert!(!notes(&found).contains("degrees"), "{}", notes(&found));
    let stands = |_: f64| [0.0, 0.0, 90.0, 0.0];
    let text = lines(PLAIN, &[("1", &stands)], 40, plain);
    let found = read(text.as_bytes(), &TableOptions::default()).unwrap();
    let said = notes(&found);
    assert!(said.contains("in degrees: so large are they"), "{said}");
}

#[test]
fn columns_of_the_same_name_are_told() {
    let header = format!("{PLAIN},x");
    let text = lines(&header, &[("1", &circle)], 30, |t, name, at| {
        format!("{},7", plain(t, name, at))
    });
    let found = read(text.as_bytes(), &TableOptions::default()).unwrap();
    follows(&found, 1, circle, CLOSE);
    let said = notes(&found);
    assert!(
        said.contains("2 columns are called `x`; the first is used"),
        "{said}"
    );
}

#[test]
fn a_folder_gives_tables_that_are_packed_or_have_other_names() {
    let folder = tempfile::tempdir().unwrap();
    let text = lines(PLAIN, &[("1", &circle), ("2", &stops)], 30, plain);
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, text.as_bytes()).unwrap();
    for (name, bytes) in [
        ("a.csv.gz", packed.finish().unwrap()),
        ("b.tsv", text.replace(',', "\t").into_bytes()),
        ("c.txt", text.replace(',', " ").into_bytes()),
        ("d.csv.zst", zstd::encode_all(text.as_bytes(), 1).unwrap()),
        ("readme.txt", b"Recorded by Ann, Bob and Eve.\n".to_vec()),
    ] {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let found = crate::find(&[folder.path().to_path_buf()]).unwrap();
    assert_eq!(found.entries.len(), 4, "{:?}", found.entries);
    assert!(found.passed_over.is_empty(), "{:?}", found.passed_over);
}

#[test]
fn what_cannot_be_known_is_told_with_its_tracks() {
    let east = |time: f64| [10.0 * time, 0.0, 0.0, 10.0];
    let text = lines(
        "time,id,x,y,speed,class",
        &[
            ("1", &east),
            ("2", &east),
            ("3", &east),
            ("4", &|_: f64| [5.0, 9.0, 0.0, 0.0]),
        ],
        30,
        |time, name, [x, y, _, speed]| {
            let speed = if name == "2" { speed * 3.6 } else { speed };
            let class = if name == "3" { "PKW" } else { "car" };
            format!("{:.1},{name},{x:.2},{y:.2},{speed:.2},{class}", time + 2.0)
        },
    );
    let found = read(text.as_bytes(), &TableOptions::default()).unwrap();
    let said = notes(&found);
    for word in [
        "time 0 is 2 in the table",
        "tracks that never move: `4`",
        "classes that are not known: `PKW` (tracks: 1)",
        "its speeds are 3.60 times its motion; are they in km/h?",
    ] {
        assert!(said.contains(word), "{word}: {said}");
    }
    assert_eq!(said.matches("times its motion").count(), 1, "{said}");
}

#[test]
fn headings_of_one_track_in_degrees_are_told() {
    let turned = |time: f64| {
        let [x, y, heading, speed] = circle(time);
        [x, y, heading.to_degrees(), speed]
    };
    let names = ["1", "2", "3", "4", "5", "6", "7", "8"];
    let mut tracks: Vec<(&str, &Drive)> = Vec::new();
    tracks.extend(names.map(|name| (name, &circle as &Drive)));
    tracks.push(("9", &turned));
    let text = lines(PLAIN, &tracks, 30, plain);
    let found = read(text.as_bytes(), &TableOptions::default()).unwrap();
    assert!(
        notes(&found).contains("off its motion; are they in degrees?"),
        "{}",
        notes(&found)
    );
}
