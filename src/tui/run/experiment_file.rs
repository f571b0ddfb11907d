//! An experiment file in the place of scenarios: `nearmiss FILE.toml`.

use std::path::{Path, PathBuf};

use nearmiss_ask::prompts::Library;
use nearmiss_settings::TextFile;
use nearmiss_workflow::{experiment_among, read_experiment};

/// The scenarios that the workbench lists, and the experiment that it opens if one is named in their place: then those
/// that it asks about, or the bundled ones where the file cannot be used, which its screen says.
///
/// # Errors
/// An experiment file is named beside other paths.
pub fn split_off(paths: Vec<PathBuf>) -> Result<(Vec<PathBuf>, Option<PathBuf>), String> {
    let Some(file) = experiment_among(&paths)?.map(Path::to_path_buf) else {
        return Ok((paths, None));
    };
    let text = TextFile::read(&file).map(|file| file.text);
    let experiment = text.and_then(|text| read_experiment(&text, &file, &Library::load(None)));
    let listed = experiment.map_or_else(|_| Vec::new(), |experiment| experiment.scenarios);
    Ok((listed, Some(file)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_experiment_lists_its_scenarios_and_stands_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("e.toml");
        let text = "scenarios = [\"ZAM_CutIn-1_1_T-1\", \"more\"]\nmodels = [\"lab/a\"]\n";
        std::fs::write(&file, text).unwrap();
        let listed = vec![
            PathBuf::from("ZAM_CutIn-1_1_T-1"),
            folder.path().join("more"),
        ];
        let split = |paths: &[&Path]| split_off(paths.iter().map(|p| p.to_path_buf()).collect());
        assert_eq!(split(&[&file]), Ok((listed, Some(file.clone()))));
        let scenario = Path::new("a.xml");
        assert_eq!(split(&[scenario]), Ok((vec![scenario.into()], None)));
        let error = split(&[scenario, &file]).unwrap_err();
        assert!(
            error.contains("e.toml") && error.contains("alone"),
            "{error}"
        );
        std::fs::write(&file, "scenarios = 3").unwrap();
        assert_eq!(split(&[&file]), Ok((Vec::new(), Some(file.clone()))));
    }
}
