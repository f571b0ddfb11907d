//! Times to brake, kick down, steer and react: how long the ego can wait until only another manoeuvre helps.
//!
//! TTB, TTK and TTS are the times from now to the latest start of full braking, full acceleration and
//! evasive steering to the better side (the limits `full_braking`, `kick_down`, `evasion` and `tightest`) that avoids
//! the overlap recorded with this obstacle; TTR is the largest of them. Source: Hillenbrand, Spieker and Kroschel
//! 2006; Tamke, Dang and Breuel 2011.

use super::super::{Danger, Encounter, Measure, Mirrored, NoValue, Reading};
use super::Starts;

const fn measure(
    id: &'static str,
    name: &'static str,
    source: &'static str,
    compute: fn(&Encounter<'_>) -> Reading,
) -> Measure {
    Measure {
        id,
        name,
        unit: "s",
        danger: Danger::Low,
        mirrored: Mirrored::Kept,
        reads_ahead: true,
        source,
        compute,
    }
}

pub(in crate::metrics) const BRAKE: Measure = measure(
    "ttb",
    "time to brake",
    "latest full braking that avoids the recorded overlap (Hillenbrand 2006)",
    |e| time(e, Starts::brake),
);

pub(in crate::metrics) const KICK_DOWN: Measure = measure(
    "ttk",
    "time to kick down",
    "latest full acceleration that avoids the recorded overlap (Tamke 2011)",
    |e| time(e, Starts::kick_down),
);

pub(in crate::metrics) const STEER: Measure = measure(
    "tts",
    "time to steer",
    "latest evasive steering that avoids the recorded overlap (Hillenbrand 2006)",
    |e| time(e, Starts::steer),
);

pub(in crate::metrics) const REACT: Measure = measure(
    "ttr",
    "time to react",
    "largest of ttb, ttk and tts (Hillenbrand 2006)",
    |e| time(e, Starts::react),
);

fn time(encounter: &Encounter<'_>, until: fn(&Starts, usize) -> Result<usize, NoValue>) -> Reading {
    let time =
        encounter.ask(|c, other, now| Ok(until(c.starts_before(other), now)? as f64 * c.dt()));
    time.into()
}
