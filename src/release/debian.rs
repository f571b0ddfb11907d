//! The Debian package: the program with completions, manual page and its texts, where Debian keeps each.

use std::error::Error;

use crate::archive::{Packed, gzip, tar_gz};
use crate::built::{Built, source};

/// What Debian calls the machine of a target; none for programs that need libraries of the system.
pub fn architecture(target: &str) -> Option<&'static str> {
    match target.strip_suffix("-unknown-linux-musl")? {
        "x86_64" => Some("amd64"),
        "aarch64" => Some("arm64"),
        _ => None,
    }
}

/// A package for these machines.
///
/// # Errors
/// A file of the source cannot be read.
pub fn package(built: &Built, architecture: &str) -> Result<Vec<u8>, Box<dyn Error>> {
    let files = [
        Packed::program("usr/bin/nearmiss", &built.program[..]),
        Packed::file(
            "usr/share/bash-completion/completions/nearmiss",
            &built.bash[..],
        ),
        Packed::file("usr/share/doc/nearmiss/README.md", source("README.md")?),
        Packed::file(
            "usr/share/doc/nearmiss/CHANGELOG.md.gz",
            gzip(&source("CHANGELOG.md")?)?,
        ),
        Packed::file("usr/share/doc/nearmiss/copyright", source("LICENSE")?),
        Packed::file(
            "usr/share/fish/vendor_completions.d/nearmiss.fish",
            &built.fish[..],
        ),
        Packed::file("usr/share/man/man1/nearmiss.1.gz", gzip(&built.man)?),
        Packed::file("usr/share/zsh/vendor-completions/_nearmiss", &built.zsh[..]),
    ];
    let control = Packed::file("control", control(&files, architecture));
    Ok(ar(
        &[
            ("debian-binary", b"2.0\n"),
            ("control.tar.gz", &tar_gz(&[control], built.time)?),
            ("data.tar.gz", &tar_gz(&files, built.time)?),
        ],
        built.time,
    ))
}

/// The program is static: it depends on nothing. Certificates are for models in the network, ffmpeg is for films.
fn control(files: &[Packed], architecture: &str) -> String {
    let kib: usize = files
        .iter()
        .map(|file| file.bytes.len().div_ceil(1024))
        .sum();
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "Package: nearmiss\n\
         Version: {version}\n\
         Architecture: {architecture}\n\
         Maintainer: the developers of nearmiss\n\
         Installed-Size: {kib}\n\
         Recommends: ca-certificates\n\
         Suggests: ffmpeg\n\
         Section: science\n\
         Priority: optional\n\
         Description: workbench for safety-critical driving scenarios\n \
         Maps, measures, language models and the exact geometric truth side by side,\n \
         in a terminal.\n"
    )
}

/// An archive of `ar`, which a package is: a line of 60 bytes before each member, which begin at even places.
fn ar(members: &[(&str, &[u8])], time: u64) -> Vec<u8> {
    let mut archive = b"!<arch>\n".to_vec();
    for (name, bytes) in members {
        let size = bytes.len();
        let line = format!(
            "{name:<16}{time:<12}{:<6}{:<6}{:<8}{size:<10}`\n",
            0, 0, 100_644
        );
        archive.extend_from_slice(line.as_bytes());
        archive.extend_from_slice(bytes);
        archive.resize(archive.len().next_multiple_of(2), b'\n');
    }
    archive
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_of_ar_begin_at_even_places_behind_a_line_of_60_bytes() {
        let archive = ar(
            &[("debian-binary", b"2.0\n"), ("odd", b"abc"), ("last", b"x")],
            7,
        );
        let text = String::from_utf8_lossy(&archive);
        let line = |name: &str, size: &str| {
            format!("{name:<16}7           0     0     100644  {size:<10}`\n")
        };
        assert_eq!(line("odd", "3").len(), 60);
        let expected = [
            "!<arch>\n",
            &line("debian-binary", "4"),
            "2.0\n",
            &line("odd", "3"),
            "abc\n",
            &line("last", "1"),
            "x\n",
        ];
        assert_eq!(text, expected.concat());
    }

    #[test]
    fn only_static_programs_are_packages() {
        assert_eq!(architecture("x86_64-unknown-linux-musl"), Some("amd64"));
        assert_eq!(architecture("aarch64-unknown-linux-musl"), Some("arm64"));
        assert_eq!(architecture("x86_64-unknown-linux-gnu"), None);
        assert_eq!(architecture("aarch64-apple-darwin"), None);
    }
}
