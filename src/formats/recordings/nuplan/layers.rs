//! Where the map of a log is, and its layers: lanes, connectors, their lines, stop polygons and crossings, in metres.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::geometry::{Bounds, Point};
use nearmiss_base::system::FileCache;
use nearmiss_scene::scenario::LineMarking;

use super::geopackage::{DEGREES, projected, shape};
use super::log::Log;
use super::sqlite::{Database, Record, TableColumns, first_names};
use crate::commonroad::ReadError;
use crate::recordings::{Leftovers, has_extension, users_maps};

/// Maps that are kept for other windows, bytes.
const MAX_CACHED: usize = 512 << 20;

static MAPS: FileCache<Layers> = FileCache::new(MAX_CACHED);

/// A lane, or a connector: a way over an intersection from one lane to another.
#[derive(Debug, Clone, Default)]
pub struct Lane {
    pub id: i64,
    /// Its borders, among [`Layers::borders`].
    pub left: Option<i64>,
    pub right: Option<i64>,
    /// m/s.
    pub limit: Option<f64>,
    /// Lanes that are driven side by side, and its place among them, counted from the left.
    pub group: Option<(i64, i64)>,
    /// Whether it is for bicycles.
    pub is_for_bicycles: bool,
    /// What only a connector has.
    pub connector: Option<Connector>,
    /// Around its outline or middle.
    pub bounds: Option<Bounds>,
}

/// What a connector connects.
#[derive(Debug, Clone, Default)]
pub struct Connector {
    pub from: Option<i64>,
    pub to: Option<i64>,
    pub intersection: Option<i64>,
    /// 0 straight, 1 left, 2 right, 3 back.
    pub turn: Option<i64>,
    /// Stop polygons of its traffic lights.
    pub stops: Vec<i64>,
}

/// Where to stop.
#[derive(Debug, Clone)]
pub struct Stop {
    pub id: i64,
    /// 1 stop sign, 2 traffic light, 4 yield; others are of no sign.
    pub kind: i64,
    pub ring: Vec<Point>,
    /// Lanes that it is for.
    pub lanes: Vec<i64>,
    /// Connectors that it is for.
    pub connectors: Vec<i64>,
}

/// A map.
#[derive(Debug, Default)]
pub struct Layers {
    pub lanes: Vec<Lane>,
    pub connectors: Vec<Lane>,
    pub borders: HashMap<i64, (Vec<Point>, LineMarking)>,
    /// The middles of lanes, and of connectors.
    pub middles: [HashMap<i64, Vec<Point>>; 2],
    pub stops: Vec<Stop>,
    pub crossings: Vec<(i64, Vec<Point>)>,
    /// Intersections at which ways only branch, merge or go on.
    pub without_traffic: HashSet<i64>,
    /// Its zone of UTM, and whether it is in the southern half.
    pub zone: (i64, bool),
    /// What stands in it and is not used.
    pub leftovers: Leftovers,
    size: usize,
}

/// A map, read anew if it changed.
///
/// # Errors
/// It is none of nuPlan, or damaged: with table, row and column.
pub fn cached_map(path: &Path) -> Result<Arc<Layers>, ReadError> {
    MAPS.get(&[path], || {
        let layers = Reader::read(&Database::open(path)?)?;
        let size = layers.size;
        Ok((layers, size))
    })
}

/// The type of lanes for bicycles.
const BICYCLES: i64 = 1;

struct Reader<'d> {
    database: &'d Database,
    /// EPSG's numbers of the systems in the file.
    systems: HashMap<i64, i64>,
    projected: i64,
    layers: Layers,
}

/// Takes a row and the parts of its geometry.
type TakeShape<'t> =
    &'t mut dyn FnMut(&mut Layers, &Record<'_>, Vec<Vec<Point>>) -> Result<(), ReadError>;

impl<'d> Reader<'d> {
    fn read(database: &'d Database) -> Result<Layers, ReadError> {
        let has = |name: &str| database.has(name);
        let tables = database.tables();
        if !has("lanes_polygons") || !has("meta") {
            let message = if tables.is_empty() {
                "not a map of nuPlan: a file without tables".into()
            } else {
                format!(
                    "not a map of nuPlan: its tables are {}",
                    first_names(tables)
                )
            };
            return Err(database.fail(message));
        }
        let (projected, zone) = projected(database)?;
        let mut systems = HashMap::from([(DEGREES, DEGREES), (projected, projected)]);
        if has("gpkg_spatial_ref_sys") {
            let columns = ["srs_id", "organization_coordsys_id"];
            database.each("gpkg_spatial_ref_sys", &columns, &mut |row| {
                systems.insert(row.integer(0)?, row.integer(1)?);
                Ok(())
            })?;
        }
        let mut reader = Self {
            database,
            systems,
            projected,
            layers: Layers {
                zone,
                ..Layers::default()
            },
        };
        reader.borders()?;
        reader.middles()?;
        reader.lanes()?;
        if has("lane_connectors") {
            reader.connectors(has("gen_lane_connectors_scaled_width_polygons"))?;
        }
        if has("intersections") {
            let columns = ["fid", "?intersection_type_fid"];
            database.each("intersections", &columns, &mut |row| {
                if matches!(row.optional_whole(1)?, Some(3..=5)) {
                    reader.layers.without_traffic.insert(row.integer(0)?);
                }
                Ok(())
            })?;
        }
        if has("stop_polygons") {
            reader.stops()?;
        }
        if has("crosswalks") {
            reader.shapes("crosswalks", &["fid", "geom"], &mut |layers, row, parts| {
                let fid = row.integer(0)?;
                layers
                    .crossings
                    .extend(parts.into_iter().map(|ring| (fid, ring)));
                Ok(())
            })?;
        }
        let mut layers = reader.layers;
        database.count_unused(&TableColumns::default(), &mut layers.leftovers);
        Ok(layers)
    }

    /// Gives the rows of a layer to `take`; its second column is the geometry.
    fn shapes(
        &mut self,
        table: &str,
        columns: &[&str],
        take: TakeShape<'_>,
    ) -> Result<(), ReadError> {
        let Self {
            database,
            systems,
            projected,
            layers,
        } = self;
        database.each(table, columns, &mut |row| {
            let parts = if row.is_empty(1) {
                Vec::new()
            } else {
                shape(row, systems, *projected, layers.zone)?
            };
            layers.size += 64 + parts.iter().map(|part| 16 * part.len()).sum::<usize>();
            take(layers, row, parts)
        })
    }

    fn borders(&mut self) -> Result<(), ReadError> {
        let columns = ["fid", "geom", "?boundary_type_fid"];
        self.shapes("boundaries", &columns, &mut |layers, row, parts| {
            let marking = match row.optional_whole(2)? {
                Some(0) => LineMarking::Dashed,
                Some(2) => LineMarking::Solid,
                _ => LineMarking::Unknown,
            };
            if let Some(line) = longest(parts) {
                layers.borders.insert(row.integer(0)?, (line, marking));
            }
            Ok(())
        })
    }

    fn middles(&mut self) -> Result<(), ReadError> {
        let columns = ["fid", "geom", "lane_fid", "lane_connector_fid"];
        self.shapes("baseline_paths", &columns, &mut |layers, row, parts| {
            let Some(line) = longest(parts) else {
                return Ok(());
            };
            for (of, column) in [2, 3].into_iter().enumerate() {
                if let Some(id) = row.optional_whole(column)? {
                    layers.middles[of].insert(id, line.clone());
                }
            }
            Ok(())
        })
    }

    fn lanes(&mut self) -> Result<(), ReadError> {
        let columns = [
            "fid",
            "geom",
            "?lane_fid",
            "?left_boundary_fid",
            "?right_boundary_fid",
            "?speed_limit_mps",
            "?lane_group_fid",
            "?lane_index",
            "?lane_type_fid",
        ];
        self.shapes("lanes_polygons", &columns, &mut |layers, row, parts| {
            let (group, index) = (row.optional_whole(6)?, row.optional_whole(7)?);
            let id = row.optional_whole(2)?.map_or_else(|| row.integer(0), Ok)?;
            let middle = layers.middles[0].get(&id);
            let lane = Lane {
                id,
                left: row.optional_whole(3)?,
                right: row.optional_whole(4)?,
                limit: row.optional_number(5)?,
                group: group.zip(index),
                is_for_bicycles: row.optional_whole(8)? == Some(BICYCLES),
                connector: None,
                bounds: bounds(&parts).or_else(|| Bounds::from_points(middle?)),
            };
            layers.lanes.push(lane);
            Ok(())
        })
    }

    fn connectors(&mut self, have_borders: bool) -> Result<(), ReadError> {
        let mut borders = HashMap::new();
        if have_borders {
            let columns = [
                "fid",
                "lane_connector_fid",
                "?left_boundary_fid",
                "?right_boundary_fid",
            ];
            let table = "gen_lane_connectors_scaled_width_polygons";
            self.database.each(table, &columns, &mut |row| {
                let both = (row.optional_whole(2)?, row.optional_whole(3)?);
                borders.insert(row.optional_whole(1)?, both);
                Ok(())
            })?;
        }
        let columns = [
            "fid",
            "geom",
            "exit_lane_fid",
            "entry_lane_fid",
            "?intersection_fid",
            "?turn_type_fid",
            "?traffic_light_stop_line_fids",
            "?speed_limit_mps",
        ];
        self.shapes("lane_connectors", &columns, &mut |layers, row, parts| {
            let id = row.integer(0)?;
            let (left, right) = borders.get(&Some(id)).copied().unwrap_or_default();
            let middle = layers.middles[1].get(&id);
            let lane = Lane {
                id,
                left,
                right,
                limit: row.optional_number(7)?,
                group: None,
                is_for_bicycles: false,
                connector: Some(Connector {
                    from: row.optional_whole(2)?,
                    to: row.optional_whole(3)?,
                    intersection: row.optional_whole(4)?,
                    turn: row.optional_whole(5)?,
                    stops: ids(&row.text(6)),
                }),
                bounds: middle
                    .and_then(Bounds::from_points)
                    .or_else(|| bounds(&parts)),
            };
            layers.connectors.push(lane);
            Ok(())
        })
    }

    fn stops(&mut self) -> Result<(), ReadError> {
        let columns = [
            "fid",
            "geom",
            "stop_polygon_type_fid",
            "?lane_fids",
            "?lane_connector_fids",
        ];
        self.shapes("stop_polygons", &columns, &mut |layers, row, parts| {
            let (id, kind) = (row.integer(0)?, row.optional_whole(2)?.unwrap_or(-1));
            let (lanes, connectors) = (ids(&row.text(3)), ids(&row.text(4)));
            layers.stops.extend(parts.into_iter().map(|ring| Stop {
                id,
                kind,
                ring,
                lanes: lanes.clone(),
                connectors: connectors.clone(),
            }));
            Ok(())
        })
    }
}

/// The ids in a text such as `17, 18`.
fn ids(text: &str) -> Vec<i64> {
    let each = text.split(',').map(str::trim);
    each.filter_map(|id| id.parse().ok()).collect()
}

/// The part with most points, if it is a line.
fn longest(parts: Vec<Vec<Point>>) -> Option<Vec<Point>> {
    let longest = parts.into_iter().max_by_key(Vec::len);
    longest.filter(|line| line.len() > 1)
}

fn bounds(parts: &[Vec<Point>]) -> Option<Bounds> {
    Bounds::from_points(parts.iter().flatten())
}

/// The name of maps.
const FILE: &str = "map.gpkg";

/// Folders of the data set in each other, from a log to the folder of its maps.
const UP: usize = 6;

/// Versions of a map that are looked at.
const MAX_VERSIONS: usize = 100;

/// The map of a log, if there is one.
pub fn find(path: &Path, log: &Log) -> Option<PathBuf> {
    let mut names = [log.map.as_str(), log.location.as_str()]
        .into_iter()
        .filter(|name| is_plain(name));
    names.find_map(|name| of_name(path, name, users_maps()))
}

/// Where it was searched, and what helps, for a log without a map.
pub fn nowhere(log: &Log) -> String {
    let name = if is_plain(&log.map) { &log.map } else { "?" };
    format!(
        "no map: no {name}/VERSION/{FILE} beside the log, in `maps` of a folder above it{}; the scenario has no lanes and no lights; unpack nuPlan's maps there, or set `maps` in config.toml",
        super::super::in_words()
    )
}

/// Whether a name from a log is one of a folder, and leads nowhere else.
fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    !name.is_empty() && name.chars().all(plain) && !name.starts_with('.')
}

fn of_name(path: &Path, name: &str, users: Option<&Path>) -> Option<PathBuf> {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let mut above = whole.ancestors().skip(1);
    let beside = above.next()?;
    let in_maps = std::iter::once(beside)
        .chain(above.take(UP))
        .map(|folder| folder.join("maps"));
    let mut found = in_folder(beside, name).or_else(|| in_folder_itself(beside));
    found = found.or_else(|| { in_maps }.find_map(|maps| in_folder(&maps, name)));
    found.or_else(|| match users? {
        file if file.is_file() => has_extension(file, "gpkg").then(|| file.to_path_buf()),
        folder => in_folder(folder, name).or_else(|| of_versions(folder, name)),
    })
}

/// The map of a name in a folder of maps: its newest version.
fn in_folder(maps: &Path, name: &str) -> Option<PathBuf> {
    let alone = maps.join(format!("{name}.gpkg"));
    let folder = maps.join(name);
    { alone.is_file().then_some(alone) }
        .or_else(|| in_folder_itself(&folder))
        .or_else(|| newest(&folder))
}

fn in_folder_itself(folder: &Path) -> Option<PathBuf> {
    let map = folder.join(FILE);
    map.is_file().then_some(map)
}

/// A folder of one map is named, not that of all maps.
fn of_versions(folder: &Path, name: &str) -> Option<PathBuf> {
    let is_its = folder.file_name().is_some_and(|folder| folder == name);
    in_folder_itself(folder).or_else(|| is_its.then(|| newest(folder))?)
}

fn newest(folder: &Path) -> Option<PathBuf> {
    let versions = folder
        .read_dir()
        .into_iter()
        .flatten()
        .flatten()
        .take(MAX_VERSIONS);
    let maps = versions.map(|version| version.path().join(FILE));
    let mut maps: Vec<PathBuf> = maps.filter(|map| map.is_file()).collect();
    maps.sort_by_key(|map| version(map));
    maps.pop()
}

/// The numbers of a version, such as `9.17.1964`.
fn version(map: &Path) -> (Vec<u64>, PathBuf) {
    let folder = map
        .parent()
        .and_then(Path::file_name)
        .unwrap_or_default()
        .to_string_lossy();
    let numbers = folder
        .split('.')
        .filter_map(|part| part.parse().ok())
        .collect();
    (numbers, map.to_path_buf())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    #[test]
    fn maps_lie_in_the_data_set_beside_the_log_or_where_the_user_says() {
        let root = tempfile::tempdir().unwrap().path().canonicalize().unwrap();
        let make = |name: &str| {
            let path = root.join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(&path, "").unwrap();
            path
        };
        let log = make("dataset/nuplan-v1.1/splits/mini/a.db");
        let find = |users: Option<&Path>| of_name(&log, "us-ma-boston", users);
        assert_eq!(find(None), None);
        let mine = make("mine/us-ma-boston/9.9.1817/map.gpkg");
        let newer = make("mine/us-ma-boston/9.12.1817/map.gpkg");
        make("mine/sg-one-north/9.17.1964/map.gpkg");
        assert_eq!(find(mine.ancestors().nth(3)), Some(newer.clone()));
        assert_eq!(find(mine.ancestors().nth(2)), Some(newer));
        assert_eq!(find(Some(&mine)), Some(mine.clone()));
        let osm = make("mine/a.osm");
        assert_eq!(find(Some(&osm)), None);
        let of_dataset = make("dataset/maps/us-ma-boston/9.12.1817/map.gpkg");
        assert_eq!(find(Some(&mine)), Some(of_dataset));
        let beside = make("dataset/nuplan-v1.1/splits/mini/map.gpkg");
        assert_eq!(find(None), Some(beside));
        for name in ["", "..", "a/b", "/", ".hidden"] {
            assert!(!is_plain(name), "{name}");
        }
    }
}
