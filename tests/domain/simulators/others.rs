//! Scenarios of others: parameters and expressions, what only a player works out, files that are no scenarios.

use super::*;

/// A scenario of an ego and one that follows a trajectory, which begin where the storyboard says.
fn scenario(ego: &str) -> String {
    format!(
        r#"<?xml version="1.0"?>
<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>
  <ParameterDeclarations>
    <ParameterDeclaration name="Kmh" parameterType="double" value="36"/>
    <ParameterDeclaration name="Speed" parameterType="double" value="${{$Kmh / 3.6}}"/>
  </ParameterDeclarations>
  <CatalogLocations><VehicleCatalog><Directory path="catalogs"/></VehicleCatalog></CatalogLocations>
  <RoadNetwork/>
  <Entities>
    <ScenarioObject name="Ego"><CatalogReference catalogName="cars" entryName="long">
      <ParameterAssignments><ParameterAssignment parameterRef="Length" value="6"/></ParameterAssignments>
    </CatalogReference></ScenarioObject>
    <ScenarioObject name="other"><CatalogReference catalogName="cars" entryName="long"/></ScenarioObject>
  </Entities>
  <Storyboard><Init><Actions>
    <Private entityRef="Ego">{ego}</Private>
    <Private entityRef="other">
      <PrivateAction><TeleportAction><Position><WorldPosition x="0" y="0"/></Position></TeleportAction></PrivateAction>
      <PrivateAction><RoutingAction><FollowTrajectoryAction>
        <TimeReference><Timing domainAbsoluteRelative="absolute" scale="1" offset="0"/></TimeReference>
        <TrajectoryRef><Trajectory name="t" closed="false"><Shape><Polyline>
          <Vertex time="0"><Position><WorldPosition x="0" y="0" h="0"/></Position></Vertex>
          <Vertex time="2"><Position><WorldPosition x="${{$Speed * 2}}" y="0" h="0"/></Position></Vertex>
        </Polyline></Shape></Trajectory></TrajectoryRef>
        <TrajectoryFollowingMode followingMode="position"/>
      </FollowTrajectoryAction></RoutingAction></PrivateAction>
    </Private>
  </Actions></Init></Storyboard>
</OpenSCENARIO>
"#
    )
}

const CATALOG: &str = r#"<?xml version="1.0"?>
<OpenSCENARIO>
  <FileHeader revMajor="1" revMinor="2" date="2026-01-01T00:00:00" description="" author=""/>
  <Catalog name="cars"><Vehicle name="long" vehicleCategory="car">
    <ParameterDeclarations><ParameterDeclaration name="Length" parameterType="double" value="5"/></ParameterDeclarations>
    <BoundingBox><Center x="${$Length / 4}" y="0" z="0.7"/><Dimensions length="$Length" width="2" height="1.5"/></BoundingBox>
  </Vehicle></Catalog>
</OpenSCENARIO>
"#;

const STANDS: &str = r#"<PrivateAction><TeleportAction><Position><WorldPosition x="${10 + 2 * 5}" y="3" h="0"/></Position></TeleportAction></PrivateAction>"#;

const ON_A_ROUTE: &str = r#"<PrivateAction><TeleportAction><Position><RoutePosition><RouteRef/></RoutePosition></Position></TeleportAction></PrivateAction>"#;

/// The log of a player: the ego drives along y = 3, the other one along y = 0.
fn log() -> String {
    let mut text = String::from(
        "made up\nIndex [-], TimeStamp [s], #1 Entity_Name [-], #1 Entity_ID [-], #1 Current_Speed [m/s], #1 bb_x [m], #1 bb_y [m], #1 bb_length [m], #1 bb_width [m], #1 World_Position_X [m], #1 World_Position_Y [m], #1 World_Heading_Angle [rad], #1 collision_ids, \n",
    );
    for i in 0..=10 {
        let (t, x) = (0.1 * f64::from(i), f64::from(i));
        text += &format!(
            "{i}, {t:.6}, Ego, 0, 10.0, 1.0, 0.0, 6.0, 2.0, {x:.6}, 3.0, 0.0, , other, 1, 5.0, 1.0, 0.0, 5.0, 2.0, {:.6}, 0.0, 0.0, , \n",
            x / 2.0
        );
    }
    text
}

fn folder_with(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("catalogs")).unwrap();
    std::fs::write(folder.path().join("catalogs/cars.xosc"), CATALOG).unwrap();
    let path = folder.path().join("x.xosc");
    std::fs::write(&path, text).unwrap();
    (folder, path)
}

#[test]
fn expressions_and_catalog_parameters_have_their_values() {
    let (_folder, path) = folder_with(&scenario(STANDS));
    let read = Entry::of_file(&path).read().unwrap();
    let ego = read.recorded_ego.as_ref().unwrap();
    let first = ego.obstacle.motion_at(0).unwrap().pose.position;
    // The middle of a body of 6 m is a quarter of its length ahead of its position.
    assert!((first - Point::new(21.5, 3.0)).norm() < 1e-9, "{first}");
    assert_eq!(
        ego.obstacle.footprint.as_ref().unwrap().shape().size().0,
        6.0
    );
    let other = &read.obstacles[0];
    let last = other.motion_at(20).unwrap().pose.position;
    assert!(
        (last - Point::new(20.0 + 1.25, 0.0)).norm() < 1e-9,
        "{last}"
    );
    assert_eq!(other.footprint.as_ref().unwrap().shape().size().0, 5.0);
}

#[test]
fn what_only_a_player_works_out_is_read_from_its_log() {
    let (_folder, path) = folder_with(&scenario(ON_A_ROUTE));
    let error = Entry::of_file(&path).read().unwrap_err();
    assert_eq!(error.element, "entity `Ego`");
    let words = [
        "begins at a <RoutePosition>",
        "only a player",
        "--csv_logger",
    ];
    for word in words {
        assert!(error.message.contains(word), "{error}");
    }
    std::fs::write(path.with_extension("csv"), log()).unwrap();
    let read = Entry::of_file(&path).read().unwrap();
    let ego = read.recorded_ego.as_ref().unwrap();
    let tenth = ego.obstacle.motion_at(10).unwrap().pose.position;
    assert!((tenth - Point::new(11.0, 3.0)).norm() < 1e-9, "{tenth}");
    // A mistake in the storyboard does not matter then.
    let broken = scenario(ON_A_ROUTE).replace("x=\"0\"", "x=\"${nonsense}\"");
    std::fs::write(&path, &broken).unwrap();
    Entry::of_file(&path).read().unwrap();
    std::fs::remove_file(path.with_extension("csv")).unwrap();
    let error = Entry::of_file(&path).read().unwrap_err();
    assert!(error.message.contains("${nonsense}"), "{error}");
    assert!(error.line > 0);
}

#[test]
fn a_driver_under_test_is_read_from_a_log() {
    let speed = r#"<PrivateAction><LongitudinalAction><SpeedAction><SpeedActionTarget><AbsoluteTargetSpeed value="$Speed"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>"#;
    let (_folder, path) = folder_with(&scenario(&format!("{STANDS}{speed}")));
    let read = Entry::of_file(&path).read().unwrap();
    assert!(read.recorded_ego.is_none());
    let said: Vec<String> = read.diagnostics.iter().map(ToString::to_string).collect();
    assert!(
        said.iter().any(|s| s.contains("recording beside it")),
        "{said:?}"
    );
    std::fs::write(path.with_extension("csv"), log()).unwrap();
    let read = Entry::of_file(&path).read().unwrap();
    assert!(read.recorded_ego.is_some());
}

#[test]
fn others_that_drive_on_by_themselves_need_a_player() {
    let speed = r#"<PrivateAction><LongitudinalAction><SpeedAction><SpeedActionTarget><AbsoluteTargetSpeed value="9"/></SpeedActionTarget></SpeedAction></LongitudinalAction></PrivateAction>"#;
    let text = scenario(STANDS);
    let (begin, end) = (
        "<PrivateAction><RoutingAction>",
        "</RoutingAction></PrivateAction>",
    );
    let (head, rest) = text.split_once(begin).unwrap();
    let (_, tail) = rest.split_once(end).unwrap();
    let (_folder, path) = folder_with(&format!("{head}{speed}{tail}"));
    let error = Entry::of_file(&path).read().unwrap_err();
    assert_eq!(error.element, "entity `other`");
    assert!(
        error.message.contains("begins at 9 m/s and drives on"),
        "{error}"
    );
    std::fs::write(path.with_extension("csv"), log()).unwrap();
    Entry::of_file(&path).read().unwrap();
}

#[test]
fn files_that_are_no_scenarios_say_what_they_are() {
    let (folder, path) = folder_with(
        r#"<OpenSCENARIO><FileHeader/><ParameterValueDistribution><ScenarioFile filepath="y.xosc"/></ParameterValueDistribution></OpenSCENARIO>"#,
    );
    let error = Entry::of_file(&path).read().unwrap_err();
    assert!(error.message.contains("open `y.xosc`"), "{error}");
    let catalog = folder.path().join("catalogs/cars.xosc");
    let error = Entry::of_file(&catalog).read().unwrap_err();
    assert!(error.message.contains("a catalog"), "{error}");
}

#[test]
fn trajectories_that_are_not_worked_out_are_named() {
    for (from, to, words) in [
        ("Polyline>", "Nurbs>", "along a <Nurbs>"),
        ("<TimeReference>", "<Other>", "without times"),
    ] {
        let closing = from.replace('<', "</");
        let text = scenario(STANDS)
            .replace(from, to)
            .replace(&closing, &to.replace('<', "</"));
        let (_folder, path) = folder_with(&text);
        let error = Entry::of_file(&path).read().unwrap_err();
        assert!(error.message.contains(words), "{error}");
    }
}
