//! Kinds of XML, JSON, tables and other texts, by their beginnings.

use super::{FORMATS, Found, Kind};
use crate::commonroad::root_name_of;
use crate::recordings::{columns_of, missing_columns};

/// How someone's own tracks come in.
const OWN_TRACKS: &str = "tracks of your own open in the form of highD or of SUMO's floating car data: `nearmiss help scenarios` has the columns";

/// What XML is, if its root is known to be no scenario.
pub fn xml(file: &str, text: &str) -> Option<Kind> {
    let lower = text.to_lowercase();
    if lower.starts_with("<!doctype html") || lower.starts_with("<html") {
        let instead = "was a page saved instead of the file?";
        return Some(Kind::new(Found::Other, "a web page (HTML)", instead));
    }
    let root = root_name_of(text.as_bytes())?;
    let beside = |what: &str, instead: String| Some(Kind::new(Found::Beside, what, instead));
    let run = |options: &str| {
        format!(
            "run it with floating car data and open that: `sumo {options} --fcd-output fcd.xml`"
        )
    };
    match root.as_str() {
        "osm" => beside(
            "a map of Lanelet2 or OpenStreetMap",
            "it is read beside tracks of inD, rounD, uniD or exiD; alone it opens as CommonRoad, which CommonRoad's Scenario Designer converts it to".into(),
        ),
        "net" => beside("a road network of SUMO", run(&format!("-n {file} -r ROUTES"))),
        "routes" | "trips" => beside(
            "routes and vehicle types of SUMO",
            run(&format!("-n NET -r {file}")),
        ),
        "additional" | "add" => beside(
            "an additional file of SUMO",
            run(&format!("-n NET -r ROUTES -a {file}")),
        ),
        "configuration" | "sumoConfiguration" => {
            beside("a configuration of SUMO", run(&format!("-c {file}")))
        }
        "netstate" => Some(Kind::new(
            Found::Data,
            "a dump of SUMO's net without positions",
            run("-n NET -r ROUTES"),
        )),
        "nodes" | "edges" | "connections" | "types" | "tlLogics" => beside(
            "a part of a road network of SUMO",
            "netconvert makes a net of such parts; of it `sumo -n NET -r ROUTES --fcd-output fcd.xml` makes what opens here".into(),
        ),
        _ if text.contains("sumo.dlr.de/xsd/") => {
            let what = format!("an output of SUMO (<{root}>) without positions");
            Some(Kind::new(Found::Other, what, run("-n NET -r ROUTES")))
        }
        "kml" => Some(Kind::other("a KML file of places")),
        "gpx" => Some(Kind::other("a GPX file of a track in degrees")),
        "svg" => Some(Kind::other("a picture (SVG)")),
        "CityModel" => Some(Kind::other("a CityGML model")),
        _ => None,
    }
}

/// What a table in Parquet is that is none of Argoverse's scenarios.
pub fn parquet(columns: &[String]) -> Kind {
    let has = |name: &str| columns.iter().any(|column| column == name);
    let begins = |name: &str| columns.iter().any(|column| column.starts_with(name));
    if has("timestep_time") && has("vehicle_id") {
        let instead = "write it as XML or CSV: `sumo … --fcd-output fcd.xml`";
        return Kind::new(Found::Data, "floating car data of SUMO in Parquet", instead);
    }
    if begins("key.segment_context_name") || begins("[Lidar") || begins("[Camera") {
        let instead = "of Waymo the motion data set is read, its TFRecord files under `scenario`";
        return Kind::new(Found::Data, "data of Waymo's perception data set", instead);
    }
    let what = format!("a Parquet table with {}", in_words(columns));
    Kind::new(
        Found::Data,
        what,
        format!("of Argoverse 2 the motion forecasting scenarios are read; {FORMATS}"),
    )
}

/// What a text other than XML is.
pub fn other(name: &str, text: &str) -> Option<Kind> {
    let name = name.to_lowercase();
    let is = |ending: &str| name.ends_with(ending);
    if text.starts_with('{') || text.starts_with('[') {
        return Some(json(text));
    }
    if is(".yaml") || is(".yml") {
        let what = if text.contains("OpenSCENARIO:") {
            "a scenario of TIER IV in YAML"
        } else {
            "a YAML file"
        };
        return Some(Kind::other(what));
    }
    if is(".osc") && text.contains(':') {
        let what = "OpenSCENARIO DSL (2.x)";
        let instead = "OpenSCENARIO XML (.xosc) is read";
        return Some(Kind::new(Found::Data, what, instead));
    }
    table(text).or_else(|| {
        // A markup further on is searched for by the reader of CommonRoad.
        let plain = !text.contains('<');
        plain.then(|| Kind::other("text"))
    })
}

fn json(text: &str) -> Kind {
    let has = |key: &str| text.contains(&format!("\"{key}\""));
    if has("lane_segments") || has("pedestrian_crossings") && has("drivable_areas") {
        let instead = "open the scenario_ID.parquet that it belongs to";
        return Kind::new(Found::Beside, "a map of Argoverse 2", instead);
    }
    if [
        "sample_token",
        "instance_token",
        "ego_pose_token",
        "log_token",
    ]
    .iter()
    .any(|key| has(key))
    {
        return Kind::data("a table of nuScenes");
    }
    if has("openlabel") {
        return Kind::data("annotations in ASAM OpenLABEL");
    }
    if has("FeatureCollection") {
        return Kind::other("places in GeoJSON");
    }
    if has("nbformat") {
        return Kind::other("a notebook of Jupyter");
    }
    Kind::other("JSON")
}

/// What a table is; nothing for a text that has no columns, and for trajectories of egos.
fn table(text: &str) -> Option<Kind> {
    let (_, columns) = columns_of(text.as_bytes());
    let lower: Vec<String> = columns.iter().map(|name| name.to_lowercase()).collect();
    let has = |name: &str| lower.iter().any(|column| column == name);
    let all = |names: &[&str]| names.iter().all(|name| has(name));
    let any = |names: &[&str]| names.iter().any(|name| has(name));
    if lower.len() < 2 || lower.iter().all(String::is_empty) {
        return None;
    }
    let plain =
        |name: &String| -> String { name.chars().filter(|c| c.is_alphanumeric()).collect() };
    let plain: Vec<String> = lower.iter().map(plain).collect();
    let has_plain = |name: &str| plain.iter().any(|column| column == name);
    if has_plain("trajectorynumber") || has_plain("xposition") && has_plain("timestep") {
        return None;
    }
    if text.starts_with("Version:") && text.contains("OpenSCENARIO") {
        let instead = "open the .xosc that it lies beside";
        return Some(Kind::new(Found::Beside, "a log of esmini", instead));
    }
    let beside = |of: &str, what: &str| {
        let instead = format!("open the XX_tracks.csv that it belongs to{of}");
        Some(Kind::new(Found::Beside, what, instead))
    };
    if all(&["framerate", "locationid"]) {
        return beside("", "a recordingMeta table of levelXdata");
    }
    if all(&["initialframe", "finalframe", "class"]) {
        return beside("", "a tracksMeta table of levelXdata");
    }
    let data = |what: &str| Some(Kind::new(Found::Data, what, OWN_TRACKS));
    if all(&["track_id", "frame_id", "timestamp_ms"]) {
        return data("tracks of the INTERACTION data set");
    }
    if all(&["vehicle_id", "frame_id"]) && any(&["local_x", "global_x"]) {
        return data("tracks of NGSIM");
    }
    if all(&["timestamp", "track_id", "object_type", "city_name"]) {
        return data("a forecasting sequence of Argoverse 1");
    }
    if let Some((set, missing)) = missing_columns(&columns) {
        let what = format!("a table like the tracks of {set}");
        let instead = format!(
            "it opens with the columns that it lacks: {}",
            missing.join(", ")
        );
        return Some(Kind::new(Found::Data, what, instead));
    }
    if all(&["timestep_time"]) && any(&["vehicle_id", "person_id"]) {
        let instead = "it opens with the columns vehicle_x, vehicle_y, vehicle_angle and vehicle_speed (`--fcd-output.attributes`)";
        return Some(Kind::new(
            Found::Data,
            "floating car data of SUMO without positions",
            instead,
        ));
    }
    let begins = |start: &str| lower.iter().any(|column| column.starts_with(start));
    if begins("tripinfo_") || begins("interval_") || begins("timestep_") {
        return Some(Kind::other(
            "an output of SUMO as a table, without positions",
        ));
    }
    let who = any(&[
        "id",
        "track_id",
        "trackid",
        "vehicle_id",
        "object_id",
        "agent_id",
        "obstacle_id",
    ]);
    let place = all(&["x", "y"])
        || all(&["lon", "lat"])
        || all(&["longitude", "latitude"])
        || all(&["position_x", "position_y"])
        || all(&["center_x", "center_y"]);
    let when = any(&[
        "t",
        "time",
        "timestamp",
        "frame",
        "frame_id",
        "step",
        "timestep",
        "time_step",
    ]);
    let what = in_words(&columns);
    match () {
        () if who && place && when => data(&format!("a table of tracks with {what}")),
        () if lower.len() > 2 && !text.contains('<') => {
            Some(Kind::other(format!("a table with {what}")))
        }
        () => None,
    }
}

/// So many columns are named.
const NAMED: usize = 6;

fn in_words(columns: &[String]) -> String {
    let names = columns.iter().take(NAMED);
    let names: Vec<String> = names
        .map(|name| format!("`{}`", name.chars().take(40).collect::<String>()))
        .collect();
    let more = match columns.len() - names.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    format!("the columns {}{more}", names.join(", "))
}
