//! Price tables of others, such as models.dev and litellm publish: read, kept as a file, and laid over the shipped prices.

mod formats;

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use jiff::civil::Date;
use jiff::tz::TimeZone;
use reqwest::Url;
use reqwest::header::LOCATION;
use serde::Deserialize;

use super::body_text::{BodyError, whole};
use super::client::{Client, deepest};
use super::deadlines::{Deadlines, Elapsed};
use super::endpoint::{Endpoint, Timeouts, plain};
use super::price::Price;
use super::provider::{PriceLine, RegistryError, date};
use super::redaction::is_loopback;
use super::registry::Registry;
use nearmiss_base::system;

/// The file's name, beside `config.toml`.
pub(super) const FILE: &str = "prices.toml";

/// More than any such table is long, in bytes.
const LONGEST: usize = 32 << 20;

/// Prices of models by provider, from a table of others.
#[derive(Debug, Clone, PartialEq)]
pub struct PriceTable {
    /// The day on which the source had them so.
    as_of: Date,
    source: String,
    /// By our names of the providers: models with their prices.
    providers: BTreeMap<&'static str, BTreeMap<String, Steps>>,
    /// Models of these providers without a price that can be used.
    left_out: usize,
}

/// Prices by the longest question they hold for, the shortest first; the last one holds for all others.
type Steps = Vec<(Option<u64>, Price)>;

impl PriceTable {
    /// The table in a file, of the day on which that was written.
    ///
    /// # Errors
    /// The file cannot be read, or is no such table: why, with the file.
    pub fn in_file(path: &Path, today: Date) -> Result<Self, String> {
        let wrong = |why: String| format!("{}: {why}", system::shown_path(path));
        let text =
            system::read_text(path, LONGEST as u64).map_err(|e| wrong(system::error_text(&e)))?;
        let written = std::fs::metadata(path)
            .and_then(|found| found.modified())
            .ok()
            .and_then(|time| jiff::Timestamp::try_from(time).ok());
        let day = written.map_or(today, |time| time.to_zoned(TimeZone::system()).date());
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let source = |form: &str| format!("{name} ({form})");
        Self::read(&text, source, day.min(today)).map_err(wrong)
    }

    /// The table at an address, as it is today; from this machine alone without encryption.
    ///
    /// # Errors
    /// It cannot be got, or is no such table: why, with the address.
    pub async fn at_address(client: &Client, address: &str, today: Date) -> Result<Self, String> {
        let url = Url::parse(address.trim()).map_err(|error| format!("{address}: {error}"))?;
        let place = plain(&url);
        let wrong = |why: String| format!("{place}: {why}");
        let text = download(client, url).await.map_err(wrong)?;
        Self::read(&text, |_| place.clone(), today).map_err(wrong)
    }

    fn read(text: &str, source: impl Fn(&str) -> String, as_of: Date) -> Result<Self, String> {
        let (form, providers, left_out) = formats::read(text)?;
        let table = Self {
            as_of,
            source: source(form),
            providers,
            left_out,
        };
        if table.to_toml().len() as u64 > system::LARGEST_TEXT {
            Err("more prices than a file of 1 MiB holds".into())
        } else {
            Ok(table)
        }
    }

    /// What is in it, in words: counts by provider, day and source.
    #[must_use]
    pub fn summary(&self) -> String {
        let counts = self.providers.iter();
        let counts: Vec<String> = counts
            .map(|(name, models)| format!("{name} {}", models.len()))
            .collect();
        let left_out = match self.left_out {
            0 => String::new(),
            count => format!(
                "; {count} left out: no price a token, a price of 0, or another one for reasoning"
            ),
        };
        let (day, source) = (self.as_of, &self.source);
        format!(
            "prices of models as of {day}, {source}: {}{left_out}",
            counts.join(", ")
        )
    }

    /// Where it is kept, beside the configuration file.
    #[must_use]
    pub fn file(config_file: &Path) -> PathBuf {
        config_file.with_file_name(FILE)
    }

    /// The file that keeps it, in the form of `config.toml`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let quoted = |text: &str| toml::Value::String(text.to_owned()).to_string();
        let mut text = format!(
            "# Written by `nearmiss models --update`. These prices overlay the shipped ones, config.toml overlays them.\n\
             # Delete this file to go back to the shipped ones. US dollars per million tokens.\n\
             as_of = {}\nsource = {}\n",
            self.as_of,
            quoted(&self.source)
        );
        for (provider, models) in &self.providers {
            let _ = writeln!(text, "\n[provider.{provider}]\nprices = [");
            for (model, steps) in models {
                for (up_to, price) in steps {
                    let part = |name: &str, value: Option<f64>| {
                        value.map_or_else(String::new, |value| format!(", {name} = {value:?}"))
                    };
                    let up_to = up_to.map_or_else(String::new, |n| format!(", up_to = {n}"));
                    let _ = writeln!(
                        text,
                        "    {{ model = {}{up_to}{}{}{}{} }},",
                        quoted(model),
                        part("input", Some(price.input)),
                        part("cached", price.cached),
                        part("cache_write", price.cache_write),
                        part("output", Some(price.output)),
                    );
                }
            }
            text.push_str("]\n");
        }
        text
    }
}

/// The file of prices.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    #[serde(deserialize_with = "date")]
    as_of: Option<Date>,
    source: String,
    #[serde(default)]
    provider: BTreeMap<String, KeptPrices>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeptPrices {
    prices: Vec<PriceLine>,
}

impl Registry {
    /// Lays the file of prices beside the configuration file over the prices, where there is one. A price that is known
    /// since a later day than the file's, or holds from one on, stays before it.
    ///
    /// # Errors
    /// [`RegistryError::Prices`]: the file cannot be used; then no price is changed.
    pub fn lay_prices(&mut self, config_file: &Path) -> Result<(), RegistryError> {
        let file = PriceTable::file(config_file);
        let wrong = |why: String| RegistryError::Prices {
            message: format!("{}: {why}", system::shown_path(&file)),
        };
        let text = match system::read_text(&file, system::LARGEST_TEXT) {
            Ok(text) => text,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
            Err(error) => return Err(wrong(system::error_text(&error))),
        };
        let kept: Kept = toml::from_str(&text).map_err(|error| {
            let line = error
                .span()
                .map_or(1, |span| system::line_at(&text, span.start));
            let words: Vec<&str> = error.message().split_whitespace().collect();
            wrong(format!("line {line}: {}", words.join(" ")))
        })?;
        for (name, entry) in kept.provider {
            let Some(own) = self.providers.get_mut(&name) else {
                continue;
            };
            let is_later = |line: &PriceLine| line.as_of > kept.as_of || line.from > kept.as_of;
            let shipped = std::mem::take(&mut own.prices).into_iter();
            let (later, earlier): (Vec<_>, Vec<_>) = shipped.partition(is_later);
            let laid = entry.prices.into_iter().map(|mut line| {
                line.as_of = line.as_of.or(kept.as_of);
                line.source = line.source.or_else(|| Some(kept.source.clone()));
                line
            });
            own.prices = later.into_iter().chain(laid).chain(earlier).collect();
        }
        Ok(())
    }
}

/// The text at an address.
async fn download(client: &Client, url: Url) -> Result<String, String> {
    if url.scheme() != "https" && !is_loopback(&url) {
        return Err("write https:// before the host".into());
    }
    let timeouts = Timeouts::default();
    let deadlines = Deadlines::starting_now(timeouts);
    let late = |elapsed: Elapsed| format!("no answer within {} s", elapsed.after.as_secs());
    let http = client.http(&Endpoint::new("prices", url.as_str()), timeouts.connect)?;
    let answer = deadlines.wait(http.get(url).send()).await;
    let response = answer.map_err(late)?.map_err(|error| deepest(&error))?;
    let status = response.status();
    if status.is_redirection() {
        let moved = response
            .headers()
            .get(LOCATION)
            .and_then(|to| to.to_str().ok())
            .unwrap_or("another address");
        return Err(format!(
            "moved to {moved}; pass that address if you trust it"
        ));
    }
    if !status.is_success() {
        return Err(format!("answered with status {}", status.as_u16()));
    }
    let body = whole(response, deadlines, LONGEST).await;
    body.map_err(|(_, fault)| match fault {
        BodyError::Elapsed(elapsed) => late(elapsed),
        BodyError::Cut(why) => format!("the connection was cut: {why}"),
        BodyError::NotText => "not text".into(),
        BodyError::TooLong => format!("more than {} MiB", LONGEST >> 20),
    })
}

#[cfg(test)]
#[path = "price_table_tests.rs"]
mod tests;
