//! Reading whole scenarios beside the bare tokenizer over the same bytes, and listing a folder of them.
//!
//! The figures to read are ratios: `model` over `tokens` (both one thread, all files once), and
//! `folder/facts` over `folder/bytes` (211 files, all cores). Scenarios: those in the folder that
//! NEARMISS_SHARED names (or ../shared), the bundled ones where there is none.

use std::hint::black_box;
use std::path::{Path, PathBuf};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nearmiss::formats::{Entry, EntryLocation, commonroad, find};
use nearmiss::metrics::{Headline, Thresholds};
use nearmiss::scenario::Scene;
use quick_xml::Reader;
use quick_xml::events::Event;
use rayon::prelude::*;

/// The scenarios to measure with.
fn entries() -> Vec<Entry> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let shared = std::env::var_os("NEARMISS_SHARED").map_or(root.join("../shared"), PathBuf::from);
    let published = shared.join("data/from-words-to-collisions");
    let folder = if published.is_dir() {
        published
    } else {
        root.join("scenarios")
    };
    find(&[folder]).expect("scenarios").entries
}

fn bytes_of(entry: &Entry) -> Vec<u8> {
    match &entry.place {
        EntryLocation::File(path) => std::fs::read(path).expect("readable"),
        EntryLocation::Bundled(_) => unreachable!("found in a folder"),
    }
}

/// Every event, and every text that is a number read as one.
fn tokens(bytes: &[u8]) -> f64 {
    let text = std::str::from_utf8(bytes).expect("UTF-8");
    let mut reader = Reader::from_str(text);
    let mut sum = 0.0;
    loop {
        match reader.read_event().expect("well-formed") {
            Event::Eof => return sum,
            Event::Text(text) => sum += text.into_inner().trim().parse::<f64>().unwrap_or(0.0),
            _ => {}
        }
    }
}

fn reading(criterion: &mut Criterion) {
    let files: Vec<Vec<u8>> = entries().iter().map(bytes_of).collect();
    let total: usize = files.iter().map(Vec::len).sum();
    println!("{} files, {total} bytes", files.len());
    let mut group = criterion.benchmark_group("reading");
    group.throughput(Throughput::Bytes(total as u64));
    group.sample_size(20);
    group.bench_function("tokens", |b| {
        b.iter(|| files.iter().map(|f| tokens(black_box(f))).sum::<f64>())
    });
    group.bench_function("model", |b| {
        b.iter(|| {
            let read = |f: &Vec<u8>| commonroad::read(black_box(f), "bench").expect("a scenario");
            files.iter().map(|f| read(f).obstacles.len()).sum::<usize>()
        })
    });
    group.finish();
}

/// What the list of scenarios shows of one.
fn facts(entry: &Entry) -> Option<Headline> {
    let scenario = entry.read().expect("a scenario");
    let ego = entry.recorded_ego(&scenario).expect("readable")?;
    let scene = Scene::new(scenario, ego);
    Some(Headline::compute(&scene, Thresholds::shipped()))
}

fn folder(criterion: &mut Criterion) {
    let all = entries();
    let folder: Vec<&Entry> = all.iter().cycle().take(211).collect();
    let mut group = criterion.benchmark_group("folder");
    group.sample_size(10);
    group.bench_function("bytes", |b| {
        b.iter(|| folder.par_iter().map(|e| bytes_of(e).len()).sum::<usize>())
    });
    group.bench_function("facts", |b| {
        b.iter(|| folder.par_iter().filter_map(|e| facts(e)).count())
    });
    group.finish();
}

criterion_group!(benches, reading, folder);
criterion_main!(benches);
