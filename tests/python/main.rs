//! The Python module: each script beside this file, in the Pythons that are there.
//!
//! `NEARMISS_PYTHON` names a Python with the packages of `requirements.txt`; without it `python3` is used, and what needs
//! packages that it lacks is skipped. `NEARMISS_ENGINES_PYTHON` names one with `engines.txt`.
#![allow(clippy::unwrap_used)]

#[path = "../support/mod.rs"]
mod support;

use std::path::{Path, PathBuf};
use std::process::Command;

use support::program::skipped;
use support::python::package;

/// A Python with these packages; nothing where there is none, which is said.
fn python(variable: &str, packages: &str) -> Option<String> {
    let python = std::env::var(variable).unwrap_or("python3".into());
    let there = Command::new(&python)
        .args([
            "-c",
            &format!("import sys, {packages}; assert sys.version_info >= (3, 10)"),
        ])
        .output();
    if there.is_ok_and(|ended| ended.status.success()) {
        return Some(python);
    }
    skipped(&format!("{python} lacks {packages} ({variable})"));
    None
}

/// Runs a script in a home of its own, and gives what it prints.
fn run(python: &str, script: &str, arguments: &[&str]) -> String {
    let (package, home) = (package(), tempfile::tempdir().unwrap());
    let file = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/python")
        .join(script);
    let ended = Command::new(python)
        .arg("-B")
        .arg(file)
        .args(arguments)
        .current_dir(home.path())
        .env("HOME", home.path())
        .env_remove("XDG_CONFIG_HOME")
        .env_remove("XDG_DATA_HOME")
        .env("NEARMISS", env!("CARGO_BIN_EXE_nearmiss"))
        .env("PYTHONPATH", package.path())
        .env("PYTHONUNBUFFERED", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    let errors = String::from_utf8_lossy(&ended.stderr);
    assert!(
        ended.status.success(),
        "{script}: {}\n{said}\n{errors}",
        ended.status
    );
    said
}

#[test]
fn the_module_needs_python_alone() {
    if let Some(python) = python("NEARMISS_PYTHON", "unittest") {
        run(&python, "basics.py", &[]);
    }
}

#[test]
fn drives_and_attacks_are_those_of_the_commands() {
    if let Some(python) = python("NEARMISS_PYTHON", "unittest") {
        run(&python, "driving.py", &[]);
    }
}

#[test]
fn tables_are_taken_and_given_by_the_libraries_for_them() {
    if let Some(python) = python("NEARMISS_PYTHON", "pyarrow, polars, pandas, duckdb") {
        run(&python, "tables.py", &[]);
    }
}

#[test]
fn the_stubs_tell_what_the_module_has() {
    let Some(python) = python("NEARMISS_PYTHON", "mypy.stubtest") else {
        return;
    };
    let package = package();
    // The compiled module lists its names by itself.
    let allowed = package.path().join("allowed");
    std::fs::write(&allowed, "nearmiss\\._nearmiss\\.__all__\n").unwrap();
    let ended = Command::new(&python)
        .args(["-m", "mypy.stubtest", "nearmiss"])
        .args(["--ignore-disjoint-bases", "--allowlist"])
        .arg(&allowed)
        .current_dir(package.path())
        .env("PYTHONPATH", package.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&ended.stdout);
    assert!(ended.status.success(), "{said}");
}

#[test]
fn the_notebook_runs_from_its_first_cell_to_its_last() {
    if let Some(python) = python("NEARMISS_PYTHON", "nbclient, ipykernel, polars") {
        let notebook = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/docs/notebook.ipynb");
        print!(
            "{}",
            run(&python, "notebook.py", &[&notebook.display().to_string()])
        );
    }
}

#[test]
fn scenarios_are_objects_of_commonroad_io_and_back() {
    if let Some(python) = python("NEARMISS_PYTHON", "commonroad") {
        run(&python, "commonroad_io.py", &[]);
    }
}

/// Scenarios in files of several formats.
fn files(folder: &Path) -> Vec<String> {
    let names = [
        "ZAM_CutIn-1_1_T-1",
        "ZAM_RedLight-1_1_T-1",
        "ZAM_Pedestrian-1_1_T-1",
    ];
    let mut files = Vec::new();
    for ending in ["xml", "csv", "parquet", "xosc"] {
        for name in names {
            let file = folder.join(format!("{name}.{ending}"));
            let ended = Command::new(env!("CARGO_BIN_EXE_nearmiss"))
                .args(["convert", name, "-o"])
                .arg(&file)
                .output()
                .unwrap();
            assert!(
                ended.status.success(),
                "{}",
                String::from_utf8_lossy(&ended.stderr)
            );
            if ending != "xosc" {
                files.push(file.display().to_string());
            }
        }
    }
    let roads = names.map(|name| folder.join(format!("{name}.xodr")));
    files.extend(
        roads
            .iter()
            .map(|road: &PathBuf| road.display().to_string()),
    );
    files
}

/// Damaged files; `NEARMISS_MUTATED_CASES` and `NEARMISS_MUTATED_SEED` name others.
#[test]
fn a_damaged_file_is_an_exception() {
    let Some(python) = python("NEARMISS_PYTHON", "random") else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let files = files(folder.path());
    let said = |name: &str, usual: &str| std::env::var(name).unwrap_or(usual.into());
    let (cases, seed) = (
        said("NEARMISS_MUTATED_CASES", "300"),
        said("NEARMISS_MUTATED_SEED", "1"),
    );
    let mut arguments = vec!["mutated", &cases, &seed];
    arguments.extend(files.iter().map(String::as_str));
    print!("{}", run(&python, "hostile.py", &arguments));
}

/// `NEARMISS_OPENS` is how often (1,000).
#[test]
fn memory_stays_flat() {
    let Some(python) = python("NEARMISS_PYTHON", "gc") else {
        return;
    };
    let opens = std::env::var("NEARMISS_OPENS").unwrap_or("1000".into());
    let names = [
        "ZAM_CutIn-1_1_T-1",
        "ZAM_Merge-1_1_T-1",
        "ZAM_RightTurn-1_1_T-1",
    ];
    let arguments = [&["memory", &opens], &names[..]].concat();
    print!("{}", run(&python, "hostile.py", &arguments));
}

#[test]
fn ray_has_the_rows_of_the_command_also_where_a_worker_is_killed() {
    if let Some(python) = python("NEARMISS_ENGINES_PYTHON", "ray.data, pyarrow") {
        print!("{}", run(&python, "engines.py", &["ray"]));
        print!("{}", run(&python, "engines.py", &["ray", "killed"]));
    }
}

#[test]
fn spark_has_the_rows_of_the_command_also_where_a_worker_is_killed() {
    if Command::new("java").arg("-version").output().is_err() {
        skipped("no java for Spark");
        return;
    }
    if let Some(python) = python("NEARMISS_ENGINES_PYTHON", "pyspark, pyarrow") {
        print!("{}", run(&python, "engines.py", &["spark"]));
        print!("{}", run(&python, "engines.py", &["spark", "killed"]));
    }
}

#[test]
fn daft_has_the_rows_of_the_command() {
    if let Some(python) = python("NEARMISS_ENGINES_PYTHON", "daft, pyarrow") {
        print!("{}", run(&python, "engines.py", &["daft"]));
    }
}
