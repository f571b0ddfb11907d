//! The manual: one Markdown file a topic, in the program (`nearmiss help TOPIC`) and in these pages.

/// A topic of the manual.
#[derive(Debug, Clone, Copy)]
pub struct Topic {
    /// What it is asked for by; no command has this name.
    pub name: &'static str,
    /// What it is about, in one line.
    pub about: &'static str,
    /// Commands that it explains.
    pub commands: &'static [&'static str],
    /// Its text, in Markdown.
    pub text: &'static str,
    /// Its file, below the folder of the manual.
    pub file: &'static str,
}

/// Makes the table, and a page of each topic.
macro_rules! topics {
    ($($module:ident, $name:literal, $file:literal, [$($command:literal),*], $about:literal;)+) => {
        $(#[doc = include_str!($file)] pub mod $module {})+

        /// Every topic, in the order of reading.
        pub const TOPICS: &[Topic] = &[$(Topic {
            name: $name,
            about: $about,
            commands: &[$($command),*],
            text: include_str!($file),
            file: $file,
        }),+];
    };
}

topics! {
    my_recording, "my-recording", "tasks/my-recording.md", [],
        "Measure your own recording";
    worst_of_many, "worst-of-many", "tasks/worst-of-many.md", [],
        "Find the worst of a thousand scenarios";
    paper_figure, "paper-figure", "tasks/paper-figure.md", [],
        "Make a figure for a paper";
    local_model, "local-model", "tasks/local-model.md", [],
        "Ask a local model";
    compare_models, "compare-models", "tasks/compare-models.md", [],
        "Compare two models";
    tweak_prompt, "tweak-prompt", "tasks/tweak-prompt.md", [],
        "Tweak a prompt, and measure whether it is better";
    check_reasoning, "check-reasoning", "tasks/check-reasoning.md", [],
        "Check a model's reasoning against the scene";
    endanger, "endanger", "tasks/endanger.md", [],
        "Endanger a safe scenario";
    test_planner, "test-planner", "tasks/test-planner.md", [],
        "Test your planner";
    careful_driver, "careful-driver", "tasks/careful-driver.md", [],
        "Would a careful driver have avoided it?";
    to_simulator, "to-simulator", "tasks/to-simulator.md", [],
        "Hand a scenario to a simulator";
    from_python, "from-python", "tasks/from-python.md", [],
        "Use it from Python";
    on_cluster, "on-cluster", "tasks/on-cluster.md", [],
        "Run it on a cluster";
    in_ci, "in-ci", "tasks/in-ci.md", [],
        "Check prompts in CI";
    workbench, "workbench", "workbench.md", [],
        "The screen: time, map, list, asking";
    answers, "answers", "answers.md", [],
        "Claims, answers side by side and blind, many at once, history, results";
    story, "story", "story.md", ["describe"],
        "What happened in a scenario, in sentences, and what its verbs mean";
    scenarios, "scenarios", "scenarios.md", ["inspect", "convert"],
        "File formats, where the ego comes from, the bundled scenarios";
    datasets, "datasets", "datasets.md", [],
        "Recordings of data sets: Waymo, Argoverse, nuPlan, nuScenes, highD, SUMO, OSI";
    python, "python", "python.md", [],
        "The Python module: tables for polars, pandas and DuckDB, notebooks, Ray, Spark, Daft";
    tracks, "tracks", "tracks.md", [],
        "Your own recordings: tables of tracks in CSV, Parquet, Arrow, JSON lines, and maps beside them";
    simulators, "simulators", "simulators.md", [],
        "OpenSCENARIO and OpenDRIVE: exports for simulators, and opening them";
    measures, "measures", "measures.md", ["metrics"],
        "Safety measures, the risk score, thresholds, the paper's convention";
    impacts, "impacts", "impacts.md", [],
        "How hard a contact is: Δv, the risk of a serious injury, and what they do not show";
    judge, "judge", "judge.md", [],
        "The built-in judge: exact geometry, and how far ahead it sees";
    prompting, "prompting", "prompting.md", ["prompt"],
        "Descriptions, techniques, templates of your own, the template editor";
    pictures, "pictures", "pictures.md", [],
        "Pictures for models that see: the storyboard, what is sent, tokens, the store";
    providers, "providers", "providers.md", ["ask", "models"],
        "Language models: keys, addresses, prices, what is refused, what fails";
    tools, "tools", "tools.md", [],
        "Tools that models call while they judge: the table, limits";
    mcp_server, "mcp-server", "mcp-server.md", ["mcp"],
        "A server for agents: tools, scenarios and prompts over the Model Context Protocol";
    evaluation, "evaluation", "evaluation.md", ["evaluate"],
        "Many scenarios and models: truth, leads, changed scenes, tables";
    recordings, "recordings", "recordings.md", [],
        "The task about a whole recording, and risk scores as the truth";
    reports, "reports", "reports.md", ["report"],
        "Tables over any axes, a page to read answers in, figures, LaTeX";
    experiments, "experiments", "experiments.md", [],
        "A batch written down in a file, for others to repeat: experiment.toml";
    tuning, "tuning", "tuning.md", ["tune"],
        "Better templates from wrong answers: rounds, what is shown, the gain with its interval";
    ci, "ci", "ci.md", [],
        "Requirements and regressions: exit status, JUnit XML, GitHub Actions";
    statistics, "statistics", "statistics.md", [],
        "What counts as an answer, what it cost, intervals, comparisons";
    planning, "planning", "planning.md", ["plan"],
        "The planner: how it drives the ego, and how drives end";
    traffic_rules, "traffic-rules", "traffic-rules.md", [],
        "Lights, signs, right of way: what the planner obeys, what a drive breaks";
    planners, "planners", "planners.md", [],
        "Planners of your own: a protocol of JSON lines, what is reported, an example";
    generating, "generating", "generating.md", ["generate"],
        "Dangerous variants of safe scenarios: attack, gate, certificate";
    preventability, "preventability", "preventability.md", ["drivers"],
        "Would a competent and careful driver have avoided it: six models, who avoids what, until when";
    requirements, "requirements", "requirements.md", ["annex"],
        "Planners held to a requirement: the file, findings, an annex for a safety case";
    figures, "figures", "figures.md", ["render"],
        "Figures for papers: map, plot, screen; SVG, PNG, GIF";
    corpora, "corpora", "corpora.md", ["corpus"],
        "Thousands of scenarios: parts for several machines, continuing, an index, samples";
    rates, "rates", "rates.md", [],
        "How often a corpus holds a manoeuvre: events, parameters, rates with intervals";
    clusters, "clusters", "clusters.md", [],
        "Slurm job arrays, and parts of an experiment asked by several persons";
    store, "store", "store.md", ["runs"],
        "Every run: nothing is paid for twice; search, export, SQL";
    fine_tuning, "fine-tuning", "fine-tuning.md", [],
        "Right answers with checked claims as chats for training";
    configuration, "configuration", "configuration.md", ["doctor", "config"],
        "Configuration and data folders, every key of config.toml, keys and keymaps";
    command_line, "command-line", "command-line.md", ["completions"],
        "Installing, input, output, exit status, interruption, crashes";
    json, "json", "json.md", [],
        "JSON of every command: one vocabulary of keys, versions, schemas";
    evidence, "evidence", "evidence.md", [],
        "How we know: each figure of the manual, and the command that measures it";
    glossary, "glossary", "glossary.md", [],
        "The terms of the field, a sentence each";
}

/// The topic with this name.
#[must_use]
pub fn topic(name: &str) -> Option<&'static Topic> {
    TOPICS.iter().find(|topic| topic.name == name)
}

/// The topic that explains a command.
#[must_use]
pub fn explaining(command: &str) -> Option<&'static Topic> {
    TOPICS
        .iter()
        .find(|topic| topic.commands.contains(&command))
}
