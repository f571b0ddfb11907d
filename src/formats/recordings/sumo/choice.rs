//! Which net is that of a recording.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::fcd::Recorded;
use super::files::{self, Nets};
use super::net::{self, Net};
use crate::commonroad::ReadError;
use crate::commonroad::builder::SourceLocation;
use crate::recordings::report::Report;

/// The net of a recording: the one that it names, or the one beside it in which its edges are. What is wrong is said.
pub fn net(
    file: &Path,
    recorded: &Recorded,
    report: &Report,
) -> Result<Option<(PathBuf, Arc<Net>)>, ReadError> {
    let (nets, started_with) = match files::nets(file, &recorded.comment) {
        Nets::Told(net) => {
            let read = net::read(&net)?;
            return Ok(Some((net, read)));
        }
        Nets::Beside(nets, started_with) => (nets, started_with),
    };
    let none = |why: String| {
        report
            .at("")
            .warn(format!("no net: {why}; the scenario has no lanes"));
        Ok(None)
    };
    let used = &recorded.edges;
    match &nets[..] {
        [] => none(match started_with {
            Some(name) => format!("{name}, which it was made with, is not beside it"),
            None => "no .net.xml beside it".into(),
        }),
        [only] => {
            let net = net::read(only)?;
            if used.is_empty() || used.iter().any(|edge| net.edges.contains(edge)) {
                Ok(Some((only.clone(), net)))
            } else {
                none(format!(
                    "{}, the only one beside it, has none of its edges, such as `{}`",
                    files::in_words(&nets),
                    used.first().map_or("", String::as_str)
                ))
            }
        }
        several => {
            // One that is damaged is none of these.
            let all = several
                .iter()
                .filter_map(|path| Some((path, net::read(path).ok()?)));
            let has_all = |net: &Net| used.iter().all(|edge| net.edges.contains(edge));
            let mut fit: Vec<_> = all
                .filter(|(_, net)| !used.is_empty() && has_all(net))
                .collect();
            if fit.len() == 1
                && let Some((path, net)) = fit.pop()
            {
                report.note(format!(
                    "net {}: the only one of {} beside it that has its edges",
                    path.display(),
                    several.len()
                ));
                return Ok(Some((path.clone(), net)));
            }
            let which = match fit.len() {
                0 => "none of them has",
                _ => "several of them have",
            };
            none(format!(
                "{} .net.xml files are beside it ({}), and {which} all its edges; leave only its own",
                several.len(),
                files::in_words(several)
            ))
        }
    }
}
