//! What clients can call: the table of tools, and jobs that are commands of this program.

use serde_json::{Value, json};

use crate::tools::{Kind, TOOLS, Tool};

/// A command of this program as a tool.
#[derive(Debug)]
pub struct Job {
    /// Its name.
    pub name: &'static str,
    /// What it does.
    pub about: &'static str,
    /// The command.
    pub command: &'static str,
    /// Its options: name of the argument, option, kind (`string`, `integer`, `number`), what it means.
    pub options: &'static [(&'static str, &'static str, &'static str, &'static str)],
    /// Whether it may cost money.
    pub paid: bool,
}

/// The jobs.
pub const JOBS: &[Job] = &[
    Job {
        name: "plan",
        about: "Plans the ego's motion with the built-in planner and simulates it in the recorded traffic: outcome, goal, \
                limits, times. Reports progress; takes seconds.",
        command: "plan",
        options: &[],
        paid: false,
    },
    Job {
        name: "generate",
        about: "Searches a dangerous but avoidable variant of a safe scenario and says what came of it: attacker, \
                manoeuvre, outcome, who could have avoided it. Writes nothing. Reports progress; takes seconds to minutes.",
        command: "generate",
        options: &[
            (
                "candidates",
                "--candidates",
                "integer",
                "Most motions that are tried.",
            ),
            ("seed", "--seed", "integer", "Seed of the search."),
        ],
        paid: false,
    },
    Job {
        name: "render",
        about: "Draws the map with all participants at a step, as an SVG text.",
        command: "render",
        options: &[
            (
                "at",
                "--at",
                "integer",
                "Time step; the most telling one where it is left out.",
            ),
            EGO_OPTION,
        ],
        paid: false,
    },
    Job {
        name: "ask_model",
        about: "Asks a language model about the scenario; costs what its provider charges. The answer is stored.",
        command: "ask",
        options: &[
            ("model", "--model", "string", "provider/model."),
            (
                "task",
                "--task",
                "string",
                "collision or safety; collision where it is left out.",
            ),
            EGO_OPTION,
            (
                "budget",
                "--budget",
                "number",
                "Most that it may cost, US dollars.",
            ),
        ],
        paid: true,
    },
];

impl Job {
    /// Whether clients call it as a tool.
    pub fn is_tool(&self) -> bool {
        JOBS.iter().any(|job| job.name == self.name)
    }
}

/// Whether a tool of the table is offered.
pub fn is_offered(tool: &Tool, oracles: bool) -> bool {
    oracles || tool.kind == Kind::Instrument
}

/// The tools as the protocol lists them.
pub fn tools(oracles: bool, paid: bool) -> Value {
    let table = TOOLS.iter().filter(|tool| is_offered(tool, oracles));
    let table = table.map(|tool| {
        let mut schema = tool.arguments_schema();
        for (name, kind, about) in PLACE {
            schema["properties"][name] = json!({"type": kind, "description": about});
        }
        if let Some(required) = schema["required"].as_array_mut() {
            required.insert(0, "scenario".into());
        }
        json!({
            "name": tool.name,
            "description": tool.about,
            "inputSchema": schema,
            "outputSchema": tool.result_schema(),
            "annotations": {"readOnlyHint": true, "openWorldHint": false},
        })
    });
    let jobs = JOBS.iter().filter(|job| paid || !job.paid).map(|job| {
        let mut schema = json!({
            "type": "object",
            "properties": {"scenario": {"type": "string", "description": PLACE[0].2}},
            "required": ["scenario"],
            "additionalProperties": false,
        });
        for (name, _, kind, about) in job.options {
            schema["properties"][name] = json!({"type": kind, "description": about});
        }
        json!({
            "name": job.name,
            "description": job.about,
            "inputSchema": schema,
            "annotations": {"readOnlyHint": !job.paid, "openWorldHint": job.paid},
        })
    });
    table.chain(jobs).collect()
}

/// The argument that chooses the ego. Files are not taken: they may lie outside the folders.
const EGO: (&str, &str, &str) = (
    "ego",
    "integer",
    "Id of the obstacle that is the ego; the recorded ego where it is left out.",
);

/// The same as an option of a job.
const EGO_OPTION: (&str, &str, &str, &str) = (EGO.0, "--ego", EGO.1, EGO.2);

/// Where a tool of the table looks: argument, type, meaning.
pub const PLACE: [(&str, &str, &str); 4] = [
    (
        "scenario",
        "string",
        "Path of the scenario below the server's folders, or the name of a bundled one; resources/list has all.",
    ),
    (
        "at",
        "integer",
        "Time step at which the window ends, beyond which nothing is seen; the last recorded one where it is left out.",
    ),
    (
        "history",
        "integer",
        "Steps in the window; 10 where it is left out.",
    ),
    EGO,
];
