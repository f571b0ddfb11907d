//! Kinds of binary files, by how they begin or by their names.

use super::{FORMATS, Found, Kind};

/// How files begin, and what they are: data of driving, and the rest.
const DATA: [(&[u8], &str); 7] = [
    (b"#ROSBAG", "a bag of ROS 1"),
    (b"\x89MCAP", "an MCAP file (ROS 2 or ASAM OSI)"),
    (b"\x89HDF\r\n", "an HDF5 file"),
    (
        b"ARROW1",
        "an Arrow table (Feather), as those of Argoverse 2's sensor data",
    ),
    (b"MDF ", "a measurement file (ASAM MDF)"),
    (b"MATLAB 5.0", "a MATLAB file"),
    (b"\x93NUMPY", "an array of NumPy"),
];
const REST: [(&[u8], &str); 9] = [
    (b"%PDF-", "a PDF document"),
    (b"\x89PNG", "a picture (PNG)"),
    (b"\xff\xd8\xff", "a picture (JPEG)"),
    (b"GIF8", "a picture (GIF)"),
    (b"RIFF", "a picture, sound or film (RIFF)"),
    (b"7z\xbc\xaf", "a 7z archive; unpack it first"),
    (b"Rar!", "a RAR archive; unpack it first"),
    (b"\x7fELF", "a program"),
    (b"MZ", "a program"),
];

/// Where a tar archive says that it is one.
const TAR: usize = 257;

/// What a binary file is, if it is known.
pub fn kind(name: &str, head: &[u8]) -> Option<Kind> {
    let of = |all: &[(&[u8], &str)]| -> Option<String> {
        let found = all.iter().find(|(begin, _)| head.starts_with(begin));
        found.map(|(_, what)| (*what).to_string())
    };
    if let Some(what) = of(&DATA) {
        return Some(Kind::data(what));
    }
    if head
        .get(TAR..)
        .is_some_and(|rest| rest.starts_with(b"ustar"))
    {
        return Some(Kind::new(Found::Other, "a tar archive", "unpack it first"));
    }
    // Programs begin with letters, as words do.
    if let Some(what) = of(&REST).filter(|what| what != "a program" || head.contains(&0)) {
        return Some(Kind::other(what));
    }
    if head.get(4..8) == Some(b"ftyp") {
        return Some(Kind::other("a film (MP4)"));
    }
    let begin = &head[..head.len().min(64)];
    if begin.windows(14).any(|w| w == b"CARLA_RECORDER") {
        let instead = "play it in CARLA and write where everyone is, for instance in the form of highD or of SUMO's floating car data (`nearmiss help scenarios`)";
        return Some(Kind::new(
            Found::Data,
            "a recording of CARLA's recorder",
            instead,
        ));
    }
    if let [0x80, 2..=5, ..] = head {
        let instead =
            format!("it could run any code, so nearmiss does not open such files; {FORMATS}");
        return Some(Kind::new(Found::Data, "a pickled Python object", instead));
    }
    if name.to_lowercase().ends_with(".osi") {
        return Some(Kind::data("a trace of ASAM OSI"));
    }
    None
}
