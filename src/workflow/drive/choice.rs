//! Who drives: the built-in planner, one of the configuration, or a command.

use std::sync::Arc;
use std::time::Duration;

use nearmiss_base::system::{did_you_mean, is_program};
use nearmiss_drive::simulation::{Clock, ExternalOptions, ExternalPlanner, Policy};
use nearmiss_scene::description::visible;
use nearmiss_settings::Config;

/// The built-in planner's name.
pub const BUILT_IN: &str = "nearmiss";

/// The recorded ego in place of a planner, beside one.
pub const RECORDED: &str = "recorded";

/// A planner that was named.
#[derive(Debug, Clone, Default)]
pub struct PlannerChoice {
    /// Its name: that of the configuration, else its command.
    pub name: String,
    /// Its process; `None` for the built-in planner and for rules.
    pub external: Option<Arc<ExternalPlanner>>,
    /// The rule that drives: a driver or a baseline.
    pub policy: Option<Policy>,
    /// It is the recorded ego.
    pub is_recorded: bool,
}

impl From<Policy> for PlannerChoice {
    fn from(policy: Policy) -> Self {
        Self {
            name: policy.name().into(),
            policy: Some(policy),
            ..Self::default()
        }
    }
}

impl PlannerChoice {
    /// The planner of this name or command; messages name it after `option`. `timeout` is of a cycle, seconds; that of the
    /// configuration where none is said.
    ///
    /// # Errors
    /// It is neither known nor a program.
    pub fn named(
        said: &str,
        option: &str,
        config: &Config,
        timeout: Option<f64>,
        clock: Clock,
    ) -> Result<Self, String> {
        let name = visible(said).into_owned();
        let known = config.external_planners();
        let found = known.iter().find(|(known, _)| known == said);
        let policy = Policy::named(said).filter(|_| found.is_none());
        if said == BUILT_IN || policy.is_some() {
            return Ok(Self {
                name,
                policy,
                ..Self::default()
            });
        }
        let mut options = match found {
            Some((_, options)) => options.clone(),
            None => command(said, option, known.iter().map(|(name, _)| name.as_str()))?,
        };
        if let Some(program) = options.command.first().filter(|p| !is_program(p)) {
            let of = match found {
                Some(_) => format!("`command` of [planner.{name}] in config.toml"),
                None => format!("{option}{name}"),
            };
            return Err(format!("{of}: no such program: {}", visible(program)));
        }
        if let Some(seconds) = timeout {
            options.cycle = Duration::from_secs_f64(seconds);
        }
        options.clock = clock;
        let external = Some(Arc::new(ExternalPlanner::new(name.clone(), options)));
        Ok(Self {
            name,
            external,
            ..Self::default()
        })
    }
}

/// The options of a command that is no name of a planner.
fn command<'a>(
    said: &str,
    option: &str,
    known: impl Iterator<Item = &'a str>,
) -> Result<ExternalOptions, String> {
    let words =
        ExternalOptions::split_command(said).map_err(|why| format!("{option}{said}: {why}"))?;
    // A name that is mistyped is no program.
    if let [program] = &words[..]
        && !is_program(program)
    {
        let mut all: Vec<&str> = vec![BUILT_IN];
        all.extend(known);
        all.extend(Policy::all().map(|policy| -> &'a str { policy.name() }));
        return Err(format!(
            "{option}{program}: no planner of this name and no such program{}; available: {}",
            did_you_mean(program, all.iter().copied()),
            all.join(", ")
        ));
    }
    Ok(ExternalOptions::new(words))
}
