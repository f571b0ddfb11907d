//! Tables of data sets that are known by their columns.

use std::path::{Path, PathBuf};

use nearmiss_scene::scenario::ObstacleType;

use super::table::Trust;
use crate::recordings::assembly::kind_by_class;
use crate::tables::OWN_COLUMNS;

/// A data set's table of tracks.
#[derive(Debug)]
pub struct Known {
    /// The data set, as scenarios name their source.
    pub source: &'static str,
    /// Columns that tell it, in any case.
    telling: &'static [&'static str],
    /// Its columns as the user would name them; those that a table does not have are left out.
    pub columns: &'static str,
    /// What classes mean.
    pub kind: Option<fn(&str) -> ObstacleType>,
    /// Tags of its scenarios.
    pub tags: &'static [&'static str],
    /// The table of the other road users of the same recording, where there is one.
    pub beside: Option<fn(&Path) -> Option<PathBuf>>,
    /// The map of the recording, where it lies with it.
    pub map: Option<fn(&Path) -> Option<PathBuf>>,
}

/// The name of our own table.
const OWN: &str = "tracks of nearmiss";

/// All of them.
static KNOWN: [Known; 5] = [
    // What `convert --format tracks` writes.
    Known {
        source: OWN,
        telling: &OWN_COLUMNS,
        // Others call columns so, too: units are those of `convert` where nothing contradicts them.
        columns: "time=time,id=id,x=x,y=y,heading=heading,speed=speed,acceleration=acceleration,length=length,width=width,\
                  class=class,ego=ego",
        kind: Some(own),
        tags: &[],
        beside: None,
        map: None,
    },
    // FHWA-HRT-06-137, US Highway 101 Dataset, table of columns: feet, and the middle of the front.
    Known {
        source: "NGSIM",
        telling: &[
            "vehicle_id",
            "frame_id",
            "global_time",
            "local_x",
            "local_y",
            "v_length",
        ],
        columns: "scenario=Location,id=Vehicle_ID,time=Global_Time[ms],x=Local_X[ft front],y=Local_Y[ft],length=v_Length[ft],\
                  width=v_Width[ft],class=v_Class,speed=v_Vel[ft/s],acceleration=v_Acc[ft/s2]",
        kind: Some(ngsim),
        tags: &["highway"],
        beside: None,
        map: None,
    },
    // The same as text without a header, 18 columns.
    Known {
        source: "NGSIM",
        telling: &["18"],
        columns: "id=1,time=4[ms],x=5[ft front],y=6[ft],length=9[ft],width=10[ft],class=11,speed=12[ft/s],acceleration=13[ft/s2]",
        kind: Some(ngsim),
        tags: &["highway"],
        beside: None,
        map: None,
    },
    // Zhan et al., INTERACTION Dataset, arXiv 1910.03088.
    Known {
        source: "INTERACTION Dataset",
        telling: &[
            "track_id",
            "frame_id",
            "timestamp_ms",
            "agent_type",
            "x",
            "y",
            "vx",
            "vy",
        ],
        columns: "scenario=case_id,id=track_id,time=timestamp_ms[ms],x=x[m],y=y[m],velocity-x=vx[m/s],velocity-y=vy[m/s],\
                  heading=psi_rad[rad],length=length[m],width=width[m],class=agent_type",
        kind: None,
        tags: &["urban"],
        beside: Some(pedestrians),
        map: Some(interaction_map),
    },
    // Chang et al., Argoverse, arXiv 1911.02620.
    Known {
        source: "Argoverse 1 Motion Forecasting",
        telling: &[
            "timestamp",
            "track_id",
            "object_type",
            "x",
            "y",
            "city_name",
        ],
        columns: "time=TIMESTAMP[s],id=TRACK_ID,class=OBJECT_TYPE,x=X[m],y=Y[m]",
        kind: Some(argoverse),
        tags: &["urban"],
        beside: None,
        map: None,
    },
];

/// A log of esmini, whose entities lie side by side.
pub static ESMINI: Known = Known {
    source: "esmini",
    telling: &[],
    columns: "time=TimeStamp[s],id=Entity_Name,x=World_Position_X[m],y=World_Position_Y[m],heading=World_Heading_Angle[rad],\
              speed=Current_Speed[m/s],length=bb_length[m],width=bb_width[m]",
    kind: None,
    tags: &[],
    beside: None,
    map: None,
};

impl Known {
    /// What is known of its units and conventions.
    pub fn trust(&self) -> Trust {
        if self.source == OWN {
            Trust::Ours
        } else {
            Trust::All
        }
    }

    /// Whether a table is read with another one of its recording.
    pub fn is_beside(&self, path: &Path) -> bool {
        self.beside.is_some() && other(path, PEDESTRIANS, VEHICLES).is_some()
    }

    /// The data set whose tables have these columns.
    pub fn find(names: &[String]) -> Option<&'static Self> {
        let has = |wanted: &&str| names.iter().any(|name| name.eq_ignore_ascii_case(wanted));
        let is_numbered = names.first().is_some_and(|name| name == "1");
        KNOWN.iter().find(|known| match known.telling {
            // A table without a header is told by how many columns it has.
            [count] => is_numbered && names.last().is_some_and(|name| name == count),
            // Others call columns so, too, and add some.
            telling if known.source == OWN => names == telling,
            telling => telling.iter().all(has),
        })
    }
}

/// Words of CommonRoad.
fn own(class: &str) -> ObstacleType {
    ObstacleType::parse(class).unwrap_or_else(|| kind_by_class(class))
}

fn ngsim(class: &str) -> ObstacleType {
    match class.trim_end_matches(".0") {
        "1" => ObstacleType::Motorcycle,
        "3" => ObstacleType::Truck,
        _ => ObstacleType::Car,
    }
}

/// `OTHERS` are mostly vehicles.
fn argoverse(class: &str) -> ObstacleType {
    match kind_by_class(class) {
        ObstacleType::Unknown => ObstacleType::Car,
        kind => kind,
    }
}

/// The tables of vehicles, and of the pedestrians and bicycles of the same recording beside it.
const VEHICLES: &str = "vehicle_tracks_";
const PEDESTRIANS: &str = "pedestrian_tracks_";

fn pedestrians(vehicles: &Path) -> Option<PathBuf> {
    other(vehicles, VEHICLES, PEDESTRIANS)
}

/// The file beside one whose name begins otherwise.
fn other(path: &Path, begins: &str, instead: &str) -> Option<PathBuf> {
    let number = path.file_name()?.to_str()?.strip_prefix(begins)?;
    let other = path.with_file_name(format!("{instead}{number}"));
    other.is_file().then_some(other)
}

/// `recorded_trackfiles/PLACE/vehicle_tracks_000.csv` and `train/PLACE_train.csv` have `maps/PLACE.osm` two folders above.
fn interaction_map(tracks: &Path) -> Option<PathBuf> {
    let folder = tracks.parent()?;
    let place = folder.file_name()?.to_str()?;
    let file = tracks.file_stem()?.to_str()?;
    let file = file.rsplit_once('_').map_or(file, |(place, _)| place);
    let folders = folder.ancestors().skip(1).take(2);
    let maps = folders.flat_map(|above| [above.join("maps"), above.join("map")]);
    let named = maps.flat_map(|maps| [place, file].map(|name| maps.join(format!("{name}.osm"))));
    named.into_iter().find(|map| map.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_of_argoverse_are_what_they_say_or_cars() {
        for (class, kind) in [
            ("AV", ObstacleType::Car),
            ("AGENT", ObstacleType::Car),
            ("OTHERS", ObstacleType::Car),
            ("PEDESTRIAN", ObstacleType::Pedestrian),
            ("BICYCLE", ObstacleType::Bicycle),
            ("BUS", ObstacleType::Bus),
        ] {
            assert_eq!(argoverse(class), kind, "{class}");
        }
    }
}
