//! Files that people have beside or instead of scenarios, and that are not read: what they are, and what to do.

use std::path::Path;

use nearmiss_scene::scenario::Scenario;

use super::commonroad::{self, ReadError};
use super::dispatch::{Address, Applies, Format};
use super::recordings;
use crate::commonroad::root_name_of;
use crate::recordings::{
    Lacking, columns_of, is_esmini_log, json_columns, lacking_columns, missing_columns,
    without_header,
};

/// Files that are not read.
pub(super) struct Unread;

/// What a file is.
pub(super) struct Kind {
    /// As in `a road network of SUMO`.
    pub what: String,
    /// What its owner can do instead.
    pub instead: String,
    /// How a search of a folder takes it.
    pub found: FileKind,
}

/// What a search of a folder makes of a file that is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FileKind {
    /// It is data of driving that one could want to open.
    Data,
    /// It belongs to recordings, and is worth a word only where there are none.
    Beside,
    /// It is anything.
    Other,
}

/// What is said where there is nothing better to do.
const FORMATS: &str = "`nearmiss help scenarios` lists the formats that are read";

impl Kind {
    fn new(found: FileKind, what: impl Into<String>, instead: impl Into<String>) -> Self {
        Self {
            what: what.into(),
            instead: instead.into(),
            found,
        }
    }

    /// Data of driving in a format that is not read.
    fn data(what: impl Into<String>) -> Self {
        Self::new(FileKind::Data, what, FORMATS)
    }

    /// Anything else.
    fn other(what: impl Into<String>) -> Self {
        Self::new(FileKind::Other, what, FORMATS)
    }
}

/// What a file is that is not read, by its name and its first bytes; `None` where it may be a scenario.
pub(super) fn kind(path: &Path, head: &[u8]) -> Option<Kind> {
    // Which of them are to be unpacked or saved anew is said by their readers.
    if head.is_empty() || commonroad::is_protobuf_name(path) || commonroad::foreign(head).is_some()
    {
        return None;
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if let Some(columns) = recordings::parquet_columns(path, head) {
        return Some(parquet(&columns));
    }
    if recordings::is_in_log_of_py123d(path) {
        let instead = "open `box_detections_se3.arrow` beside it";
        return Some(Kind::new(
            FileKind::Beside,
            "a file of a py123d log",
            instead,
        ));
    }
    if let Some(kind) = binary_kind(&name, head) {
        return Some(kind);
    }
    let decoded = String::from_utf8_lossy(head);
    let text = decoded.trim_start_matches('\u{feff}').trim_start();
    if text.contains('\0') {
        return None;
    }
    if text.starts_with('<') {
        return xml(&name, text);
    }
    other(&name, text)
}

impl Format for Unread {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        kind(path, head).is_some()
    }

    fn is_found(&self, _: &Path, _: &[u8]) -> bool {
        false
    }

    /// What they are is said when they are read.
    fn applies(&self, _: &Path, _: &[u8]) -> Applies {
        Applies::All
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        let file = &address.file;
        let head = commonroad::beginning_of_file(file, super::dispatch::HEAD).unwrap_or_default();
        let message = match kind(file, &head) {
            Some(kind) => format!("{}, not a scenario; {}", kind.what, kind.instead),
            None => format!("not a scenario; {FORMATS}"),
        };
        Err(ReadError {
            file: file.display().to_string(),
            line: 0,
            column: 0,
            element: String::new(),
            message,
        })
    }
}

/// How files begin, and what they are: data of driving, and the rest.
const DATA: [(&[u8], &str); 7] = [
    (b"#ROSBAG", "a bag of ROS 1"),
    (
        b"\x89MCAP",
        "an MCAP file with no ground truth of ASAM OSI in it",
    ),
    (b"\x89HDF\r\n", "an HDF5 file"),
    (
        b"ARROW1",
        "an Arrow table (Feather), as those of Argoverse 2's sensor data",
    ),
    (b"MDF ", "a measurement file (ASAM MDF)"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"\x93NUMPY", "an array of NumPy"),
];
const REST: [(&[u8], &str); 9] = [
    (b"%PDF-", "a PDF document"),
    (b"\x89PNG", "a picture (PNG)"),
    (b"\xff\xd8\xff", "a picture (JPEG)"),
    (b"GIF8", "a picture (GIF)"),
    (b"RIFF", "a picture, sound or film (RIFF)"),
    (b"7z\xbc\xaf", "a 7z archive; unpack it first"),
    (b"Rar!", "a RAR archive; unpack it first"),
    (b"\x7fELF", "a program"),
    (b"MZ", "a program"),
];

/// Where a tar archive says that it is one.
const TAR: usize = 257;

/// What a binary file is, if it is known.
fn binary_kind(name: &str, head: &[u8]) -> Option<Kind> {
    let of = |all: &[(&[u8], &str)]| -> Option<String> {
        let found = all.iter().find(|(begin, _)| head.starts_with(begin));
        found.map(|(_, what)| (*what).to_string())
    };
    if let Some(what) = of(&DATA) {
        return Some(Kind::data(what));
    }
    if head
        .get(TAR..)
        .is_some_and(|rest| rest.starts_with(b"ustar"))
    {
        return Some(Kind::new(
            FileKind::Other,
            "a tar archive",
            "unpack it first",
        ));
    }
    // Programs begin with letters, as words do.
    if let Some(what) = of(&REST).filter(|what| what != "a program" || head.contains(&0)) {
        return Some(Kind::other(what));
    }
    if head.get(4..8) == Some(b"ftyp") {
        return Some(Kind::other("a film (MP4)"));
    }
    let begin = &head[..head.len().min(64)];
    if begin.windows(14).any(|w| w == b"CARLA_RECORDER") {
        let instead =
            "play it in CARLA and write where everyone is as a table (`nearmiss help tracks`)";
        return Some(Kind::new(
            FileKind::Data,
            "a recording of CARLA's recorder",
            instead,
        ));
    }
    if let [0x80, 2..=5, ..] = head {
        let instead =
            format!("it could run any code, so nearmiss does not open such files; {FORMATS}");
        return Some(Kind::new(
            FileKind::Data,
            "a pickled Python object",
            instead,
        ));
    }
    if name.to_lowercase().ends_with(".osi") {
        return Some(Kind::data("no trace of ASAM OSI, by its name one"));
    }
    None
}

/// What XML is, if its root is known to be no scenario.
fn xml(file: &str, text: &str) -> Option<Kind> {
    let lower = text.to_lowercase();
    if lower.starts_with("<!doctype html") || lower.starts_with("<html") {
        let instead = "was a page saved instead of the file?";
        return Some(Kind::new(FileKind::Other, "a web page (HTML)", instead));
    }
    let root = root_name_of(text.as_bytes())?;
    let beside = |what: &str, instead: String| Some(Kind::new(FileKind::Beside, what, instead));
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
            FileKind::Data,
            "a dump of SUMO's net without positions",
            run("-n NET -r ROUTES"),
        )),
        "nodes" | "edges" | "connections" | "types" | "tlLogics" => beside(
            "a part of a road network of SUMO",
            "netconvert makes a net of such parts; of it `sumo -n NET -r ROUTES --fcd-output fcd.xml` makes what opens here".into(),
        ),
        _ if text.contains("sumo.dlr.de/xsd/") => {
            let what = format!("an output of SUMO (<{root}>) without positions");
            Some(Kind::new(FileKind::Other, what, run("-n NET -r ROUTES")))
        }
        "kml" => Some(Kind::other("a KML file of places")),
        "gpx" => Some(Kind::other("a GPX file of a track in degrees")),
        "svg" => Some(Kind::other("a picture (SVG)")),
        "CityModel" => Some(Kind::other("a CityGML model")),
        _ => None,
    }
}

/// What a table in Parquet is that is none of Argoverse's scenarios.
fn parquet(columns: &[String]) -> Kind {
    let begins = |name: &str| columns.iter().any(|column| column.starts_with(name));
    if begins("key.segment_context_name") || begins("[Lidar") || begins("[Camera") {
        let instead = "of Waymo the motion data set is read, its TFRecord files under `scenario`";
        return Kind::new(
            FileKind::Data,
            "data of Waymo's perception data set",
            instead,
        );
    }
    let lacking = lacking_columns(columns);
    let what = format!("a Parquet table with {}", lacking.columns);
    Kind::new(FileKind::Data, what, lacking.instead)
}

/// What a text other than XML is.
fn other(name: &str, text: &str) -> Option<Kind> {
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
        return Some(Kind::new(FileKind::Data, what, instead));
    }
    if let Some(count) = without_header(text).filter(|_| !text.contains('<')) {
        let what = format!("a table of {count} columns without a header");
        let instead = "if it has tracks, say which column is what, from 1: --columns time=1,id=2,x=3,y=4 (`nearmiss help tracks`)";
        return Some(Kind::new(FileKind::Other, what, instead));
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
        return Kind::new(FileKind::Beside, "a map of Argoverse 2", instead);
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
        let instead = "open the scene.json that it lies beside";
        return Kind::new(FileKind::Beside, "a table of nuScenes", instead);
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
    let lacking = json_columns(text).map(|columns| lacking_columns(&columns));
    if let Some(lacking) = lacking.filter(|lacking| lacking.has_some) {
        return lacking.into();
    }
    let instead = format!(
        "tables of tracks are read with an object a row, in lines or in an array: `to_json(path, orient='records', lines=True)` of pandas; {FORMATS}"
    );
    Kind::new(FileKind::Other, "JSON", instead)
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
    if is_esmini_log(text.as_bytes()) {
        let instead = "open the .xosc that it lies beside";
        return Some(Kind::new(FileKind::Beside, "a log of esmini", instead));
    }
    let beside = |of: &str, what: &str| {
        let instead = format!("open the XX_tracks.csv that it belongs to{of}");
        Some(Kind::new(FileKind::Beside, what, instead))
    };
    if all(&["framerate", "locationid"]) {
        return beside("", "a recordingMeta table of levelXdata");
    }
    if all(&["initialframe", "finalframe", "class"]) {
        return beside("", "a tracksMeta table of levelXdata");
    }
    if let Some((set, missing)) = missing_columns(&columns) {
        let what = format!("a table like the tracks of {set}");
        let instead = format!(
            "it opens with the columns that it lacks: {}",
            missing.join(", ")
        );
        return Some(Kind::new(FileKind::Data, what, instead));
    }
    if all(&["timestep_time"]) && any(&["vehicle_id", "person_id"]) {
        let instead = "it opens with the columns vehicle_x, vehicle_y, vehicle_angle and vehicle_speed (`--fcd-output.attributes`)";
        return Some(Kind::new(
            FileKind::Data,
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
    let is_table = lower.len() > 2 && !text.contains('<');
    is_table.then(|| lacking_columns(&columns).into())
}

impl From<Lacking> for Kind {
    fn from(lacking: Lacking) -> Self {
        let found = if lacking.is_near {
            FileKind::Data
        } else {
            FileKind::Other
        };
        let what = format!("a table with {}", lacking.columns);
        Self::new(found, what, lacking.instead)
    }
}
