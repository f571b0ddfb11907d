//! Questions with tools to models that take them in another dialect than other questions.

use std::borrow::Cow;

use super::endpoint::Endpoint;
use super::request::Request;

impl Endpoint {
    /// The endpoint as it is for this request: one with tools is asked in [`super::Quirks::tools_dialect`], with the same
    /// key, limits and prices. What is stored of the request is of this one.
    #[must_use]
    pub fn for_request(&self, request: &Request) -> Cow<'_, Self> {
        let dialect = self.quirks.tools_dialect;
        let Some(dialect) = dialect.filter(|_| request.offered().is_some()) else {
            return Cow::Borrowed(self);
        };
        // An address may be written with the method of the other dialect.
        let method = self.dialect.protocol().method();
        let (path, query) = match self.base_url.trim().split_once('?') {
            Some((path, query)) => (path, format!("?{query}")),
            None => (self.base_url.trim(), String::new()),
        };
        let path = path.trim_end_matches('/');
        let root = path.strip_suffix(method).unwrap_or(path);
        Cow::Owned(Self {
            dialect,
            base_url: format!("{root}{query}"),
            ..self.clone()
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::llm::{Dialect, ToolSpec, Toolbox};

    fn request(tools: bool) -> Request {
        let spec = ToolSpec {
            name: "distance".into(),
            about: String::new(),
            schema: serde_json::json!({"type": "object"}),
        };
        Request {
            model: "m".into(),
            messages: Vec::new(),
            parameters: Default::default(),
            schema: None,
            tools: tools.then(|| Toolbox {
                specs: vec![spec],
                rounds: Vec::new(),
                may_call: true,
            }),
        }
    }

    #[test]
    fn only_questions_with_tools_go_elsewhere_however_the_address_is_written() {
        for (base, url) in [
            ("https://x.org/v1", "https://x.org/v1/responses"),
            ("https://x.org", "https://x.org/v1/responses"),
            (
                "https://x.org/v1/chat/completions/",
                "https://x.org/v1/responses",
            ),
            (
                "https://x.org/v1?api-version=2",
                "https://x.org/v1/responses?api-version=2",
            ),
        ] {
            let mut endpoint = Endpoint::new("mine", base);
            assert_eq!(
                endpoint.for_request(&request(true)).dialect,
                Dialect::OpenAiChat
            );
            endpoint.quirks.tools_dialect = Some(Dialect::OpenAiResponses);
            let asked = endpoint.for_request(&request(true));
            assert_eq!(asked.request_url("m").unwrap().as_str(), url);
            let plain = endpoint.for_request(&request(false));
            assert_eq!(plain.dialect, Dialect::OpenAiChat, "{base}");
        }
    }
}
