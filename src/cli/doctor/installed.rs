//! How the program was installed: what lies beside its file says it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use nearmiss_base::system::{LARGEST_TEXT, read_text};
use schemars::JsonSchema;
use serde::de::IgnoredAny;
use serde::{Deserialize, Serialize};

/// How the program was installed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Installed {
    Wheel,
    Debian,
    Cargo,
    Build,
    Container,
    Copy,
}

/// What `cargo install` and cargo-binstall write beside `bin`.
#[derive(Deserialize)]
struct CratesOfCargo {
    installs: BTreeMap<String, IgnoredAny>,
}

impl Installed {
    /// Of the program with this file, on the system below `root` (`/`).
    pub fn of(program: &Path, root: &Path) -> Self {
        let there = |file: &str| root.join(file).exists();
        if is_of_wheel(program) {
            Self::Wheel
        } else if is_of_debian(program, root) {
            Self::Debian
        } else if is_of_cargo(program) {
            Self::Cargo
        } else if is_build(program) {
            Self::Build
        } else if there(".dockerenv") || there("run/.containerenv") {
            Self::Container
        } else {
            Self::Copy
        }
    }

    /// The rest of a sentence that begins with the program's file.
    pub fn words(self) -> &'static str {
        match self {
            Self::Wheel => "comes from the Python package nearmiss-av",
            Self::Debian => "comes from the Debian package nearmiss",
            Self::Cargo => "comes from `cargo install` or `cargo binstall`",
            Self::Build => "comes from a build and is not installed",
            Self::Container => "is a copied file in a container",
            Self::Copy => "is a copied file",
        }
    }
}

/// Programs of a wheel lie in `bin` of an environment, its other files in a folder of packages.
fn is_of_wheel(program: &Path) -> bool {
    let library = program.ancestors().nth(2).map(|root| root.join("lib"));
    let pythons = library.iter().flat_map(|lib| found(lib, "python3", ""));
    let beside = pythons.flat_map(|python| {
        ["site-packages", "dist-packages"].map(|packages| python.join(packages))
    });
    let around = program.ancestors().map(Path::to_path_buf);
    around
        .chain(beside)
        .any(|folder| !found(&folder, "nearmiss_av-", ".dist-info").is_empty())
}

/// What in a folder has a name that begins and ends so; nothing where it cannot be read.
fn found(folder: &Path, begin: &str, end: &str) -> Vec<PathBuf> {
    let entries = folder.read_dir().into_iter().flatten().flatten();
    let named = entries.filter(|entry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        name.starts_with(begin) && name.ends_with(end)
    });
    named.map(|entry| entry.path()).collect()
}

fn is_of_debian(program: &Path, root: &Path) -> bool {
    let Ok(program) = program.strip_prefix(root) else {
        return false;
    };
    let list = text(&root.join("var/lib/dpkg/info/nearmiss.list"));
    let mut files = list.lines().map(|line| line.trim_start_matches('/'));
    files.any(|file| Path::new(file) == program)
}

fn is_of_cargo(program: &Path) -> bool {
    let root = program.ancestors().nth(2);
    let list = root.map(|root| text(&root.join(".crates2.json")));
    let crates = list.and_then(|list| serde_json::from_str::<CratesOfCargo>(&list).ok());
    let names = crates.into_iter().flat_map(|crates| crates.installs);
    names
        .into_iter()
        .any(|(name, _)| name.starts_with("nearmiss "))
}

/// Cargo keeps a lock beside the programs that it builds: `.cargo-lock`, in newer ones one for each kind of file.
fn is_build(program: &Path) -> bool {
    let folder = program.parent();
    folder.is_some_and(|folder| !found(folder, ".cargo-", "lock").is_empty())
}

/// The text of a file; nothing where it cannot be read.
fn text(file: &Path) -> String {
    read_text(file, LARGEST_TEXT).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    /// A system with these files, and how a program in it was installed.
    fn installed(program: &str, files: &[(&str, &str)]) -> Installed {
        let root = tempfile::tempdir().unwrap();
        for (file, text) in files {
            let file = root.path().join(file);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, text).unwrap();
        }
        Installed::of(&root.path().join(program), root.path())
    }

    #[test]
    fn a_wheel_is_beside_the_programs_of_its_environment_or_around_the_file() {
        let record = "lib/python3.12/site-packages/nearmiss_av-0.1.0.dist-info/RECORD";
        let here = [(record, "")];
        assert_eq!(installed("bin/nearmiss", &here), Installed::Wheel);
        let inside = "lib/python3.12/site-packages/nearmiss/bin/nearmiss";
        assert_eq!(installed(inside, &here), Installed::Wheel);
        let debian = "usr/local/lib/python3.11/dist-packages/nearmiss_av-0.1.0.dist-info/RECORD";
        let other = [(debian, "")];
        assert_eq!(
            installed("usr/local/bin/nearmiss", &other),
            Installed::Wheel
        );
        // The environment of another program, and a package with another name.
        assert_eq!(installed("usr/bin/nearmiss", &other), Installed::Copy);
        let another = "lib/python3.12/site-packages/nearmiss-1.0.dist-info/RECORD";
        assert_eq!(installed("bin/nearmiss", &[(another, "")]), Installed::Copy);
    }

    #[test]
    fn a_package_of_debian_lists_the_program() {
        let list = (
            "var/lib/dpkg/info/nearmiss.list",
            "/.\n/usr\n/usr/bin/nearmiss\n",
        );
        assert_eq!(installed("usr/bin/nearmiss", &[list]), Installed::Debian);
        assert_eq!(installed("opt/nearmiss", &[list]), Installed::Copy);
    }

    #[test]
    fn cargo_lists_the_crate() {
        let list =
            |name: &str| format!("{{\"installs\":{{\"{name} 0.1.0 (path)\":{{}}}},\"v\":1}}");
        let of = |text: &str| installed(".cargo/bin/nearmiss", &[(".cargo/.crates2.json", text)]);
        assert_eq!(of(&list("nearmiss")), Installed::Cargo);
        for other in [&list("nearmiss-other"), "{}", "no json"] {
            assert_eq!(of(other), Installed::Copy, "{other}");
        }
    }

    #[test]
    fn a_build_lies_beside_the_lock_of_cargo() {
        for lock in [
            "target/debug/.cargo-lock",
            "target/debug/.cargo-artifact-lock",
        ] {
            let files = [(lock, "")];
            assert_eq!(installed("target/debug/nearmiss", &files), Installed::Build);
            assert_eq!(installed("target/nearmiss", &files), Installed::Copy);
        }
    }

    #[test]
    fn what_nothing_lists_is_a_copy_in_a_container_or_not() {
        let docker = (".dockerenv", "");
        assert_eq!(installed("nearmiss", &[docker]), Installed::Container);
        let podman = ("run/.containerenv", "");
        assert_eq!(installed("nearmiss", &[podman]), Installed::Container);
        assert_eq!(installed("opt/nearmiss", &[]), Installed::Copy);
    }
}
