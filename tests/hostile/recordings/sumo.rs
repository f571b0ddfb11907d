//! SUMO: floating car data with its net.

use std::f64::consts::FRAC_PI_2;
use std::fmt::Write;
use std::path::PathBuf;

use nearmiss::geometry::Point;
use nearmiss::scenario::{ObstacleType, SignalColor};

use super::*;

/// A car to the north, a truck to the east, and the ego of the default type to the west.
pub fn fcd(steps: usize) -> String {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<!-- <sumoConfiguration><input><net-file value=\"cross.net.xml\"/><route-files value=\"cross.rou.xml\"/></input></sumoConfiguration> -->\n<fcd-export>\n",
    );
    for step in 0..steps {
        let t = step as f64 * 0.1;
        let _ = writeln!(xml, "  <timestep time=\"{:.2}\">", 5.0 + t);
        let mut vehicle = |id: &str, x: f64, y: f64, angle: f64, kind: &str, speed: f64| {
            let _ = writeln!(
                xml,
                "    <vehicle id=\"{id}\" x=\"{x:.2}\" y=\"{y:.2}\" angle=\"{angle:.2}\" type=\"{kind}\" speed=\"{speed:.2}\" pos=\"5.10\" lane=\"in_0\" slope=\"0.00\"/>"
            );
        };
        vehicle("4", 1.6, -50.0 + 10.0 * t, 0.0, "car", 10.0);
        vehicle("lorry", -40.0 + 8.0 * t, -1.6, 90.0, "lorry", 8.0);
        if step > 1 {
            vehicle("ego", 60.0 - 9.0 * t, 1.6, 270.0, "DEFAULT_VEHTYPE", 9.0);
        }
        xml += "  </timestep>\n";
    }
    xml + "</fcd-export>\n"
}

pub const NET: &str = r#"<net>
  <edge id=":j_0" function="internal"><lane id=":j_0_0" index="0" speed="10" length="10" shape="5,-1.6 15,-1.6"/></edge>
  <edge id=":j_w" function="walkingarea"><lane id=":j_w_0" index="0" shape="0,0 1,0 1,1"/></edge>
  <edge id="in" from="a" to="j"><lane id="in_0" index="0" speed="13.89" length="50" shape="-45,-4.8 5,-4.8"/><lane id="in_1" index="1" speed="13.89" width="4" length="50" shape="-45,-1.2 5,-1.2"/></edge>
  <edge id="out" from="j" to="b"><lane id="out_0" index="0" speed="13.89" length="50" shape="15,-1.6 65,-1.6"/></edge>
  <tlLogic id="j" type="static" programID="0" offset="2"><phase duration="4" state="Gr"/><phase duration="1" state="yr"/><phase duration="5" state="rG"/></tlLogic>
  <connection from="in" to="out" fromLane="1" toLane="0" via=":j_0_0" tl="j" linkIndex="0" dir="s" state="O"/>
  <connection from=":j_0" to="out" fromLane="0" toLane="0" dir="s" state="M"/>
</net>"#;

pub const ROUTES: &str = r#"<routes>
  <vTypeDistribution id="all"><vType id="car" vClass="passenger" length="4.4" width="1.9"/></vTypeDistribution>
  <vType id="lorry" vClass="truck"/>
</routes>"#;

fn written(steps: usize) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fcd.xml");
    std::fs::write(&path, fcd(steps)).unwrap();
    std::fs::write(folder.path().join("cross.net.xml"), NET).unwrap();
    std::fs::write(folder.path().join("cross.rou.xml"), ROUTES).unwrap();
    (folder, path)
}

#[test]
fn fronts_become_middles_and_angles_are_from_north() {
    let (folder, path) = written(50);
    assert_eq!(found(folder.path()), ["fcd.xml"]);
    let (scenario, ego) = own_ego(&path);
    near(scenario.header.time_step_size, 0.1);
    assert_eq!(ego.track.steps(), 2..50);
    near(ego.footprint.shape().size().0, 5.0);
    near(ego.footprint.shape().size().1, 1.8);
    let at = ego.track.at(10).unwrap();
    assert!((at.pose.position - Point::new(60.0 - 9.0 + 2.5, 1.6)).norm() < 1e-9);
    near(at.pose.heading.cos(), -1.0);
    let car = scenario.obstacle(4).unwrap();
    let at = car.track().at(0).unwrap();
    assert!((at.pose.position - Point::new(1.6, -52.2)).norm() < 1e-9);
    near(at.pose.heading, FRAC_PI_2);
    let lorry = scenario
        .obstacles
        .iter()
        .find(|o| o.kind == ObstacleType::Truck)
        .unwrap();
    near(lorry.footprint.as_ref().unwrap().shape().size().0, 7.1);
    near(lorry.track().at(0).unwrap().pose.position.x, -40.0 - 3.55);
    let said = messages(&scenario);
    assert!(
        said.contains("vehicles are numbered: `lorry` 5, `ego` 6"),
        "{said}"
    );
    survives_conversion(&scenario);
    any_track_can_be_the_ego(&path, ego.id, 4);
    let other = part(&path, "track=4");
    assert_eq!(own_ego(&other).1.id, 4);
}

#[test]
fn lanes_have_widths_links_and_lights() {
    let (_folder, path) = written(50);
    let scenario = open(&path);
    let lanes = &scenario.network.lanelets;
    assert_eq!(lanes.len(), 4);
    let [across, right, left, out] = [0, 1, 2, 3].map(|i| &lanes[i]);
    near(right.left.points[0].y, -3.2);
    near(left.left.points[0].y, 0.8);
    assert_eq!(right.adjacent_left.unwrap().id, left.id);
    assert_eq!(
        (left.successors[0], across.successors[0]),
        (across.id, out.id)
    );
    assert_eq!(out.predecessors, [across.id]);
    assert_eq!(right.signs, out.signs);
    let light = &scenario.network.lights[0];
    assert_eq!(across.lights, [light.id]);
    // The recording begins at 5 s, the program at 2 s: 3 s of its 4 s of green are over.
    let colors = [0, 9, 10, 20, 69, 70].map(|step| light.color_at(step));
    use SignalColor::{Green, Red, Yellow};
    assert_eq!(colors, [Green, Green, Yellow, Red, Red, Green]);
}

#[test]
fn long_data_is_listed_as_windows() {
    let (folder, path) = written(400);
    let windows = found(folder.path());
    assert!(
        windows.iter().all(|w| w.starts_with("fcd.xml#track=")),
        "{windows:?}"
    );
    let scenario = open(&folder.path().join(&windows[0]));
    assert_eq!(scenario.planning_problems.len(), 1);
    assert!(refused(&path).contains("longer than 30 s"));
}

#[test]
fn errors_name_line_and_element() {
    let (folder, path) = written(3);
    std::fs::write(&path, fcd(3).replace("y=\"-1.60\"", "y=\"north\"")).unwrap();
    let error = refused(&path);
    assert!(
        error.contains("fcd.xml:6:") && error.contains("y=\"north\" is not a number"),
        "{error}"
    );
    std::fs::write(&path, fcd(3)).unwrap();
    std::fs::write(
        folder.path().join("cross.net.xml"),
        NET.replace("5,-1.6 15", "5,a 15"),
    )
    .unwrap();
    let error = refused(&path);
    assert!(
        error.contains("cross.net.xml:2:") && error.contains("`5,a` in a shape"),
        "{error}"
    );
    std::fs::remove_file(folder.path().join("cross.net.xml")).unwrap();
    assert!(messages(&open(&path)).contains("no net"));
}
