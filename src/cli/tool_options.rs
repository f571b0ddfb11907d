//! Options about tools that models may call.

use nearmiss_ask::llm::ToolLimits;

/// Limits of the calls of one answer.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct ToolLimitOptions {
    /// Most requests of one answer that may end in tool calls; then the model answers without tools [default: 8].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    pub tool_rounds: Option<u32>,
    /// Most tool calls of one answer; further ones are refused [default: 32].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub tool_calls: Option<u32>,
}

impl ToolLimitOptions {
    /// Whether one is given.
    pub fn any(&self) -> bool {
        self.tool_rounds.is_some() || self.tool_calls.is_some()
    }

    /// The limits.
    pub fn limits(&self) -> ToolLimits {
        let usual = ToolLimits::default();
        ToolLimits {
            rounds: self.tool_rounds.unwrap_or(usual.rounds),
            calls: self.tool_calls.unwrap_or(usual.calls),
        }
    }
}
