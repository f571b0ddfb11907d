//! Where the scenarios of an unpacked batch are on this machine.

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};

use super::BundleError;
use super::manifest::{Manifest, SCENARIOS, TRUTH};
use super::pack::is_bundled;
use super::runs::portable_paths;
use super::unpack::UnpackRequest;
use nearmiss_store::BatchId;
use nearmiss_study::evaluation::batch::{Spec, TruthSource};

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
        } else if let Some(file) = self.beside(path) {
            *path = file.display().to_string();
        }
    }

    /// The file of a scenario of another part, where this machine has it.
    fn beside(&self, path: &str) -> Option<PathBuf> {
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
        let now = Spec::templates_of(&spec.experiment, request.library);
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
