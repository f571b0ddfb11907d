use nearmiss::{planner, scenario, simulation};
use rayon::prelude::*;
fn main() {
    let mut args = std::env::args().skip(1);
    let forecast = planner::Forecast::parse(&args.next().unwrap()).unwrap();
    let files: Vec<String> = args.collect();
    let rows: Vec<String> = files.par_iter().map(|f| {
        let bytes = std::fs::read(f).unwrap();
        let sc = scenario::commonroad::read(&bytes, f).unwrap();
        let settings = simulation::Settings { planner: planner::Settings::default(), forecast, replan: 1, without: None };
        let name = std::path::Path::new(f).file_stem().unwrap().to_string_lossy().into_owned();
        let Some(problem) = sc.planning_problems.first() else { return format!("{name} none") };
        match simulation::drive(&sc, problem, &settings) {
            Err(e) => format!("{name} ERR {e}"),
            Ok(d) => {
                let mut ms: Vec<f64> = d.cycles.iter().map(|c| c.took.as_secs_f64() * 1e3).collect();
                ms.sort_by(f64::total_cmp);
                let em: Vec<i64> = d.cycles.iter().filter(|c| c.plan.emergency.is_some()).map(|c| c.step).collect();
                let last = d.states.last().unwrap();
                let maxacc = d.states.iter().map(|s| s.1.acceleration).fold(0.0f64, |m, a| if a < m { a } else { m });
                format!("{name:28} {:10} step {:3} v {:5.1} amin {:5.1} ref {} emerg {} {:?} ms {:.2} cand {} {:?} {:?}", d.outcome.name(), last.0, last.1.velocity, maxacc, d.cycles.iter().filter(|c| c.plan.refinements > 0).count(), em.len(), em.first(), ms.get(ms.len() / 2).unwrap_or(&0.0), d.cycles.first().map_or(0, |c| c.plan.candidates), d.outcome, d.cycles.iter().filter(|c|c.plan.emergency.is_some()).next().map(|c|&c.plan.rejected))
            }
        }
    }).collect();
    for r in &rows {
        println!("{r}");
    }
    let mut counts = std::collections::BTreeMap::new();
    for r in &rows {
        *counts
            .entry(r.split_whitespace().nth(1).unwrap().to_string())
            .or_insert(0) += 1;
    }
    eprintln!("{counts:?}");
}
