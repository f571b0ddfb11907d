//! The protobuf messages in the source are those that their .proto file makes.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use tempfile::tempdir;

/// The first line of the generated file.
const FIRST_LINE: &str = "//! CommonRoad's protobuf messages, generated from messages.proto.\n";

#[test]
fn the_messages_are_those_of_the_proto_file() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/formats/commonroad/protobuf");
    let schema = protox::compile([folder.join("messages.proto")], [&folder]).unwrap();
    let out = tempdir().unwrap();
    let mut config = prost_build::Config::new();
    config.out_dir(out.path()).compile_fds(schema).unwrap();
    let made = std::fs::read_to_string(out.path().join("commonroad.rs")).unwrap();
    let made = format!("{FIRST_LINE}{made}");
    let file = folder.join("messages.rs");
    if std::env::var_os("NEARMISS_GENERATE_MESSAGES").is_some() {
        std::fs::write(&file, &made).unwrap();
    }
    let same = std::fs::read_to_string(file).unwrap() == made;
    assert!(
        same,
        "messages.rs is not what messages.proto makes: run this test with NEARMISS_GENERATE_MESSAGES=1"
    );
}
