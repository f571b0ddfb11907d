//! `nearmiss mcp`: a Model Context Protocol server over standard input and output.
//!
//! The protocol is spoken by hand: it is JSON-RPC 2.0 with a message a line, of which a server without subscriptions
//! needs ten methods, and the length of a line is bounded.

mod catalogue;
mod jobs;
mod lines;
mod places;
mod prompts;
mod purse;
mod server;

use std::io::{BufReader, stdin};
use std::path::PathBuf;

use super::ask::budget;
use super::open::{configuration, user_thresholds};
use super::{Failure, Outcome, output};
use places::Places;
use purse::Purse;
use server::Server;

/// Arguments of `mcp`.
#[derive(Debug, clap::Args)]
pub struct Mcp {
    /// Folders whose scenarios clients may open; nothing outside them is read, and nothing is written [default: none, the
    /// bundled scenarios alone].
    folders: Vec<PathBuf>,
    /// Also offer the oracles: the recorded future, contacts, and the built-in judge's verdict. Without them, clients can
    /// still read whole recordings; models that are being judged belong to `ask --tools`.
    #[arg(long)]
    oracles: bool,
    /// Let clients ask language models, which may cost money: adds the tool ask_model; needs --budget.
    #[arg(long, requires = "budget")]
    allow_models: bool,
    /// Maximum cost of all answers of the session in US dollars.
    #[arg(long, value_name = "USD", value_parser = budget, requires = "allow_models")]
    budget: Option<f64>,
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
        { arguments.budget }
            .filter(|_| arguments.allow_models)
            .map(Purse::new),
    );
    server.serve(BufReader::new(stdin().lock()));
    Ok(())
}
