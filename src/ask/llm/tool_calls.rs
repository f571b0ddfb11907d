//! Tools that a model may call: what is offered, calls, and the rounds of calls and results so far.

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A tool as a model is told of it.
#[derive(Clone, Debug, PartialEq)]
pub struct ToolSpec {
    /// Its name: letters, digits and `_`.
    pub name: String,
    /// What it computes.
    pub about: String,
    /// The JSON schema of its arguments.
    pub schema: Value,
}

/// Bytes that a call adds to a request beside its name, arguments and result, roughly.
pub const CALL: usize = 32;

/// Limits of the calls of one answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ToolLimits {
    /// Most requests that may end in calls; after them the model answers once without tools.
    pub rounds: u32,
    /// Most calls of all rounds together; further ones get an error as their result.
    pub calls: u32,
}

impl Default for ToolLimits {
    fn default() -> Self {
        Self {
            rounds: 8,
            calls: 32,
        }
    }
}

/// One call.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ToolCall {
    /// What the server knows it by.
    pub id: String,
    /// The tool.
    pub name: String,
    /// The arguments as the model wrote them: JSON, if it wrote it well.
    pub arguments: String,
}

/// A turn of the model that ends in calls.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ToolTurn {
    /// What the model said beside them.
    pub text: String,
    /// What it thought, where the server has to see that again.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub thought: String,
    /// The calls.
    pub calls: Vec<ToolCall>,
    /// Parts of the turn that the server has to see again as it sent them, such as signed thoughts; in the form of its
    /// dialect.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub echo: Vec<Value>,
}

/// A turn with the results of its calls.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolRound {
    /// The calls.
    #[serde(flatten)]
    pub turn: ToolTurn,
    /// Their results, in the order of the calls: JSON as text.
    pub results: Vec<String>,
}

/// The tools of a request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Toolbox {
    /// The tools.
    pub specs: Vec<ToolSpec>,
    /// The rounds before this request.
    pub rounds: Vec<ToolRound>,
    /// Whether the model may call tools now; otherwise it has to answer.
    pub may_call: bool,
}

impl ToolTurn {
    /// The same without secrets. What cannot be read afterwards held one, and is left out.
    pub(super) fn cleared(self, clear: impl Fn(String) -> String) -> Self {
        let echo = self.echo.into_iter().filter_map(|part| {
            let text = part.to_string();
            let cleared = clear(text.clone());
            if cleared == text {
                Some(part)
            } else {
                serde_json::from_str(&cleared).ok()
            }
        });
        Self {
            echo: echo.collect(),
            text: clear(self.text),
            thought: clear(self.thought),
            calls: self
                .calls
                .into_iter()
                .map(|call| ToolCall {
                    id: clear(call.id),
                    name: clear(call.name),
                    arguments: clear(call.arguments),
                })
                .collect(),
        }
    }
}

impl ToolCall {
    /// The arguments as a JSON object, for dialects that have them so; empty where the model wrote none.
    pub(super) fn object(&self) -> Value {
        let read = serde_json::from_str(&self.arguments);
        read.ok()
            .filter(Value::is_object)
            .unwrap_or_else(|| Value::Object(serde_json::Map::new()))
    }
}

impl ToolRound {
    /// Each call with its result.
    pub fn pairs(&self) -> impl Iterator<Item = (&ToolCall, &str)> {
        let results = self.results.iter().map(String::as_str);
        self.turn.calls.iter().zip(results)
    }

    /// Two bytes a token; a turn has no more tokens than an answer may have.
    fn bytes(&self, answer: Option<u32>) -> usize {
        let calls = self
            .turn
            .calls
            .iter()
            .map(|call| call.name.len() + call.arguments.len());
        let echo = self.turn.echo.iter().map(|part| part.to_string().len());
        let turn = self.turn.text.len() + self.turn.thought.len();
        let turn = turn + calls.sum::<usize>() + echo.sum::<usize>();
        let most = answer.map_or(usize::MAX, |tokens| (tokens as usize).saturating_mul(2));
        let results = self.results.iter().map(|result| result.len() + CALL);
        turn.min(most) + results.sum::<usize>()
    }
}

impl Toolbox {
    /// Tokens that the tools and the rounds add to a request, estimated to be rather too many than too few.
    #[must_use]
    pub fn tokens(&self) -> usize {
        self.bytes(None).div_ceil(2)
    }

    /// Bytes that the tools and the rounds add to a request, roughly; `answer` is the most tokens of an answer.
    pub(super) fn bytes(&self, answer: Option<u32>) -> usize {
        let specs = self
            .specs
            .iter()
            .map(|s| s.name.len() + s.about.len() + s.schema.to_string().len() + 48);
        specs.sum::<usize>()
            + self
                .rounds
                .iter()
                .map(|round| round.bytes(answer))
                .sum::<usize>()
    }
}
