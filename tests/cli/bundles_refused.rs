//! Bundles that are damaged or hostile: refused with a reason, and nothing is written.

use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use nearmiss::workflow::{Manifest, Member};
use sha2::{Digest, Sha256};

use super::CUT_IN;
use super::bundles::opened;
use super::support::program::Home;

/// A bundle of the built-in judge's answers.
fn bundle(home: &Home) -> Vec<u8> {
    let batch = [
        "evaluate",
        CUT_IN,
        "--model",
        "reference/geometry",
        "--samples",
        "1",
    ];
    home.run(&batch).status(0);
    home.run(&[
        "runs",
        "export",
        "--format=bundle",
        "--batch",
        "last",
        "-o",
        "e.nearmiss",
    ])
    .status(0);
    std::fs::read(home.files().join("e.nearmiss")).unwrap()
}

/// Its manifest, and its members with their bytes.
fn parts(path: &Path) -> (Manifest, Vec<(String, Vec<u8>)>) {
    let (bytes, _) = opened(path);
    let mut tar = tar::Archive::new(bytes.as_slice());
    let members = tar.entries().unwrap().map(|entry| {
        let mut entry = entry.unwrap();
        let name = entry.path().unwrap().display().to_string();
        let mut bytes = Vec::new();
        std::io::Read::read_to_end(&mut entry, &mut bytes).unwrap();
        (name, bytes)
    });
    let mut members: Vec<_> = members.collect();
    let (_, manifest) = members.remove(0);
    (serde_json::from_slice(&manifest).unwrap(), members)
}

/// A bundle of these parts; the manifest is told the truth about the bytes.
fn made(mut manifest: Manifest, members: &[(String, Vec<u8>)]) -> Vec<u8> {
    manifest.members = members
        .iter()
        .map(|(name, bytes)| Member {
            name: name.clone(),
            bytes: bytes.len() as u64,
            sha256: Sha256::digest(bytes)
                .iter()
                .map(|b| format!("{b:02x}"))
                .collect(),
        })
        .collect();
    packed(&manifest, members, tar::EntryType::Regular)
}

fn packed(manifest: &Manifest, members: &[(String, Vec<u8>)], kind: tar::EntryType) -> Vec<u8> {
    let mut tar = tar::Builder::new(GzEncoder::new(Vec::new(), Compression::default()));
    let mut add = |name: &str, bytes: &[u8], kind| {
        let mut header = tar::Header::new_ustar();
        header.set_path(name).unwrap();
        header.set_size(bytes.len() as u64);
        header.set_entry_type(kind);
        header.set_cksum();
        tar.append(&header, bytes).unwrap();
    };
    let json = serde_json::to_vec(manifest).unwrap();
    add("manifest.json", &json, tar::EntryType::Regular);
    for (at, (_, bytes)) in members.iter().enumerate() {
        add(&format!("m{at}"), bytes, kind);
    }
    tar.into_inner().unwrap().finish().unwrap()
}

#[test]
fn hostile_bundles_are_refused_and_nothing_is_written() {
    let home = Home::new();
    let whole = bundle(&home);
    let (manifest, members) = parts(&home.files().join("e.nearmiss"));
    let with = |name: &str, bytes: &[u8]| {
        let mut more = members.clone();
        more.insert(0, (name.into(), bytes.to_vec()));
        made(manifest.clone(), &more)
    };
    let mut later = manifest.clone();
    later.nearmiss_bundle = 99;
    let mut wrong = manifest.clone();
    wrong.members[0].sha256 = "0".repeat(64);
    let mut altered = members.clone();
    let batch = altered
        .iter_mut()
        .find(|(name, _)| name == "batch.jsonl")
        .unwrap();
    batch.1.extend_from_slice(b"{\"nearmiss_run\":99}\n");
    let mut zip = GzEncoder::new(Vec::new(), Compression::default());
    zip.write_all(b"something else").unwrap();
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "traversal",
            with("scenarios/../../evil.xml", b"x"),
            "no member of a bundle",
        ),
        (
            "absolute",
            with("/tmp/evil.xml", b"x"),
            "no member of a bundle",
        ),
        (
            "control characters",
            with("scenarios/\u{1b}[31m", b"x"),
            "no member of a bundle",
        ),
        ("stranger", with("evil.sh", b"x"), "no member of a bundle"),
        (
            "a name that no file system takes",
            with(&format!("scenarios/{}.xml", "x".repeat(300)), b"x"),
            "no member of a bundle",
        ),
        (
            "twice",
            with("Experiment.toml", b"x"),
            "no member of a bundle",
        ),
        (
            "bomb",
            with("scenarios/bomb.xml", &vec![0; 300 << 20]),
            "far more than its size",
        ),
        (
            "later",
            packed(&later, &members, tar::EntryType::Regular),
            "update nearmiss",
        ),
        (
            "wrong hash",
            packed(&wrong, &members, tar::EntryType::Regular),
            "another hash",
        ),
        (
            "links",
            packed(&manifest, &members, tar::EntryType::Symlink),
            "not what the manifest says",
        ),
        (
            "later line",
            made(manifest.clone(), &altered),
            "update nearmiss",
        ),
        (
            "no batch",
            made(manifest.clone(), &members[..1]),
            "it has no batch",
        ),
        ("half", whole[..whole.len() / 2].to_vec(), "cut off"),
        (
            "without its end",
            whole[..whole.len() - 4].to_vec(),
            "cut off",
        ),
        ("empty", Vec::new(), "cut off"),
        (
            "text",
            b"hello, this is a text and no bundle".to_vec(),
            "not a bundle",
        ),
        ("another gzip", zip.finish().unwrap(), ""),
    ];
    let other = Home::new();
    other.run(&["runs", "list"]).status(0);
    for (what, bytes, why) in cases {
        let file = other.write("bad.nearmiss", bytes);
        let unpack = other.run(&["runs", "import", "bad.nearmiss", "--into", "d"]);
        let said = unpack.status(2).says(&[why]).stderr;
        assert!(!said.contains('\u{1b}'), "{what}: {said}");
        assert!(!other.files().join("d").exists(), "{what}");
        assert!(other.rows("SELECT * FROM batches").is_empty(), "{what}");
        assert!(other.rows("SELECT * FROM runs").is_empty(), "{what}");
        std::fs::remove_file(file).unwrap();
    }
    // A byte changed anywhere is noticed, or makes no difference.
    other.write("good.nearmiss", &whole);
    for at in (20..whole.len()).step_by(whole.len() / 12) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        other.write("bad.nearmiss", bytes);
        other
            .run(&["runs", "import", "--dry-run", "bad.nearmiss"])
            .status(2);
    }
    // What is in the way stays as it is.
    other.write("d/experiment.toml", "mine");
    other
        .run(&["runs", "import", "good.nearmiss", "--into", "d"])
        .status(2)
        .says(&["experiment.toml", "--into"]);
    assert!(other.rows("SELECT * FROM batches").is_empty());
    assert_eq!(
        std::fs::read_to_string(other.files().join("d/experiment.toml")).unwrap(),
        "mine"
    );
    other.run(&["runs", "import", "good.nearmiss"]).status(0);
    assert_eq!(other.rows("SELECT * FROM batches").len(), 1);
    other
        .run(&["runs", "export", "--format=bundle", "--batch", "b9"])
        .status(2)
        .says(&["no batch b9"]);
    other
        .run(&["runs", "export", "--format=bundle", "--batch", "nonsense"])
        .status(2)
        .says(&["nonsense"]);
    other
        .run(&["runs", "import", "--dry-run", "none.nearmiss"])
        .status(2);
}
