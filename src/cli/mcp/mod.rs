//! `nearmiss mcp`: a Model Context Protocol server over standard input and output.
//!
//! The protocol is spoken by hand: it is JSON-RPC 2.0 with a message a line, of which a server without subscriptions
//! needs ten methods. The official crate `rmcp` (Apache-2.0) would bring its own runtime glue, macros and four crates, and
//! does not bound the length of a line, which this server must.

mod catalogue;
mod jobs;
mod lines;
mod places;
mod prompts;
mod server;

use std::io::{BufReader, stdin};
use std::path::PathBuf;

use super::open::{configuration, user_thresholds};
use super::{Failure, Outcome, output};
use places::Places;
use server::Server;

/// Arguments of `mcp`.
#[derive(Debug, clap::Args)]
pub struct Mcp {
    /// Folders whose scenarios clients may open; nothing outside them is read, and nothing is written [default: none, the
    /// bundled scenarios alone].
    folders: Vec<PathBuf>,
    /// Also offer the oracles, which know the recorded future and the built-in judge's verdict; not for models that are
    /// being judged.
    #[arg(long)]
    oracles: bool,
    /// Let clients ask language models, which may cost money: adds the tool ask_model.
    #[arg(long)]
    allow_models: bool,
}

/// Runs `mcp` until standard input ends.
pub fn run(arguments: &Mcp) -> Outcome {
    let (folders, _) = configuration()?;
    let thresholds = user_thresholds(&folders)?;
    let places = Places::new(&arguments.folders).map_err(Failure::input)?;
    output::say(&format!(
        "nearmiss: MCP server on standard input and output; {}",
        places.words()
    ));
    let server = Server::new(
        places,
        thresholds,
        arguments.oracles,
        arguments.allow_models,
    );
    server.serve(BufReader::new(stdin().lock()));
    Ok(())
}
