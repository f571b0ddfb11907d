//! nuScenes: scenes of 20 s in tables of JSON, with two annotated key frames a second. `scene.json` is the recording.
//!
//! The ego is the vehicle that recorded, whose rear axle the data set tells the places of.

mod tables;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::geometry::Point;
use nearmiss_scene::scenario::{ObstacleType, Scenario};

use super::assembly::{TrackState, kind_by_class, median, signed_speed, yaw};
use super::tracks::table::{Decided, Recorded, Track};
use super::tracks::{AboutTable, Table, cached};
use super::{Leftovers, Report};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::dispatch::{Address, Applies, Format, Parts};
use tables::{Annotation, Category, EgoPose, Instance, Sample, SampleData, Scene, Token, each};

/// The format.
pub struct NuScenes;

/// The tables that are read.
const FILES: [&str; 7] = [
    "scene.json",
    "sample.json",
    "category.json",
    "instance.json",
    "sample_annotation.json",
    "sample_data.json",
    "ego_pose.json",
];

/// Keys of every row of `scene.json`.
const KEYS: [&str; 3] = ["\"log_token\"", "\"first_sample_token\"", "\"nbr_samples\""];

impl Format for NuScenes {
    fn recognises(&self, path: &Path, head: &[u8]) -> bool {
        let is_named = path.file_name().is_some_and(|name| name == FILES[0]);
        let text = String::from_utf8_lossy(head);
        is_named && text.trim_start().starts_with('[') && KEYS.iter().all(|key| text.contains(key))
    }

    fn applies(&self, _: &Path, _: &[u8]) -> Applies {
        Applies::Map
    }

    fn parts(&self, path: &Path) -> Result<Parts, ReadError> {
        let mut names = Vec::new();
        each(path, FILES[0], |scene: Scene| names.push(scene.name))?;
        Ok(Parts::Named(names))
    }

    fn open(&self, address: &Address) -> Result<Scenario, ReadError> {
        read(&address.file)?.open_at(address)
    }
}

/// Half a second: key frames are annotated twice a second.
const TIME_STEP: f64 = 0.5;

/// Boxes farther apart in time say nothing of the speed between them, seconds.
const LONGEST: f64 = 1.5;

/// The vehicle that records, a Renault Zoe: length and width, and how far its middle is before its rear axle, metres.
const EGO: (f64, f64) = (4.084, 1.730);
const AHEAD: f64 = 1.385;

/// The name of its track.
const RECORDER: &str = "ego";

/// All scenes of a data set: one after the other would read every table for each.
fn read(scenes: &Path) -> Result<Arc<Table>, ReadError> {
    cached(&paths(&files(scenes)), || {
        let report = Report::about(scenes.display().to_string());
        let set = DataSet::read(scenes)?;
        set.table(scenes, report)
    })
}

/// The tables beside that of the scenes.
fn files(scenes: &Path) -> [PathBuf; 7] {
    FILES.map(|name| scenes.with_file_name(name))
}

fn paths(files: &[PathBuf; 7]) -> [&Path; 7] {
    files.each_ref().map(PathBuf::as_path)
}

/// What a category means.
fn kind(category: &str) -> ObstacleType {
    match category {
        "vehicle.construction" => ObstacleType::Truck,
        "static_object.bicycle_rack" => ObstacleType::Unknown,
        name if name.starts_with("vehicle.emergency") => ObstacleType::PriorityVehicle,
        name => kind_by_class(name),
    }
}

/// A key frame: its scene, and when it is.
#[derive(Clone, Copy)]
struct Frame {
    scene: u32,
    /// Within the scene.
    step: u32,
    /// Microseconds.
    time: i64,
}

/// A box of an object, or of the vehicle that records.
#[derive(Clone, Copy)]
struct Seen {
    step: u32,
    time: i64,
    position: Point,
    heading: f64,
}

#[derive(Default)]
struct Object {
    scene: u32,
    kind: Option<ObstacleType>,
    /// Lengths and widths of its boxes, metres.
    sizes: Vec<(f32, f32)>,
    seen: Vec<Seen>,
}

struct DataSet {
    scenes: Vec<Scene>,
    /// By instance, in the order of their tokens, so that all readings number them alike.
    objects: BTreeMap<Token, Object>,
    /// By scene.
    egos: Vec<Vec<Seen>>,
    /// By how much key frames are off the steps at most, seconds.
    off: f64,
    /// Annotations of frames or objects that are not there.
    lost: usize,
}

impl DataSet {
    fn read(path: &Path) -> Result<Self, ReadError> {
        let mut scenes = Vec::new();
        each(path, FILES[0], |scene: Scene| scenes.push(scene))?;
        let (frames, off) = frames(path, &scenes)?;
        let mut set = Self {
            egos: vec![Vec::new(); scenes.len()],
            scenes,
            objects: BTreeMap::new(),
            off,
            lost: 0,
        };
        set.read_objects(path, &frames)?;
        set.read_egos(path, &frames)?;
        Ok(set)
    }

    fn read_objects(
        &mut self,
        path: &Path,
        frames: &HashMap<Token, Frame>,
    ) -> Result<(), ReadError> {
        let mut kinds = HashMap::new();
        each(path, FILES[2], |category: Category| {
            kinds.insert(category.token, kind(&category.name));
        })?;
        let objects = &mut self.objects;
        each(path, FILES[3], |instance: Instance| {
            let object = objects.entry(instance.token).or_default();
            object.kind = kinds.get(&instance.category_token).copied();
        })?;
        let mut lost = 0;
        each(path, FILES[4], |row: Annotation| {
            let object = self.objects.get_mut(&row.instance_token);
            let (Some(frame), Some(object)) = (frames.get(&row.sample_token), object) else {
                lost += 1;
                return;
            };
            object.scene = frame.scene;
            let [width, length, _] = row.size;
            object.sizes.push((length as f32, width as f32));
            object.seen.push(Seen {
                step: frame.step,
                time: frame.time,
                position: Point::new(row.translation[0], row.translation[1]),
                heading: yaw(row.rotation),
            });
        })?;
        self.lost = lost;
        Ok(())
    }

    /// The vehicle that records, at each key frame where it was when the sensor nearest in time saw that.
    fn read_egos(&mut self, path: &Path, frames: &HashMap<Token, Frame>) -> Result<(), ReadError> {
        let mut nearest: HashMap<Token, (i64, Token)> = HashMap::with_capacity(frames.len());
        each(path, FILES[5], |row: SampleData| {
            let Some(frame) = frames.get(&row.sample_token).filter(|_| row.is_key_frame) else {
                return;
            };
            let off = (row.timestamp - frame.time).abs();
            let known = nearest
                .entry(row.sample_token)
                .or_insert((i64::MAX, row.ego_pose_token));
            if off < known.0 {
                *known = (off, row.ego_pose_token);
            }
        })?;
        let mut of_pose: HashMap<Token, Vec<Frame>> = HashMap::with_capacity(nearest.len());
        for (sample, (_, pose)) in nearest {
            of_pose.entry(pose).or_default().extend(frames.get(&sample));
        }
        each(path, FILES[6], |row: EgoPose| {
            for frame in of_pose.get(&row.token).into_iter().flatten() {
                let heading = yaw(row.rotation);
                let (sin, cos) = heading.sin_cos();
                self.egos[frame.scene as usize].push(Seen {
                    step: frame.step,
                    time: frame.time,
                    position: Point::new(
                        row.translation[0] + AHEAD * cos,
                        row.translation[1] + AHEAD * sin,
                    ),
                    heading,
                });
            }
        })
    }

    fn table(self, path: &Path, report: Report) -> Result<Table, ReadError> {
        if self.off > 0.01 {
            report.note(format!(
                "key frames are up to {:.3} s off steps of {TIME_STEP} s; taken as at the nearest one, speeds by their own times",
                self.off
            ));
        }
        if self.lost > 0 {
            report.at("").warn(format!(
                "{} annotations are of no key frame or no object; left out",
                self.lost
            ));
        }
        report.note(format!(
            "the ego is the vehicle that recorded, a Renault Zoe of {} m × {} m, {AHEAD} m ahead of its rear axle, which the data set tells the places of",
            EGO.0, EGO.1
        ));
        let mut tracks = Vec::with_capacity(self.objects.len() + self.egos.len());
        for (scene, seen) in (0..).zip(self.egos) {
            let ego = Object {
                scene,
                seen,
                kind: Some(ObstacleType::Car),
                sizes: Vec::new(),
            };
            tracks.extend(track(&self.scenes, RECORDER.to_string(), ego, &report)?);
        }
        for (token, object) in self.objects {
            tracks.extend(track(&self.scenes, token.to_string(), object, &report)?);
        }
        let recorded = Recorded {
            tracks,
            start: 0.0,
            time_step: TIME_STEP,
            plane: None,
            diagnostics: report.into_diagnostics(),
            decided: Decided::default(),
        };
        let about = AboutTable {
            source: "nuScenes",
            tags: &["urban"],
            how: String::new(),
            notes: Vec::new(),
        };
        Table::new(
            recorded,
            about,
            None,
            &paths(&files(path)),
            Leftovers::default(),
        )
    }
}

/// The key frames by their tokens, and by how much they are off the steps at most, seconds.
fn frames(path: &Path, scenes: &[Scene]) -> Result<(HashMap<Token, Frame>, f64), ReadError> {
    let numbered = (0..).zip(scenes);
    let of_scene: HashMap<Token, u32> = numbered
        .map(|(place, scene)| (scene.token, place))
        .collect();
    let mut samples: Vec<Vec<(i64, Token)>> = vec![Vec::new(); scenes.len()];
    each(path, FILES[1], |sample: Sample| {
        if let Some(place) = of_scene.get(&sample.scene_token) {
            samples[*place as usize].push((sample.timestamp, sample.token));
        }
    })?;
    let (mut frames, mut off) = (HashMap::new(), 0.0_f64);
    for (scene, mut samples) in (0..).zip(samples) {
        samples.sort_unstable();
        let Some((first, _)) = samples.first().copied() else {
            continue;
        };
        let mut next = 0;
        for (time, token) in samples {
            let steps = (time - first) as f64 / 1e6 / TIME_STEP;
            let step = (steps.round() as u32).max(next);
            next = step + 1;
            off = off.max((steps - f64::from(step)).abs() * TIME_STEP);
            frames.insert(token, Frame { scene, step, time });
        }
    }
    Ok((frames, off))
}

/// An object as a track; nothing where it is never seen.
fn track(
    scenes: &[Scene],
    name: String,
    mut object: Object,
    report: &Report,
) -> Result<Option<Track>, ReadError> {
    object.seen.sort_by_key(|seen| seen.step);
    object.seen.dedup_by_key(|seen| seen.step);
    let mut states = Vec::with_capacity(object.seen.len());
    for (i, seen) in object.seen.iter().enumerate() {
        let at = report.at(format!("track `{name}`"));
        let position = at.point(seen.position.x, seen.position.y)?;
        let before = &object.seen[i.saturating_sub(1)];
        let after = &object.seen[(i + 1).min(object.seen.len() - 1)];
        let time = (after.time - before.time) as f64 / 1e6;
        let moved = after.position - before.position;
        let heading = at.number(seen.heading)?;
        states.push(TrackState {
            step: i64::from(seen.step),
            position,
            heading,
            velocity: (time > 0.0 && time <= LONGEST)
                .then(|| signed_speed(heading, moved.x / time, moved.y / time)),
            acceleration: None,
        });
    }
    if states.is_empty() {
        return Ok(None);
    }
    let size = if object.sizes.is_empty() {
        EGO
    } else {
        let of = |pick: fn(&(f32, f32)) -> f32| {
            median(
                object
                    .sizes
                    .iter()
                    .map(|size| f64::from(pick(size)))
                    .collect(),
            )
        };
        (of(|size| size.0), of(|size| size.1))
    };
    Ok(Some(Track {
        is_ego: name == RECORDER,
        name,
        scenario: scenes[object.scene as usize].name.clone(),
        kind: object.kind.unwrap_or(ObstacleType::Unknown),
        size,
        states,
    }))
}
