//! `nearmiss mcp`: a Model Context Protocol server over standard input and output, or over HTTP on loopback.
//!
//! `rmcp` speaks the protocol. What comes in is bounded before: lines and bodies, connections, and who may send.

mod catalogue;
mod http;
mod jobs;
mod looks;
mod places;
mod resources;
mod scenes;
mod stdio;

use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use nearmiss_scene::metrics::Thresholds;
use rmcp::model::{
    CallToolRequestParams, CallToolResponse, CallToolResult, ContentBlock, CustomRequest,
    CustomResult, ErrorCode, GetPromptRequestParams, GetPromptResponse, GetPromptResult,
    Implementation, ListPromptsResult, ListResourceTemplatesResult, ListResourcesResult,
    ListToolsResult, PaginatedRequestParams, ReadResourceRequestParams, ReadResourceResponse,
    ServerCapabilities, ServerConfig,
};
use rmcp::service::{RequestContext, RoleServer};
use rmcp::{ErrorData, ServerHandler};
use serde_json::Value;
use tempfile::TempDir;
use tokio::sync::{Semaphore, watch};
use tokio::task::spawn_blocking;

use super::ask::budget;
use super::open::{configuration, user_thresholds};
use super::{Failure, Outcome, output};
use catalogue::{Does, EGO, Job, JobOption, SCENARIO, Tool};
use http::Token;
use jobs::{BUDGET, Progress, SpendingLimit};
use places::Places;
use resources::PROMPT;

/// Each tool with what it does and its arguments, for the manual.
pub fn tools() -> String {
    let lines = catalogue::offered(true).map(|tool| {
        let options: Vec<&str> = tool.options.iter().map(|option| option.name).collect();
        let about = format!("{} Arguments: {}.", tool.about, options.join(", "));
        let about = textwrap::fill(&about, 66).replace('\n', &format!("\n{:22}", ""));
        format!("    {:<17} {about}\n", tool.name)
    });
    lines.collect()
}

/// Arguments of `mcp`.
#[derive(Debug, clap::Args)]
pub struct Mcp {
    /// Folders with scenarios that clients may open, besides the bundled ones [default: none]
    ///
    /// Clients can read no scenario outside them and write no files.
    folders: Vec<PathBuf>,
    /// Let clients ask language models, which may cost money: adds the tool ask_model, which stores its answers; needs
    /// --budget.
    #[arg(long, requires = "budget")]
    allow_models: bool,
    /// Maximum cost of all answers of the session in US dollars.
    #[arg(long, value_name = "USD", value_parser = budget, requires = "allow_models")]
    budget: Option<f64>,
    /// Serve streamable HTTP at http://ADDRESS/mcp, on a loopback address; port 0 picks a free port. Clients send the
    /// printed token, or that of NEARMISS_MCP_TOKEN.
    #[arg(long, value_name = "ADDRESS", value_parser = loopback)]
    http: Option<SocketAddr>,
}

/// An address of this machine: `127.0.0.1:8000`.
fn loopback(text: &str) -> Result<SocketAddr, String> {
    let address: SocketAddr = text
        .parse()
        .map_err(|_| "expected an address with a port, such as 127.0.0.1:8000")?;
    if address.ip().is_loopback() {
        Ok(address)
    } else {
        Err("only addresses of this machine are served, such as 127.0.0.1:8000".into())
    }
}

/// Runs `mcp` until standard input ends, or over HTTP until it is interrupted.
pub fn run(arguments: &Mcp) -> Outcome {
    let (folders, config) = configuration()?;
    let thresholds = user_thresholds(&folders)?;
    let places = Places::new(&arguments.folders, config.maps.as_deref()).map_err(Failure::input)?;
    let words = places.words();
    let purse = arguments.budget.filter(|_| arguments.allow_models);
    let server = Arc::new(Server::new(
        places,
        thresholds,
        purse.map(SpendingLimit::new),
    ));
    // When it is dropped, it waits for what still runs.
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .build()
        .map_err(Failure::input)?;
    if let Some(address) = arguments.http {
        let given = std::env::var(http::VARIABLE).ok();
        let token = Token::new(given.as_deref()).map_err(Failure::input)?;
        return runtime.block_on(http::serve(server, address, token));
    }
    output::say(&format!(
        "nearmiss: MCP server on standard input and output; {words}"
    ));
    runtime.block_on(stdio::serve(&server))
}

/// Tools that take long which run at once, of all clients.
const MOST_JOBS: usize = 4;

/// How commands say that they have paid nothing.
const UNSENT: &str = "nearmiss: nothing was sent: ";

/// Why there is no answer to who does not want it any more.
const TAKEN_BACK: &str = "the request was taken back";

/// The methods that are served; `rmcp` takes one with other parameters for an unknown one.
const METHODS: [&str; 7] = [
    "tools/list",
    "tools/call",
    "resources/list",
    "resources/templates/list",
    "resources/read",
    "prompts/list",
    "prompts/get",
];

/// What all clients share.
#[derive(Debug)]
struct Server {
    /// What clients may see.
    places: Places,
    /// What moments are measured with.
    thresholds: Thresholds,
    /// What may be spent on models; `None` where none may be asked.
    purse: Option<SpendingLimit>,
    /// The index of the scenarios, once a client searched it.
    index: Mutex<Option<TempDir>>,
    /// Places of tools that take long.
    long: Arc<Semaphore>,
    /// What is soon done is done one after the other.
    turn: Arc<tokio::sync::Mutex<()>>,
    ends: watch::Sender<bool>,
}

impl Server {
    /// A server of these places.
    fn new(places: Places, thresholds: Thresholds, purse: Option<SpendingLimit>) -> Self {
        Self {
            places,
            thresholds,
            purse,
            index: Mutex::default(),
            long: Arc::new(Semaphore::new(MOST_JOBS)),
            turn: Arc::default(),
            ends: watch::Sender::new(false),
        }
    }

    /// Ends what takes long.
    fn end_long(&self) {
        self.ends.send_replace(true);
    }

    /// The result of a tool. Mistakes of the caller are results, too, so that a model reads them.
    fn call(&self, tool: &Tool, arguments: &Value, progress: &Progress) -> CallToolResult {
        let result = self.result(tool, arguments, progress);
        result.unwrap_or_else(|why| failed(&self.places.told(&why)))
    }

    fn result(
        &self,
        tool: &Tool,
        arguments: &Value,
        progress: &Progress,
    ) -> Result<CallToolResult, String> {
        let mut words = jobs::command_line(tool.options, arguments)?;
        let job = match &tool.does {
            Does::Look(look) => {
                let value = look(self, arguments, progress)?;
                let text = self.places.told(&value.to_string());
                let value = serde_json::from_str(&text).unwrap_or(value);
                return Ok(CallToolResult::structured(value));
            }
            Does::Run(job) => job,
        };
        words.insert(0, self.scenario(job, arguments)?);
        let purse = self.purse.as_ref().filter(|_| tool.paid);
        let reserved = purse.map(|purse| purse.reserve(arguments)).transpose()?;
        let budget = reserved.filter(|_| arguments[BUDGET].is_null());
        words.extend(budget.map(|usd| format!("--budget={usd}")));
        let given = self.run(job, tool.options, &words, progress);
        if let Some((purse, usd)) = purse.zip(reserved) {
            match &given {
                Ok(given) => purse.settle(usd, given),
                Err(why) if why.starts_with(UNSENT) => purse.put_back(usd),
                // It may have been paid.
                Err(_) => {}
            }
        }
        Ok(jobs::result(job, &given?, &self.places))
    }

    /// A filled prompt.
    fn prompt(
        &self,
        request: &GetPromptRequestParams,
        progress: &Progress,
    ) -> Result<GetPromptResult, String> {
        let (mut words, arguments) = resources::prompt_command(request)?;
        words.insert(0, self.scenario(&PROMPT, &arguments)?);
        let given = self.run(&PROMPT, resources::OPTIONS, &words, progress)?;
        resources::filled_prompt(&given, &self.places)
    }

    /// How a command names the scenario of its arguments, which clients may see.
    fn scenario(&self, job: &Job, arguments: &Value) -> Result<String, String> {
        let name = arguments[SCENARIO.name].as_str().unwrap_or_default();
        let entry = self.places.entry(name)?;
        let ego = arguments[EGO.name].as_i64();
        self.places.check(&entry, ego, job.needs_ego)?;
        Ok(Places::argument(&entry))
    }

    fn run(
        &self,
        job: &Job,
        options: &[JobOption],
        words: &[String],
        progress: &Progress,
    ) -> Result<Vec<u8>, String> {
        let given = jobs::run(job, words, progress);
        given.map_err(|why| jobs::with_argument_names(options, &self.places.told(&why)))
    }
}

/// The server for one client.
#[derive(Debug, Clone)]
struct Handler(Arc<Server>);

/// Takes a request back when its client no longer waits for the answer.
struct Unwanted(Arc<AtomicBool>);

impl Drop for Unwanted {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
    }
}

impl Handler {
    /// Does what waits for files or commands in a thread of its own, which keeps `held` until it has ended.
    async fn apart<T: Send + 'static>(
        &self,
        request: RequestContext<RoleServer>,
        held: impl Send + 'static,
        work: impl FnOnce(&Server, &Progress) -> Result<T, ErrorData> + Send + 'static,
    ) -> Result<T, ErrorData> {
        let taken_back = || Err(ErrorData::internal_error(TAKEN_BACK, None));
        if request.ct.is_cancelled() {
            return taken_back();
        }
        let (server, progress) = (Arc::clone(&self.0), Progress::new(&request));
        let _unwanted = Unwanted(Arc::clone(&progress.cancel));
        let done = spawn_blocking(move || {
            let _held = held;
            work(&server, &progress)
        });
        tokio::select! {
            done = done => {
                done.map_err(|why| ErrorData::internal_error(why.to_string(), None))?
            }
            () = request.ct.cancelled() => taken_back(),
        }
    }

    /// Does what is soon done, when it is its turn.
    async fn soon<T: Send + 'static>(
        &self,
        request: RequestContext<RoleServer>,
        work: impl FnOnce(&Server, &Progress) -> Result<T, ErrorData> + Send + 'static,
    ) -> Result<T, ErrorData> {
        let turn = Arc::clone(&self.0.turn).lock_owned().await;
        self.apart(request, turn, work).await
    }
}

impl ServerHandler for Handler {
    fn get_info(&self) -> ServerConfig {
        let capabilities = ServerCapabilities::builder()
            .enable_tools()
            .enable_resources()
            .enable_prompts();
        ServerConfig::new(capabilities.build())
            .with_server_info(Implementation::new("nearmiss", env!("CARGO_PKG_VERSION")))
            .with_instructions(
                "Traffic scenarios, measured exactly. list_scenarios ranks them by danger; inspect says what is in \
                 one and when it is most severe; describe gives the table of a window, render its picture; find \
                 searches the windows of all. `at` is a time step; ids are those of obstacles.",
            )
    }

    async fn list_tools(
        &self,
        request: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListToolsResult, ErrorData> {
        resources::no_cursor(request)?;
        let tools = catalogue::tools(self.0.purse.is_some());
        Ok(ListToolsResult::with_all_items(tools))
    }

    async fn call_tool(
        &self,
        call: CallToolRequestParams,
        request: RequestContext<RoleServer>,
    ) -> Result<CallToolResponse, ErrorData> {
        let mut tools = catalogue::offered(self.0.purse.is_some());
        let Some(tool) = tools.find(|tool| tool.name == call.name) else {
            let name: String = call.name.chars().take(80).collect();
            let why = format!("no tool `{name}`; tools/list has all");
            return Err(ErrorData::invalid_params(why, None));
        };
        let arguments = Value::Object(call.arguments.unwrap_or_default());
        let work = move |server: &Server, progress: &Progress| {
            Ok(server.call(tool, &arguments, progress).into())
        };
        if !tool.takes_long {
            return self.soon(request, work).await;
        }
        let Ok(place) = Arc::clone(&self.0.long).try_acquire_owned() else {
            let why = format!("{MOST_JOBS} jobs run already; wait for one or cancel it");
            return Ok(failed(&why).into());
        };
        let mut ends = self.0.ends.subscribe();
        tokio::select! {
            done = self.apart(request, place, work) => done,
            _ = ends.wait_for(|ends| *ends) => Err(ErrorData::internal_error("the server ends", None)),
        }
    }

    async fn list_resources(
        &self,
        page: Option<PaginatedRequestParams>,
        request: RequestContext<RoleServer>,
    ) -> Result<ListResourcesResult, ErrorData> {
        let cursor = page.and_then(|page| page.cursor);
        let list = move |server: &Server, _: &Progress| {
            resources::list_resources(&server.places, cursor.as_deref())
        };
        self.soon(request, list).await
    }

    async fn list_resource_templates(
        &self,
        request: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListResourceTemplatesResult, ErrorData> {
        resources::no_cursor(request)?;
        Ok(ListResourceTemplatesResult::default())
    }

    async fn read_resource(
        &self,
        resource: ReadResourceRequestParams,
        request: RequestContext<RoleServer>,
    ) -> Result<ReadResourceResponse, ErrorData> {
        let read = move |server: &Server, _: &Progress| {
            resources::read_resource(&server.places, &resource.uri)
        };
        self.soon(request, read).await.map(Into::into)
    }

    async fn list_prompts(
        &self,
        request: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListPromptsResult, ErrorData> {
        resources::no_cursor(request)?;
        Ok(ListPromptsResult::with_all_items(resources::list_prompts()))
    }

    async fn get_prompt(
        &self,
        prompt: GetPromptRequestParams,
        request: RequestContext<RoleServer>,
    ) -> Result<GetPromptResponse, ErrorData> {
        let fill = move |server: &Server, progress: &Progress| {
            let filled = server.prompt(&prompt, progress);
            filled.map_err(|why| ErrorData::invalid_params(why, None))
        };
        self.soon(request, fill).await.map(Into::into)
    }

    async fn on_custom_request(
        &self,
        request: CustomRequest,
        _: RequestContext<RoleServer>,
    ) -> Result<CustomResult, ErrorData> {
        let method: String = request.method.chars().take(80).collect();
        Err(if METHODS.contains(&method.as_str()) {
            let why = format!("the parameters of `{method}` are not those of the protocol");
            ErrorData::invalid_params(why, None)
        } else {
            ErrorData::new(
                ErrorCode::METHOD_NOT_FOUND,
                format!("no method `{method}`"),
                None,
            )
        })
    }
}

/// A result that says what went wrong.
fn failed(why: &str) -> CallToolResult {
    CallToolResult::error(vec![ContentBlock::text(why)])
}
