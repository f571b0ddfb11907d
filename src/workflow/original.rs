//! Finds the original of a saved variant, which the certificate beside the variant names.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::VariantRecord;
use nearmiss_base::system;
use nearmiss_drive::generation::AttackStyle;
use nearmiss_formats::{Entry, EntryLocation, bundled};
use nearmiss_scene::description::visible;
use nearmiss_scene::scenario::{Scenario, VehicleType};

/// An obstacle with a new motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attacker {
    /// Its id.
    pub id: i64,
    /// The last step before its two motions part.
    pub from: i64,
}

/// What the certificate beside a saved variant says of its origin.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VariantOrigin {
    /// Benchmark id of the original.
    pub id: String,
    /// SHA-256 of the original's file, hexadecimal.
    pub sha256: String,
    /// The attacker that the ego touches or that comes nearest to it.
    pub attacker: i64,
    /// All obstacles with a new motion, at least one.
    pub attackers: Vec<Attacker>,
    /// Reaction times of good drivers who survive the variant, seconds, and the names of their drives' files, the
    /// shortest first.
    pub certificates: Vec<(String, String)>,
    /// The planner whose drive lies beside the variant; of earlier versions nothing.
    pub planner: Option<String>,
    /// Whose limits its attackers keep; of earlier versions nothing.
    pub style: Option<AttackStyle>,
    /// The names of all its files with their SHA-256, hexadecimal.
    pub hashes: Vec<(String, String)>,
    /// The planning problem that is driven.
    pub problem: Option<i64>,
    /// The vehicle that drives.
    pub vehicle: Option<VehicleType>,
    /// Attack, outcome and certificates.
    pub record: VariantRecord,
    /// The variant's file.
    variant: PathBuf,
    /// Where the original was when the variant was made, seen from the folder that was the current one then.
    said: Vec<PathBuf>,
}

impl VariantOrigin {
    /// Reads what lies beside a scenario under its name; `None` where that is no certificate of this scenario, as other
    /// JSON says nothing about it.
    #[must_use]
    pub fn of(entry: &Entry) -> Option<Self> {
        let EntryLocation::File(file) = &entry.place else {
            return None;
        };
        let text = system::read_text(&file.with_extension("json"), system::LARGEST_TEXT).ok()?;
        let said: Value = serde_json::from_str(&text).ok()?;
        if file.file_name()?.to_str()? != said["variant"].as_str()? {
            return None;
        }
        let original = &said["original"];
        let places = [&original["file"], &said["made"]["line"]["file"]]
            .into_iter()
            .filter_map(|place| place.as_str());
        let attacker = said["attacker"].as_i64()?;
        Some(Self {
            id: original["benchmark_id"].as_str()?.into(),
            sha256: original["sha256"].as_str()?.into(),
            attacker,
            attackers: attackers(&said).or_else(|| {
                // Before there could be several.
                let from = said["change"]["from_step"].as_i64()?;
                Some(vec![Attacker { id: attacker, from }])
            })?,
            certificates: certificates(&said),
            planner: planner(&said["planning"]["planner"]),
            style: style(&said),
            hashes: hashes(&said),
            problem: said["planning"]["problem"].as_i64(),
            vehicle: { said["planning"]["vehicle"].as_i64() }
                .and_then(|number| VehicleType::parse(&number.to_string())),
            record: VariantRecord::of(&said),
            variant: file.clone(),
            said: places.map(PathBuf::from).collect(),
        })
    }

    /// The drive of a good driver who survives the variant: the reaction time and the file; with the longest reaction
    /// time where none is asked for.
    #[must_use]
    pub fn certificate(&self, delay: Option<f64>) -> Option<(f64, PathBuf)> {
        let folder = self.variant.parent().unwrap_or(Path::new(""));
        let mut all = self
            .certificates
            .iter()
            .rev()
            .filter_map(|(seconds, name)| {
                // A name that leads elsewhere is none.
                let name = Path::new(name).file_name()?;
                Some((seconds.parse::<f64>().ok()?, folder.join(name)))
            });
        all.find(|(seconds, _)| delay.is_none_or(|delay| delay == *seconds))
    }

    /// The ids of the obstacles with a new motion.
    #[must_use]
    pub fn ids(&self) -> Vec<i64> {
        self.attackers.iter().map(|a| a.id).collect()
    }

    /// The last step before the first of them moves otherwise.
    #[must_use]
    pub fn from(&self) -> i64 {
        let all = self.attackers.iter().map(|a| a.from);
        all.min().unwrap_or(i64::MIN)
    }

    /// Whether a scenario is the original, byte for byte.
    #[must_use]
    pub fn is_of(&self, scenario: &Scenario) -> bool {
        scenario.hash.to_string() == self.sha256
    }

    /// The original: one of the bundled scenarios, beside the variant, in the folder above, or where it was when the
    /// variant was made.
    #[must_use]
    pub fn original(&self) -> Option<(Entry, Arc<Scenario>)> {
        let read = |entry: Entry| {
            let scenario = entry.read().ok()?;
            self.is_of(&scenario).then_some((entry, scenario))
        };
        let named = bundled().into_iter().filter(|entry| entry.name == self.id);
        // A certificate may name anything; reading what is not a file may never end.
        let files = self.places().into_iter().filter(|path| path.is_file());
        let mut all = named.chain(files.map(|path| Entry::of_file(&path)));
        all.find_map(read)
    }

    /// Why there is no original, and where it was looked for.
    #[must_use]
    pub fn missing(&self) -> String {
        let said = self.said.first().map_or(String::new(), |path| {
            format!("nor {}, ", visible(&path.display().to_string()))
        });
        format!(
            "the original {} (SHA-256 {}) is neither beside it, nor in the folder above, {said}nor among the bundled scenarios",
            visible(&self.id),
            visible(&self.sha256)
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
        for path in &self.said {
            // As it was said then, and with the variants and originals beside each other also from any other folder.
            places.extend([path.clone(), above.join(path)]);
        }
        places
    }

    /// The name of its file; an id that leads into other folders has none.
    fn file(&self) -> PathBuf {
        let mut name = Path::new(&self.id)
            .file_name()
            .unwrap_or_default()
            .to_os_string();
        name.push(".xml");
        name.into()
    }
}

fn hashes(said: &Value) -> Vec<(String, String)> {
    let all = said["sha256"]
        .as_object()
        .into_iter()
        .flatten()
        .map(|(name, hash)| (name.clone(), hash.as_str().unwrap_or_default().to_owned()));
    all.collect()
}

/// The drives that avoid a variant, by reaction time.
fn certificates(said: &Value) -> Vec<(String, String)> {
    let all = said["avoidable"].as_object().into_iter().flatten();
    let mut found: Vec<(String, String)> = all
        .filter(|(_, one)| one["avoided"] == true)
        .filter_map(|(seconds, one)| Some((seconds.clone(), one["trajectory"].as_str()?.into())))
        .collect();
    found.sort();
    found
}

/// The planner that was attacked, with its version.
fn planner(said: &Value) -> Option<String> {
    let word = |name: &str| said[name].as_str().filter(|word| !word.is_empty());
    let named = match (word("name"), word("version")) {
        (Some(name), Some(version)) => format!("{name} {version}"),
        (Some(name), None) => name.into(),
        (None, _) => word("named").or(said.as_str())?.into(),
    };
    Some(visible(&named).into_owned())
}

/// The style of the attackers: of bulk runs as a setting, of searches in the words about their author.
fn style(said: &Value) -> Option<AttackStyle> {
    let made = &said["made"];
    let settings = [&made["settings"]["style"], &made["line"]["style"]];
    let named = settings.into_iter().find_map(Value::as_str);
    let author = || Some(said["by"].as_str()?.rsplit_once("style ")?.1);
    AttackStyle::parse(named.or_else(author)?)
}

/// The attackers that a certificate lists.
fn attackers(said: &Value) -> Option<Vec<Attacker>> {
    let all = said["attackers"].as_array().filter(|all| !all.is_empty())?;
    let one = |one: &Value| {
        Some(Attacker {
            id: one["id"].as_i64()?,
            from: one["from_step"].as_i64()?,
        })
    };
    all.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use serde_json::json;

    use super::*;

    fn saved(folder: &Path, original: Value) -> Entry {
        let file = folder.join("v.xml");
        std::fs::write(&file, "<commonRoad/>").unwrap();
        let certificate = json!({
            "variant": "v.xml", "original": original, "attacker": 7, "change": {"from_step": 3},
        });
        std::fs::write(folder.join("v.json"), certificate.to_string()).unwrap();
        Entry::of_file(&file)
    }

    #[test]
    fn a_bundled_original_is_found_by_its_content() {
        let folder = tempfile::tempdir().unwrap();
        let first = bundled().remove(0);
        let hash = first.read().unwrap().hash.to_string();
        let named = json!({"benchmark_id": first.name, "sha256": hash});
        let origin = VariantOrigin::of(&saved(folder.path(), named)).unwrap();
        assert_eq!(origin.attacker, 7);
        assert_eq!(origin.attackers, [Attacker { id: 7, from: 3 }]);
        assert_eq!(origin.style, None);
        assert_eq!(origin.original().unwrap().0, first);

        let changed = json!({"benchmark_id": first.name, "sha256": "00", "file": "gone/x.xml"});
        let origin = VariantOrigin::of(&saved(folder.path(), changed)).unwrap();
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
        let origin = VariantOrigin::of(&saved(folder.path(), named)).unwrap();
        assert_eq!(origin.original().unwrap().0, entry);
    }

    #[test]
    fn all_attackers_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let entry = saved(folder.path(), json!({"benchmark_id": "A", "sha256": "00"}));
        let file = folder.path().join("v.json");
        let text = std::fs::read_to_string(&file).unwrap();
        let mut said: Value = serde_json::from_str(&text).unwrap();
        said["attackers"] = json!([{"id": 9, "from_step": 5}, {"id": 7, "from_step": 3}]);
        std::fs::write(&file, said.to_string()).unwrap();
        let origin = VariantOrigin::of(&entry).unwrap();
        assert_eq!((origin.attacker, origin.from()), (7, 3));
        assert_eq!(origin.ids(), [9, 7]);
    }

    #[test]
    fn the_style_is_that_of_the_settings_or_of_the_author() {
        let set = json!({"made": {"settings": {"style": "limit"}}, "by": "search, style human"});
        assert_eq!(style(&set), Some(AttackStyle::Limit));
        let by = json!({"made": null, "by": "search with seed 1, style human"});
        assert_eq!(style(&by), Some(AttackStyle::Human));
        assert_eq!(style(&json!({"by": "lab/x"})), None);
    }

    #[test]
    fn other_json_beside_a_scenario_says_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let entry = saved(folder.path(), json!({"benchmark_id": "A"}));
        assert_eq!(VariantOrigin::of(&entry), None);
        assert_eq!(VariantOrigin::of(&bundled().remove(0)), None);
    }
}
