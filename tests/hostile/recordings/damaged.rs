//! 500 cuts and flips of the files of each format: a scenario or an error, and no panic.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use fastrand::Rng;
use nearmiss::formats::{Entry, Export, ExportedEgo, bundled, write_openscenario};

use super::{argoverse, levelx, nuplan_file, one_entry, sumo, tfrecord_file, waymo};

/// Files that are damaged one at a time, the first of which is opened.
fn damage(files: &[(&str, Vec<u8>)], open: &[&str], mend: impl Fn(usize, Vec<u8>) -> Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    let seed = std::env::var("NEARMISS_DAMAGE_SEED");
    let seed = seed.map_or(0, |seed| seed.parse().expect("a whole number"));
    let mut rng = Rng::with_seed(files.len() as u64 + 1000 * seed);
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let (mut read, mut refused) = (0, 0);
    for case in 0..500 {
        files.iter().for_each(|(name, bytes)| write(name, bytes));
        let which = rng.usize(..files.len());
        let (name, bytes) = &files[which];
        write(name, &mend(which, damaged(&mut rng, bytes)));
        for name in open {
            let begun = Instant::now();
            let path = folder.path().join(name);
            match Entry::of_file(Path::new(&path)).read() {
                Ok(_) => read += 1,
                Err(error) => {
                    assert!(!error.message.is_empty());
                    refused += 1;
                }
            }
            assert!(
                begun.elapsed().as_secs() < 20,
                "case {case} of {name} takes long"
            );
        }
    }
    println!("{}: {read} read, {refused} refused", open[0]);
    assert!(refused > 0);
}

fn damaged(rng: &mut Rng, bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    match rng.u8(..3) {
        0 => bytes.truncate(rng.usize(..bytes.len())),
        1 => {
            for _ in 0..rng.usize(1..8) {
                let at = rng.usize(..bytes.len());
                bytes[at] = rng.u8(..);
            }
        }
        _ => {
            let at = rng.usize(..bytes.len());
            bytes[at] ^= 1 << rng.u8(..8);
        }
    }
    bytes
}

fn as_it_is(_: usize, bytes: Vec<u8>) -> Vec<u8> {
    bytes
}

#[test]
fn waymo_files() {
    let file = tfrecord_file::file(&[waymo::scenario("a1"), waymo::scenario("b2")]);
    damage(
        &[("x.tfrecord", file)],
        &["x.tfrecord#a1", "x.tfrecord#2"],
        as_it_is,
    );
}

#[test]
fn waymo_records_whose_checksums_are_right() {
    let record = waymo::scenario("a1");
    damage(&[("x.tfrecord", record)], &["x.tfrecord"], |_, bytes| {
        tfrecord_file::file(&[bytes])
    });
}

#[test]
fn argoverse_files() {
    let map = argoverse::map().into_bytes();
    let files = [
        ("scenario_x.parquet", argoverse::table()),
        ("log_map_archive_x.json", map),
    ];
    damage(&files, &["scenario_x.parquet"], as_it_is);
}

#[test]
fn levelx_files() {
    let [tracks, meta, about] = levelx::highd(3).map(|(_, text)| text.into_bytes());
    let files = [
        ("01_tracks.csv", tracks),
        ("01_tracksMeta.csv", meta),
        ("01_recordingMeta.csv", about),
    ];
    damage(
        &files,
        &["01_tracks.csv#track=2@0.5s", "01_tracks.csv"],
        as_it_is,
    );
    let [tracks, meta, about] = levelx::ind().map(|(_, text)| text.into_bytes());
    let map = levelx::osm().into_bytes();
    let files = [
        ("07_tracks.csv", tracks),
        ("07_tracksMeta.csv", meta),
        ("07_recordingMeta.csv", about),
        ("07.osm", map),
    ];
    damage(&files, &["07_tracks.csv#track=0"], as_it_is);
}

#[test]
fn sumo_files() {
    let files = [
        ("fcd.xml", sumo::fcd(8).into_bytes()),
        ("cross.net.xml", sumo::NET.as_bytes().to_vec()),
        ("cross.rou.xml", sumo::ROUTES.as_bytes().to_vec()),
    ];
    damage(&files, &["fcd.xml", "fcd.xml#track=4@5.2s"], as_it_is);
}

/// A log of so many seconds, and its map.
fn nuplan(seconds: f64) -> [Vec<u8>; 2] {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let log = nuplan_file::Log {
        seconds,
        ..nuplan_file::Log::default()
    };
    nuplan_file::write_log(&path("x.db"), &log);
    nuplan_file::write_map(&path("map.gpkg"));
    ["x.db", "map.gpkg"].map(|name| std::fs::read(path(name)).unwrap())
}

#[test]
fn nuplan_files() {
    let [log, map] = nuplan(1.0);
    let files = [("x.db", log), ("map.gpkg", map)];
    damage(&files, &["x.db", "x.db#track=3@0.2s"], as_it_is);
}

/// Each kind of the one entry as it should be, packed.
fn seeds() -> Vec<Vec<u8>> {
    let texts = |all: &[&str]| all.iter().map(|t| t.as_bytes().to_vec()).collect();
    let [tracks, meta, about] = levelx::highd(3).map(|(_, text)| text);
    let [own_tracks, own_meta, own_about] = levelx::ind().map(|(_, text)| text);
    let entry = &bundled()[0];
    let scenario = entry.read().unwrap();
    let ego = entry.recorded_ego(&scenario).unwrap().unwrap();
    let exported = write_openscenario(&Export {
        scenario: &scenario,
        ego: ExportedEgo::Follows(&ego),
        road_file: "x.xodr",
        properties: &BTreeMap::new(),
        about: &[],
        varied: None,
    })
    .unwrap();
    let files: [Vec<Vec<u8>>; 8] = [
        vec![tfrecord_file::file(&[
            waymo::scenario("a1"),
            waymo::scenario("b2"),
        ])],
        vec![argoverse::table(), argoverse::map().into_bytes()],
        texts(&[&tracks, &meta, &about]),
        texts(&[&own_tracks, &own_meta, &own_about, &levelx::osm()]),
        texts(&[&sumo::fcd(8), sumo::NET, sumo::ROUTES]),
        vec![exported.scenario, exported.roads.clone()],
        vec![exported.roads],
        nuplan(0.5).to_vec(),
    ];
    let kinds = (0..).zip(&files);
    kinds
        .map(|(kind, files)| one_entry::packed(kind, files))
        .collect()
}

/// What the fuzz target does; `NEARMISS_FUZZ_SEEDS` names a folder that its first inputs are written to.
#[test]
fn every_kind_opens_through_the_one_entry() {
    let seeds = seeds();
    assert_eq!(seeds.len(), one_entry::KINDS.len());
    let folder = std::env::var_os("NEARMISS_FUZZ_SEEDS").map(PathBuf::from);
    let mut rng = Rng::with_seed(24);
    for (seed, names) in seeds.iter().zip(one_entry::KINDS) {
        assert!(one_entry::open(seed) > 0, "{names:?}");
        if let Some(folder) = &folder {
            std::fs::create_dir_all(folder).unwrap();
            std::fs::write(folder.join(names[0]).with_extension("seed"), seed).unwrap();
        }
        for _ in 0..40 {
            let mut bytes = damaged(&mut rng, seed);
            if let Some(kind) = bytes.first_mut() {
                *kind = seed[0];
            }
            one_entry::open(&bytes);
        }
    }
    assert_eq!(one_entry::open(b""), 0);
}
