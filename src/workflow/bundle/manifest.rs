//! The file of a bundle: tar, compressed by gzip; its first member says what is in it, every other is checked against that.

use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use nearmiss_base::system;
use nearmiss_study::evaluation::Provenance;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::BundleError;

/// The form of bundles that this version writes, and the latest that it reads.
pub const FORMAT: u32 = 1;

/// What a bundle contains.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Manifest {
    /// The form of the bundle.
    pub nearmiss_bundle: u32,
    /// When it was packed, milliseconds since 1970, UTC.
    pub created_ms: i64,
    /// What its answers were made from.
    pub provenance: Provenance,
    /// Questions of the batch.
    pub questions: u64,
    /// Stored runs: answers, and attempts without one.
    pub runs: u64,
    /// Ratings of these answers.
    pub ratings: u64,
    /// The scenarios that were asked about.
    pub scenarios: Vec<PackedScenario>,
    /// What is in the file behind the manifest, in order.
    pub members: Vec<Member>,
}

/// A scenario that was asked about.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PackedScenario {
    /// Its path below the folder that was asked about, or the name of a bundled one.
    pub path: String,
    /// SHA-256 of the scenario; null if it could not be read.
    pub sha256: Option<String>,
    /// Whether its files are in the bundle.
    pub included: bool,
}

/// A part of a bundle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct Member {
    /// Its path, with `/` between the parts.
    pub name: String,
    /// Bytes.
    pub bytes: u64,
    /// SHA-256.
    pub sha256: String,
}

/// The experiment file.
pub(super) const EXPERIMENT: &str = "experiment.toml";
/// The user's thresholds.
pub(super) const THRESHOLDS: &str = "thresholds.toml";
/// Templates and fragments.
pub(super) const TEMPLATES: &str = "templates/";
/// Files with labels.
pub(super) const TRUTH: &str = "truth/";
/// Scenarios and their egos.
pub(super) const SCENARIOS: &str = "scenarios/";
/// The batch, its runs, and its questions with truth, as lines of an export.
pub(super) const BATCH: &str = "batch.jsonl";
/// Ratings, one a line.
pub(super) const RATINGS: &str = "ratings.jsonl";

/// Bytes of the longest path below a folder, and of the longest of its parts that file systems take.
const MAX_PATH_BYTES: usize = 1000;
const MAX_PART_LENGTH: usize = 255;

/// Whether a name is one that bundles have, and stays below the folder that it is written to.
pub(super) fn is_safe(name: &str) -> bool {
    let known = [EXPERIMENT, THRESHOLDS, BATCH, RATINGS].contains(&name)
        || [TEMPLATES, TRUTH, SCENARIOS].iter().any(|folder| {
            name.strip_prefix(folder)
                .is_some_and(|rest| !rest.is_empty())
        });
    let is_safe = |part: &str| part.len() <= MAX_PART_LENGTH && part == safe_part(part);
    known && name.len() <= MAX_PATH_BYTES && name.split('/').all(is_safe)
}

/// A part of a path that every system takes.
fn safe_part(part: &str) -> String {
    let allowed = |c: char| !c.is_control() && !"\\:*?\"<>|".contains(c);
    let safe: String = part
        .chars()
        .map(|c| if allowed(c) { c } else { '_' })
        .collect();
    match safe
        .trim_matches(|c: char| c.is_whitespace())
        .trim_end_matches('.')
    {
        "" => "_".into(),
        trimmed => trimmed.into(),
    }
}

/// A path whose parts every system takes.
pub(super) fn safe(path: &str) -> String {
    let parts: Vec<String> = path.split('/').map(safe_part).collect();
    parts.join("/")
}

/// Whether a member is a file of the folder that is unpacked into.
pub(super) fn is_file(name: &str) -> bool {
    name != BATCH && name != RATINGS
}

const MANIFEST: &str = "manifest.json";

/// Bytes of the largest manifest: that of some hundred thousand scenarios.
const MAX_MANIFEST_BYTES: u64 = 64 << 20;

/// Bytes that a bundle of any size may unpack to, and how many times its size a larger one: text shrinks to a tenth.
const MIN_UNPACKED_LIMIT: u64 = 256 << 20;
const MAX_EXPANSION: u64 = 200;

/// Writes a bundle: each member with what reads it.
pub(super) fn write<'a>(
    out: impl Write,
    manifest: &Manifest,
    members: impl Iterator<Item = (&'a Member, io::Result<Box<dyn Read>>)>,
) -> io::Result<()> {
    let mut tar = tar::Builder::new(GzEncoder::new(out, Compression::default()));
    let seconds = u64::try_from(manifest.created_ms / 1000).unwrap_or_default();
    let mut add = |name: &str, bytes: u64, content: &mut dyn Read| {
        let mut header = tar::Header::new_ustar();
        // The manifest has the names; those of the archive are for people, and may be too long for it.
        if header.set_path(name).is_err() {
            header.set_path("long-name")?;
        }
        header.set_size(bytes);
        header.set_mode(0o644);
        header.set_mtime(seconds);
        header.set_entry_type(tar::EntryType::Regular);
        header.set_cksum();
        tar.append(&header, content)
    };
    let json = serde_json::to_vec(manifest)?;
    add(MANIFEST, json.len() as u64, &mut json.as_slice())?;
    for (member, content) in members {
        // A file that has changed since it was hashed must not shift the others.
        let mut content = content?.take(member.bytes);
        add(&member.name, member.bytes, &mut content)?;
    }
    tar.into_inner()?.finish()?.flush()
}

/// What is done with each member.
pub(super) type Visit<'a> =
    &'a mut dyn FnMut(&Manifest, &Member, &mut dyn Read) -> Result<(), BundleError>;

/// Reads a bundle from its beginning to its end. What `visit` leaves of a member is read after it; a member whose hash is
/// wrong is an error after `visit` saw it, so that nothing may be kept before the whole was read once.
pub(super) fn read(path: &Path, visit: Visit<'_>) -> Result<Manifest, BundleError> {
    let io = |source| BundleError::io(path, source);
    let file: File = system::open_file(path).map_err(io)?;
    let most = file
        .metadata()
        .map_err(io)?
        .len()
        .saturating_mul(MAX_EXPANSION)
        .max(MIN_UNPACKED_LIMIT);
    let damaged = |why: String| BundleError::Damaged {
        file: path.display().to_string(),
        why,
    };
    let broken = |error: io::Error| match error.kind() {
        io::ErrorKind::UnexpectedEof => damaged("it is cut off".into()),
        _ => damaged(error.to_string()),
    };
    let mut decoder = GzDecoder::new(io::BufReader::new(file));
    let manifest = {
        let mut tar = tar::Archive::new((&mut decoder).take(most));
        // Raw: names that are members of their own could be of any length.
        let mut entries = tar.entries().map_err(broken)?.raw(true);
        let mut first = match entries.next() {
            Some(Ok(first)) if first.path_bytes().as_ref() == MANIFEST.as_bytes() => first,
            Some(Err(error)) if error.kind() == io::ErrorKind::UnexpectedEof => {
                return Err(broken(error));
            }
            _ => return Err(BundleError::NoBundle(path.display().to_string())),
        };
        let manifest = manifest(path, &mut first)?;
        check(&manifest, most).map_err(damaged)?;
        for member in &manifest.members {
            let mut entry = match entries.next() {
                Some(entry) => entry.map_err(broken)?,
                None => return Err(damaged(format!("{} is missing", member.name))),
            };
            let is_file = entry.header().entry_type() == tar::EntryType::Regular;
            if !is_file || entry.size() != member.bytes {
                return Err(damaged(format!(
                    "{} is not what the manifest says",
                    member.name
                )));
            }
            let mut content = Hashed::new(&mut entry);
            let visited = visit(&manifest, member, &mut content);
            if content.failed {
                return Err(damaged("it is cut off, or its bytes were changed".into()));
            }
            io::copy(&mut content, &mut io::sink()).map_err(broken)?;
            if content.read != member.bytes || content.hex() != member.sha256 {
                return Err(damaged(format!("{} has another hash", member.name)));
            }
            visited?;
        }
        if entries.next().is_some() {
            return Err(damaged("it has more members than the manifest says".into()));
        }
        manifest
    };
    // The check sum of gzip stands at its end.
    io::copy(&mut decoder.take(1 << 20), &mut io::sink()).map_err(broken)?;
    Ok(manifest)
}

fn manifest(path: &Path, from: &mut dyn Read) -> Result<Manifest, BundleError> {
    #[derive(serde::Deserialize)]
    struct Form {
        nearmiss_bundle: u32,
    }
    let none = || BundleError::NoBundle(path.display().to_string());
    let mut json = Vec::new();
    let mut limited = from.take(MAX_MANIFEST_BYTES);
    limited.read_to_end(&mut json).map_err(|_| none())?;
    let form: Form = serde_json::from_slice(&json).map_err(|_| none())?;
    if form.nearmiss_bundle > FORMAT {
        return Err(BundleError::Later {
            file: path.display().to_string(),
            found: form.nearmiss_bundle,
        });
    }
    serde_json::from_slice(&json).map_err(|error| BundleError::Damaged {
        file: path.display().to_string(),
        why: format!("manifest.json: {error}"),
    })
}

/// What is wrong with the names and sizes of a manifest.
fn check(manifest: &Manifest, most: u64) -> Result<(), String> {
    let mut names = BTreeSet::new();
    let mut bytes = 0_u64;
    for member in &manifest.members {
        if !is_safe(&member.name) {
            return Err(format!(
                "{}: no member of a bundle has this name",
                member.name
            ));
        }
        // Some file systems take upper and lower case for the same.
        if !names.insert(member.name.to_lowercase()) {
            return Err(format!("{} is there twice", member.name));
        }
        bytes = bytes.saturating_add(member.bytes);
    }
    if bytes > most {
        return Err(format!(
            "it would unpack to {} MiB, far more than its size",
            bytes >> 20
        ));
    }
    Ok(())
}

/// A reader or writer that hashes what passes.
pub(super) struct Hashed<T> {
    inner: T,
    digest: Sha256,
    /// Bytes so far.
    pub read: u64,
    failed: bool,
}

impl<T> Hashed<T> {
    pub(super) fn new(inner: T) -> Self {
        Self {
            inner,
            digest: Sha256::new(),
            read: 0,
            failed: false,
        }
    }

    /// The hash of what passed, in hexadecimal digits.
    pub(super) fn hex(&self) -> String {
        let hash = self.digest.clone().finalize();
        hash.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    pub(super) fn into_inner(self) -> T {
        self.inner
    }
}

impl<T: Read> Read for Hashed<T> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.inner.read(buffer);
        self.failed |= read.is_err();
        let read = read?;
        self.digest.update(&buffer[..read]);
        self.read += read as u64;
        Ok(read)
    }
}

impl<T: Write> Write for Hashed<T> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.digest.update(&bytes[..written]);
        self.read += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// The hash of bytes, in hexadecimal digits.
pub(super) fn hash(bytes: &[u8]) -> String {
    let mut hashed = Hashed::new(io::sink());
    // A sink takes everything.
    let _ = hashed.write_all(bytes);
    hashed.hex()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_below_the_folder_are_safe() {
        for name in [
            "experiment.toml",
            "templates/a.md",
            "scenarios/x/a b.xml",
            "batch.jsonl",
        ] {
            assert!(is_safe(name), "{name}");
        }
        for name in [
            "",
            "/etc/passwd",
            "scenarios/../../x",
            "scenarios//x",
            "scenarios/",
            "scenarios/./x",
            "scenarios/a\\..\\b",
            "templates/C:x",
            "other/x",
            "experiment.toml/x",
            "scenarios/\u{1b}[2J",
            "scenarios/x.",
        ] {
            assert!(!is_safe(name), "{name}");
        }
        let long = |bytes: usize| format!("scenarios/{}/a.xml", "x".repeat(bytes));
        assert!(is_safe(&long(255)) && !is_safe(&long(256)));
        assert_eq!(safe("a:b/../c\n.xml"), "a_b/_/c_.xml");
    }
}
