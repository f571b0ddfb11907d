//! Pictures one after the other as a film, MP4 with H.264, by the program ffmpeg.

use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use nearmiss_base::system::processes::{ProcessGroup, with_default};
use tiny_skia::Pixmap;

use super::animation::{AnimationError, each_frame};
use super::raster::pixels;
use super::{Color, Picture};

/// The program, found in `PATH`.
const PROGRAM: &str = "ffmpeg";

/// Screens show no more pictures a second.
const MOST_RATE: f64 = 60.0;

/// Writes `count` pictures, each `dt` seconds after the one before, into a file that there may be; gives the number of
/// frames. Where steps are shorter than screens show, some are left out.
///
/// # Errors
/// See [`AnimationError`]; ffmpeg is missing, or says why it fails.
pub fn film(
    file: &Path,
    count: usize,
    dt: f64,
    dpi: f64,
    picture: impl Fn(usize) -> Result<Picture, String> + Sync,
    stop: &AtomicBool,
) -> Result<usize, AnimationError> {
    let stride = (1.0 / (dt * MOST_RATE) - 1e-9).ceil().clamp(1.0, 1000.0) as usize;
    let shown: Vec<usize> = (0..count).step_by(stride).collect();
    let paint = |place: &usize| -> Result<(Pixmap, Color), AnimationError> {
        if stop.load(Ordering::Relaxed) {
            return Err(AnimationError::Stopped);
        }
        let picture = picture(*place).map_err(AnimationError::Picture)?;
        Ok((pixels(&picture, dpi)?, picture.background))
    };
    let rate = 1.0 / (dt * stride as f64);
    let mut encoder: Option<Encoder> = None;
    each_frame(&shown, paint, |(pixmap, background)| {
        let running = match &mut encoder {
            Some(running) => running,
            None => encoder.insert(Encoder::start(file, &pixmap, background, rate)?),
        };
        running.write(pixmap.data())
    })?;
    if let Some(encoder) = encoder {
        encoder.finish(stop)?;
    }
    Ok(shown.len())
}

/// ffmpeg, while it is given frames.
struct Encoder {
    child: Child,
    group: ProcessGroup,
    said: Option<JoinHandle<Vec<u8>>>,
}

impl Encoder {
    fn start(
        file: &Path,
        first: &Pixmap,
        background: Color,
        rate: f64,
    ) -> Result<Self, AnimationError> {
        let size = format!("{}x{}", first.width(), first.height());
        // H.264 halves colours: widths and heights are even.
        let edge = background.to_string().replace('#', "0x");
        let even = format!("pad=ceil(iw/2)*2:ceil(ih/2)*2:color={edge}");
        let mut target = std::ffi::OsString::from("file:");
        target.push(file);
        let mut command = Command::new(PROGRAM);
        command
            .args(["-hide_banner", "-loglevel", "error", "-y"])
            .args(["-f", "rawvideo", "-pixel_format", "rgba"])
            .args(["-video_size", &size, "-framerate", &format!("{rate:.6}")])
            .args(["-i", "pipe:0", "-vf", &even])
            .args(["-c:v", "libx264", "-crf", "18", "-pix_fmt", "yuv420p"])
            // The same pictures are the same bytes.
            .args(["-threads", "1", "-map_metadata", "-1"])
            .args(["-fflags", "+bitexact", "-flags:v", "+bitexact"])
            .args(["-movflags", "+faststart", "-f", "mp4"])
            .arg(target);
        command.stdin(Stdio::piped());
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = with_default(|| command.spawn()).map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => AnimationError::NoFfmpeg,
            _ => error.into(),
        })?;
        let group = ProcessGroup::led_by(child.id());
        let said = child.stderr.take().map(|mut stream| {
            std::thread::spawn(move || {
                let mut said = Vec::new();
                // What cannot be read is not told.
                let _ = stream.read_to_end(&mut said);
                said
            })
        });
        Ok(Self { child, group, said })
    }

    fn write(&mut self, frame: &[u8]) -> Result<(), AnimationError> {
        let Some(to) = &mut self.child.stdin else {
            return Ok(());
        };
        match to.write_all(frame) {
            // It has gone: what it said tells why.
            Err(_) => Err(self.failure()),
            Ok(()) => Ok(()),
        }
    }

    /// Waits until the film is whole.
    fn finish(mut self, stop: &AtomicBool) -> Result<(), AnimationError> {
        drop(self.child.stdin.take());
        loop {
            match self.child.try_wait()? {
                Some(status) if status.success() => return Ok(()),
                Some(_) => return Err(self.failure()),
                None if stop.load(Ordering::Relaxed) => return Err(AnimationError::Stopped),
                None => std::thread::sleep(Duration::from_millis(10)),
            }
        }
    }

    /// The last line that it said.
    fn failure(&mut self) -> AnimationError {
        drop(self.child.stdin.take());
        self.group.kill();
        let said = self.said.take().and_then(|said| said.join().ok());
        let said = said.unwrap_or_default();
        let text = String::from_utf8_lossy(&said);
        let last = text.lines().rfind(|line| !line.trim().is_empty());
        AnimationError::Ffmpeg(last.unwrap_or("it ended early").trim().to_string())
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        self.group.kill();
        self.group.forget();
        // It has ended, or was killed just now.
        let _ = self.child.wait();
    }
}
