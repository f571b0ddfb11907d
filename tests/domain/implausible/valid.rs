//! A scenario in which everything is true, made here so that each number has its own place in the text.

use std::fmt::Write;

fn bound(name: &str, y: f64, from: f64, to: f64) -> String {
    let mut text = format!("<{name}>\n");
    for i in 0..=10 {
        let x = from + (to - from) * f64::from(i) / 10.0;
        writeln!(text, "<point><x>{x}</x><y>{y}</y></point>").unwrap();
    }
    text + &format!("</{name}>\n")
}

/// A lanelet along x whose right bound is at `right`; with `links`, its neighbours and the like.
fn lanelet(id: i64, right: f64, from: f64, to: f64, links: &str) -> String {
    let (left, right) = if to > from {
        (right + 4.0, right)
    } else {
        (right, right + 4.0)
    };
    format!(
        "<lanelet id=\"{id}\">\n{}{}{links}</lanelet>\n",
        bound("leftBound", left, from, to),
        bound("rightBound", right, from, to),
    )
}

fn state(name: &str, step: i64, x: f64, y: f64, heading: f64, velocity: f64) -> String {
    format!(
        "<{name}>\n<position><point><x>{x}</x><y>{y}</y></point></position>\n\
         <orientation><exact>{heading}</exact></orientation>\n<time><exact>{step}</exact></time>\n\
         <velocity><exact>{velocity}</exact></velocity>\n\
         <acceleration><exact>0</exact></acceleration>\n</{name}>\n"
    )
}

/// A drive along x at an even speed.
fn obstacle(id: i64, kind: &str, shape: &str, from: f64, y: f64, velocity: f64) -> String {
    let mut text =
        format!("<dynamicObstacle id=\"{id}\">\n<type>{kind}</type>\n<shape>{shape}</shape>\n");
    for step in 0..=20 {
        let x = from + velocity * 0.1 * step as f64;
        match step {
            0 => {
                text += &state("initialState", 0, x, y, 0.0, velocity);
                text += "<trajectory>\n";
            }
            step => text += &state("state", step, x, y, 0.0, velocity),
        }
    }
    text + "</trajectory>\n</dynamicObstacle>\n"
}

/// Three lanelets and one for the way back, a sign, a light, an intersection, obstacles and a planning problem.
pub fn scenario() -> String {
    let rectangle = |length: f64, width: f64| {
        format!("<rectangle><length>{length}</length><width>{width}</width></rectangle>")
    };
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <commonRoad commonRoadVersion=\"2020a\" benchmarkID=\"ZAM_Untrue-1_1_T-1\" timeStepSize=\"0.1\" \
         author=\"a\" affiliation=\"b\" source=\"c\" date=\"2026-01-02\">\n\
         <location>\n<geoNameId>-999</geoNameId>\n<gpsLatitude>48.1</gpsLatitude>\n\
         <gpsLongitude>11.6</gpsLongitude>\n\
         <geoTransformation>\n<geoReference>EPSG:32632</geoReference>\n<additionalTransformation>\n<xTranslation>0</xTranslation>\n\
         <yTranslation>0</yTranslation>\n<zRotation>0</zRotation>\n<scaling>1</scaling>\n\
         </additionalTransformation>\n</geoTransformation>\n</location>\n<scenarioTags><urban/></scenarioTags>\n",
    );
    text += &lanelet(
        1,
        0.0,
        0.0,
        100.0,
        "<successor ref=\"3\"/>\n<adjacentLeft ref=\"2\" drivingDir=\"same\"/>\n\
         <stopLine>\n<point><x>99</x><y>4</y></point>\n<point><x>99</x><y>0</y></point>\n\
         <lineMarking>solid</lineMarking>\n</stopLine>\n<laneletType>urban</laneletType>\n\
         <trafficSignRef ref=\"20\"/>\n<trafficLightRef ref=\"21\"/>\n",
    );
    text += &lanelet(
        2,
        4.0,
        0.0,
        100.0,
        "<adjacentLeft ref=\"4\" drivingDir=\"opposite\"/>\n\
         <adjacentRight ref=\"1\" drivingDir=\"same\"/>\n<laneletType>urban</laneletType>\n",
    );
    text += &lanelet(
        3,
        0.0,
        100.0,
        200.0,
        "<predecessor ref=\"1\"/>\n<laneletType>urban</laneletType>\n",
    );
    text += &lanelet(
        4,
        8.0,
        100.0,
        0.0,
        "<adjacentLeft ref=\"2\" drivingDir=\"opposite\"/>\n<laneletType>urban</laneletType>\n",
    );
    text += "<trafficSign id=\"20\">\n<trafficSignElement>\n<trafficSignID>274</trafficSignID>\n\
         <additionalValue>13.9</additionalValue>\n</trafficSignElement>\n\
         <position><point><x>5</x><y>-2</y></point></position>\n<virtual>false</virtual>\n</trafficSign>\n\
         <trafficLight id=\"21\">\n<cycle>\n\
         <cycleElement><duration>100</duration><color>red</color></cycleElement>\n\
         <cycleElement><duration>200</duration><color>green</color></cycleElement>\n\
         <timeOffset>7</timeOffset>\n</cycle>\n\
         <position><point><x>99</x><y>-3</y></point></position>\n<direction>all</direction>\n<active>true</active>\n\
         </trafficLight>\n\
         <intersection id=\"30\">\n<incoming id=\"31\">\n<incomingLanelet ref=\"1\"/>\n\
         <successorsStraight ref=\"3\"/>\n</incoming>\n</intersection>\n";
    text += &format!(
        "<staticObstacle id=\"40\">\n<type>parkedVehicle</type>\n<shape>{}</shape>\n\
         {}</staticObstacle>\n",
        rectangle(4.6, 1.9),
        state("initialState", 0, 60.0, -1.5, 0.0, 0.0)
    );
    text += &obstacle(41, "car", &rectangle(4.5, 1.8), 20.0, 2.0, 10.0);
    text += &obstacle(42, "truck", &rectangle(12.0, 2.5), 50.0, 6.0, 15.0);
    text += &obstacle(
        43,
        "pedestrian",
        "<circle><radius>0.35</radius></circle>",
        70.0,
        -3.0,
        1.0,
    );
    text += &format!(
        "<planningProblem id=\"60\">\n{}<goalState>\n<position><rectangle><length>20</length><width>4</width>\
         <orientation>0</orientation><center><x>40</x><y>6</y></center></rectangle></position>\n\
         <orientation><intervalStart>-0.5</intervalStart><intervalEnd>0.5</intervalEnd></orientation>\n\
         <time><intervalStart>10</intervalStart><intervalEnd>30</intervalEnd></time>\n\
         <velocity><intervalStart>0</intervalStart><intervalEnd>20</intervalEnd></velocity>\n\
         </goalState>\n</planningProblem>\n</commonRoad>\n",
        state("initialState", 0, 5.0, 6.0, 0.0, 11.0)
            .replace("<acceleration>", "<yawRate><exact>0</exact></yawRate>\n<slipAngle><exact>0</exact></slipAngle>\n<acceleration>"),
    );
    text
}
