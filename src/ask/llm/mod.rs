//! Asks language models over HTTP: one question in, a stream of chunks out.
//!
//! ```no_run
//! # async fn example() -> Result<(), nearmiss_ask::llm::Error> {
//! use futures_util::StreamExt;
//! use nearmiss_ask::llm::{Chunk, Client, Endpoint, Message, Parameters, Request, Role, stream};
//!
//! let request = Request {
//!     model: "qwen3".into(),
//!     messages: vec![Message::new(Role::User, "Is this dangerous?")],
//!     parameters: Parameters::default(),
//!     schema: None,
//!     tools: None,
//! };
//! let mut answer = stream(&Client::new(), Endpoint::new("local", "http://127.0.0.1:8080"), request);
//! while let Some(chunk) = answer.next().await {
//!     if let Chunk::Text(text) = chunk? {
//!         print!("{text}");
//!     }
//! }
//! # Ok(())
//! # }
//! ```

mod accumulator;
mod api_keys;
mod attempt;
/// Batches that providers work off at half the price.
pub mod batch;
mod body_text;
mod chunk;
mod client;
mod decoder;
mod dialect;
mod endpoint;
mod error;
mod error_body;
mod events;
mod limits;
mod portable_schema;
mod price;
mod price_table;
mod probe;
mod provider;
mod quirks;
mod redaction;
mod registry;
mod request;
mod sending;
mod streaming;

pub use accumulator::MAX_CALLS;
pub use api_keys::{Environment, KeyCommand, ResolvedKey, without_secrets};
pub use attempt::{ProviderOutage, RetryHint};
pub use chunk::{Chunk, Cost, CostSource, Finish, MAX_ANSWER_BYTES, Token, Usage};
pub use client::Client;
pub use decoder::THINKING_TAGS;
pub use dialect::{Auth, Dialect, body, gives_log_probabilities, notes, sends_form};
pub use endpoint::{Endpoint, ResponseFormat, Retry, Timeouts};
pub use error::{Error, ProviderAddress, TimeoutKind};
pub use events::decode;
pub use limits::{Budget, Limits, OverBudget};
pub use price::{Peak, Price, PriceEntry, Prices, Pricing};
pub use price_table::PriceTable;
pub use probe::{Discovered, Probed, ProviderStatus, Reachability, probe, reach};
pub use provider::RegistryError;
pub use quirks::{
    Effort, EffortLevels, Efforts, LogProbabilities, QUIRKS, Quirks, StatedQuirks, Temperature,
};
pub use redaction::Secrets;
pub use registry::{Address, KeyState, ModelListing, ModelOffer, Registry, Retirement};
pub use request::{
    CALL_OVERHEAD, Image, ImageTokens, Message, Parameters, Request, Role, Schema, ToolCall,
    ToolLimits, ToolRound, ToolSpec, ToolTurn, Toolbox,
};

use futures_util::stream::{self, Stream, StreamExt};

/// Whether a request can be sent as things stand: its address, its key, its size, and the money for it. A command that
/// prints the key is run, once for a client; nothing is sent.
///
/// # Errors
/// Why it would never be sent: [`Error::Setup`] or [`Error::Budget`].
pub async fn check(client: &Client, endpoint: &Endpoint, request: &Request) -> Result<(), Error> {
    let mut endpoint = endpoint.for_request(request).into_owned();
    sending::sendable(client, &mut endpoint, request).await
}

/// Asks once and gives the answer as it arrives; see [`Chunk`] for the order of the pieces and [`Error`] for what can
/// fail.
///
/// Nothing is sent before the stream is polled, and it must be polled within a tokio runtime. Dropping it closes the
/// connection. It ends after [`Chunk::Finished`] or after the first error. Failures that may pass are repeated as
/// [`Retry`] says, but only while no answer has begun: afterwards a repetition would be paid twice.
pub fn stream(
    client: &Client,
    endpoint: Endpoint,
    request: Request,
) -> impl Stream<Item = Result<Chunk, Error>> + Send + Unpin + 'static {
    let endpoint = endpoint.for_request(&request).into_owned();
    let exchange = streaming::StreamingRequest::new(client.clone(), endpoint, request);
    let chunks = stream::unfold(exchange, |mut exchange| async move {
        let item = exchange.next().await?;
        Some((item, exchange))
    });
    // Fused, because `unfold` panics when polled once too often.
    Box::pin(chunks.fuse())
}
