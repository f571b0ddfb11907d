//! What the names of columns usually say.

use std::collections::BTreeMap;

use super::columns::{Columns, Role, Source, unit};

/// The names of positions along an axis of the map.
macro_rules! positions {
    ($axis:literal, $east:literal, $towards:literal, $place:literal) => {
        &[
            $axis,
            concat!($axis, "pos"),
            concat!("pos", $axis),
            concat!("position", $axis),
            concat!($axis, "position"),
            concat!($axis, "center"),
            concat!("center", $axis),
            concat!($axis, "centre"),
            concat!("centre", $axis),
            concat!("local", $axis),
            concat!("global", $axis),
            concat!("utm", $axis),
            concat!($axis, "utm"),
            $east,
            $towards,
            concat!("p", $axis),
            concat!("world", $axis),
            concat!("location", $axis),
            concat!("translation", $axis),
            concat!("c", $axis),
            $place,
        ]
    };
}

/// The names of velocities along an axis of the map.
macro_rules! velocities {
    ($axis:literal, $place:literal) => {
        &[
            concat!("v", $axis),
            concat!("velocity", $axis),
            concat!($axis, "velocity"),
            concat!("vel", $axis),
            concat!($axis, "vel"),
            concat!("speed", $axis),
            concat!($axis, "speed"),
            $place,
            concat!($axis, "dot"),
        ]
    };
}

/// Names of columns, without case and punctuation; of several that are there the first one is taken.
const SYNONYMS: [(Role, &[&str]); 24] = [
    (
        Role::Time,
        &[
            "time",
            "t",
            "timestamp",
            "timestamps",
            "ts",
            "sec",
            "seconds",
            "simtime",
            "globaltime",
            "timesec",
            "elapsed",
            "headerstampsecs",
            "headerstampsec",
            "headerstamp",
            "stampsecs",
            "stampsec",
            "stamp",
            "secs",
        ],
    ),
    (
        Role::Nanoseconds,
        &[
            "headerstampnsecs",
            "headerstampnsec",
            "headerstampnanosec",
            "stampnsecs",
            "stampnsec",
            "stampnanosec",
            "nsecs",
            "nsec",
            "nanosec",
        ],
    ),
    (
        Role::Frame,
        &[
            "frame",
            "frameid",
            "framenumber",
            "frameno",
            "step",
            "timestep",
            "stepid",
            "index",
            "frameindex",
            "framenum",
            "tick",
        ],
    ),
    (
        Role::Id,
        &[
            "trackid",
            "id",
            "track",
            "trackno",
            "tracknumber",
            "vehicleid",
            "vehid",
            "vehicle",
            "objectid",
            "object",
            "objid",
            "obstacleid",
            "agentid",
            "agent",
            "actorid",
            "actor",
            "carid",
            "participantid",
            "tracktoken",
            "uid",
            "name",
            "targetid",
            "trackuid",
        ],
    ),
    (Role::X, positions!("x", "easting", "east", "position0")),
    (Role::Y, positions!("y", "northing", "north", "position1")),
    (Role::Latitude, &["latitude", "lat"]),
    (Role::Longitude, &["longitude", "lon", "lng", "long"]),
    (
        Role::Heading,
        &[
            "heading",
            "yaw",
            "psi",
            "psirad",
            "theta",
            "orientation",
            "headingangle",
            "yawangle",
            "angle",
            "bearing",
            "course",
            "azimuth",
            "hdg",
            "rotationyaw",
        ],
    ),
    (
        Role::QuaternionX,
        &["orientationx", "rotationx", "quaternionx", "quatx", "qx"],
    ),
    (
        Role::QuaternionY,
        &["orientationy", "rotationy", "quaterniony", "quaty", "qy"],
    ),
    (
        Role::QuaternionZ,
        &["orientationz", "rotationz", "quaternionz", "quatz", "qz"],
    ),
    (
        Role::QuaternionW,
        &["orientationw", "rotationw", "quaternionw", "quatw", "qw"],
    ),
    (
        Role::Speed,
        &[
            "speed",
            "velocity",
            "v",
            "vel",
            "vvel",
            "currentspeed",
            "absspeed",
            "groundspeed",
            "velocityabs",
            "spd",
        ],
    ),
    (Role::VelocityX, velocities!("x", "velocity0")),
    (Role::VelocityY, velocities!("y", "velocity1")),
    (
        Role::Acceleration,
        &[
            "acceleration",
            "acc",
            "accel",
            "vacc",
            "a",
            "lonacceleration",
            "longitudinalacceleration",
        ],
    ),
    (
        Role::Length,
        &[
            "length",
            "len",
            "vlength",
            "vehiclelength",
            "objectlength",
            "sizex",
            "dimensionx",
            "l",
            "lengthx",
            "boundingboxlength",
            "sizelength",
            "dimensionlength",
            "dimensionslength",
            "dimensionsx",
            "dimx",
        ],
    ),
    (
        Role::Width,
        &[
            "width",
            "vwidth",
            "vehiclewidth",
            "objectwidth",
            "sizey",
            "dimensiony",
            "w",
            "widthy",
            "boundingboxwidth",
            "sizewidth",
            "dimensionwidth",
            "dimensionswidth",
            "dimensionsy",
            "dimy",
        ],
    ),
    (
        Role::Class,
        &[
            "class",
            "type",
            "agenttype",
            "objecttype",
            "vehicletype",
            "vclass",
            "category",
            "kind",
            "label",
            "classification",
            "objectclass",
            "actortype",
            "agentclass",
            "roaduser",
            "classid",
            "typeid",
            "cls",
        ],
    ),
    (
        Role::Ego,
        &[
            "isego",
            "ego",
            "issdc",
            "ishost",
            "host",
            "isav",
            "egoflag",
            "isegovehicle",
            "rolename",
        ],
    ),
    (
        Role::Scenario,
        &[
            "scenario",
            "scenarioid",
            "scene",
            "sceneid",
            "caseid",
            "case",
            "sceneindex",
            "segmentid",
            "scenename",
            "scenarioindex",
            "scenetoken",
        ],
    ),
    (Role::Mode, &["mode", "modeid", "modality", "hypothesis"]),
    (
        Role::Probability,
        &["probability", "prob", "confidence", "likelihood", "p"],
    ),
];

/// The role that a column's plain name says, and how usual that name is.
fn of_name(name: &str) -> Option<(Role, usize)> {
    let found = |name: &str| {
        SYNONYMS.iter().find_map(|(role, names)| {
            let rank = names.iter().position(|known| *known == name)?;
            Some((*role, rank))
        })
    };
    // Messages of ROS have poses of poses.
    let inner = || found(name.trim_start_matches("pose"));
    found(name).or_else(|| inner().map(|(role, rank)| (role, rank + POSE)))
}

/// So much less usual is a name behind `pose`.
const POSE: usize = 100;

/// The columns, such as `ego.x` and `car1.x`, that say where someone is along x behind a name of their own: road users side
/// by side. Those that say it alone are none.
pub fn side_by_side(names: &[String]) -> Vec<&String> {
    let is_x = |end: &str| matches!(said(end), Some((Role::X, ..)));
    let is_of_one = |name: &&String| {
        let mut ends = name.match_indices(['.', '_', ' ', '/']);
        said(name).is_none() && ends.any(|(at, _)| is_x(&name[at + 1..]))
    };
    names.iter().filter(is_of_one).collect()
}

/// A name without case and punctuation.
fn plain(name: &str) -> String {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

/// The role that a column's name says, how usual that name is, and its unit.
fn said(name: &str) -> Option<(Role, usize, Option<f64>)> {
    if let Some((role, rank)) = of_name(&plain(name)) {
        return Some((role, rank, None));
    }
    // A unit stands behind the name: `x [m]`, `x (m)`, `speed_kmh`, `time.ms`.
    let brackets = name.split_once(['[', '(']);
    let (base, written) = match brackets {
        Some((base, rest)) => (base, rest.trim_end_matches([']', ')', ' '])),
        None => name.rsplit_once(['_', '.', ' ', '-'])?,
    };
    let (role, rank) = of_name(&plain(base))?;
    let factor = unit(role.quantity(), written.trim())?;
    Some((role, rank, Some(factor)))
}

impl Columns {
    /// What the names of a table's columns say.
    pub fn by_name(names: &[String]) -> Self {
        let mut found: BTreeMap<Role, (usize, Source)> = BTreeMap::new();
        for name in names {
            let Some((role, rank, factor)) = said(name) else {
                continue;
            };
            let better = found.get(&role).is_none_or(|(known, _)| rank < *known);
            if better {
                let column = name.clone();
                found.insert(role, (rank, Source { column, factor }));
            }
        }
        let of = found.into_iter().map(|(role, (_, source))| (role, source));
        let mut columns = Self {
            of: of.collect(),
            ..Self::default()
        };
        columns.add_by_others(names);
        columns.settled()
    }

    /// What names say beside others only.
    fn add_by_others(&mut self, names: &[String]) {
        let named = |wanted: &str| names.iter().find(|name| plain(name) == wanted);
        let source = |column: &String| Source {
            column: column.clone(),
            factor: None,
        };
        // esmini's heading, pitch and roll; elsewhere it is a height.
        if let (Some(heading), Some(_), Some(_)) = (named("h"), named("p"), named("r")) {
            self.of
                .entry(Role::Heading)
                .or_insert_with(|| source(heading));
        }
        // Beside an id, a name tells the ego.
        if let Some(name) = named("name")
            && self.of.get(&Role::Id).is_some_and(|id| id.column != *name)
        {
            self.of.entry(Role::Ego).or_insert_with(|| source(name));
        }
        // The rest of a second belongs to a whole one of the same name.
        let stem = |role: Role| {
            let name = plain(&self.of.get(&role)?.column);
            let ends = ["nanosec", "nsecs", "nsec", "secs", "sec"];
            let stem = ends.iter().find_map(|end| name.strip_suffix(end))?;
            Some(stem.to_string())
        };
        if stem(Role::Time).is_none() || stem(Role::Time) != stem(Role::Nanoseconds) {
            self.of.remove(&Role::Nanoseconds);
        }
    }
}
