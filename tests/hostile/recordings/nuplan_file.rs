//! A log and a map of nuPlan, written from their published schemas: a road to the east with an intersection.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use rusqlite::{Connection, params};

/// East and north of the places below, in UTM zone 11, metres: Las Vegas.
pub const PLACE: (f64, f64) = (664_400.0, 3_996_600.0);

/// The same in scenarios, whose origin is a whole kilometre.
pub const LOCAL: (f64, f64) = (400.0, 600.0);

/// The microsecond at which the log begins.
const BEGIN: i64 = 1_633_000_000_000_000;

/// What varies between logs.
pub struct Log {
    pub seconds: f64,
    /// Where the vehicle that records is turned to, radians.
    pub heading: f64,
    /// When it starts to drive, seconds.
    pub starts: f64,
    pub indexed: bool,
    pub map: &'static str,
}

impl Default for Log {
    fn default() -> Self {
        Self {
            seconds: 10.0,
            heading: 0.0,
            starts: 0.0,
            indexed: true,
            map: "us-nv-las-vegas-strip",
        }
    }
}

/// The token of a row; each table counts from another start.
pub fn token(table: u64, row: u64) -> [u8; 8] {
    ((table << 56) | (row + 1).wrapping_mul(0x9e37_79b9)).to_be_bytes()
}

/// The same as users write it.
pub fn hex(table: u64, row: u64) -> String {
    format!("{:016x}", u64::from_be_bytes(token(table, row)))
}

pub const SWEEP: u64 = 1;
const POSE: u64 = 2;
pub const TRACK: u64 = 3;
const CATEGORY: u64 = 4;
const BOX: u64 = 5;
pub const SCENE: u64 = 6;
pub const TAG: u64 = 7;
const LIGHT: u64 = 8;

const CATEGORIES: [&str; 7] = [
    "vehicle",
    "bicycle",
    "pedestrian",
    "traffic_cone",
    "barrier",
    "czone_sign",
    "generic_object",
];

/// A track: its category, length and width, and its place, yaw and velocity at a time.
type Tracked = (
    &'static str,
    Option<(f64, f64)>,
    fn(f64) -> (f64, f64, f64, Option<(f64, f64)>),
);

/// Tracks in their order: a car that stands, a bicycle to the north, a pedestrian, a cone, a truck, a bin that rolls away, a
/// sign without a size.
pub const TRACKS: [Tracked; 7] = [
    ("vehicle", Some((4.5, 1.9)), |_| {
        (80.0, -1.75, 0.0, Some((0.0, 0.0)))
    }),
    ("bicycle", Some((1.8, 0.7)), |t| {
        (150.0, -30.0 + 4.0 * t, FRAC_PI_2, Some((0.0, 4.0)))
    }),
    ("pedestrian", Some((0.8, 0.7)), |_| (50.0, 8.0, 0.0, None)),
    ("traffic_cone", Some((0.4, 0.4)), |t| {
        (30.0 + 0.1 * (40.0 * t).sin(), -9.0, 0.0, Some((0.3, 0.0)))
    }),
    ("vehicle", Some((12.0, 2.5)), |_| {
        (40.0, 20.0, 3.0, Some((0.0, 0.0)))
    }),
    ("generic_object", Some((0.6, 0.5)), |t| {
        (20.0 + t, 9.0, 0.0, Some((1.0, 0.0)))
    }),
    ("barrier", None, |_| (60.0, -9.0, 0.1, Some((0.0, 0.0)))),
];

/// The rear axle of the vehicle that records: it drives at 10 m/s and stops behind the first car.
pub fn axle(log: &Log, t: f64) -> (f64, f64, f64) {
    let driven = ((t - log.starts).max(0.0) * 10.0).min(55.0);
    let drives = t >= log.starts && driven < 55.0;
    let (sin, cos) = log.heading.sin_cos();
    (
        10.0 + driven * cos,
        -1.75 + driven * sin,
        if drives { 10.0 } else { 0.0 },
    )
}

const TABLES: &str = "
CREATE TABLE log (token BLOB NOT NULL, vehicle_name VARCHAR(64), date VARCHAR(64), timestamp INTEGER, logfile VARCHAR(64), location VARCHAR(64), map_version VARCHAR(64), PRIMARY KEY (token));
CREATE TABLE lidar_pc (token BLOB NOT NULL, next_token BLOB, prev_token BLOB, ego_pose_token BLOB NOT NULL, lidar_token BLOB NOT NULL, scene_token BLOB, filename VARCHAR(128), timestamp INTEGER, PRIMARY KEY (token));
CREATE TABLE ego_pose (token BLOB NOT NULL, timestamp INTEGER, x FLOAT, y FLOAT, z FLOAT, qw FLOAT, qx FLOAT, qy FLOAT, qz FLOAT, vx FLOAT, vy FLOAT, vz FLOAT, acceleration_x FLOAT, acceleration_y FLOAT, acceleration_z FLOAT, angular_rate_x FLOAT, angular_rate_y FLOAT, angular_rate_z FLOAT, epsg INTEGER, log_token BLOB NOT NULL, PRIMARY KEY (token));
CREATE TABLE lidar_box (token BLOB NOT NULL, lidar_pc_token BLOB NOT NULL, track_token BLOB NOT NULL, next_token BLOB, prev_token BLOB, x FLOAT, y FLOAT, z FLOAT, width FLOAT, length FLOAT, height FLOAT, vx FLOAT, vy FLOAT, vz FLOAT, yaw FLOAT, confidence FLOAT, PRIMARY KEY (token));
CREATE TABLE track (token BLOB NOT NULL, category_token BLOB NOT NULL, width FLOAT, length FLOAT, height FLOAT, PRIMARY KEY (token));
CREATE TABLE category (token BLOB NOT NULL, name VARCHAR(64), description TEXT, PRIMARY KEY (token));
CREATE TABLE scene (token BLOB NOT NULL, log_token BLOB NOT NULL, name TEXT, goal_ego_pose_token BLOB, roadblock_ids TEXT, PRIMARY KEY (token));
CREATE TABLE scenario_tag (token BLOB NOT NULL, lidar_pc_token BLOB NOT NULL, type TEXT, agent_track_token BLOB, PRIMARY KEY (token));
CREATE TABLE traffic_light_status (token BLOB NOT NULL, lidar_pc_token BLOB NOT NULL, lane_connector_id INTEGER, status VARCHAR(8), PRIMARY KEY (token));
";

/// Writes a log.
pub fn write_log(path: &Path, log: &Log) {
    let mut file = Connection::open(path).unwrap();
    let all = file.transaction().unwrap();
    all.execute_batch(TABLES).unwrap();
    if log.indexed {
        let index = "CREATE INDEX boxes ON lidar_box (lidar_pc_token); CREATE INDEX lights ON traffic_light_status (lidar_pc_token);";
        all.execute_batch(index).unwrap();
    }
    let insert = |sql: &str, values: &[&dyn rusqlite::ToSql]| {
        all.prepare_cached(sql).unwrap().execute(values).unwrap();
    };
    let none = [0_u8; 8];
    insert(
        "INSERT INTO log VALUES (?1, 'test', '2021-09-30', ?2, 'test', 'las_vegas', ?3)",
        params![none, BEGIN, log.map],
    );
    for (i, name) in (0..).zip(CATEGORIES) {
        let row = params![token(CATEGORY, i), name];
        insert("INSERT INTO category VALUES (?1, ?2, '')", row);
    }
    for (i, (category, size, _)) in (0..).zip(TRACKS) {
        let category = CATEGORIES.iter().position(|c| *c == category).unwrap() as u64;
        let (length, width) = size.unzip();
        let row = params![token(TRACK, i), token(CATEGORY, category), width, length];
        insert("INSERT INTO track VALUES (?1, ?2, ?3, ?4, 1.5)", row);
    }
    let sweeps = (log.seconds * 20.0).round() as u64;
    for scene in 0..=sweeps / 400 {
        let row = params![token(SCENE, scene), none, format!("scene-{scene}")];
        insert("INSERT INTO scene VALUES (?1, ?2, ?3, NULL, '')", row);
    }
    let tagged = token(SWEEP, sweeps / 2);
    insert(
        "INSERT INTO scenario_tag VALUES (?1, ?2, 'near_multiple_vehicles', NULL)",
        params![token(TAG, 0), tagged],
    );
    let (mut boxes, mut lights) = (0, 0);
    // Not in the order of time.
    for sweep in (0..=sweeps).rev() {
        let t = sweep as f64 / 20.0;
        // Clocks are off by less than a millisecond.
        let time = BEGIN + sweep as i64 * 50_000 + (sweep % 3) as i64 * 300;
        insert(
            "INSERT INTO lidar_pc VALUES (?1, NULL, NULL, ?2, ?3, ?4, 'x.pcd', ?5)",
            params![
                token(SWEEP, sweep),
                token(POSE, sweep),
                none,
                token(SCENE, sweep / 400),
                time
            ],
        );
        let (x, y, speed) = axle(log, t);
        let (sin, cos) = (log.heading / 2.0).sin_cos();
        insert(
            "INSERT INTO ego_pose VALUES (?1, ?2, ?3, ?4, 600, ?5, 0, 0, ?6, ?7, 0, 0, 0, 0, 0, 0, 0, 0, 32611, ?8)",
            params![
                token(POSE, sweep),
                time,
                PLACE.0 + x,
                PLACE.1 + y,
                cos,
                sin,
                speed,
                none
            ],
        );
        for (track, (.., at)) in (0..).zip(TRACKS) {
            let (x, y, yaw, velocity) = at(t);
            let (vx, vy) = velocity.unzip();
            insert(
                "INSERT INTO lidar_box VALUES (?1, ?2, ?3, NULL, NULL, ?4, ?5, 600, 0.9, 0.9, 1.5, ?6, ?7, 0, ?8, 0.9)",
                params![
                    token(BOX, boxes),
                    token(SWEEP, sweep),
                    token(TRACK, track),
                    PLACE.0 + x,
                    PLACE.1 + y,
                    vx,
                    vy,
                    yaw
                ],
            );
            boxes += 1;
        }
        for connector in [20, 21] {
            let status = if t < 5.0 { "red" } else { "green" };
            insert(
                "INSERT INTO traffic_light_status VALUES (?1, ?2, ?3, ?4)",
                params![token(LIGHT, lights), token(SWEEP, sweep), connector, status],
            );
            lights += 1;
        }
    }
    all.commit().unwrap();
}

/// Longitude and latitude of a place in zone 11, degrees: the inverse series of Krüger, to the third order.
fn degrees((x, y): (f64, f64)) -> (f64, f64) {
    let (f, axis, scale) = (1.0 / 298.257_223_563, 6_378_137.0, 0.9996);
    let n: f64 = f / (2.0 - f);
    let radius = axis / (1.0 + n) * (1.0 + n.powi(2) / 4.0 + n.powi(4) / 64.0);
    let (n2, n3) = (n.powi(2), n.powi(3));
    let beta = [
        n / 2.0 - 2.0 / 3.0 * n2 + 37.0 / 96.0 * n3,
        n2 / 48.0 + n3 / 15.0,
        17.0 / 480.0 * n3,
    ];
    let delta = [
        2.0 * n - 2.0 / 3.0 * n2 - 2.0 * n3,
        7.0 / 3.0 * n2 - 8.0 / 5.0 * n3,
        56.0 / 15.0 * n3,
    ];
    let xi = (PLACE.1 + y) / (scale * radius);
    let eta = (PLACE.0 + x - 500_000.0) / (scale * radius);
    let (mut north, mut east) = (xi, eta);
    for (j, b) in (1..).zip(beta) {
        let k = 2.0 * f64::from(j);
        north -= b * (k * xi).sin() * (k * eta).cosh();
        east -= b * (k * xi).cos() * (k * eta).sinh();
    }
    let chi = (north.sin() / east.cosh()).asin();
    let mut latitude = chi;
    for (j, d) in (1..).zip(delta) {
        latitude += d * (2.0 * f64::from(j) * chi).sin();
    }
    let longitude = east.sinh().atan2(north.cos());
    (longitude.to_degrees() - 117.0, latitude.to_degrees())
}

/// A geometry of a GeoPackage in degrees: a line (2) or polygon (3).
fn geometry(kind: u32, points: &[(f64, f64)]) -> Vec<u8> {
    let mut bytes = vec![b'G', b'P', 0, 1];
    bytes.extend(4326_i32.to_le_bytes());
    bytes.push(1);
    bytes.extend(kind.to_le_bytes());
    if kind == 3 {
        bytes.extend(1_u32.to_le_bytes());
    }
    bytes.extend((points.len() as u32).to_le_bytes());
    for point in points {
        let (longitude, latitude) = degrees(*point);
        bytes.extend(longitude.to_le_bytes());
        bytes.extend(latitude.to_le_bytes());
    }
    bytes
}

const LAYERS: &str = "
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL, organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT, description TEXT, last_change TEXT, min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER);
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL);
CREATE TABLE meta (fid INTEGER PRIMARY KEY, key TEXT, value TEXT);
CREATE TABLE boundaries (fid INTEGER PRIMARY KEY, geom LINESTRING, boundary_segment_fids TEXT, has_reflectors BOOLEAN, boundary_type_fid INTEGER, creator_id TEXT);
CREATE TABLE baseline_paths (fid INTEGER PRIMARY KEY, geom LINESTRING, path_type_fid INTEGER, creator_id TEXT, lane_fid INTEGER, lane_connector_fid INTEGER);
CREATE TABLE lanes_polygons (fid INTEGER PRIMARY KEY, geom POLYGON, lane_group_fid INTEGER, lane_fid INTEGER, lane_index MEDIUMINT, left_boundary_fid INTEGER, right_boundary_fid INTEGER, speed_limit_mps REAL);
CREATE TABLE lane_connectors (fid INTEGER PRIMARY KEY, geom LINESTRING, exit_lane_fid INTEGER, entry_lane_fid INTEGER, intersection_fid INTEGER, turn_type_fid INTEGER, traffic_light_stop_line_fids TEXT, speed_limit_mps REAL);
CREATE TABLE gen_lane_connectors_scaled_width_polygons (fid INTEGER PRIMARY KEY, geom POLYGON, lane_connector_fid INTEGER, left_boundary_fid INTEGER, right_boundary_fid INTEGER);
CREATE TABLE stop_polygons (fid INTEGER PRIMARY KEY, geom POLYGON, stop_polygon_type_fid INTEGER, lane_fids TEXT, lane_connector_fids TEXT);
CREATE TABLE crosswalks (fid INTEGER PRIMARY KEY, geom POLYGON, is_marked BOOLEAN);
CREATE TABLE intersections (fid INTEGER PRIMARY KEY, geom POLYGON, intersection_type_fid INTEGER);
INSERT INTO gpkg_spatial_ref_sys VALUES ('WGS 84', 4326, 'EPSG', 4326, '', '');
INSERT INTO gpkg_contents VALUES ('lanes_polygons', 'features', 'lanes_polygons', '', '', 0, 0, 0, 0, 4326);
INSERT INTO meta (key, value) VALUES ('geographicCoordSystem', 'epsg:4326'), ('projectedCoordSystem', 'epsg:32611');
";

/// The ends of a line.
type Ends = [(f64, f64); 2];

/// Lanes: id, group and index, its middle, its half width, left and right border.
type Lane = (i64, (i64, i64), Ends, (i64, i64));

const LANES: [Lane; 6] = [
    (10, (100, 0), [(0.0, 1.75), (100.0, 1.75)], (1, 2)),
    (11, (100, 1), [(0.0, -1.75), (100.0, -1.75)], (2, 3)),
    (12, (101, 0), [(120.0, 1.75), (200.0, 1.75)], (4, 5)),
    (13, (101, 1), [(120.0, -1.75), (200.0, -1.75)], (5, 6)),
    (14, (102, 0), [(110.0, -12.0), (110.0, -60.0)], (9, 10)),
    (99, (103, 0), [(900.0, 1.75), (990.0, 1.75)], (1, 2)),
];

/// Connectors: id, from, to, its middle, its borders, its turn and the stop polygons of its lights.
type Connector = (
    i64,
    i64,
    i64,
    &'static [(f64, f64)],
    (i64, i64),
    i64,
    &'static str,
);

const CONNECTORS: [Connector; 3] = [
    (
        20,
        10,
        12,
        &[(100.0, 1.75), (120.0, 1.75)],
        (7, 8),
        0,
        "300",
    ),
    (
        21,
        11,
        13,
        &[(100.0, -1.75), (120.0, -1.75)],
        (8, 11),
        0,
        "300",
    ),
    // Its borders are not in the map.
    (
        22,
        11,
        14,
        &[(100.0, -1.75), (106.0, -3.0), (109.0, -7.0), (110.0, -12.0)],
        (98, 97),
        2,
        "",
    ),
];

/// Borders: id, kind, points; the second and third are drawn against the driving direction.
const BORDERS: [(i64, i64, Ends); 11] = [
    (1, 2, [(0.0, 3.5), (100.0, 3.5)]),
    (2, 0, [(100.0, 0.0), (0.0, 0.0)]),
    (3, 2, [(100.0, -3.5), (0.0, -3.5)]),
    (4, 2, [(120.0, 3.5), (200.0, 3.5)]),
    (5, 0, [(120.0, 0.0), (200.0, 0.0)]),
    (6, 2, [(120.0, -3.5), (200.0, -3.5)]),
    (7, 1, [(100.0, 3.5), (120.0, 3.5)]),
    (8, 1, [(100.0, 0.0), (120.0, 0.0)]),
    (9, 2, [(111.75, -12.0), (111.75, -60.0)]),
    (10, 2, [(108.25, -12.0), (108.25, -60.0)]),
    (11, 1, [(100.0, -3.5), (120.0, -3.5)]),
];

/// Writes a map.
pub fn write_map(path: &Path) {
    let file = Connection::open(path).unwrap();
    file.pragma_update(None, "application_id", 0x4750_4b47)
        .unwrap();
    file.execute_batch(LAYERS).unwrap();
    let insert = |sql: &str, values: &[&dyn rusqlite::ToSql]| {
        file.execute(sql, values).unwrap();
    };
    let ring = |(x0, y0): (f64, f64), (x1, y1): (f64, f64)| {
        geometry(3, &[(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)])
    };
    for (id, kind, line) in BORDERS {
        let row = params![id, geometry(2, &line), kind];
        insert("INSERT INTO boundaries VALUES (?1, ?2, '', 0, ?3, '')", row);
    }
    for (id, (group, index), middle, (left, right)) in LANES {
        let [(x0, y0), (x1, y1)] = middle;
        let outline = ring((x0 - 1.0, y0 - 1.75), (x1 + 1.0, y1 + 1.75));
        let row = params![id, outline, group, index, left, right];
        insert(
            "INSERT INTO lanes_polygons VALUES (?1, ?2, ?3, ?1, ?4, ?5, ?6, 11.176)",
            row,
        );
        let row = params![id + 1000, geometry(2, &middle), id];
        insert(
            "INSERT INTO baseline_paths VALUES (?1, ?2, 1, '', ?3, NULL)",
            row,
        );
    }
    for (id, from, to, middle, (left, right), turn, stops) in CONNECTORS {
        let row = params![id, geometry(2, middle), from, to, turn, stops];
        insert(
            "INSERT INTO lane_connectors VALUES (?1, ?2, ?3, ?4, 500, ?5, ?6, NULL)",
            row,
        );
        let row = params![id + 1000, geometry(2, middle), id];
        insert(
            "INSERT INTO baseline_paths VALUES (?1, ?2, 2, '', NULL, ?3)",
            row,
        );
        let row = params![id + 2000, id, left, right];
        let sql =
            "INSERT INTO gen_lane_connectors_scaled_width_polygons VALUES (?1, NULL, ?2, ?3, ?4)";
        insert(sql, row);
    }
    let stop = "INSERT INTO stop_polygons VALUES (?1, ?2, ?3, '', '')";
    insert(stop, params![300, ring((97.0, -3.4), (98.0, 3.4)), 2]);
    insert(stop, params![301, ring((108.5, -58.0), (111.5, -57.0)), 1]);
    let crossing = ring((102.0, -5.0), (105.0, 5.0));
    insert(
        "INSERT INTO crosswalks VALUES (400, ?1, 1)",
        params![crossing],
    );
    insert("INSERT INTO intersections VALUES (500, NULL, 1)", params![]);
}
