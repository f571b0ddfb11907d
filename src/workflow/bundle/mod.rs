//! Bundles: an experiment with its answers as one file, which gives the same tables on every machine.
//!
//! [`pack`] reads a batch and writes the file: paths become names, and what reports would read off the scenarios (the
//! built-in judge's verdicts, ids of renumbered obstacles, counts of claims) is recorded. [`unpack`] checks the whole file
//! before any of it is in its place. [`read_manifest`] says what is in it.

mod manifest;
mod pack;
mod unpack;

pub use manifest::{FORMAT as BUNDLE_FORMAT, Manifest, Member, PackedScenario};
pub use pack::{PackRequest, Packed, pack};
pub use unpack::{UnpackRequest, Unpacked, stored_bundle, unpack};

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use nearmiss_base::system::{self, SaveError, without_folders};
use nearmiss_formats::{Entry, bundled};
use nearmiss_scene::scenario::Transform;
use nearmiss_store::{
    Batch, ClaimCounts, Filter, Item, Run, RunId, RunState, SceneRecord, Store, StoreError,
    record_line,
};
use nearmiss_study::evaluation::batch::{Judgement, Spec, Variant, numbered};

use super::{count_claims, files_of_batches, is_unchecked};
use manifest::{BATCH, Hashed, safe};

/// Why a bundle cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum BundleError {
    /// The system refused.
    #[error("{file}: {}", system::error_text(source))]
    Io {
        /// Which file.
        file: String,
        /// What the system said.
        source: io::Error,
    },
    /// A file was not saved.
    #[error(transparent)]
    Save(#[from] SaveError),
    /// The store refused.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The file is something else.
    #[error("{0}: not a bundle of `nearmiss runs export`")]
    NoBundle(String),
    /// It is not what was packed.
    #[error("{file}: damaged or altered: {why}; nothing was unpacked")]
    Damaged {
        /// Which file.
        file: String,
        /// What is wrong.
        why: String,
    },
    /// A newer program wrote it.
    #[error(
        "{file}: the bundle has format {found}, and this version reads up to {}; update nearmiss",
        manifest::FORMAT
    )]
    Later {
        /// Which file.
        file: String,
        /// Its format.
        found: u32,
    },
    /// There is another file in the way.
    #[error("{0}: already there with other content; unpack into another folder (--into)")]
    InTheWay(PathBuf),
    /// The batch cannot be packed.
    #[error("{0}")]
    Batch(String),
}

impl BundleError {
    fn io(path: &Path, source: io::Error) -> Self {
        Self::Io {
            file: path.display().to_string(),
            source,
        }
    }
}

/// What is in a bundle, after every member was checked.
///
/// # Errors
/// It cannot be read, is no bundle, or not what was packed.
pub fn read_manifest(file: &Path) -> Result<Manifest, BundleError> {
    manifest::read(file, &mut |_, _, _| Ok(()))
}

/// The paths of a batch's scenarios, each with the one that it has in the bundle: different ones stay different.
fn portable_paths(spec: &Spec, items: &[Item]) -> BTreeMap<String, String> {
    let mut paths: BTreeMap<String, String> = BTreeMap::new();
    let mut taken = BTreeSet::new();
    for item in items {
        let path = &item.asked.path;
        if paths.contains_key(path) {
            continue;
        }
        let name = safe(&spec.portable_path(path));
        let mut unique = name.clone();
        let mut number = 2;
        while !taken.insert(unique.to_lowercase()) {
            unique = numbered(Path::new(&name), number).display().to_string();
            number += 1;
        }
        paths.insert(path.clone(), unique);
    }
    paths
}

/// The runs that were made for questions of a batch, by number.
fn numbers(store: &Store, batch: &Batch) -> Result<BTreeSet<RunId>, StoreError> {
    let filter = Filter {
        batch: Some(batch.id.to_string()),
        ..Filter::default()
    };
    let mut numbers: BTreeSet<RunId> = store.numbers(&filter)?.into_iter().collect();
    let of_questions = store.question_runs(batch.id, 0, None)?;
    numbers.extend(of_questions.into_values().flatten().map(|run| run.run));
    Ok(numbers)
}

/// What is written of a batch.
struct BatchLines<'a> {
    store: &'a Store,
    batch: &'a Batch,
    portable: &'a Spec,
    items: &'a [Item],
    paths: &'a BTreeMap<String, String>,
    judgements: &'a BTreeMap<u64, Judgement>,
    runs: &'a BTreeSet<RunId>,
}

impl BatchLines<'_> {
    /// Writes the lines into a file without a name; says how many runs they have.
    fn write(&self) -> Result<(Member, File, u64), BundleError> {
        let io = |source| BundleError::Io {
            file: BATCH.into(),
            source,
        };
        let file = tempfile::tempfile().map_err(io)?;
        let mut out = Hashed::new(BufWriter::new(file));
        let batch = Batch {
            spec: self.portable.to_json(),
            ..self.batch.clone()
        };
        write!(out, "{}", record_line(&batch.to_record())?).map_err(io)?;
        let claims = self.claims()?;
        let (mut runs, mut shown) = (0, BTreeSet::new());
        for number in self.runs {
            let Some(run) = self.store.run(*number)? else {
                continue;
            };
            if run.ending.state == RunState::Running {
                continue;
            }
            let run = self.portable(run, &claims);
            for hash in run.question.image_hashes() {
                let new = shown.insert(hash.clone()).then(|| self.store.image(&hash));
                if let Some(image) = new.transpose()?.flatten() {
                    write!(out, "{}", record_line(&image.to_record())?).map_err(io)?;
                }
            }
            write!(out, "{}", record_line(&run.to_record(false))?).map_err(io)?;
            runs += 1;
        }
        for item in self.items {
            let item = self.question(item)?;
            write!(out, "{}", record_line(&item.to_record(self.batch.id))?).map_err(io)?;
        }
        let member = Member {
            name: BATCH.into(),
            bytes: out.read,
            sha256: out.hex(),
        };
        let file = out.into_inner().into_inner();
        Ok((member, file.map_err(|e| io(e.into_error()))?, runs))
    }

    /// Claims that are counted only now, as a report would.
    fn claims(&self) -> Result<HashMap<RunId, ClaimCounts>, StoreError> {
        let mut outcomes = self.store.outcomes(&Filter::default())?;
        outcomes.retain(|one| self.runs.contains(&one.run));
        if !outcomes.iter().any(is_unchecked) {
            return Ok(HashMap::new());
        }
        let mut files = files_of_batches(self.store)?;
        files.extend(bundled());
        let counted = count_claims(self.store, &outcomes, &files, &|_, _| {})?;
        Ok(counted.into_iter().collect())
    }

    fn portable(&self, mut run: Run, claims: &HashMap<RunId, ClaimCounts>) -> Run {
        if let Some(counts) = claims.get(&run.id) {
            run.ending.claims = *counts;
        }
        // A batch of this number elsewhere is another one.
        let own = self.batch.id.to_string();
        run.question.batch = run.question.batch.filter(|name| *name == own);
        run.source = run.source.as_deref().map(without_folders);
        run.ending.error = run.ending.error.as_deref().map(without_folders);
        run
    }

    fn question(&self, item: &Item) -> Result<Item, BundleError> {
        let mut item = item.clone();
        let mut scene = item.asked.scene.take().unwrap_or_default();
        match self.judgements.get(&item.place) {
            Some(Ok(verdict)) => scene.reference = Some(verdict.clone()),
            Some(Err(why)) => scene.unjudged = Some(why.clone()),
            None => {}
        }
        let variant = Variant::from_item(&item.asked).map_err(BundleError::Batch)?;
        if let Some(change @ Transform::Renumber(_)) = variant.transform
            && scene.ids.is_empty()
            && let Ok(scenario) = Entry::of_argument(Path::new(&item.asked.path)).read()
            && item.asked.scenario_hash == Some(scenario.hash.to_string())
        {
            scene.ids = change.ids(&scenario);
        }
        item.asked.scene = (scene != SceneRecord::default()).then_some(scene);
        item.error = item.error.as_deref().map(without_folders);
        if let Some(path) = self.paths.get(&item.asked.path) {
            item.asked.path.clone_from(path);
        }
        Ok(item)
    }
}
