//! The Python module, as it is installed.
#![allow(clippy::unwrap_used)]

use std::path::Path;

/// The module as it is installed: the files of the package, and the library beside them.
pub fn package() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let package = folder.path().join("nearmiss");
    std::fs::create_dir(&package).unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/python/nearmiss");
    for entry in std::fs::read_dir(source).unwrap() {
        let path = entry.unwrap().path();
        let is_text = |path: &Path| path.extension().is_some_and(|end| end != "so");
        if path.is_file() && is_text(&path) {
            std::fs::copy(&path, package.join(path.file_name().unwrap())).unwrap();
        }
    }
    let tests = std::env::current_exe().unwrap();
    let ending = if cfg!(target_os = "macos") {
        "dylib"
    } else {
        "so"
    };
    let library = tests.with_file_name(format!("lib_nearmiss.{ending}"));
    let place = package.join("_nearmiss.abi3.so");
    std::os::unix::fs::symlink(&library, place).unwrap();
    assert!(library.exists(), "{} was not built", library.display());
    folder
}
