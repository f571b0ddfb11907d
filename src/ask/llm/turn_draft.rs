//! The calls of a turn while they arrive in fragments.

use serde_json::Value;

use super::tool_calls::{ToolCall, ToolTurn};

/// Most calls of one turn that are read.
pub const MOST_CALLS: usize = 64;

/// Numbers of calls whose server gave them the number of another one.
const AGAIN: u64 = 1 << 32;

/// Calls so far, in the order in which they began.
#[derive(Debug, Default)]
pub(super) struct TurnDraft {
    /// Under the server's number, or one of [`AGAIN`] and more where that number had been taken by another call.
    calls: Vec<(u64, ToolCall)>,
    echo: Vec<Value>,
}

impl TurnDraft {
    /// The call with this number; the first mention begins it. `None` if there are too many.
    fn call(&mut self, number: u64) -> Option<&mut ToolCall> {
        let place = self.calls.iter().position(|(known, _)| *known == number);
        let place = match place {
            Some(place) => place,
            None if self.calls.len() == MOST_CALLS => return None,
            None => {
                let call = ToolCall {
                    id: String::new(),
                    name: String::new(),
                    arguments: String::new(),
                };
                self.calls.push((number, call));
                self.calls.len() - 1
            }
        };
        Some(&mut self.calls[place].1)
    }

    /// Under which number the call is that a server names by a number and an id: calls with the same number but another id
    /// are another one, and fragments without an id belong to the newest of them.
    pub fn number_of(&self, number: u64, id: &str) -> u64 {
        let same = |known: u64| known == number || known >= AGAIN && known % AGAIN == number;
        let mut calls = self.calls.iter().filter(|(known, _)| same(*known));
        let named = |call: &ToolCall| id.is_empty() || call.id.is_empty() || call.id == id;
        match calls.clone().rev().find(|(_, call)| named(call)) {
            Some((known, _)) => *known,
            None if calls.next().is_none() => number,
            None => AGAIN * (1 + self.calls.len() as u64) + number,
        }
    }

    /// Names a call. Servers say a name once or, some, with every fragment.
    pub fn named(&mut self, number: u64, id: &str, name: &str) {
        if let Some(call) = self.call(number) {
            if !id.is_empty() {
                id.clone_into(&mut call.id);
            }
            if !name.is_empty() {
                name.clone_into(&mut call.name);
            }
        }
    }

    /// A fragment of a call's arguments.
    pub fn arguments(&mut self, number: u64, fragment: &str) {
        if let Some(call) = self.call(number) {
            call.arguments.push_str(fragment);
        }
    }

    /// The whole arguments of a call, whatever fragments said.
    pub fn whole(&mut self, number: u64, arguments: &str) {
        if let Some(call) = self.call(number) {
            arguments.clone_into(&mut call.arguments);
        }
    }

    /// A part that the server has to see again.
    pub fn echo(&mut self, part: Value) {
        self.echo.push(part);
    }

    /// Whether a tool is called.
    pub fn is_empty(&self) -> bool {
        self.calls.is_empty()
    }

    /// How many calls there are.
    pub fn len(&self) -> u64 {
        self.calls.len() as u64
    }

    /// The turn; calls without an id get one, by which their results are found.
    pub fn turn(self, text: String, thought: String) -> ToolTurn {
        let calls = self
            .calls
            .into_iter()
            .enumerate()
            .map(|(place, (_, mut call))| {
                if call.id.is_empty() {
                    call.id = format!("call_{place}");
                }
                call
            });
        ToolTurn {
            text,
            thought,
            calls: calls.collect(),
            echo: self.echo,
        }
    }
}
