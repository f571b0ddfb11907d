//! The terminal: one guard owns raw mode, the alternate screen, mouse, paste and cursor, and gives them all back.

use std::io::{self, IsTerminal, Stdout, Write, stdout};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crossterm::cursor::Show;
use crossterm::event::{
    DisableBracketedPaste, DisableMouseCapture, EnableBracketedPaste, EnableMouseCapture, Event,
    EventStream, KeyCode, KeyEvent, KeyModifiers, MouseButton, MouseEventKind,
};
use crossterm::execute;
use crossterm::style::force_color_output;
use crossterm::terminal::{
    BeginSynchronizedUpdate, Clear, ClearType, EndSynchronizedUpdate, EnterAlternateScreen,
    LeaveAlternateScreen, disable_raw_mode, enable_raw_mode, window_size,
};
use futures_util::StreamExt;
use ratatui::Terminal;
use ratatui::backend::CrosstermBackend;
use ratatui::layout::Position;

use super::keymap::Key;
use super::message::{Mouse, Msg};

/// Whether the terminal is ours at the moment.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// The terminal while the workbench has it; dropped, it is as it was before.
pub struct Screen {
    terminal: Terminal<CrosstermBackend<Stdout>>,
    mouse: bool,
}

impl Screen {
    /// Takes the terminal over.
    ///
    /// # Errors
    /// It is none, or refuses; nothing is taken then.
    pub fn take(mouse: bool) -> io::Result<Self> {
        // With NO_COLOR set, crossterm would write empty sequences that wipe bold and reversed text;
        // the theme leaves colours out instead.
        force_color_output(true);
        enter(mouse).inspect_err(|_| give_back())?;
        let terminal =
            Terminal::new(CrosstermBackend::new(stdout())).inspect_err(|_| give_back())?;
        Ok(Self { terminal, mouse })
    }

    /// Draws a frame, as one synchronized update.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn draw(&mut self, draw: impl FnOnce(&mut ratatui::Frame<'_>)) -> io::Result<()> {
        execute!(stdout(), BeginSynchronizedUpdate)?;
        let drawn = self.terminal.draw(draw).map(|_| ());
        execute!(stdout(), EndSynchronizedUpdate)?;
        drawn
    }

    /// Columns and rows.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn size(&self) -> io::Result<(u16, u16)> {
        self.terminal.size().map(|s| (s.width, s.height))
    }

    /// How much higher than wide a cell is, where the terminal tells its size in pixels.
    #[must_use]
    pub fn cell_aspect(&self) -> Option<f64> {
        let size = window_size().ok()?;
        let all = [size.width, size.height, size.columns, size.rows];
        let [width, height, columns, rows] = all.map(f64::from);
        let known = all.iter().all(|&n| n > 0);
        known.then(|| (height / rows) / (width / columns))
    }

    /// Uses the mouse, or leaves it to the terminal.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn use_mouse(&mut self, on: bool) -> io::Result<()> {
        self.mouse = on;
        if on {
            execute!(stdout(), EnableMouseCapture)
        } else {
            execute!(stdout(), DisableMouseCapture)
        }
    }

    /// Puts text into the clipboard of the terminal, also over SSH (OSC 52).
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn copy(&mut self, text: &str) -> io::Result<()> {
        let mut out = stdout();
        write!(out, "\x1b]52;c;{}\x07", base64(text.as_bytes()))?;
        out.flush()
    }

    /// Gives the terminal to another program until that ends.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn lend<T>(&mut self, to: impl FnOnce() -> T) -> io::Result<T> {
        #[cfg(unix)]
        let stops = stops()?;
        give_back();
        #[cfg(unix)]
        stops.store(true, Ordering::SeqCst);
        let result = to();
        #[cfg(unix)]
        stops.store(false, Ordering::SeqCst);
        enter(self.mouse)?;
        self.terminal = Terminal::new(CrosstermBackend::new(stdout()))?;
        Ok(result)
    }

    /// Gives the terminal back to the shell until the program is continued.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn suspend(&mut self) -> io::Result<()> {
        give_back();
        #[cfg(unix)]
        signal_hook::low_level::emulate_default_handler(signal_hook::consts::SIGTSTP)?;
        enter(self.mouse)?;
        // A new terminal draws everything again; clearing the old one would wait for the cursor's position.
        self.terminal = Terminal::new(CrosstermBackend::new(stdout()))?;
        Ok(())
    }
}

/// Columns and rows of the terminal that standard output is, if it is one.
#[must_use]
pub fn size_here() -> Option<(u16, u16)> {
    let there = stdout().is_terminal();
    there.then(|| crossterm::terminal::size().ok()).flatten()
}

/// Whether Ctrl-Z stops this program without more ado, as it has to while another one has the terminal: the shell
/// waits until both have stopped.
#[cfg(unix)]
fn stops() -> io::Result<&'static std::sync::Arc<AtomicBool>> {
    use std::sync::{Arc, OnceLock};
    static STOPS: OnceLock<Arc<AtomicBool>> = OnceLock::new();
    if let Some(stops) = STOPS.get() {
        return Ok(stops);
    }
    let stops = Arc::new(AtomicBool::new(false));
    let signal = signal_hook::consts::SIGTSTP;
    signal_hook::flag::register_conditional_default(signal, stops.clone())?;
    Ok(STOPS.get_or_init(|| stops))
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
    }
}

fn enter(mouse: bool) -> io::Result<()> {
    TAKEN.store(true, Ordering::SeqCst);
    enable_raw_mode()?;
    execute!(
        stdout(),
        EnterAlternateScreen,
        EnableBracketedPaste,
        Clear(ClearType::All)
    )?;
    if mouse {
        execute!(stdout(), EnableMouseCapture)?;
    }
    Ok(())
}

/// Gives everything back, once; errors have nobody left to tell.
fn give_back() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        let _ = execute!(
            stdout(),
            EndSynchronizedUpdate,
            DisableMouseCapture,
            DisableBracketedPaste,
            LeaveAlternateScreen,
            Show
        );
        let _ = disable_raw_mode();
    }
}

/// Makes every panic give the terminal back before it is reported, and end the program.
///
/// A panic in a background thread would otherwise leave the screen to a program that has lost a part.
pub fn give_back_on_panic() {
    let report = std::panic::take_hook();
    let main = std::thread::current().id();
    std::panic::set_hook(Box::new(move |info| {
        give_back();
        report(info);
        if std::thread::current().id() != main {
            std::process::exit(101);
        }
    }));
}

/// The terminal's events as messages; ends when the terminal is gone.
pub struct Events {
    stream: EventStream,
    stray: Option<Stray>,
}

impl Events {
    /// Begins to listen. What the terminal still answers to an older question is left out if `stray`.
    #[must_use]
    pub fn listen(stray: bool) -> Self {
        Self {
            stream: EventStream::new(),
            stray: stray.then(|| Stray::until(Instant::now() + LATE)),
        }
    }

    /// Stops listening, so that another program can read the keys.
    ///
    /// The stream's end wakes whoever waits for events. With nobody waiting, crossterm would keep that for the next
    /// stream, which takes the waking for its own and leaves a key of the same moment unread until another one comes.
    pub fn close(self) {
        drop(self);
        // Nothing is waited for; an error comes again where events are read.
        let _ = crossterm::event::poll(Duration::ZERO);
    }

    /// The next event that means something.
    pub async fn next(&mut self) -> Option<io::Result<Msg>> {
        loop {
            match self.stream.next().await? {
                Ok(event) => {
                    if let (Some(stray), Event::Key(key)) = (&mut self.stray, &event)
                        && stray.takes(key, Instant::now())
                    {
                        continue;
                    }
                    if let Some(msg) = message(event) {
                        return Some(Ok(msg));
                    }
                }
                Err(error) => return Some(Err(error)),
            }
        }
    }
}

/// How long an answer of the terminal may be late.
const LATE: Duration = Duration::from_secs(5);

/// Characters that an answer may have.
const LONGEST: usize = 40;

/// A late answer of the terminal about its background, which arrives as keys: `Alt-]`, `11;rgb:…`, and `Ctrl-g` or
/// `Alt-\`. Taken for keys it would ask models and change settings.
struct Stray {
    until: Instant,
    /// Characters of the answer so far, once it has begun.
    taken: Option<usize>,
}

impl Stray {
    fn until(until: Instant) -> Self {
        Self { until, taken: None }
    }

    /// Whether this key is a piece of the answer.
    fn takes(&mut self, key: &KeyEvent, now: Instant) -> bool {
        let alt = key.modifiers.contains(KeyModifiers::ALT);
        let ctrl = key.modifiers.contains(KeyModifiers::CONTROL);
        let begins = alt && key.code == KeyCode::Char(']');
        match self.taken {
            None if begins && now < self.until => self.taken = Some(0),
            None => return false,
            Some(count) => {
                let ends = alt && key.code == KeyCode::Char('\\')
                    || ctrl && key.code == KeyCode::Char('g');
                self.taken = (!ends && count < LONGEST).then_some(count + 1);
            }
        }
        true
    }
}

fn message(event: Event) -> Option<Msg> {
    match event {
        Event::Key(key) => Key::of_event(&key).map(Msg::Key),
        Event::Paste(text) => Some(Msg::Paste(text)),
        Event::Resize(columns, rows) => Some(Msg::Resize(columns, rows)),
        Event::Mouse(mouse) => {
            let at = Position::new(mouse.column, mouse.row);
            Some(Msg::Mouse(match mouse.kind {
                MouseEventKind::Down(MouseButton::Left) => Mouse::Press(at),
                MouseEventKind::Drag(MouseButton::Left) => Mouse::Drag(at),
                MouseEventKind::Up(MouseButton::Left) => Mouse::Release(at),
                MouseEventKind::ScrollUp => Mouse::WheelUp(at),
                MouseEventKind::ScrollDown => Mouse::WheelDown(at),
                _ => return None,
            }))
        }
        _ => None,
    }
}

/// Base 64 of RFC 4648, as OSC 52 wants it.
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let group =
            chunk.iter().fold(0u32, |g, &b| (g << 8) | u32::from(b)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let letter = LETTERS[(group >> (18 - 6 * i) & 63) as usize];
            text.push(if i > chunk.len() { '=' } else { letter as char });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_answer_is_no_keys() {
        let start = Instant::now();
        let alt = |c| KeyEvent::new(KeyCode::Char(c), KeyModifiers::ALT);
        let plain = |c| KeyEvent::new(KeyCode::Char(c), KeyModifiers::NONE);
        let bell = KeyEvent::new(KeyCode::Char('g'), KeyModifiers::CONTROL);
        for end in [alt('\\'), bell] {
            let mut stray = Stray::until(start + LATE);
            assert!(!stray.takes(&plain('r'), start));
            assert!(stray.takes(&alt(']'), start));
            for c in "11;rgb:1e1e/1e1e/1e1e".chars() {
                assert!(stray.takes(&plain(c), start));
            }
            assert!(stray.takes(&end, start));
            assert!(!stray.takes(&plain('r'), start));
        }
        // Somebody who presses these keys later means them, and nothing takes keys for ever.
        let mut stray = Stray::until(start + LATE);
        assert!(!stray.takes(&alt(']'), start + LATE));
        assert!(stray.takes(&alt(']'), start));
        let taken = (0..100).filter(|_| stray.takes(&plain('r'), start)).count();
        assert!(taken < 50);
    }

    #[test]
    fn base64_of_the_rfc() {
        for (plain, coded) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }
}
