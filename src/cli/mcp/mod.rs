//! `nearmiss mcp`: a Model Context Protocol server over standard input and output, or over HTTP on loopback.
//!
//! `rmcp` speaks the protocol. What comes in is bounded before: lines and bodies, connections, and who may send.

mod catalogue;
mod http;
mod jobs;
mod looks;
mod places;
mod resources;
mod scenes;
mod server;
mod stdio;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::Arc;

use super::ask::budget;
use super::open::{configuration, user_thresholds};
use super::{Failure, Outcome, output};
use http::Token;
use jobs::Purse;
use places::Places;
use server::Server;

/// Arguments of `mcp`.
#[derive(Debug, clap::Args)]
pub struct Mcp {
    /// Folders whose scenarios clients may open, besides the bundled ones; no scenario outside them is read, and nothing is
    /// written [default: none, the bundled scenarios alone].
    folders: Vec<PathBuf>,
    /// Let clients ask language models, which may cost money: adds the tool ask_model; needs --budget.
    #[arg(long, requires = "budget")]
    allow_models: bool,
    /// Maximum cost of all answers of the session in US dollars.
    #[arg(long, value_name = "USD", value_parser = budget, requires = "allow_models")]
    budget: Option<f64>,
    /// Serve streamable HTTP at http://ADDRESS/mcp, on this machine alone; port 0 takes a free one. Clients send the token
    /// that is printed, or that of NEARMISS_MCP_TOKEN.
    #[arg(long, value_name = "ADDRESS", value_parser = loopback)]
    http: Option<SocketAddr>,
}

/// An address of this machine: `127.0.0.1:8000`.
fn loopback(text: &str) -> Result<SocketAddr, String> {
    let address: SocketAddr = text
        .parse()
        .map_err(|_| "expected an address with a port, such as 127.0.0.1:8000")?;
    if address.ip().is_loopback() {
        Ok(address)
    } else {
        Err("only addresses of this machine are served, such as 127.0.0.1:8000".into())
    }
}

/// Runs `mcp` until standard input ends, or over HTTP until it is interrupted.
pub fn run(arguments: &Mcp) -> Outcome {
    let (folders, config) = configuration()?;
    let thresholds = user_thresholds(&folders)?;
    let places = Places::new(&arguments.folders, config.maps.as_deref()).map_err(Failure::input)?;
    let words = places.words();
    let purse = arguments.budget.filter(|_| arguments.allow_models);
    let server = Arc::new(Server::new(places, thresholds, purse.map(Purse::new)));
    // When it is dropped, it waits for what still runs.
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .map_err(Failure::input)?;
    if let Some(address) = arguments.http {
        let given = std::env::var(http::VARIABLE).ok();
        let token = Token::new(given.as_deref()).map_err(Failure::input)?;
        return runtime.block_on(http::serve(server, address, token));
    }
    output::say(&format!(
        "nearmiss: MCP server on standard input and output; {words}"
    ));
    runtime.block_on(stdio::serve(&server))
}
