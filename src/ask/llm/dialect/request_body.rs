//! What a request becomes on the wire.

use serde_json::Value;

use super::super::endpoint::Endpoint;
use super::super::request::Request;
use super::body::Body;
use super::kind::Dialect;

/// The JSON body of a request, exactly as [`crate::llm::stream()`] sends it.
#[must_use]
pub fn body(endpoint: &Endpoint, request: &Request) -> Value {
    let endpoint = &*endpoint.for_request(request);
    Value::Object(endpoint.dialect.protocol().body(endpoint, request).fields)
}

/// Whether a request carries the form of its answer: some servers take none while tools may be called.
#[must_use]
pub fn sends_form(endpoint: &Endpoint, request: &Request) -> bool {
    let with = Request {
        messages: Vec::new(),
        ..request.clone()
    };
    let without = Request {
        schema: None,
        ..with.clone()
    };
    body(endpoint, &with) != body(endpoint, &without)
}

/// Whether a request asks for log probabilities, and the endpoint's model gives them.
#[must_use]
pub fn gives_log_probabilities(endpoint: &Endpoint, request: &Request) -> bool {
    let endpoint = &*endpoint.for_request(request);
    let wanted = request.parameters.log_probabilities;
    wanted && endpoint.dialect != Dialect::Anthropic && {
        let mut asked = Body::default();
        asked.log_probabilities(endpoint, request, |out| out.put("asked", Value::Null));
        !asked.fields.is_empty()
    }
}

/// Parts of a request the endpoint's model does not accept, and parameters sent unrequested; one sentence each.
#[must_use]
pub fn notes(endpoint: &Endpoint, request: &Request) -> Vec<String> {
    let endpoint = &*endpoint.for_request(request);
    endpoint.dialect.protocol().body(endpoint, request).notes
}
