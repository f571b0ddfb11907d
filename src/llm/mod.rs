//! Asks language models over HTTP: one question in, a stream of chunks out.
//!
//! ```no_run
//! # async fn example() -> Result<(), nearmiss::llm::Error> {
//! use futures_util::StreamExt;
//! use nearmiss::llm::{Chunk, Client, Endpoint, Message, Parameters, Request, Role, stream};
//!
//! let request = Request {
//!     model: "qwen3".into(),
//!     messages: vec![Message { role: Role::User, content: "Is this dangerous?".into() }],
//!     parameters: Parameters::default(),
//!     schema: None,
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

mod chunk;
mod client;
mod endpoint;
mod error;
mod exchange;
mod failure;
mod openai_chat;
mod patience;
mod problem;
mod registry;
mod request;
mod retry;
mod text;
mod think;

pub use chunk::{Chunk, Finish, Usage};
pub use client::Client;
pub use endpoint::{Endpoint, ResponseFormat, Retry, Timeouts};
pub use error::{Error, Place, Which};
pub use openai_chat::body;
pub use registry::{Offer, Provider, Registry, RegistryError};
pub use request::{Message, Parameters, Request, Role, Schema};

use futures_util::stream::{self, Stream, StreamExt};

/// Asks once and gives the answer as it arrives; see [`Chunk`] for the order of the pieces and [`Error`] for what can fail.
///
/// Nothing is sent before the stream is polled, and it must be polled within a tokio runtime. Dropping it closes the
/// connection. It ends after [`Chunk::Finished`] or after the first error. Failures that may pass are repeated as
/// [`Retry`] says, but only while no answer has begun: afterwards a repetition would be paid twice.
pub fn stream(
    client: &Client,
    endpoint: Endpoint,
    request: Request,
) -> impl Stream<Item = Result<Chunk, Error>> + Send + Unpin + 'static {
    let exchange = exchange::Exchange::new(client.clone(), endpoint, request);
    let chunks = stream::unfold(exchange, |mut exchange| async move {
        let item = exchange.next().await?;
        Some((item, exchange))
    });
    // Fused, because `unfold` panics when polled once too often.
    Box::pin(chunks.fuse())
}
