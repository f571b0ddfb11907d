//! A small scenario with one of everything, so that a mutation hits something that matters.

use std::fmt::Write;

/// Steps of 0.1 s in the trajectories.
const STEPS: usize = 12;

/// CommonRoad 2020a: two lanes and a third that follows them, a sign, a light, an intersection, obstacles of each
/// kind and role, and a planning problem.
pub fn scenario() -> String {
    let mut xml = String::from(
        r#"<?xml version="1.0" encoding="UTF-8"?>
<commonRoad commonRoadVersion="2020a" benchmarkID="ZAM_Small-1_1_T-1" timeStepSize="0.1" author="a" affiliation="b" source="c" date="2026-01-01">
  <location><geoNameId>-999</geoNameId><gpsLatitude>48.1</gpsLatitude><gpsLongitude>11.6</gpsLongitude></location>
  <scenarioTags><urban/></scenarioTags>
"#,
    );
    lanelet(
        &mut xml,
        [1, 0],
        0.0,
        r#"<successor ref="3"/><adjacentLeft ref="2" drivingDir="same"/>"#,
    );
    lanelet(
        &mut xml,
        [2, 0],
        3.5,
        r#"<adjacentRight ref="1" drivingDir="same"/>"#,
    );
    lanelet(
        &mut xml,
        [3, 60],
        0.0,
        "<predecessor ref=\"1\"/><laneletType>urban</laneletType><userOneWay>vehicle</userOneWay>",
    );
    xml += r#"  <trafficSign id="10"><trafficSignElement><trafficSignID>274</trafficSignID><additionalValue>13.9</additionalValue></trafficSignElement><position><point><x>5</x><y>-3</y></point></position><virtual>false</virtual></trafficSign>
  <trafficLight id="11"><cycle><cycleElement><duration>30</duration><color>red</color></cycleElement><cycleElement><duration>40</duration><color>green</color></cycleElement><timeOffset>3</timeOffset></cycle><position><point><x>59</x><y>3</y></point></position><active>true</active></trafficLight>
  <intersection id="12"><incoming id="13"><incomingLanelet ref="1"/><successorsStraight ref="3"/></incoming></intersection>
"#;
    let car = "<rectangle><length>4.5</length><width>1.8</width></rectangle>";
    dynamic(&mut xml, 20, "car", car, [20.0, 0.0, 9.0]);
    dynamic(
        &mut xml,
        21,
        "truck",
        "<rectangle><length>9</length><width>2.5</width></rectangle>",
        [30.0, 3.5, 8.0],
    );
    dynamic(
        &mut xml,
        22,
        "pedestrian",
        "<circle><radius>0.3</radius></circle>",
        [40.0, 5.5, 1.0],
    );
    xml += r#"  <staticObstacle id="23"><type>parkedVehicle</type><shape><polygon><point><x>-2</x><y>-1</y></point><point><x>2</x><y>-1</y></point><point><x>2</x><y>1</y></point><point><x>-2</x><y>1</y></point></polygon></shape><initialState><position><point><x>50</x><y>-2.8</y></point></position><orientation><exact>0.1</exact></orientation><time><exact>0</exact></time></initialState></staticObstacle>
  <dynamicObstacle id="24"><type>bicycle</type><shape><rectangle><length>1.8</length><width>0.6</width></rectangle></shape><initialState><position><point><x>10</x><y>5</y></point></position><orientation><exact>0</exact></orientation><time><exact>0</exact></time><velocity><exact>4</exact></velocity></initialState><occupancySet>
"#;
    for step in 1..=4 {
        let x = 10.0 + 0.4 * step as f64;
        let _ = writeln!(
            xml,
            "    <occupancy><shape><rectangle><length>2.2</length><width>0.9</width><orientation>0</orientation><center><x>{x:.2}</x><y>5</y></center></rectangle></shape><time><intervalStart>{step}</intervalStart><intervalEnd>{}</intervalEnd></time></occupancy>",
            step + 1
        );
    }
    xml += "  </occupancySet></dynamicObstacle>\n";
    xml += r#"  <planningProblem id="30"><initialState><position><point><x>4</x><y>0</y></point></position><velocity><exact>10</exact></velocity><orientation><exact>0</exact></orientation><yawRate><exact>0</exact></yawRate><slipAngle><exact>0</exact></slipAngle><time><exact>0</exact></time></initialState>
  <goalState><position><lanelet ref="3"/></position><time><intervalStart>5</intervalStart><intervalEnd>80</intervalEnd></time><velocity><intervalStart>5</intervalStart><intervalEnd>15</intervalEnd></velocity></goalState></planningProblem>
</commonRoad>
"#;
    xml
}

/// Its id, and the x at which it begins; it is 60 m long.
fn lanelet(xml: &mut String, [id, begin]: [i64; 2], y: f64, links: &str) {
    let mut bound = |name: &str, offset: f64| {
        let _ = write!(xml, "    <{name}>");
        for i in 0..=4 {
            let (x, y) = (begin + 15 * i, y + offset);
            let _ = write!(xml, "<point><x>{x}</x><y>{y:.2}</y></point>");
        }
        let _ = writeln!(xml, "<lineMarking>dashed</lineMarking></{name}>");
    };
    bound("leftBound", 1.75);
    bound("rightBound", -1.75);
    let at = xml
        .rfind("    <leftBound>")
        .expect("the bound was just written");
    xml.insert_str(at, &format!("  <lanelet id=\"{id}\">\n"));
    let references = match id {
        1 => r#"<trafficSignRef ref="10"/><trafficLightRef ref="11"/>"#,
        _ => "",
    };
    let _ = writeln!(xml, "    {links}{references}\n  </lanelet>");
}

/// Drives straight on from x, y with a speed.
fn dynamic(xml: &mut String, id: i64, kind: &str, shape: &str, [x, y, speed]: [f64; 3]) {
    let state = |step: usize| {
        let x = x + speed * 0.1 * step as f64;
        format!(
            "<position><point><x>{x:.3}</x><y>{y}</y></point></position><orientation><exact>0</exact></orientation><time><exact>{step}</exact></time><velocity><exact>{speed}</exact></velocity><acceleration><exact>0</exact></acceleration>"
        )
    };
    let _ = writeln!(
        xml,
        "  <dynamicObstacle id=\"{id}\"><type>{kind}</type><shape>{shape}</shape><initialState>{}</initialState><trajectory>",
        state(0)
    );
    for step in 1..=STEPS {
        let _ = writeln!(xml, "    <state>{}</state>", state(step));
    }
    *xml += "  </trajectory></dynamicObstacle>\n";
}

/// The log of an ego that drives into the car ahead.
pub fn ego() -> String {
    let mut csv =
        String::from("ego_id,timestep,x_position,y_position,orientation,velocity,acceleration\n");
    for step in 0..=STEPS {
        let x = 4.0 + 1.2 * step as f64;
        let _ = writeln!(csv, "1,{step},{x:.3},0,0,12,0");
    }
    csv
}
