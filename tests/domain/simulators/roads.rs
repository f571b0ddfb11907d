//! Roads of others: moved, reversed, cut by side, torn, too long; their signals and junctions; what a reader does not know.

use super::made::{alone, on_road, place, road, said, says, unused};
use super::*;

/// The first points of the bounds of lanelets.
fn begins(scenario: &Scenario) -> Vec<(f64, f64)> {
    let first = |l: &nearmiss::scenario::Lanelet| l.left.points[0];
    let round = |v: f64| (v * 1e3).round() / 1e3 + 0.0;
    let all = scenario.network.lanelets.iter().map(first);
    all.map(|p| (round(p.x), round(p.y))).collect()
}

#[test]
fn the_offset_of_a_header_moves_roads_and_world_positions() {
    let turned = std::f64::consts::FRAC_PI_2;
    let offset = format!(r#"<offset x="100" y="20" z="0" hdg="{turned}"/>"#);
    let plain = alone("a.xodr", &road("", "", "")).unwrap();
    assert_eq!(begins(&plain), [(100.0, 0.0), (0.0, 0.0)]);
    let moved = alone("a.xodr", &road(&offset, "", "")).unwrap();
    // First by (100, 20), then a quarter turn to the left about the origin.
    assert_eq!(begins(&moved), [(-20.0, 200.0), (-20.0, 100.0)]);
    assert!(says(
        &moved,
        "the offset of the header moves the roads by 100 m, 20 m"
    ));
    // A car in the world and one on a lane are where the road is.
    let world = place("Ego", r#"<WorldPosition x="50" y="-1.75" h="0"/>"#);
    let lane = place(
        "B",
        r#"<LanePosition roadId="1" laneId="-1" s="70" offset="0"/>"#,
    );
    let read = on_road(&road(&offset, "", ""), &format!("{world}{lane}"), "");
    let ego = read.recorded_ego.as_ref().unwrap();
    let pose = |o: &nearmiss::scenario::Obstacle| o.motion_at(0).unwrap().pose;
    let (a, b) = (pose(&ego.obstacle), pose(&read.obstacles[0]));
    assert!(
        (a.position - Point::new(-18.25, 150.0)).norm() < 1e-6,
        "{a:?}"
    );
    assert!(
        (b.position - Point::new(-18.25, 170.0)).norm() < 1e-6,
        "{b:?}"
    );
    assert!((a.heading - turned).abs() < 1e-9 && (b.heading - turned).abs() < 1e-9);
}

/// A road with these geometries, lane sections and length.
fn drawn(length: f64, geometry: &str, sections: &str) -> String {
    format!(
        r#"<OpenDRIVE><header revMajor="1" revMinor="8"/><road id="7" length="{length}" junction="-1">
<planView>{geometry}</planView><lanes>{sections}</lanes></road></OpenDRIVE>"#
    )
}

const RIGHT: &str =
    r#"<right><lane id="-1" type="driving"><width sOffset="0" a="3.5"/></lane></right>"#;

fn line(s: f64, x: f64, length: f64) -> String {
    format!(r#"<geometry s="{s}" x="{x}" y="0" hdg="0" length="{length}"><line/></geometry>"#)
}

fn section(s: f64, sides: &str) -> String {
    format!(
        r#"<laneSection s="{s}"><center><lane id="0" type="none"/></center>{sides}</laneSection>"#
    )
}

#[test]
fn lanes_run_as_their_direction_says() {
    let reversed = alone("a.xodr", &road("", r#"direction="reversed""#, "")).unwrap();
    // Both lanes run against the road; the left bound of a lane is on its left.
    assert_eq!(begins(&reversed), [(100.0, 0.0), (100.0, -3.5)]);
    let right = &reversed.network.lanelets[1];
    assert!(right.adjacent_right.is_some_and(|a| a.same_direction));
    let both = alone("a.xodr", &road("", r#"direction="both""#, "")).unwrap();
    assert_eq!(begins(&both), [(100.0, 0.0), (0.0, 0.0)]);
    assert!(!both.network.lanelets[1].users_bidirectional.is_empty());
    assert!(both.network.lanelets[1].users_one_way.is_empty());
    assert!(says(&both, "lanes that are driven both ways: 1"));
}

#[test]
fn sections_of_one_side_keep_the_other() {
    let left = r#"<left><lane id="1" type="driving"><width sOffset="0" a="2"/></lane></left>"#;
    let wide = r#"<left><lane id="1" type="driving"><link><predecessor id="1"/></link><width sOffset="0" a="2" b="0.1"/></lane></left>"#;
    let single = |s: f64, side: &str| {
        section(s, side).replace("<laneSection", r#"<laneSection singleSide="true""#)
    };
    let sections = [single(0.0, RIGHT), single(0.0, left), single(40.0, wide)].concat();
    let read = alone("a.xodr", &drawn(100.0, &line(0.0, 0.0, 100.0), &sections)).unwrap();
    // The right lane is cut where a section of the left side begins, and follows itself.
    assert_eq!(
        begins(&read),
        [(40.0, 0.0), (0.0, 0.0), (100.0, 0.0), (40.0, 0.0)]
    );
    let lanelets = &read.network.lanelets;
    assert_eq!(lanelets[1].successors, [lanelets[3].id]);
    assert_eq!(lanelets[2].successors, [lanelets[0].id]);
    let end = lanelets[2].right.points[0];
    assert!((end - Point::new(100.0, 8.0)).norm() < 1e-6, "{end}");
}

#[test]
fn what_does_not_fit_together_in_roads_is_said() {
    let right = section(0.0, RIGHT);
    let gap = drawn(
        100.0,
        &(line(0.0, 0.0, 50.0) + &line(50.0, 60.0, 50.0)),
        &right,
    );
    let read = alone("a.xodr", &gap).unwrap();
    assert!(
        says(
            &read,
            "road 7: its reference line jumps by 10.0 m at s=50 m"
        ),
        "{:?}",
        said(&read)
    );
    // A road that is longer than its line goes on; a straight line needs no points on its way.
    let read = alone("a.xodr", &drawn(3000.0, &line(0.0, 0.0, 50.0), &right)).unwrap();
    let last = read.network.lanelets[0].left.points.last().copied();
    assert_eq!(last, Some(Point::new(3000.0, 0.0)));
    assert!(says(
        &read,
        "it is 3000 m long, its reference line 50 m; the last piece goes on"
    ));
    assert!(!says(&read, "is a coordinate wrong"), "{:?}", said(&read));
    let linked = road(
        "",
        "",
        r#"<link><successor elementType="road" elementId="9" contactPoint="start"/></link>"#,
    );
    assert!(says(
        &alone("a.xodr", &linked).unwrap(),
        "is linked to road 9, which is not in the file"
    ));
    let sound = alone("a.xodr", &road("", "", "")).unwrap();
    let notes = said(&sound);
    assert!(notes.iter().all(|s| s.starts_with("note")), "{notes:?}");
}

#[test]
fn spirals_may_leave_out_curvatures_and_are_bounded() {
    let spiral = |with: &str, length: f64| {
        let geometry = format!(
            r#"<geometry s="0" x="0" y="0" hdg="0" length="{length}"><spiral {with}/></geometry>"#
        );
        alone("a.xodr", &drawn(length, &geometry, &section(0.0, RIGHT)))
    };
    let half = spiral(r#"curvEnd="0.02""#, 50.0).unwrap();
    let whole = spiral(r#"curvStart="0" curvEnd="0.02""#, 50.0).unwrap();
    assert_eq!(
        half.network.lanelets[0].left,
        whole.network.lanelets[0].left
    );
    let error = spiral(r#"curvStart="-1000" curvEnd="1000""#, 1e6).unwrap_err();
    assert!(error.contains("may turn by 1000000000 rad"), "{error}");
}

#[test]
fn signals_are_for_those_that_they_face() {
    let signal = |more: &str| {
        let signals = format!(
            r#"<signals><signal id="5" s="50" t="-4" type="205" subtype="-1" dynamic="no" {more}</signals>"#
        );
        alone("a.xodr", &road("", "", &signals)).unwrap()
    };
    let with_sign = |s: &Scenario| -> Vec<bool> {
        s.network
            .lanelets
            .iter()
            .map(|l| !l.signs.is_empty())
            .collect()
    };
    assert_eq!(with_sign(&signal(r#"orientation="+"/>"#)), [false, true]);
    assert_eq!(with_sign(&signal(r#"orientation="-"/>"#)), [true, false]);
    assert_eq!(with_sign(&signal(r#"orientation="none"/>"#)), [true, true]);
    let named = r#"orientation="-"><validity fromLane="-1" toLane="-1"/></signal>"#;
    assert_eq!(with_sign(&signal(named)), [false, true]);
}

#[test]
fn direct_junctions_join_lanes() {
    let text = r#"<OpenDRIVE><header revMajor="1" revMinor="8"/>
<road id="1" length="50" junction="-1"><link><successor elementType="junction" elementId="4"/></link>
<planView><geometry s="0" x="0" y="0" hdg="0" length="50"><line/></geometry></planView><lanes>SECTION</lanes></road>
<road id="2" length="50" junction="-1"><link><predecessor elementType="junction" elementId="4"/></link>
<planView><geometry s="0" x="50" y="0" hdg="0" length="50"><line/></geometry></planView><lanes>SECTION</lanes></road>
<junction id="4" type="direct"><connection id="0" incomingRoad="1" linkedRoad="2" contactPoint="start"><laneLink from="-1" to="-1"/></connection></junction>
</OpenDRIVE>"#;
    let read = alone("a.xodr", &text.replace("SECTION", &section(0.0, RIGHT))).unwrap();
    let lanelets = &read.network.lanelets;
    assert_eq!(lanelets[0].successors, [lanelets[1].id]);
}

#[test]
fn what_is_not_used_of_roads_is_counted() {
    let more = r#"<objects><object id="1"/><object id="2"/></objects><planted/>"#;
    let text = road(r#"<planted deep="1"/>"#, r#"planted="1""#, more)
        .replace(r#"a="3.5"/>"#, r#"a="3.5" planted="x"/>"#);
    let read = alone("a.xodr", &text).unwrap();
    let unused = unused(&read);
    for (kind, count) in [
        ("header/planted", 1),
        ("lane@planted", 1),
        ("width@planted", 2),
        ("road/planted", 1),
        ("objects/object", 2),
    ] {
        assert!(
            unused.contains(&(kind.to_string(), count)),
            "{kind}: {unused:?}"
        );
    }
    assert_eq!(unused.len(), 5, "{unused:?}");
}
