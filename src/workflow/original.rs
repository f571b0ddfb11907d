//! Saved variants: the original that a certificate names, and whether files and certificate still hold.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nearmiss_base::system;
use nearmiss_drive::driver::{PreventabilityRecord, VerdictRecord};
use nearmiss_drive::generation::{AttackStyle, Manifest, PlannerIdentity};
use nearmiss_drive::planner::{self, Cancel, Forecast};
use nearmiss_drive::simulation::{Settings, TrafficMode};
use nearmiss_formats::{EgoSelection, Entry, EntryLocation, bundled};
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::{ContentHash, Scenario, Scene, VehicleType};
use serde::Deserialize;

use super::{OpenRequest, PlanRequest, StandIn, open, prepare};

/// A saved variant: where it lies, and the manifest beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct VariantOrigin {
    /// What was recorded when it was made.
    pub manifest: Manifest,
    /// The variant's file.
    variant: PathBuf,
}

/// Places of the same drive in two files differ by no more, metres.
const WRITTEN: f64 = 1e-3;

impl VariantOrigin {
    /// Reads what lies beside a scenario under its name; `None` where that is no manifest of this scenario. Other JSON says
    /// nothing about it.
    ///
    /// # Errors
    /// Why a manifest of this scenario cannot be read, with the name of its file.
    pub fn read(entry: &Entry) -> Result<Option<Self>, String> {
        #[derive(Deserialize)]
        struct Named {
            variant: String,
        }
        let beside = || {
            let EntryLocation::File(file) = &entry.place else {
                return None;
            };
            let path = file.with_extension("json");
            let text = system::read_text(&path, system::LARGEST_TEXT).ok()?;
            let named: Named = serde_json::from_str(&text).ok()?;
            (file.file_name()?.to_str()? == named.variant).then_some((file.clone(), path, text))
        };
        let Some((variant, path, text)) = beside() else {
            return Ok(None);
        };
        let manifest: Manifest = serde_json::from_str(&text).map_err(|why| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            visible(&format!("{name}: {why}")).into_owned()
        })?;
        if { manifest.preventability.as_ref() }.is_some_and(|said| !said.is_consistent()) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let words = format!("{name}: preventability: its counts are not those of its drivers");
            return Err(visible(&words).into_owned());
        }
        let is_none = manifest.attackers.is_empty() || manifest.original.sha256.is_empty();
        Ok((!is_none).then_some(Self { manifest, variant }))
    }

    /// Reaction times of ideal drivers who survive the variant, seconds, and the names of their drives' files, the
    /// shortest first; a name is empty where the manifest has none.
    pub fn certificates(&self) -> impl DoubleEndedIterator<Item = (&str, &str)> {
        let all = self.manifest.avoidable.iter().flatten();
        all.filter(|(_, record)| record.avoided)
            .map(|(seconds, record)| {
                let evasion = record.evasion.as_ref();
                let name = evasion.and_then(|evasion| evasion.trajectory.as_deref());
                (&**seconds, name.unwrap_or_default())
            })
    }

    /// The planner whose drive lies beside the variant, with its version.
    #[must_use]
    pub fn planner(&self) -> String {
        let named = match &self.manifest.planning.planner {
            PlannerIdentity::BuiltIn(name) => name.clone(),
            PlannerIdentity::External { named, name, .. } if name.is_empty() => named.clone(),
            PlannerIdentity::External { name, version, .. } => format!("{name} {version}"),
        };
        visible(named.trim()).into_owned()
    }

    /// The vehicle that drives.
    #[must_use]
    pub fn vehicle(&self) -> Option<VehicleType> {
        VehicleType::parse(&self.manifest.planning.vehicle.to_string())
    }

    /// Whose limits its attackers keep: of bulk runs a setting, of searches in the words about their author.
    #[must_use]
    pub fn style(&self) -> Option<AttackStyle> {
        #[derive(serde::Deserialize)]
        struct Made {
            settings: Settings,
        }
        #[derive(serde::Deserialize)]
        struct Settings {
            style: String,
        }
        let made = self.manifest.made.as_ref();
        let made = made.and_then(|made| Made::deserialize(made).ok());
        let author = || Some(self.manifest.by.rsplit_once("style ")?.1.to_owned());
        AttackStyle::parse(&made.map(|made| made.settings.style).or_else(author)?)
    }

    /// The drive of an ideal driver who survives the variant: the reaction time and the file; with the longest reaction
    /// time where none is asked for.
    #[must_use]
    pub fn certificate(&self, delay: Option<f64>) -> Option<(f64, PathBuf)> {
        let folder = self.variant.parent().unwrap_or(Path::new(""));
        let mut all = self.certificates().rev().filter_map(|(seconds, name)| {
            // A name that leads elsewhere is none.
            let name = Path::new(name).file_name()?;
            Some((seconds.parse::<f64>().ok()?, folder.join(name)))
        });
        all.find(|(seconds, _)| delay.is_none_or(|delay| delay == *seconds))
    }

    /// Whether a certificate holds for the ego of a scene of the variant: an ideal driver survives who drives like it until
    /// attackers move otherwise.
    #[must_use]
    pub fn certifies(&self, entry: &Entry, scene: &Scene) -> bool {
        let Some((_, path)) = self.certificate(None) else {
            return false;
        };
        let from_file = EgoSelection::File {
            path,
            planning_problem: None,
        };
        let Ok(Some(survivor)) = from_file.resolve(entry, &scene.scenario) else {
            return false;
        };
        let step = self.from().max(scene.steps().start);
        let both = survivor.track.at(step).zip(scene.ego.track.at(step));
        both.is_some_and(|(survivor, ego)| {
            (survivor.pose.position - ego.pose.position).norm() <= WRITTEN
        })
    }

    /// The same of the scene of an entry; not where it is no variant.
    ///
    /// # Errors
    /// As of [`VariantOrigin::read`].
    pub fn certified(entry: &Entry, scene: &Scene) -> Result<bool, String> {
        let origin = Self::read(entry)?;
        Ok(origin.is_some_and(|origin| origin.certifies(entry, scene)))
    }

    /// The ids of the obstacles with a new motion.
    #[must_use]
    pub fn ids(&self) -> Vec<i64> {
        self.manifest.attackers.iter().map(|a| a.id).collect()
    }

    /// The last step before the first of them moves otherwise.
    #[must_use]
    pub fn from(&self) -> i64 {
        let all = self.manifest.attackers.iter().map(|a| a.from_step);
        all.min().unwrap_or(i64::MIN)
    }

    /// Whether a scenario is the original, byte for byte.
    #[must_use]
    pub fn is_original(&self, scenario: &Scenario) -> bool {
        scenario.hash.to_string() == self.manifest.original.sha256
    }

    /// The original: one of the bundled scenarios, beside the variant, in the folder above, or where it was when the
    /// variant was made.
    #[must_use]
    pub fn original(&self) -> Option<(Entry, Arc<Scenario>)> {
        let read = |entry: Entry| {
            let scenario = entry.read().ok()?;
            self.is_original(&scenario).then_some((entry, scenario))
        };
        let named = bundled()
            .into_iter()
            .filter(|entry| entry.name == self.manifest.original.benchmark_id);
        // A certificate may name anything; reading what is not a file may never end.
        let files = self.places().into_iter().filter(|path| path.is_file());
        let mut all = named.chain(files.map(|path| Entry::of_file(&path)));
        all.find_map(read)
    }

    /// Why there is no original, and where it was looked for.
    #[must_use]
    pub fn missing(&self) -> String {
        let original = &self.manifest.original;
        let elsewhere = original
            .file
            .as_ref()
            .map_or(String::new(), |file| format!("nor {}, ", visible(file)));
        format!(
            "the original {} (SHA-256 {}) is neither beside it, nor in the folder above, {elsewhere}nor among the bundled scenarios",
            visible(&self.manifest.original.benchmark_id),
            visible(&self.manifest.original.sha256)
        )
    }

    /// The files that may be the original.
    fn places(&self) -> Vec<PathBuf> {
        let folder = self.variant.parent().unwrap_or(Path::new(""));
        let above = match folder.parent() {
            Some(above) if folder.file_name().is_some() => above.to_path_buf(),
            _ => folder.join(".."),
        };
        let mut places: Vec<PathBuf> = [folder, &above]
            .map(|folder| folder.join(self.file()))
            .into();
        if let Some(file) = &self.manifest.original.file {
            // As it was named then, and with the variants and originals beside each other also from any other folder.
            places.extend([PathBuf::from(file), above.join(file)]);
        }
        places
    }

    /// The name of its file; an id that leads into other folders has none.
    fn file(&self) -> PathBuf {
        let mut name = Path::new(&self.manifest.original.benchmark_id)
            .file_name()
            .unwrap_or_default()
            .to_os_string();
        name.push(".xml");
        name.into()
    }
}

/// What was verified of a variant.
#[derive(Debug, Clone, PartialEq)]
pub struct VariantProofs {
    /// Files whose SHA-256 the manifest names.
    pub files: usize,
    /// What is wrong with them.
    pub changed: Vec<String>,
    /// The certificates, the shortest reaction time first.
    pub certificates: Vec<VerifiedCertificate>,
    /// Which drivers avoid its contact or near miss, looked at anew, or why that is not what the manifest says; `None` where
    /// it says nothing.
    pub drivers: Option<Result<PreventabilityRecord, String>>,
}

/// The drive of an ideal driver, looked at anew.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VerifiedCertificate {
    /// Reaction time of the driver, seconds.
    pub delay: String,
    /// The file of the drive.
    pub file: String,
    /// Steps of the drive; or why it proves nothing.
    pub result: Result<usize, String>,
}

impl VariantProofs {
    /// Whether all of it holds.
    #[must_use]
    pub fn hold(&self) -> bool {
        let is_survived = self.certificates.iter().all(|c| c.result.is_ok());
        self.changed.is_empty() && is_survived && !matches!(self.drivers, Some(Err(_)))
    }
}

/// Verifies a variant by the manifest beside it; `None` where there is none.
///
/// Contact is looked for at and between the steps of each drive, with exact bodies; leaving the road counts as well.
/// Whether the vehicle can be driven so is not verified again. Drivers are asked again who of them avoids it.
#[must_use]
pub fn verify_variant(variant: &Path) -> Option<VariantProofs> {
    let entry = Entry::of_file(variant);
    let origin = match VariantOrigin::read(&entry) {
        Ok(origin) => origin?,
        Err(why) => {
            return Some(VariantProofs {
                files: 0,
                changed: vec![why],
                certificates: Vec::new(),
                drivers: None,
            });
        }
    };
    let folder = variant.parent().unwrap_or(Path::new(""));
    let hashes = &origin.manifest.sha256;
    let changed = hashes.iter().filter_map(|(name, hash)| {
        // A name that leads elsewhere is none.
        let name = Path::new(name).file_name()?;
        is_unchanged(&folder.join(name), hash).err()
    });
    let certificates = origin.certificates().map(|(delay, name)| {
        let path = delay
            .parse()
            .ok()
            .and_then(|d: f64| origin.certificate(Some(d)));
        VerifiedCertificate {
            delay: visible(delay).into_owned(),
            file: visible(name).into_owned(),
            result: match path {
                Some((_, path)) => drive(&entry, &origin, &path),
                None => Err("no such file".into()),
            },
        }
    });
    Some(VariantProofs {
        files: hashes.len(),
        changed: changed.collect(),
        certificates: certificates.collect(),
        drivers: { origin.manifest.preventability.as_ref() }
            .map(|said| judged(&entry, &origin, said)),
    })
}

/// The number of steps of a drive that touches nothing.
fn drive(entry: &Entry, origin: &VariantOrigin, path: &Path) -> Result<usize, String> {
    let mut planner = planner::Settings::default();
    planner.vehicle = origin.vehicle().unwrap_or(planner.vehicle);
    let settings = Settings {
        planner,
        forecast: Forecast::Lane,
        replan: 1,
        without: None,
        traffic: TrafficMode::Recorded,
        policy: None,
    };
    let ego = EgoSelection::File {
        path: path.to_owned(),
        planning_problem: None,
    };
    let open = OpenRequest {
        entry,
        ego: &ego,
        transform: None,
        strict: true,
        stand_in: StandIn::None,
    };
    let prepared = prepare(&PlanRequest {
        open,
        problem: Some(origin.manifest.planning.problem),
        settings: &settings,
    })
    .map_err(|error| error.to_string())?;
    let Some(scene) = &prepared.recorded else {
        return Err("no drive in it".into());
    };
    let driver = prepared
        .driver(&prepared.scenario, &Cancel::default())
        .map_err(|error| error.to_string())?;
    match driver.fault_of(&prepared.scenario, &scene.ego.track) {
        Some(fault) => Err(fault.to_string()),
        None => Ok(scene.ego.track.steps().count()),
    }
}

/// What drivers make of the encounter of a variant, as the manifest says it.
fn judged(
    entry: &Entry,
    origin: &VariantOrigin,
    said: &PreventabilityRecord,
) -> Result<PreventabilityRecord, String> {
    let opened = open(&OpenRequest {
        entry,
        ego: &EgoSelection::Beside,
        transform: None,
        strict: true,
        stand_in: StandIn::None,
    });
    let opened = opened.map_err(|error| error.to_string())?;
    let scene = opened.scene.map_err(|why| why.to_string())?;
    let is_certified = origin.certifies(entry, &scene);
    let found = PreventabilityRecord::of(&scene, said.obstacle, said.step, is_certified)
        .ok_or("the ego is not there before")?;
    let is_said = |(one, other): (&VerdictRecord, &VerdictRecord)| {
        (&one.driver, &one.result) == (&other.driver, &other.result)
    };
    let is_same = found.drivers.len() == said.drivers.len()
        && found.drivers.iter().zip(&said.drivers).all(is_said);
    if is_same {
        return Ok(found);
    }
    let said = visible(&said.words()).into_owned();
    Err(format!("{}, but the manifest says {said}", found.words()))
}

/// Whether a file is there, and still has the content with this SHA-256.
///
/// # Errors
/// It is not, or cannot be read.
pub fn is_unchanged(path: &Path, hash: &str) -> Result<(), String> {
    let named = |words: &str| format!("{}: {words}", path.display());
    let bytes =
        system::read_file(path, system::LARGEST).map_err(|e| named(&system::error_text(&e)))?;
    if ContentHash::digest(&bytes).to_string() == hash {
        Ok(())
    } else {
        Err(named("it was changed after generation"))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use nearmiss_drive::generation::AttackerRecord;
    use serde_json::{Value, json};

    use super::*;

    fn manifest(attackers: &[(i64, i64)]) -> Manifest {
        let attackers = attackers.iter().map(|(id, from_step)| AttackerRecord {
            id: *id,
            from_step: *from_step,
            ..AttackerRecord::default()
        });
        Manifest {
            variant: "v.xml".into(),
            attacker: 7,
            attackers: attackers.collect(),
            ..Manifest::default()
        }
    }

    fn saved(folder: &Path, original: Value) -> Entry {
        saved_with(folder, original, &[(7, 3)])
    }

    fn saved_with(folder: &Path, original: Value, attackers: &[(i64, i64)]) -> Entry {
        let file = folder.join("v.xml");
        std::fs::write(&file, "<commonRoad/>").unwrap();
        let mut manifest = serde_json::to_value(manifest(attackers)).unwrap();
        manifest["original"] = original;
        std::fs::write(folder.join("v.json"), manifest.to_string()).unwrap();
        Entry::of_file(&file)
    }

    #[test]
    fn a_bundled_original_is_found_by_its_content() {
        let folder = tempfile::tempdir().unwrap();
        let first = bundled().remove(0);
        let hash = first.read().unwrap().hash.to_string();
        let named = json!({"benchmark_id": first.name, "sha256": hash});
        let origin = VariantOrigin::read(&saved(folder.path(), named))
            .unwrap()
            .unwrap();
        assert_eq!((origin.manifest.attacker, origin.from()), (7, 3));
        assert_eq!(origin.style(), None);
        assert_eq!(origin.original().unwrap().0, first);

        let changed = json!({"benchmark_id": first.name, "sha256": "00", "file": "gone/x.xml"});
        let origin = VariantOrigin::read(&saved(folder.path(), changed))
            .unwrap()
            .unwrap();
        assert!(origin.original().is_none());
        let missing = origin.missing();
        assert!(
            missing.contains(&first.name) && missing.contains("gone/x.xml"),
            "{missing}"
        );
    }

    #[test]
    fn the_original_is_read_where_the_certificate_says() {
        let folder = tempfile::tempdir().unwrap();
        let elsewhere = tempfile::tempdir().unwrap();
        let first = bundled().remove(0).read().unwrap();
        let bytes = nearmiss_formats::commonroad::write(&first).unwrap();
        let file = elsewhere.path().join("moved.xml");
        std::fs::write(&file, &bytes).unwrap();
        let entry = Entry::of_file(&file);
        let hash = entry.read().unwrap().hash.to_string();
        let named = json!({"benchmark_id": "X", "sha256": hash, "file": file.to_str()});
        let origin = VariantOrigin::read(&saved(folder.path(), named))
            .unwrap()
            .unwrap();
        assert_eq!(origin.original().unwrap().0, entry);
    }

    #[test]
    fn a_manifest_with_a_wrong_type_is_damaged_and_a_drive_without_a_file_is_counted() {
        let folder = tempfile::tempdir().unwrap();
        let entry = saved(folder.path(), json!({"benchmark_id": "A", "sha256": "00"}));
        let file = folder.path().join("v.json");
        let text = std::fs::read_to_string(&file).unwrap();
        let mut manifest: Value = serde_json::from_str(&text).unwrap();
        manifest["avoidable"] = json!({"0.5": {"avoided": true}});
        std::fs::write(&file, manifest.to_string()).unwrap();
        let origin = VariantOrigin::read(&entry).unwrap().unwrap();
        assert_eq!(Vec::from_iter(origin.certificates()), [("0.5", "")]);
        manifest["avoidable"]["0.5"]["max_acceleration"] = "4.8".into();
        std::fs::write(&file, manifest.to_string()).unwrap();
        let why = VariantOrigin::read(&entry).unwrap_err();
        assert!(why.contains("4.8") && why.starts_with("v.json: "), "{why}");
    }

    #[test]
    fn all_attackers_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let original = json!({"benchmark_id": "A", "sha256": "00"});
        let entry = saved_with(folder.path(), original, &[(9, 5), (7, 3)]);
        let origin = VariantOrigin::read(&entry).unwrap().unwrap();
        assert_eq!((origin.manifest.attacker, origin.from()), (7, 3));
        assert_eq!(origin.ids(), [9, 7]);
    }

    #[test]
    fn the_style_is_that_of_the_settings_or_of_the_author() {
        let style = |made: Value, by: &str| {
            let manifest = Manifest {
                made: Some(made),
                by: by.into(),
                ..Manifest::default()
            };
            let variant = PathBuf::new();
            VariantOrigin { manifest, variant }.style()
        };
        let set = json!({"settings": {"style": "limit"}});
        assert_eq!(style(set, "search, style human"), Some(AttackStyle::Limit));
        let by = "search with seed 1, style human";
        assert_eq!(style(Value::Null, by), Some(AttackStyle::Human));
        assert_eq!(style(Value::Null, "lab/x"), None);
    }

    #[test]
    fn other_json_beside_a_scenario_says_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let entry = saved(folder.path(), json!({"benchmark_id": "A"}));
        assert_eq!(VariantOrigin::read(&entry), Ok(None));
        assert_eq!(VariantOrigin::read(&bundled().remove(0)), Ok(None));
    }
}
