//! Opening a scenario, from its bytes to what the workbench shows, beside the bare tokenizer over the same bytes.
//!
//! The figures to read are ratios: `read` and `open` over `tokens`. Scenarios: the bundled ones.

use std::hint::black_box;
use std::path::Path;
use std::sync::Arc;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use nearmiss::formats::{commonroad, read_ego};
use nearmiss::judge::judge;
use nearmiss::metrics::{Headline, Thresholds};
use nearmiss::scenario::{Scene, Window};
use nearmiss::verdict::Task;
use quick_xml::Reader;
use quick_xml::events::Event;

/// The bundled scenario with the most bytes, and its ego.
fn largest() -> (Vec<u8>, Vec<u8>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios");
    let files = std::fs::read_dir(&folder)
        .expect("the folder of scenarios")
        .flatten()
        .map(|e| e.path());
    let xml = files.filter(|p| p.extension().is_some_and(|x| x == "xml"));
    let path = xml
        .max_by_key(|p| p.metadata().map_or(0, |m| m.len()))
        .expect("a scenario");
    let ego = path.with_extension("ego_trajectory.csv");
    (
        std::fs::read(path).expect("readable"),
        std::fs::read(ego).expect("readable"),
    )
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

fn open(xml: &[u8], csv: &[u8]) -> usize {
    let scenario = Arc::new(commonroad::read(xml, "bench").expect("a scenario"));
    let ego = read_ego(csv, "bench", &scenario, None).expect("an ego");
    let scene = Scene::new(scenario, ego);
    let headline = Headline::compute(&scene, Thresholds::shipped());
    let window = Window::ending_at(&scene, i64::MAX, 1);
    let judgement = judge(&scene, Task::Collision, &window);
    judgement.reasoning.len() + usize::from(headline.collides())
}

fn opening(criterion: &mut Criterion) {
    let (xml, csv) = largest();
    let mut group = criterion.benchmark_group("opening");
    group.throughput(Throughput::Bytes(xml.len() as u64));
    group.bench_function("tokens", |b| b.iter(|| tokens(black_box(&xml))));
    group.bench_function("read", |b| {
        b.iter(|| commonroad::read(black_box(&xml), "bench"))
    });
    group.bench_function("open", |b| {
        b.iter(|| open(black_box(&xml), black_box(&csv)))
    });
    group.finish();
}

criterion_group!(benches, opening);
criterion_main!(benches);
