//! Unpacking: the answers of a bundle go into the store, its files into a folder; nothing before all of it was checked
//! and all files were written beside the folder.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use super::BundleError;
use super::archive::{self, hash};
use super::manifest::{BATCH, Manifest, Member, RATINGS, TEMPLATES, is_file};
use super::placement::Placement;
use super::staged::Staged;
use nearmiss_ask::prompts::Library;
use nearmiss_base::system;
use nearmiss_store::{Batch, BatchId, MergeCounts, Rating, Record, RecordIntake, Store};
use nearmiss_study::evaluation::batch::Spec;

/// Bytes of the longest line; an answer has some ten thousand.
const LONGEST: u64 = 64 << 20;

/// What is unpacked.
pub struct UnpackRequest<'a> {
    /// The bundle.
    pub file: &'a Path,
    /// The folder for its files, absolute; it is made where there is none.
    pub into: &'a Path,
    /// The store for its answers.
    pub store: &'a Store,
    /// The user's templates: those of the bundle are used for its batch where they differ.
    pub library: &'a Library,
}

/// What was unpacked.
#[derive(Debug, Clone, PartialEq)]
pub struct Unpacked {
    /// What is in the bundle.
    pub manifest: Manifest,
    /// Its batch in this store.
    pub batch: BatchId,
    /// What is new in the store.
    pub counts: MergeCounts,
    /// Ratings that are new.
    pub ratings: usize,
    /// Files that were written.
    pub written: usize,
    /// Files that were there already.
    pub kept: usize,
}

/// What the first reading found.
struct Checked {
    batch: Option<Batch>,
    templates: BTreeMap<String, String>,
    /// Files that are there already.
    there: usize,
    /// The others.
    staged: Staged,
}

/// Unpacks a bundle. A second time it changes nothing.
///
/// # Errors
/// See [`BundleError`]. Nothing is changed then, unless it is the store that cannot be written: unpacking again completes
/// it.
pub fn unpack(request: &UnpackRequest<'_>) -> Result<Unpacked, BundleError> {
    let mut checked = Checked {
        batch: None,
        templates: BTreeMap::new(),
        there: 0,
        staged: Staged::begin(request.into)?,
    };
    let manifest = archive::read(request.file, &mut |_, member, content| {
        check(request, &mut checked, member, content)
    })?;
    let damaged = |why: String| BundleError::Damaged {
        file: request.file.display().to_string(),
        why,
    };
    let Some(batch) = checked.batch else {
        return Err(damaged("it has no batch".into()));
    };
    let spec = Spec::from_json(&batch.spec).map_err(|error| damaged(error.to_string()))?;
    let ours = same(request.store, &batch, &spec)?;
    let place = Placement::new(request, &manifest, &spec, ours.as_ref())?;
    let ours = ours.map(|(id, _)| id);
    let spec = place.spec(request, spec, &checked.templates);
    let theirs = Batch {
        spec: spec.to_json(),
        ..batch
    };
    let written = checked.staged.place(request.into)?;
    let mut intake = RecordIntake::new(request.store);
    let (mut batch, mut ratings) = (None, Vec::new());
    archive::read(request.file, &mut |_, member, content| {
        match member.name.as_str() {
            BATCH => lines(content, &mut |line| {
                let bytes = line.len();
                match record(line)? {
                    Record::Batch(_) => {
                        batch = Some(intake.intake.batch_as(&theirs, ours)?);
                    }
                    Record::Question(of, mut item) => {
                        place.item(&mut item.asked.path);
                        intake.take(Record::Question(of, item), bytes)?;
                    }
                    other @ (Record::Run(_) | Record::Image(_)) => intake.take(other, bytes)?,
                }
                Ok(())
            })?,
            RATINGS => lines(content, &mut |line| {
                ratings.push(rating(line)?);
                Ok(())
            })?,
            _ => {}
        }
        Ok(())
    })?;
    let intake = intake.finish()?;
    let mut new = 0;
    for rating in ratings {
        new += usize::from(request.store.take_rating(rating, &intake)?);
    }
    let batch = batch.ok_or_else(|| damaged("it has changed while it was read".into()))?;
    Ok(Unpacked {
        manifest,
        batch,
        counts: intake.counts(),
        ratings: new,
        written,
        kept: checked.there,
    })
}

/// The answers of a bundle in a store of their own, which is gone with the program.
///
/// # Errors
/// See [`BundleError`].
pub fn stored_bundle(file: &Path) -> Result<(Store, BatchId), BundleError> {
    let store = Store::in_memory()?;
    let mut intake = RecordIntake::new(&store);
    let mut batch = None;
    archive::read(file, &mut |_, member, content| {
        if member.name != BATCH {
            return Ok(());
        }
        lines(content, &mut |line| {
            let record = record(line)?;
            if let Record::Batch(theirs) = &record {
                batch = Some(intake.intake.batch_as(theirs, None)?);
                return Ok(());
            }
            Ok(intake.take(record, line.len())?)
        })
    })?;
    intake.finish()?;
    match batch {
        Some(batch) => Ok((store, batch)),
        None => Err(BundleError::NoBundle(file.display().to_string())),
    }
}

/// Checks a member, and writes it beside the folder where it is a file.
fn check(
    request: &UnpackRequest<'_>,
    checked: &mut Checked,
    member: &Member,
    content: &mut dyn Read,
) -> Result<(), BundleError> {
    let name = member.name.as_str();
    if name == BATCH {
        let mut id = None;
        return lines(content, &mut |line| {
            match record(line)? {
                Record::Batch(batch) if id.is_none() => {
                    id = Some(batch.id);
                    checked.batch = Some(*batch);
                }
                Record::Question(of, _) if Some(of) == id => {}
                Record::Run(_) | Record::Image(_) if id.is_some() => {}
                _ => return Err(BundleError::Batch("a line of another batch".into())),
            }
            Ok(())
        });
    }
    if name == RATINGS {
        return lines(content, &mut |line| rating(line).map(drop));
    }
    let mut path = request.into.join(name);
    if path.symlink_metadata().is_ok() {
        let there = system::read_file(&path, system::LARGEST);
        if there.is_ok_and(|bytes| hash(&bytes) == member.sha256) {
            checked.there += 1
        } else {
            return Err(BundleError::InTheWay(path));
        }
    } else {
        checked.staged.add(name, content)?;
        path = checked.staged.path(name);
    }
    if let Some(file) = name.strip_prefix(TEMPLATES) {
        let text = system::read_text(&path, system::LARGEST_TEXT);
        let wrong = |why| BundleError::Batch(format!("{name}: {}", system::error_text(&why)));
        checked.templates.insert(file.into(), text.map_err(wrong)?);
    }
    Ok(())
}

/// Each line, without its end.
fn lines(
    content: &mut dyn Read,
    each: &mut dyn FnMut(&str) -> Result<(), BundleError>,
) -> Result<(), BundleError> {
    let mut content = BufReader::new(content);
    let mut line = Vec::new();
    loop {
        line.clear();
        let read = (&mut content)
            .take(LONGEST)
            .read_until(b'\n', &mut line)
            .map_err(|source| BundleError::Io {
                file: BATCH.into(),
                source,
            })?;
        if read == 0 {
            return Ok(());
        }
        let text = std::str::from_utf8(&line).ok();
        let text = text
            .and_then(|text| text.strip_suffix('\n'))
            .ok_or_else(|| BundleError::Batch("a line that is no text, or too long".into()))?;
        each(text)?;
    }
}

fn record(line: &str) -> Result<Record, BundleError> {
    Record::from_line(line).map_err(|error| BundleError::Batch(format!("{BATCH}: {error}")))
}

fn rating(line: &str) -> Result<Rating, BundleError> {
    Rating::from_record(line).map_err(|error| BundleError::Batch(format!("{RATINGS}: {error}")))
}

/// The batch here that was packed, or unpacked before: begun at the same time, about the same. Of a part also the one in
/// which the same is asked, such as another part of it.
fn same(
    store: &Store,
    theirs: &Batch,
    spec: &Spec,
) -> Result<Option<(BatchId, Spec)>, BundleError> {
    let mut of_parts = None;
    // The newest batch comes first.
    for (batch, _) in store.batches()? {
        let Ok(ours) = Spec::from_json(&batch.spec) else {
            continue;
        };
        let portable = ours.portable();
        let about = |spec: &Spec| {
            (
                spec.experiment.scenarios.clone(),
                spec.experiment.tasks.clone(),
            )
        };
        if batch.created_ms == theirs.created_ms
            && about(&portable) == about(spec)
            && portable.templates == spec.templates
        {
            return Ok(Some((batch.id, ours)));
        }
        if theirs.shard.is_some() && without_texts(portable) == without_texts(spec.clone()) {
            of_parts = Some((batch.id, ours));
        }
    }
    Ok(of_parts)
}

/// What is asked, with templates by their hashes alone.
fn without_texts(mut spec: Spec) -> String {
    spec.drafts.clear();
    spec.to_json()
}

impl Manifest {
    /// The files that are written into a folder.
    pub fn files(&self) -> impl Iterator<Item = &Member> {
        self.members.iter().filter(|member| is_file(&member.name))
    }
}
