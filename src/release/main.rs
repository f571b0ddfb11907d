//! Packs the program for a release: an archive of a target, of a static one a Debian package, too, and their checksums.
//!
//! `cargo run -p nearmiss-release -- TARGET`

mod archive;
mod built;
mod debian;

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use archive::{Packed, tar_gz};
use built::{Built, source};
use clap::Parser;
use sha2::{Digest, Sha256};

/// Build nearmiss for a target and pack it into target/archives.
#[derive(Parser)]
struct Arguments {
    /// A target of Rust; by default this machine, on Linux as a static program.
    #[arg(default_value_t = built::usual_target())]
    target: String,
}

fn main() -> ExitCode {
    match pack(&Arguments::parse().target) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("nearmiss-release: {error}");
            ExitCode::FAILURE
        }
    }
}

fn pack(target: &str) -> Result<(), Box<dyn Error>> {
    let built = Built::for_target(target)?;
    let folder = built.folder.join("archives");
    std::fs::create_dir_all(&folder)?;
    let version = env!("CARGO_PKG_VERSION");
    let name = format!("nearmiss-{version}-{target}");
    let archive = tar_gz(&in_archive(&built, &name)?, built.time)?;
    write(&folder, &format!("{name}.tar.gz"), &archive)?;
    if let Some(architecture) = debian::architecture(target) {
        let package = debian::package(&built, architecture)?;
        write(
            &folder,
            &format!("nearmiss_{version}_{architecture}.deb"),
            &package,
        )?;
    }
    Ok(())
}

/// What an archive holds, in the folder `name`.
fn in_archive(built: &Built, name: &str) -> Result<[Packed; 7], Box<dyn Error>> {
    let place = |file: &str| format!("{name}/{file}");
    Ok([
        Packed::program(place("nearmiss"), &built.program[..]),
        Packed::file(place("LICENSE"), source("LICENSE")?),
        Packed::file(place("README.md"), source("README.md")?),
        Packed::file(place("completions/_nearmiss"), &built.zsh[..]),
        Packed::file(place("completions/nearmiss.bash"), &built.bash[..]),
        Packed::file(place("completions/nearmiss.fish"), &built.fish[..]),
        Packed::file(place("nearmiss.1"), &built.man[..]),
    ])
}

/// Writes a file, and beside it its checksum as `sha256sum --check` reads it.
fn write(folder: &Path, name: &str, bytes: &[u8]) -> Result<(), Box<dyn Error>> {
    let file = folder.join(name);
    std::fs::write(&file, bytes)?;
    let digest = Sha256::digest(bytes);
    let digest: String = digest.iter().map(|byte| format!("{byte:02x}")).collect();
    std::fs::write(
        folder.join(format!("{name}.sha256")),
        format!("{digest}  {name}\n"),
    )?;
    println!("{}", file.display());
    Ok(())
}
