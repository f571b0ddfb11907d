//! What clients can call: looks into the scenarios, and jobs that are commands of this program.

use rmcp::model::{JsonObject, Tool as ListedTool, ToolAnnotations};
use serde_json::{Value, json};

use super::jobs::Progress;
use super::{Server, looks};
use crate::span::At;

/// A tool.
#[derive(Debug)]
pub struct Tool {
    /// Its name.
    pub name: &'static str,
    /// What it tells or does.
    pub about: &'static str,
    /// Its arguments.
    pub options: &'static [JobOption],
    /// Whether it may take minutes, so that others do not wait for it.
    pub takes_long: bool,
    /// Whether it may cost money.
    pub paid: bool,
    /// How it is answered.
    pub does: Does,
}

/// How a tool is answered.
#[derive(Debug)]
pub enum Does {
    /// By this process: the result of checked arguments, or in words why there is none.
    Look(fn(&Server, &Value, &Progress) -> Result<Value, String>),
    /// By a command.
    Run(Job),
}

/// A command of this program, about a scenario.
#[derive(Debug)]
pub struct Job {
    /// The command, with what is always said to it behind spaces.
    pub command: &'static str,
    /// What it gives.
    pub gives: Gives,
    /// Whether it is about the ego, the recorded one where the arguments choose none.
    pub needs_ego: bool,
}

/// What a command gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gives {
    /// Text.
    Text,
    /// A JSON object.
    Json,
    /// A PNG.
    Picture,
}

/// What the value of an option is.
#[derive(Debug, Clone, Copy)]
pub enum JobValue {
    /// Text.
    Text,
    /// A moment, as `--at` takes it; the most severe one where it is left out.
    Moment,
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
    /// The option; empty for what is no option of the command.
    pub option: &'static str,
    /// What its value is.
    pub value: JobValue,
    /// What it means.
    pub about: &'static str,
    /// Whether it may not be left out.
    pub required: bool,
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
        required: false,
    }
}

impl JobOption {
    /// What clients are told of it.
    pub fn schema(&self) -> Value {
        let mut schema = match self.value {
            JobValue::Text => json!({"type": "string"}),
            JobValue::Moment => json!({"type": ["integer", "string"]}),
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

/// The argument that chooses the scenario.
pub const SCENARIO: JobOption = JobOption {
    required: true,
    ..option(
        "scenario",
        "",
        JobValue::Text,
        "Scenario name from list_scenarios.",
    )
};

/// The argument that chooses the ego. Files are not taken: they may lie outside the folders.
pub const EGO: JobOption = option(
    "ego",
    "--ego",
    JobValue::Whole(None, None),
    "Id of the obstacle that is the ego [default: the recorded ego].",
);

/// The argument that chooses the moment.
const AT: JobOption = option(
    "at",
    "--at",
    JobValue::Moment,
    "Time step, or worst, worst:ttc, worst:distance or worst:risk [default: worst, the most severe moment].",
);

/// The argument that asks for the next page.
pub const CURSOR: JobOption = option("cursor", "", JobValue::Text, "Previous page's `cursor`.");

/// What is looked for.
pub const FILTER: JobOption = JobOption {
    required: true,
    ..option(
        "filter",
        "",
        JobValue::Text,
        "Terms, separated by spaces: manoeuvre:cut_in,merging ttc<1.5 road:highway.",
    )
};

/// How much is given.
pub const NUMBER: JobOption = option(
    "number",
    "",
    JobValue::Whole(Some(1), Some(100)),
    "Maximum number of windows [default: 10].",
);

/// The tools.
const TOOLS: &[Tool] = &[
    Tool {
        name: "list_scenarios",
        about: "Lists the scenarios, most severe first. Each has its severity (0 contact, 1 conflict, 2 near miss, 3 \
                course, 4 later, 5 none), the time step `at` of the most severe moment, the obstacle, and the reason. \
                Scenarios without a recorded ego have `ego`: pass it to the other tools. Start here.",
        options: &[CURSOR],
        takes_long: true,
        paid: false,
        does: Does::Look(looks::list),
    },
    Tool {
        name: "inspect",
        about: "Shows what a scenario contains: time steps and their length, road, obstacles, ego and warnings. Lists \
                the most severe moment with each obstacle, most severe first.",
        options: &[SCENARIO, EGO],
        takes_long: false,
        paid: false,
        does: Does::Look(looks::inspect),
    },
    Tool {
        name: "find",
        about: "Searches the 2 s windows of every pair of road users in all scenarios for those that match all terms, \
                most severe first: manoeuvre: (cut_in, lane_change, merging, following, followed, parallel, oncoming, \
                crossing, turning_across, standing, other), road: (intersection, highway, ramp, urban, country, \
                untyped, off_road), actor: (car, truck, bus, motorcycle, bicycle, pedestrian, …), severity<=2, \
                measures such as ttc<1.5, pet<1, drac>4, distance<2; country:DEU, tag:, a word of a name. `,` \
                separates alternatives, `!` negates a term. If `ego_source` is obstacle, pass `ego_id` as `ego` to \
                other tools. The first call measures all scenarios and takes longer.",
        options: &[FILTER, NUMBER],
        takes_long: true,
        paid: false,
        does: Does::Look(looks::find),
    },
    Tool {
        name: "describe",
        about: "Describes the window that ends at a moment as a table, as in prompts. Each step has the road user, \
                lane, speed, acceleration, direction, distance, gaps and relative motion; t = 0 is the end of the \
                window. The metrics frame adds TTC, braking measures, risk scores and the worst value of each.",
        options: &[
            SCENARIO,
            AT,
            option(
                "frame",
                "--frame",
                JobValue::Word(&["ego", "cartesian", "metrics"]),
                "Frame: relative to the ego, on the map, or safety measures [default: ego].",
            ),
            option(
                "measures",
                "--set=measures",
                JobValue::Text,
                "Columns of the metrics frame, such as ttc,thw,drac,pet,ttb,rss_margin.",
            ),
            option(
                "history",
                "--history",
                JobValue::Whole(Some(1), Some(10_000)),
                "Steps in the window [default: 10].",
            ),
            option(
                "stride",
                "--set=stride",
                JobValue::Whole(Some(1), Some(10_000)),
                "Describe every Nth step [default: 1].",
            ),
            option(
                "obstacle",
                "--obstacle",
                JobValue::Whole(None, None),
                "Describe only this obstacle.",
            ),
            EGO,
        ],
        takes_long: false,
        paid: false,
        does: Does::Run(Job {
            command: "prompt describe --set=contact=on",
            gives: Gives::Text,
            needs_ego: true,
        }),
    },
    Tool {
        name: "render",
        about: "Draws the road and all road users from above.",
        options: &[
            SCENARIO,
            AT,
            option(
                "view",
                "--view",
                JobValue::Text,
                "Part of the map in metres: ego, ego,WIDTH, all, or X,Y,WIDTH [default: ego].",
            ),
            EGO,
        ],
        takes_long: false,
        paid: false,
        does: Does::Run(Job {
            command: "render",
            gives: Gives::Picture,
            needs_ego: false,
        }),
    },
    Tool {
        name: "plan",
        about: "Plans the ego's motion with the built-in planner and simulates it in the recorded traffic. Reports \
                outcome, goal, limits, traffic rules and times. Takes seconds.",
        options: &[SCENARIO],
        takes_long: true,
        paid: false,
        does: Does::Run(Job {
            command: "plan",
            gives: Gives::Json,
            needs_ego: false,
        }),
    },
    Tool {
        name: "generate",
        about: "Searches for a dangerous but avoidable variant of a safe scenario. Reports attacker, manoeuvre, \
                outcome, and who could have avoided it. Writes nothing. Takes seconds to minutes.",
        options: &[
            SCENARIO,
            option(
                "candidates",
                "--candidates",
                JobValue::Whole(Some(1), Some(100_000)),
                "Maximum number of motions to try.",
            ),
            option(
                "seed",
                "--seed",
                JobValue::Whole(Some(0), None),
                "Random seed of the search.",
            ),
        ],
        takes_long: true,
        paid: false,
        does: Does::Run(Job {
            command: "generate",
            gives: Gives::Json,
            needs_ego: false,
        }),
    },
    Tool {
        name: "ask_model",
        about: "Asks a language model about the scenario, at the price of its provider, and stores the answer.",
        options: &[
            SCENARIO,
            option("model", "--model", JobValue::Text, "As provider/model."),
            option(
                "task",
                "--task",
                JobValue::Word(&["collision", "safety"]),
                "Task [default: collision].",
            ),
            EGO,
            option(
                "budget",
                "--budget",
                JobValue::Number,
                "Maximum cost in US dollars [default: what is left of the session's budget].",
            ),
            option(
                "max_tokens",
                "--set=max_tokens",
                JobValue::Whole(Some(1), Some(u32::MAX as u64)),
                "Maximum number of tokens per answer; bounds the cost [default: from config.toml; else required].",
            ),
        ],
        takes_long: true,
        paid: true,
        does: Does::Run(Job {
            command: "ask",
            gives: Gives::Json,
            needs_ego: true,
        }),
    },
];

/// The tools that are offered, with or without those that may cost money.
pub fn offered(paid: bool) -> impl Iterator<Item = &'static Tool> {
    TOOLS.iter().filter(move |tool| paid || !tool.paid)
}

/// The tools as the protocol lists them.
pub fn tools(paid: bool) -> Vec<ListedTool> {
    let listed = offered(paid).map(|tool| {
        let hints = ToolAnnotations::new()
            .read_only(!tool.paid)
            .open_world(tool.paid);
        ListedTool::new(tool.name, tool.about, schema(tool.options)).with_annotations(hints)
    });
    listed.collect()
}

/// What arguments there are.
fn schema(options: &[JobOption]) -> JsonObject {
    let properties: JsonObject = { options.iter() }
        .map(|option| (option.name.into(), option.schema()))
        .collect();
    let required: Vec<&str> = { options.iter() }
        .filter(|option| option.required)
        .map(|option| option.name)
        .collect();
    JsonObject::from_iter([
        ("type".into(), "object".into()),
        ("properties".into(), properties.into()),
        ("required".into(), required.into()),
        ("additionalProperties".into(), false.into()),
    ])
}

/// Whether a text is a moment, as `--at` takes it.
pub fn is_moment(text: &str) -> bool {
    text.parse::<At>().is_ok()
}
