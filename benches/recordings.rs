//! Opening recordings of other data sets, each written here as its description says, and windows of a long one.
//!
//! `read` is a recording from its files, `window` one of a recording that was read before: the figure to read is their
//! ratio. `list` ranks the windows. Real samples of Waymo and Argoverse are those in the folder that NEARMISS_SHARED names
//! (or ../shared). `official_loaders.py` compares with the loaders that the data sets come with.

use std::fmt::Write;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nearmiss::formats::Entry;
use nearmiss::workflow::find;

/// Length of the long recordings, seconds.
const SECONDS: u32 = 120;

/// highD: a vehicle enters each of two lanes every three seconds and takes 14 s.
fn highd(folder: &Path) -> PathBuf {
    let mut tracks = String::from("frame,id,x,y,width,height,xVelocity,yVelocity,laneId\n");
    let mut meta = String::from("id,width,height,initialFrame,finalFrame,class,drivingDirection\n");
    for id in 1..=2 * SECONDS / 3 {
        let first = id / 2 * 75 + 1;
        let last = (first + 350).min(SECONDS * 25);
        let lane = id % 2;
        let speed = 28.0 + f64::from(id % 5);
        for frame in first..=last {
            let x = f64::from(frame - first) / 25.0 * speed;
            let y = 21.0 + 4.0 * f64::from(lane);
            let _ = writeln!(
                tracks,
                "{frame},{id},{x:.2},{y},4.5,1.9,{speed},0.00,{}",
                5 + lane
            );
        }
        let _ = writeln!(meta, "{id},4.5,1.9,{first},{last},Car,2");
    }
    let about = "id,frameRate,locationId,speedLimit,upperLaneMarkings,lowerLaneMarkings\n1,25,2,36.11,8.5;12.5;16.5,20;24;28\n";
    for (end, text) in [
        ("tracks", tracks),
        ("tracksMeta", meta),
        ("recordingMeta", about.into()),
    ] {
        std::fs::write(folder.join(format!("01_{end}.csv")), text).expect("written");
    }
    folder.join("01_tracks.csv")
}

/// SUMO: ten vehicles behind each other.
fn fcd(folder: &Path) -> PathBuf {
    let mut xml = String::from("<fcd-export>\n");
    for step in 0..SECONDS * 10 {
        let t = f64::from(step) / 10.0;
        let _ = writeln!(xml, "<timestep time=\"{t:.1}\">");
        for id in 1..=10 {
            let x = 10.0 * t - 25.0 * f64::from(id);
            let _ = writeln!(
                xml,
                "<vehicle id=\"{id}\" x=\"{x:.2}\" y=\"0.00\" angle=\"90.00\" type=\"DEFAULT_VEHTYPE\" speed=\"10.00\" pos=\"1.00\" lane=\"a_0\" slope=\"0.00\"/>"
            );
        }
        xml.push_str("</timestep>\n");
    }
    let path = folder.join("fcd.xml");
    std::fs::write(&path, xml + "</fcd-export>\n").expect("written");
    path
}

/// Says that a file changed so long ago: what changed just now is not kept.
fn changed(path: &Path, ago: Duration) {
    let file = std::fs::File::options()
        .write(true)
        .open(path)
        .expect("open");
    file.set_modified(SystemTime::now() - ago).expect("set");
}

/// A sample in the shared folder.
fn sample(below: &str) -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let shared = std::env::var_os("NEARMISS_SHARED").map_or(root, PathBuf::from);
    let folder = shared.join("data").join(below);
    let found = find(std::slice::from_ref(&folder)).ok();
    let path = found.and_then(|found| match &found.entries.first()?.place {
        nearmiss::formats::EntryLocation::File(path) => Some(path.clone()),
        nearmiss::formats::EntryLocation::Bundled(_) => None,
    });
    if path.is_none() {
        println!("skipped: no recording in {}", folder.display());
    }
    path
}

fn recordings(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("recordings");
    group.sample_size(20);
    for (name, below) in [("waymo", "waymo-motion"), ("argoverse", "argoverse2")] {
        let Some(path) = sample(below) else { continue };
        let entry = Entry::of_file(&path);
        let bytes = entry.file().and_then(|file| file.metadata().ok());
        group.throughput(Throughput::Bytes(bytes.map_or(0, |m| m.len())));
        group.bench_function(format!("{name}/read"), |b| {
            b.iter(|| {
                black_box(&entry)
                    .read()
                    .expect("a scenario")
                    .obstacles
                    .len()
            })
        });
    }
    let folder = tempfile::tempdir().expect("a folder");
    let own = |name: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir(&path).expect("made");
        path
    };
    for (name, path) in [("highd", highd(&own("highd"))), ("sumo", fcd(&own("sumo")))] {
        let window = PathBuf::from(format!("{}#track=5@10.0s", path.display()));
        let entry = Entry::of_file(&window);
        let open = || entry.read().expect("a window").obstacles.len();
        group.throughput(Throughput::Bytes(path.metadata().map_or(0, |m| m.len())));
        group.bench_function(format!("{name}/read"), |b| {
            b.iter_batched(
                || changed(&path, Duration::ZERO),
                |()| open(),
                criterion::BatchSize::PerIteration,
            );
        });
        changed(&path, Duration::from_secs(3600));
        // The files beside it were written just now, too.
        for file in path
            .parent()
            .into_iter()
            .flat_map(|f| f.read_dir().expect("read"))
            .flatten()
        {
            changed(&file.path(), Duration::from_secs(3600));
        }
        open();
        group.bench_function(format!("{name}/window"), |b| b.iter(open));
        let paths = [path.clone()];
        group.bench_function(format!("{name}/list"), |b| {
            b.iter(|| find(black_box(&paths)).expect("windows").entries.len());
        });
    }
    group.finish();
}

criterion_group!(benches, recordings);
criterion_main!(benches);
