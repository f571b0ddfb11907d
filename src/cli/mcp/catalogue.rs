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
    /// Its options.
    pub options: &'static [JobOption],
    /// Whether it is about the ego, the recorded one where the arguments choose none.
    pub needs_ego: bool,
    /// Whether it may cost money.
    pub paid: bool,
}

/// What the value of an option is.
#[derive(Debug, Clone, Copy)]
pub enum JobValue {
    /// Text that does not begin with `-`.
    Text,
    /// One of some words.
    Word(&'static [&'static str]),
    /// A whole number from the first to the second, ends included; without bounds where there is none.
    Whole(Option<u64>, Option<u64>),
    /// A number.
    Number,
}

/// An option of a job's command as an argument of its tool.
#[derive(Debug)]
pub struct JobOption {
    /// The argument.
    pub name: &'static str,
    /// The option.
    pub option: &'static str,
    /// What its value is.
    pub value: JobValue,
    /// What it means.
    pub about: &'static str,
}

const fn option(
    name: &'static str,
    option: &'static str,
    value: JobValue,
    about: &'static str,
) -> JobOption {
    JobOption {
        name,
        option,
        value,
        about,
    }
}

impl JobOption {
    /// What clients are told of it.
    pub fn schema(&self) -> Value {
        let mut schema = match self.value {
            JobValue::Text => json!({"type": "string"}),
            JobValue::Word(words) => json!({"type": "string", "enum": words}),
            JobValue::Whole(least, most) => {
                let mut schema = json!({"type": "integer"});
                for (name, bound) in [("minimum", least), ("maximum", most)] {
                    if let Some(bound) = bound {
                        schema[name] = bound.into();
                    }
                }
                schema
            }
            JobValue::Number => json!({"type": "number"}),
        };
        schema["description"] = self.about.into();
        schema
    }
}

/// The jobs.
pub const JOBS: &[Job] = &[
    Job {
        name: "plan",
        about: "Plans the ego's motion with the built-in planner and simulates it in the recorded traffic: outcome, goal, \
                limits, times. Reports progress; takes seconds.",
        command: "plan",
        options: &[],
        needs_ego: false,
        paid: false,
    },
    Job {
        name: "generate",
        about: "Searches a dangerous but avoidable variant of a safe scenario and says what came of it: attacker, \
                manoeuvre, outcome, who could have avoided it. Writes nothing. Reports progress; takes seconds to minutes.",
        command: "generate",
        options: &[
            option(
                "candidates",
                "--candidates",
                JobValue::Whole(Some(1), Some(100_000)),
                "Most motions that are tried.",
            ),
            option(
                "seed",
                "--seed",
                JobValue::Whole(Some(0), None),
                "Seed of the search.",
            ),
        ],
        needs_ego: false,
        paid: false,
    },
    Job {
        name: "render",
        about: "Draws the map with all participants at a step, as an SVG text.",
        command: "render",
        options: &[
            option(
                "at",
                "--at",
                JobValue::Whole(None, None),
                "Time step; the most telling one where it is left out.",
            ),
            EGO_OPTION,
        ],
        needs_ego: false,
        paid: false,
    },
    Job {
        name: "ask_model",
        about: "Asks a language model about the scenario; costs what its provider charges. The answer is stored. Needs \
                `max_tokens` where the server's configuration sets no limit of tokens.",
        command: "ask",
        options: &[
            option("model", "--model", JobValue::Text, "provider/model."),
            option(
                "task",
                "--task",
                JobValue::Word(&["collision", "safety"]),
                "collision or safety; collision where it is left out.",
            ),
            EGO_OPTION,
            option(
                "budget",
                "--budget",
                JobValue::Number,
                "Most that it may cost, US dollars; what is left of the session's budget where it is left out.",
            ),
            option(
                "max_tokens",
                "--max-tokens",
                JobValue::Whole(Some(1), Some(u32::MAX as u64)),
                "Most tokens of the answer, which bound its cost; `max_tokens` of the server's config.toml where it is left \
                 out.",
            ),
        ],
        needs_ego: true,
        paid: true,
    },
];

impl Job {
    /// Whether it needs the ego recorded beside the scenario: the arguments choose none.
    pub fn needs_recorded_ego(&self, arguments: &Value) -> bool {
        self.needs_ego && arguments[EGO.0].is_null()
    }

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
        for option in job.options {
            schema["properties"][option.name] = option.schema();
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
pub const EGO_OPTION: JobOption = option(EGO.0, "--ego", JobValue::Whole(None, None), EGO.2);

/// Where a tool of the table looks: argument, type, meaning.
pub const PLACE: [(&str, &str, &str); 4] = [
    (
        "scenario",
        "string",
        "Path of a scenario below the server's folders, or the name of a bundled one; resources/list has those of the \
         folders, or the bundled ones where the server has no folders.",
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

/// The argument `scenario` of a call.
///
/// # Errors
/// In words: it is missing, or no string.
pub fn scenario(arguments: &Value) -> Result<&str, String> {
    let shown = |value: &Value| value.to_string().chars().take(80).collect::<String>();
    match &arguments["scenario"] {
        Value::String(name) => Ok(name),
        Value::Null => Err("argument `scenario` is missing: the path or name of a scenario".into()),
        other => Err(format!(
            "argument `scenario` is {}, no string; expected the path or name of a scenario",
            shown(other)
        )),
    }
}
