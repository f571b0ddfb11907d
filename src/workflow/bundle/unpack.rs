//! Unpacking: the answers of a bundle go into the store, its files into a folder; nothing before all of it was checked.

use std::collections::{BTreeMap, HashMap};
use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};

use nearmiss_ask::prompts::Library;
use nearmiss_base::system::{self, Unfinished};
use nearmiss_store::{Batch, BatchId, MergeCounts, Rating, Record, RecordIntake, Store};
use nearmiss_study::evaluation::batch::{Spec, TruthSource};
use tempfile::TempDir;

use super::manifest::{
    BATCH, Manifest, Member, RATINGS, SCENARIOS, TEMPLATES, TRUTH, hash, is_file,
};
use super::pack::is_bundled;
use super::{BundleError, manifest, portable_paths};

/// Bytes of the longest line; an answer has some ten thousand.
const MAX_LINE_BYTES: u64 = 64 << 20;

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
    let manifest = manifest::read(request.file, &mut |_, member, content| {
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
    manifest::read(request.file, &mut |_, member, content| {
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
    manifest::read(file, &mut |_, member, content| {
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
            .take(MAX_LINE_BYTES)
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

/// Where the scenarios of a batch are on this machine.
pub(super) struct Placement {
    /// By path in the bundle, where the store has questions about them already.
    known: HashMap<String, String>,
    /// The folders and files of the batch here, by their names in the bundle.
    roots: Vec<(PathBuf, PathBuf)>,
    /// The files that the bundle holds, by their paths in it.
    files: BTreeMap<String, PathBuf>,
    has_truth: bool,
}

impl Placement {
    pub fn new(
        request: &UnpackRequest<'_>,
        manifest: &Manifest,
        spec: &Spec,
        ours: Option<&(BatchId, Spec)>,
    ) -> Result<Self, BundleError> {
        let (mut known, mut roots) = (HashMap::new(), Vec::new());
        if let Some((ours, spec)) = ours {
            let paths = portable_paths(spec, &request.store.items(*ours)?);
            known.extend(paths.into_iter().map(|(here, there)| (there, here)));
            roots.extend({
                let portable = spec.portable().experiment.scenarios.into_iter();
                portable.zip(spec.experiment.scenarios.clone())
            });
        }
        let included = manifest.scenarios.iter().filter(|one| one.included);
        let files = included.map(|one| {
            let file = request.into.join(SCENARIOS).join(&one.path);
            (one.path.clone(), file)
        });
        let has_truth = match spec.truth() {
            TruthSource::Files(files) => files.iter().all(|file| {
                let name = format!("{TRUTH}{}", file.display());
                manifest.members.iter().any(|member| member.name == name)
            }),
            _ => false,
        };
        Ok(Self {
            known,
            roots,
            files: files.collect(),
            has_truth,
        })
    }

    /// The path of a question's scenario here.
    pub fn item(&self, path: &mut String) {
        if let Some(known) = self.known.get(path) {
            path.clone_from(known);
        } else if let Some(file) = self.files.get(path) {
            *path = file.display().to_string();
        } else if let Some(file) = self.in_other_part(path) {
            *path = file.display().to_string();
        }
    }

    /// The file of a scenario of another part, where this machine has it.
    fn in_other_part(&self, path: &str) -> Option<PathBuf> {
        let path = Path::new(path);
        let here = self.roots.iter().filter_map(|(name, root)| {
            let rest = path.strip_prefix(name).ok()?;
            Some(if rest.as_os_str().is_empty() {
                root.clone()
            } else {
                root.join(rest)
            })
        });
        here.into_iter()
            .find(|file| file.is_absolute() && file.is_file())
    }

    /// The batch as this machine can go on with it: files that are here by their paths, and the bundle's templates where
    /// the user's are others.
    pub fn spec(
        &self,
        request: &UnpackRequest<'_>,
        mut spec: Spec,
        texts: &BTreeMap<String, String>,
    ) -> Spec {
        if !self.files.is_empty() {
            let scenarios = request.into.join(SCENARIOS);
            let outside = |path: &&mut PathBuf| !is_bundled(&path.display().to_string());
            for path in spec.experiment.scenarios.iter_mut().filter(outside) {
                *path = scenarios.join(&*path);
            }
        }
        if let (Some(TruthSource::Files(files)), true) =
            (&mut spec.experiment.truth, self.has_truth)
        {
            for file in files {
                *file = request.into.join(TRUTH).join(&*file);
            }
        }
        let now = Spec::templates_for(&spec.experiment, request.library);
        let others: Vec<String> = spec.templates.keys().cloned().collect();
        for file in others {
            if spec.drafts.contains_key(&file) || now.get(&file) == spec.templates.get(&file) {
                continue;
            }
            let Some(text) = texts.get(&file) else {
                continue;
            };
            for (name, fragment) in texts.iter().filter(|(name, _)| name.starts_with('_')) {
                let own = request.library.source(name).map(|(text, _)| text);
                if own != Some(fragment.as_str()) {
                    spec.drafts.insert(name.clone(), fragment.clone());
                }
            }
            spec.drafts.insert(file, text.clone());
        }
        spec
    }
}

/// Files that are written and not yet in their places. They are gone when this is dropped.
pub(super) struct Staged {
    folder: TempDir,
    /// Names, with `/` between the parts.
    names: Vec<String>,
    /// What a signal that ends the program removes.
    _unfinished: Unfinished,
}

impl Staged {
    /// Begins on the disk where `into` is, or will be.
    pub fn begin(into: &Path) -> Result<Self, BundleError> {
        let mut there = into;
        while let (false, Some(above)) = (there.is_dir(), there.parent()) {
            there = above;
        }
        let folder = tempfile::Builder::new()
            .prefix(".")
            .suffix(".part")
            .tempdir_in(there)
            .map_err(|source| BundleError::io(there, source))?;
        Ok(Self {
            _unfinished: Unfinished::begin(folder.path()),
            folder,
            names: Vec::new(),
        })
    }

    /// Where the file with this name is meanwhile.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn add(&mut self, name: &str, content: &mut dyn Read) -> Result<(), BundleError> {
        let path = self.path(name);
        let mut write = || {
            path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
            let mut file = File::create_new(&path)?;
            io::copy(content, &mut file)?;
            file.flush()?;
            file.sync_all()
        };
        write().map_err(|source| BundleError::io(&path, source))?;
        self.names.push(name.into());
        Ok(())
    }

    /// Puts all files into their places below `into`, and none where one cannot be: nothing is replaced.
    pub fn place(self, into: &Path) -> Result<usize, BundleError> {
        let mut placed = Placed::default();
        for name in &self.names {
            let target = into.join(name);
            let moved = { target.parent() }
                .map_or(Ok(()), |folder| placed.make_folder(folder))
                .and_then(|()| move_to(&self.path(name), &target));
            if let Err(source) = moved {
                placed.remove();
                return Err(match source.kind() {
                    ErrorKind::AlreadyExists => BundleError::InTheWay(target),
                    _ => BundleError::io(&target, source),
                });
            }
            placed.files.push(target);
        }
        Ok(placed.files.len())
    }
}

/// What was put into its place so far.
#[derive(Default)]
struct Placed {
    files: Vec<PathBuf>,
    /// The folders that were made for them, outer ones first.
    folders: Vec<PathBuf>,
}

impl Placed {
    fn make_folder(&mut self, folder: &Path) -> io::Result<()> {
        let missing = folder.ancestors().take_while(|folder| !folder.exists());
        let mut missing: Vec<PathBuf> = missing.map(Path::to_path_buf).collect();
        missing.reverse();
        std::fs::create_dir_all(folder)?;
        self.folders.extend(missing);
        Ok(())
    }

    /// As if nothing had been placed.
    fn remove(&self) {
        // What cannot be removed was changed by another program meanwhile.
        for file in &self.files {
            let _ = std::fs::remove_file(file);
        }
        for folder in self.folders.iter().rev() {
            let _ = std::fs::remove_dir(folder);
        }
    }
}

/// Moves a file on one disk to where nothing is.
fn move_to(from: &Path, to: &Path) -> io::Result<()> {
    match std::fs::hard_link(from, to) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(error),
        // The file system knows no second names.
        Err(_) if to.symlink_metadata().is_err() => std::fs::rename(from, to),
        linked => linked,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn all_files_are_placed_or_none() {
        let folder = tempfile::tempdir().unwrap();
        let into = folder.path().join("new/place");
        let names = || {
            let entries = std::fs::read_dir(folder.path()).unwrap();
            entries.map(|e| e.unwrap().file_name()).collect::<Vec<_>>()
        };
        let staged = |into: &Path| {
            let mut staged = Staged::begin(into).unwrap();
            for name in ["a.xml", "deep/down/b.xml", "c.xml"] {
                staged.add(name, &mut name.as_bytes()).unwrap();
            }
            staged
        };
        // One of their folders is a file, which is seen when others are in their places.
        std::fs::create_dir_all(&into).unwrap();
        std::fs::write(into.join("deep"), "mine").unwrap();
        assert!(staged(&into).place(&into).is_err());
        assert!(!into.join("a.xml").exists());
        std::fs::remove_file(into.join("deep")).unwrap();
        std::fs::write(into.join("c.xml"), "mine").unwrap();
        let error = staged(&into).place(&into);
        assert!(matches!(error, Err(BundleError::InTheWay(_))));
        assert!(!into.join("deep").exists() && !into.join("a.xml").exists());
        assert_eq!(std::fs::read(into.join("c.xml")).unwrap(), b"mine");
        std::fs::remove_dir_all(folder.path().join("new")).unwrap();
        assert_eq!(staged(&into).place(&into).unwrap(), 3);
        assert_eq!(
            std::fs::read(into.join("deep/down/b.xml")).unwrap(),
            b"deep/down/b.xml"
        );
        drop(staged(&into));
        assert_eq!(names(), ["new"]);
        assert_eq!(std::fs::read_dir(&into).unwrap().count(), 3);
    }
}
