//! The protobuf messages in the source are those that their .proto file makes.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use tempfile::tempdir;

/// The folder of each file, its package, and the first line of what is generated.
const FILES: [(&str, &str, &str); 3] = [
    (
        "src/formats/commonroad/protobuf",
        "commonroad",
        "//! CommonRoad's protobuf messages, generated from messages.proto.\n",
    ),
    (
        "src/formats/recordings/waymo",
        "waymo",
        "//! The messages of Waymo Open Motion, generated from messages.proto.\n",
    ),
    (
        "src/formats/recordings/osi",
        "osi",
        "//! The messages of ASAM OSI, generated from messages.proto.\n",
    ),
];

#[test]
fn the_messages_are_those_of_the_proto_file() {
    for (folder, package, first_line) in FILES {
        check(folder, package, first_line);
    }
}

fn check(folder: &str, package: &str, first_line: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let schema = protox::compile([folder.join("messages.proto")], [&folder]).unwrap();
    let out = tempdir().unwrap();
    let mut config = prost_build::Config::new();
    config.out_dir(out.path()).compile_fds(schema).unwrap();
    let made = std::fs::read_to_string(out.path().join(format!("{package}.rs"))).unwrap();
    let made = format!("{first_line}{made}");
    let file = folder.join("messages.rs");
    if std::env::var_os("NEARMISS_GENERATE_MESSAGES").is_some() {
        std::fs::write(&file, &made).unwrap();
    }
    let same = std::fs::read_to_string(file).unwrap() == made;
    assert!(
        same,
        "{package}: messages.rs is not what messages.proto makes: run this test with NEARMISS_GENERATE_MESSAGES=1"
    );
}
