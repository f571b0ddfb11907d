//! Checks the planners of `config.toml`: whether the program of each can be found. None is started.

use super::Finding;
use nearmiss_base::system::is_program;
use nearmiss_settings::Config;

const AREA: &str = "planners";

pub fn look(config: &Config) -> Vec<Finding> {
    let planners = config.external_planners().into_iter();
    let all = planners.map(|(name, options)| {
        let program = options.command.first().map_or("", String::as_str);
        if is_program(program) {
            Finding::ok(
                AREA,
                format!(
                    "{name}: {}; `nearmiss plan SCENARIO --planner {name}` starts it",
                    options.command.join(" ")
                ),
            )
        } else {
            Finding::problem(
                AREA,
                format!("{name}: no program {program}"),
                format!("install it, or set `command` of [planner.{name}] to where it is"),
            )
        }
    });
    all.collect()
}
