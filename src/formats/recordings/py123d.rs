//! py123d: logs of many data sets in one form, a folder of Arrow files. `box_detections_se3.arrow` has a row a moment with
//! the boxes of all road users; `ego_state_se3.arrow` beside it says where the vehicle that recorded is.
//!
//! As `ArrowLogWriter` of version 0.1 writes them. Its maps are not read.

use std::fs::File;
use std::io::{self, Cursor, Read};
use std::path::Path;
use std::sync::Arc;

use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type, UInt16Type};
use arrow_array::{Array, FixedSizeListArray, ListArray, RecordBatch};
use arrow_ipc::reader::StreamReader;
use nearmiss_base::system;
use nearmiss_scene::scenario::Scenario;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::assembly::{signed_speed, yaw};
use super::tracks::table::{Recorded, Said, Trust};
use super::tracks::{AboutTable, Batch, Columns, Dictionary, Role, Rows, Table, Values, cached};
use super::{Leftovers, Report, has_extension};
use crate::commonroad::ReadError;
use crate::dispatch::{Address, Applies, Format, Parts};

/// The format.
pub struct Py123d;

/// Names of the files, of which those of columns begin with.
const BOXES: &str = "box_detections_se3";
const EGO: &str = "ego_state_se3";

impl Format for Py123d {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        let is_named = path.file_stem().is_some_and(|name| name == BOXES);
        is_named && head.starts_with(MAGIC)
    }

    fn applies(&self, _: &Path, _: &[u8]) -> Applies {
        Applies::Map
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        read(path)?.parts(path)
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        read(&address.file)?.open_at(address)
    }
}

/// Whether a file is another one of a log.
pub fn is_in_log(path: &Path) -> bool {
    has_extension(path, "arrow") && path.with_file_name(format!("{BOXES}.arrow")).is_file()
}

fn read(boxes: &Path) -> Result<Arc<Table>, ReadError> {
    let beside = boxes.with_file_name(format!("{EGO}.arrow"));
    let ego = beside.is_file().then_some(beside);
    let files: Vec<&Path> = std::iter::once(boxes).chain(ego.as_deref()).collect();
    cached(&files, || {
        let mut log = Log::default();
        let mut notes = vec!["the maps of py123d are not read".to_string()];
        let of_file = |path: &Path, read: &mut dyn FnMut(&Path) -> Result<(), String>| {
            let report = Report::about(path.display().to_string());
            // Crates assert that what is in a file is sound.
            let read = system::crash::contained(|| read(path));
            let read = read.unwrap_or_else(|| Err("it is damaged".into()));
            read.map_err(|why| report.fail(format!("no log of py123d: {why}")))
        };
        of_file(boxes, &mut |path| {
            let (about, rows): (AboutBoxes, _) = open(path)?;
            let labels = labels(&about.box_detection_label_class);
            if labels.is_empty() {
                let class = about.box_detection_label_class;
                notes.push(format!(
                    "labels of `{class}` are not known; road users are told by size"
                ));
            }
            rows.into_iter()
                .try_for_each(|rows| log.add_boxes(&rows.map_err(|e| e.to_string())?, &labels))
        })?;
        match &ego {
            Some(ego) => of_file(ego, &mut |path| {
                let (vehicle, rows): (Vehicle, _) = open(path)?;
                rows.into_iter()
                    .try_for_each(|rows| log.add_ego(&rows.map_err(|e| e.to_string())?, &vehicle))
            })?,
            None => notes.push(format!(
                "no {EGO}.arrow beside it: the vehicle that recorded is not in it"
            )),
        }
        log.table(notes, &files)
    })
}

/// What a file of boxes says of them.
#[derive(Deserialize)]
struct AboutBoxes {
    /// The Python class that numbers the labels.
    box_detection_label_class: String,
}

/// What a file of the ego says of the vehicle, metres.
#[derive(Deserialize)]
struct Vehicle {
    length: f64,
    width: f64,
    /// Its middle as the measuring unit sees it: x, y, z, and a quaternion.
    center_to_imu_se3: [f64; 7],
}

const MAGIC: &[u8] = b"ARROW1";

/// No schema with what it says is longer, bytes.
const LONGEST_SCHEMA: u32 = 1 << 20;

type Batches = StreamReader<io::Chain<Cursor<Vec<u8>>, File>>;

/// What a file says, and its rows. What it says is written as MessagePack where Arrow has text, which its readers refuse:
/// they are given a schema without it.
fn open<T: DeserializeOwned>(path: &Path) -> Result<(T, Batches), String> {
    let words = |error: io::Error| system::error_text(&error);
    let mut file = system::open_file(path).map_err(words)?;
    // The magic and its padding, then a stream: a mark, the length of the schema, the schema.
    let mut head = [0; 16];
    file.read_exact(&mut head).map_err(words)?;
    let length = u32::from_le_bytes([head[12], head[13], head[14], head[15]]);
    if !head.starts_with(MAGIC) || length > LONGEST_SCHEMA {
        return Err("no file of Arrow".into());
    }
    let mut schema = vec![0; length as usize];
    file.read_exact(&mut schema).map_err(words)?;
    // A map of fewer than 16 keys, behind its length.
    let maps = (4..schema.len()).filter(|at| schema[*at] & 0xf0 == 0x80);
    let found = maps.filter_map(|at| {
        let before = [
            schema[at - 4],
            schema[at - 3],
            schema[at - 2],
            schema[at - 1],
        ];
        let inside = schema.get(at..at.checked_add(u32::from_le_bytes(before) as usize)?)?;
        let about = rmp_serde::from_slice::<T>(inside).ok()?;
        Some((at..at + inside.len(), about))
    });
    let (place, about) = { found }
        .next()
        .ok_or("its schema does not say what it is of")?;
    schema[place].fill(b' ');
    let mut stream = head[8..].to_vec();
    stream.append(&mut schema);
    let reader = StreamReader::try_new(Cursor::new(stream).chain(file), None);
    Ok((about, reader.map_err(|error| error.to_string())?))
}

/// The rows of a log as a table, a column a role.
#[derive(Default)]
struct Log {
    /// The first moment, microseconds.
    first: Option<i64>,
    /// By [`NUMBERS`].
    numbers: [Vec<f64>; NUMBERS.len()],
    ids: (Vec<u32>, Dictionary),
    classes: (Vec<u32>, Dictionary),
}

const NUMBERS: [Role; 7] = [
    Role::Time,
    Role::X,
    Role::Y,
    Role::Heading,
    Role::Speed,
    Role::Length,
    Role::Width,
];

/// The units of these.
const COLUMNS: &str = "time=timestamp_us[s],id=track_token,x=x[m],y=y[m],heading=heading[rad],speed=speed[m/s],\
                       length=length[m],width=width[m],class=label";

/// Where a body is: its moment, place, heading, speed and size in SI.
struct Body {
    time: i64,
    place: (f64, f64),
    heading: f64,
    speed: f64,
    size: (f64, f64),
}

impl Log {
    fn add(&mut self, id: &str, class: &str, body: &Body) {
        let first = *self.first.get_or_insert(body.time);
        let values = [
            // Without the microseconds of decades, times keep their digits.
            (body.time - first) as f64 / 1e6,
            body.place.0,
            body.place.1,
            body.heading,
            body.speed,
            body.size.0,
            body.size.1,
        ];
        for (column, value) in self.numbers.iter_mut().zip(values) {
            column.push(value);
        }
        for ((places, texts), text) in [(&mut self.ids, id), (&mut self.classes, class)] {
            places.push(texts.place(text));
        }
    }

    fn add_boxes(&mut self, rows: &RecordBatch, labels: &[&str]) -> Result<(), String> {
        let column = |name: &str| column(rows, BOXES, name);
        let times = column("timestamp_us")?;
        let times = times
            .as_primitive_opt::<Int64Type>()
            .ok_or("times are no int64")?;
        let list = |name: &str| -> Result<ListArray, String> {
            let lists = column(name)?.as_list_opt::<i32>().cloned();
            lists.ok_or_else(|| format!("`{name}` is no list"))
        };
        let [boxes, tokens, classes, velocities] =
            ["bounding_box_se3", "track_token", "label", "velocity_3d"].map(list);
        let (boxes, tokens, classes, velocities) = (boxes?, tokens?, classes?, velocities?);
        for (row, time) in times.values().iter().enumerate() {
            let (boxes, velocities) = (boxes.value(row), velocities.value(row));
            let (tokens, classes) = (tokens.value(row), classes.value(row));
            let (boxes, velocities) = (fixed(&boxes, 10)?, fixed(&velocities, 3)?);
            let tokens = tokens.as_string_opt::<i32>().ok_or("tokens are no texts")?;
            let classes = classes
                .as_primitive_opt::<UInt16Type>()
                .ok_or("labels are no uint16")?;
            let count = boxes.len();
            if [tokens.len(), classes.len(), velocities.len()] != [count; 3] {
                return Err(format!("row {}: lists of different lengths", row + 1));
            }
            for at in 0..count {
                let of = numbers(boxes, at)?;
                let heading = yaw([of[3], of[4], of[5], of[6]]);
                let speed = if velocities.is_null(at) {
                    f64::NAN
                } else {
                    let along = numbers(velocities, at)?;
                    signed_speed(heading, along[0], along[1])
                };
                let class = labels.get(usize::from(classes.value(at)));
                let body = Body {
                    time: *time,
                    place: (of[0], of[1]),
                    heading,
                    speed,
                    size: (of[7], of[8]),
                };
                self.add(tokens.value(at), class.unwrap_or(&""), &body);
            }
        }
        Ok(())
    }

    fn add_ego(&mut self, rows: &RecordBatch, vehicle: &Vehicle) -> Result<(), String> {
        let times = column(rows, EGO, "timestamp_us")?;
        let times = times
            .as_primitive_opt::<Int64Type>()
            .ok_or("times are no int64")?;
        let (poses, states) = (
            column(rows, EGO, "imu_se3")?,
            column(rows, EGO, "dynamic_state_se3")?,
        );
        let (poses, states) = (fixed(&poses, 7)?, fixed(&states, 9)?);
        for (row, time) in times.values().iter().enumerate() {
            let of = numbers(poses, row)?;
            let heading = yaw([of[3], of[4], of[5], of[6]]);
            let (sin, cos) = heading.sin_cos();
            let [ahead, left, ..] = vehicle.center_to_imu_se3;
            let speed = if states.is_null(row) {
                f64::NAN
            } else {
                // Forward and to the left.
                numbers(states, row).map(|of| of[0].hypot(of[1]).copysign(of[0]))?
            };
            let body = Body {
                time: *time,
                place: (
                    of[0] + ahead * cos - left * sin,
                    of[1] + ahead * sin + left * cos,
                ),
                heading,
                speed,
                size: (vehicle.length, vehicle.width),
            };
            self.add("ego", "ego", &body);
        }
        Ok(())
    }

    fn table(self, notes: Vec<String>, files: &[&Path]) -> Result<Table, ReadError> {
        let report = Report::about(files[0].display().to_string());
        let columns: Columns = COLUMNS.parse().unwrap_or_default();
        let count = self.numbers[0].len();
        let mut roles = NUMBERS.to_vec();
        roles.extend([Role::Id, Role::Class]);
        let mut values: Vec<Values> = self.numbers.into_iter().map(Values::Numbers).collect();
        values.extend([self.ids, self.classes].map(|(places, texts)| Values::Texts(places, texts)));
        let batch = Batch {
            values,
            lines: vec![0; count],
            ..Batch::default()
        };
        let mut rows = Rows::default();
        rows.add(&roles, batch)
            .map_err(|bad| report.fail(bad.message))?;
        let said = Said {
            trust: Trust::All,
            ..Said::default()
        };
        let recorded = Recorded::new(rows, &columns, said, report.file())?;
        let about = AboutTable {
            source: "py123d",
            tags: &[],
            how: String::new(),
            notes,
        };
        Table::new(recorded, about, None, files, Leftovers::default())
    }
}

fn column(rows: &RecordBatch, file: &str, name: &str) -> Result<Arc<dyn Array>, String> {
    let name = format!("{file}.{name}");
    let column = rows.column_by_name(&name).cloned();
    column.ok_or_else(|| format!("no column `{name}`"))
}

/// Lists of so many numbers.
fn fixed(column: &Arc<dyn Array>, length: i32) -> Result<&FixedSizeListArray, String> {
    let lists = column.as_fixed_size_list_opt();
    let lists = lists.filter(|lists| lists.value_length() == length);
    lists.ok_or_else(|| format!("a column that is no list of {length} numbers"))
}

fn numbers(lists: &FixedSizeListArray, at: usize) -> Result<Vec<f64>, String> {
    let list = lists.value(at);
    let numbers = list.as_primitive_opt::<Float64Type>();
    Ok(numbers
        .ok_or("numbers that are no float64")?
        .values()
        .to_vec())
}

/// What the numbers of labels mean, in words that classes of tables are told by; empty where the class is not known.
fn labels(class: &str) -> Vec<&'static str> {
    let name = class.rsplit('.').next().unwrap_or_default();
    let known = LABELS.iter().find(|(known, _)| *known == name);
    known.map_or_else(Vec::new, |(_, labels)| labels.split_whitespace().collect())
}

/// By Python class, as `py123d.parser.registry` numbers them.
#[rustfmt::skip]
const LABELS: [(&str, &str); 9] = [
    ("DefaultBoxDetectionLabel",
     "ego vehicle train bicycle person animal sign cone light barrier object"),
    ("AV2SensorBoxDetectionLabel",
     "animal bus bicycle bicyclist bollard truck bus cone cone animal truck trailer sign motorcycle \
      motorcyclist person pedestrian train vehicle bus sign sign pedestrian trailer truck truck trailer \
      pedestrian scooter cyclist"),
    ("KITTI360BoxDetectionLabel",
     "bicycle object bus car trailer lamp motorcycle person pole cyclist pole sign light sign trailer \
      train object truck object"),
    ("NuPlanBoxDetectionLabel",
     "vehicle bicycle pedestrian cone barrier sign object"),
    ("NuScenesBoxDetectionLabel",
     "car truck bus bus truck vehicle vehicle trailer bicycle motorcycle pedestrian pedestrian pedestrian \
      scooter pedestrian pedestrian pedestrian cone barrier object object object animal"),
    ("PandasetBoxDetectionLabel",
     "animal animal bicycle bus car cone sign vehicle truck motorcycle scooter truck bicycle vehicle \
      pedestrian pedestrian scooter car cone barrier object truck sign barrier trailer train tram"),
    ("WODPerceptionBoxDetectionLabel",
     "object vehicle pedestrian sign cyclist"),
    ("WODMotionBoxDetectionLabel",
     "object vehicle pedestrian cyclist object"),
    ("PhysicalAIAVBoxDetectionLabel",
     "car person bus truck vehicle object cyclist pedestrian trailer animal"),
];

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::collections::HashMap;

    use arrow_array::builder::{
        FixedSizeListBuilder, Float64Builder, Int64Builder, ListBuilder, StringBuilder,
        UInt16Builder,
    };
    use arrow_array::{ArrayRef, RecordBatchOptions};
    use arrow_ipc::MetadataVersion;
    use arrow_ipc::writer::{FileWriter, IpcWriteOptions};
    use arrow_schema::{Field, Schema};
    use nearmiss_scene::scenario::ObstacleType;

    use super::*;

    /// Lists of so many numbers; none where there is `None`.
    fn fixed_lists(
        length: i32,
        lists: &[Option<Vec<f64>>],
    ) -> FixedSizeListBuilder<Float64Builder> {
        let mut builder = FixedSizeListBuilder::new(Float64Builder::new(), length);
        for list in lists {
            let values = list.clone().unwrap_or_else(|| vec![0.0; length as usize]);
            builder.values().append_slice(&values);
            builder.append(list.is_some());
        }
        builder
    }

    /// Writes a file as Python does: what it says is MessagePack, which Arrow of Rust cannot write.
    fn write(path: &Path, columns: Vec<(String, ArrayRef)>, about: &impl serde::Serialize) {
        let about = rmp_serde::to_vec_named(about).unwrap();
        let stand_in = "~".repeat(about.len());
        let fields: Vec<Field> = columns
            .iter()
            .map(|(name, c)| Field::new(name, c.data_type().clone(), true))
            .collect();
        let metadata = HashMap::from([("metadata".to_string(), stand_in.clone())]);
        let schema = Arc::new(Schema::new_with_metadata(fields, metadata));
        let arrays = columns.into_iter().map(|(_, column)| column).collect();
        let rows =
            RecordBatch::try_new_with_options(schema.clone(), arrays, &RecordBatchOptions::new())
                .unwrap();
        let mut bytes = Vec::new();
        let padded = IpcWriteOptions::try_new(8, false, MetadataVersion::V5).unwrap();
        let mut writer = FileWriter::try_new_with_options(&mut bytes, &schema, padded).unwrap();
        writer.write(&rows).unwrap();
        writer.finish().unwrap();
        drop(writer);
        while let Some(at) = bytes
            .windows(about.len())
            .position(|w| w == stand_in.as_bytes())
        {
            bytes[at..at + about.len()].copy_from_slice(&about);
        }
        std::fs::write(path, bytes).unwrap();
    }

    #[derive(serde::Serialize)]
    struct Boxes {
        box_detection_label_class: &'static str,
    }

    #[derive(serde::Serialize)]
    struct Car {
        vehicle_name: &'static str,
        width: f64,
        length: f64,
        center_to_imu_se3: [f64; 7],
    }

    const START: i64 = 1_600_000_000_000_000;

    /// Three moments, 0.1 s apart: the ego goes east, a car south before it, a pedestrian stands.
    fn log(folder: &Path) {
        let half = std::f64::consts::FRAC_PI_4;
        let mut times = Int64Builder::new();
        let mut boxes = ListBuilder::new(FixedSizeListBuilder::new(Float64Builder::new(), 10));
        let mut velocities = ListBuilder::new(FixedSizeListBuilder::new(Float64Builder::new(), 3));
        let mut tokens = ListBuilder::new(StringBuilder::new());
        let mut labels = ListBuilder::new(UInt16Builder::new());
        for step in 0..3_i32 {
            times.append_value(START + i64::from(step) * 100_000);
            let t = f64::from(step) * 0.1;
            let car = vec![
                30.0,
                8.0 - 5.0 * t,
                0.0,
                half.cos(),
                0.0,
                0.0,
                -half.sin(),
                4.5,
                1.9,
                1.5,
            ];
            let walker = vec![12.0, 4.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.6, 0.5, 1.8];
            for (body, velocity) in [(car, Some(vec![0.0, -5.0, 0.0])), (walker, None)] {
                boxes.values().values().append_slice(&body);
                boxes.values().append(true);
                velocities
                    .values()
                    .values()
                    .append_slice(&velocity.clone().unwrap_or_else(|| vec![0.0; 3]));
                velocities.values().append(velocity.is_some());
            }
            boxes.append(true);
            velocities.append(true);
            for (token, label) in [("c4", 0), ("p7", 2)] {
                tokens.values().append_value(token);
                labels.values().append_value(label);
            }
            tokens.append(true);
            labels.append(true);
        }
        let named = |file: &str, name: &str| format!("{file}.{name}");
        write(
            &folder.join("box_detections_se3.arrow"),
            vec![
                (
                    named(BOXES, "timestamp_us"),
                    Arc::new(times.finish()) as ArrayRef,
                ),
                (named(BOXES, "bounding_box_se3"), Arc::new(boxes.finish())),
                (named(BOXES, "track_token"), Arc::new(tokens.finish())),
                (named(BOXES, "label"), Arc::new(labels.finish())),
                (named(BOXES, "velocity_3d"), Arc::new(velocities.finish())),
            ],
            &Boxes {
                box_detection_label_class: "py123d.parser.registry.NuPlanBoxDetectionLabel",
            },
        );
        let mut times = Int64Builder::new();
        let at = |step: i32| f64::from(step);
        (0..3).for_each(|step| times.append_value(START + step * 100_000));
        let poses = [0, 1, 2].map(|step| Some(vec![at(step), 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]));
        let states = [0, 1, 2].map(|_| Some(vec![10.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]));
        write(
            &folder.join("ego_state_se3.arrow"),
            vec![
                (
                    named(EGO, "timestamp_us"),
                    Arc::new(times.finish()) as ArrayRef,
                ),
                (
                    named(EGO, "imu_se3"),
                    Arc::new(fixed_lists(7, &poses).finish()),
                ),
                (
                    named(EGO, "dynamic_state_se3"),
                    Arc::new(fixed_lists(9, &states).finish()),
                ),
            ],
            &Car {
                vehicle_name: "pacifica",
                width: 2.3,
                length: 5.2,
                center_to_imu_se3: [1.5, 0.0, 0.4, 1.0, 0.0, 0.0, 0.0],
            },
        );
    }

    #[test]
    fn boxes_and_the_ego_are_where_the_log_says() {
        let folder = tempfile::tempdir().unwrap();
        log(folder.path());
        let file = folder.path().join("box_detections_se3.arrow");
        let scenario = crate::dispatch::open(&file).unwrap();
        assert_eq!(scenario.header.time_step_size, 0.1);
        let ego = &scenario.recorded_ego.as_ref().unwrap().obstacle;
        let kinds: Vec<ObstacleType> = scenario.obstacles.iter().map(|o| o.kind).collect();
        assert_eq!(kinds, [ObstacleType::Car, ObstacleType::Pedestrian]);
        let last = |of: &nearmiss_scene::scenario::Obstacle| {
            let state = of.states().last().unwrap();
            let place = state.point().unwrap();
            let value =
                |q: &Option<nearmiss_scene::scenario::Quantity>| q.as_ref().unwrap().middle();
            (
                place.x,
                place.y,
                value(&state.orientation),
                value(&state.velocity),
            )
        };
        let near = |a: (f64, f64, f64, f64), b: (f64, f64, f64, f64)| {
            let off = [a.0 - b.0, a.1 - b.1, a.2 - b.2, a.3 - b.3];
            assert!(off.iter().all(|off| off.abs() < 1e-6), "{a:?} is not {b:?}");
        };
        near(last(ego), (3.5, 0.0, 0.0, 10.0));
        near(
            last(&scenario.obstacles[0]),
            (30.0, 7.0, -std::f64::consts::FRAC_PI_2, 5.0),
        );
        near(last(&scenario.obstacles[1]), (12.0, 4.0, 0.0, 0.0));
    }

    #[test]
    fn damaged_logs_say_so() {
        let folder = tempfile::tempdir().unwrap();
        log(folder.path());
        let file = folder.path().join("box_detections_se3.arrow");
        let whole = std::fs::read(&file).unwrap();
        for length in [8, 20, 200, whole.len() / 2] {
            std::fs::write(&file, &whole[..length]).unwrap();
            let error = crate::dispatch::open(&file).unwrap_err().to_string();
            assert!(error.contains("no log of py123d"), "{length}: {error}");
        }
        std::fs::write(&file, &whole).unwrap();
        std::fs::remove_file(folder.path().join("ego_state_se3.arrow")).unwrap();
        let scenario = crate::dispatch::open(&file).unwrap();
        assert!(scenario.recorded_ego.is_none());
        let said = |d: &nearmiss_scene::scenario::Diagnostic| {
            d.message.contains("the vehicle that recorded is not in it")
        };
        assert!(scenario.diagnostics.iter().any(said));
    }
}
