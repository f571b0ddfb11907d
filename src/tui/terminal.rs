//! The terminal: a guard owns raw mode, alternate screen, mouse, paste and cursor, and restores them all.

#[cfg(unix)]
use std::fs::File;
#[cfg(unix)]
use std::io::Read;
use std::io::{self, IsTerminal, Stdout, Write, stdout};
#[cfg(unix)]
use std::os::fd::AsFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crossterm::cursor::Show;
use crossterm::event::{
    DisableBracketedPaste, DisableMouseCapture, EnableBracketedPaste, EnableMouseCapture, Event,
    EventStream, KeyCode, KeyEvent, KeyModifiers, KeyboardEnhancementFlags, MouseButton,
    MouseEventKind, PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
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
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tokio::sync::oneshot;
use tokio::task::JoinHandle;

use crate::keymap::Key;
use crate::message::{Mouse, Msg};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use nearmiss_base::system::processes;

/// Whether the terminal is ours at the moment.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// The terminal while the workbench has it; dropped, it is as it was before.
pub struct Screen {
    /// `None` once it is gone.
    terminal: Option<Terminal<CrosstermBackend<Stdout>>>,
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
        Ok(Self {
            terminal: Some(terminal),
            mouse,
        })
    }

    /// Draws a frame, as one synchronized update.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn draw(&mut self, draw: impl FnOnce(&mut ratatui::Frame<'_>)) -> io::Result<()> {
        let terminal = self.terminal.as_mut().ok_or(io::ErrorKind::NotConnected)?;
        execute!(stdout(), BeginSynchronizedUpdate)?;
        let drawn = terminal.draw(draw).map(|_| ());
        execute!(stdout(), EndSynchronizedUpdate)?;
        drawn
    }

    /// Columns and rows.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn size(&self) -> io::Result<(u16, u16)> {
        crossterm::terminal::size()
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
        write!(out, "\x1b]52;c;{}\x07", STANDARD.encode(text))?;
        out.flush()
    }

    /// Gives the terminal to another program, until it is [taken again](Self::take_again).
    pub fn lend(&mut self) {
        give_back();
    }

    /// Gives the terminal back to the shell until the program is continued.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn suspend(&mut self) -> io::Result<()> {
        give_back();
        processes::stop()?;
        self.take_again()
    }

    /// Takes the terminal again, as another program or the shell has had it, and draws everything anew.
    ///
    /// # Errors
    /// The terminal is gone.
    pub fn take_again(&mut self) -> io::Result<()> {
        // A continuation from here on counts as another one.
        let _ = processes::was_continued();
        give_back();
        enter(self.mouse)?;
        // A new terminal draws everything again; clearing the old one would wait for the cursor's position.
        let_go(self.terminal.take());
        self.terminal = Some(Terminal::new(CrosstermBackend::new(stdout()))?);
        Ok(())
    }
}

/// Whether an error says that the terminal is gone: a window was closed, a connection lost.
#[must_use]
pub fn is_gone(error: &io::Error) -> bool {
    use io::ErrorKind::{BrokenPipe, NotConnected, UnexpectedEof};
    /// The system's `EIO` and `ENXIO`.
    const GONE: [i32; 2] = [5, 6];
    let known = [BrokenPipe, NotConnected, UnexpectedEof].contains(&error.kind());
    // Where it was hung up, it is none any more.
    known || error.raw_os_error().is_some_and(|n| GONE.contains(&n)) || !stdout().is_terminal()
}

/// Drops ratatui's terminal. It would say on standard error that it cannot show the cursor, and panic where that is
/// gone, too.
fn let_go(terminal: Option<Terminal<CrosstermBackend<Stdout>>>) {
    if let Some(mut terminal) = terminal
        && terminal.show_cursor().is_err()
    {
        std::mem::forget(terminal);
    }
}

/// The answer to [`STATUS`](super::background::STATUS).
const STATUS_ANSWER: &[u8] = b"\x1b[0n";

/// What the terminal answers to a question that ends in [`STATUS`](super::background::STATUS); `None` where it does not within `patience`. Nothing
/// else may read the terminal meanwhile.
#[cfg(unix)]
#[must_use]
pub fn answers(question: &str, patience: Duration) -> Option<String> {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let deadline = Instant::now() + patience;
    // Read past the buffer of standard input: what follows the answers is crossterm's.
    let mut input = if io::stdin().is_terminal() {
        File::from(io::stdin().as_fd().try_clone_to_owned().ok()?)
    } else {
        File::open("/dev/tty").ok()?
    };
    enable_raw_mode().ok()?;
    let mut read = || {
        stdout().write_all(question.as_bytes()).ok()?;
        stdout().flush().ok()?;
        let mut answers = Vec::new();
        while !answers
            .windows(STATUS_ANSWER.len())
            .any(|end| end == STATUS_ANSWER)
        {
            let left = deadline.checked_duration_since(Instant::now())?;
            let left = Timespec::try_from(left).ok()?;
            let mut waiting = [PollFd::new(&input, PollFlags::IN)];
            if poll(&mut waiting, Some(&left)).ok()? == 0 {
                return None;
            }
            let mut some = [0; 64];
            let count = input.read(&mut some).ok().filter(|count| *count > 0)?;
            answers.extend_from_slice(&some[..count]);
        }
        Some(String::from_utf8_lossy(&answers).into_owned())
    };
    let answers = read();
    let _ = disable_raw_mode();
    answers
}

/// Nothing where terminals cannot be asked.
#[cfg(not(unix))]
#[must_use]
pub fn answers(_: &str, _: Duration) -> Option<String> {
    None
}

/// Columns and rows of the terminal that standard output is, if it is one.
#[must_use]
pub fn size_here() -> Option<(u16, u16)> {
    let there = stdout().is_terminal();
    there.then(|| crossterm::terminal::size().ok()).flatten()
}

impl Drop for Screen {
    fn drop(&mut self) {
        give_back();
        let_go(self.terminal.take());
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
    // Ctrl-Enter is told from Enter where the terminal can; others ignore this.
    let _ = execute!(
        stdout(),
        PushKeyboardEnhancementFlags(KeyboardEnhancementFlags::DISAMBIGUATE_ESCAPE_CODES)
    );
    if mouse {
        execute!(stdout(), EnableMouseCapture)?;
    }
    Ok(())
}

/// Restores the terminal, once; errors can no longer be shown.
fn give_back() {
    if TAKEN.swap(false, Ordering::SeqCst) {
        let _ = execute!(stdout(), PopKeyboardEnhancementFlags);
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
        if nearmiss_base::system::crash::is_contained() {
            return;
        }
        give_back();
        report(info);
        if std::thread::current().id() != main {
            nearmiss_base::system::end_process_groups();
            std::process::exit(101);
        }
    }));
}

/// The terminal's events as messages; ends when the terminal is gone.
///
/// They are read in a task of their own: crossterm reads on for ever where the terminal goes away in between.
pub struct Events {
    read: UnboundedReceiver<io::Result<Msg>>,
    stop: oneshot::Sender<()>,
    task: JoinHandle<()>,
}

impl Events {
    /// Begins to listen. What the terminal still answers to an older question is left out if `stray`.
    #[must_use]
    pub fn listen(stray: bool) -> Self {
        let stray = stray.then(|| Stray::until(Instant::now() + LATE));
        let (sender, read) = unbounded_channel();
        let (stop, stopped) = oneshot::channel();
        let task = tokio::spawn(forward(stray, sender, stopped));
        Self { read, stop, task }
    }

    /// Stops listening, so that another program can read the keys. What was read and not taken is dropped: it may have
    /// been meant for the shell, and here it could ask a model.
    pub async fn close(self) {
        drop(self.stop);
        // A terminal that is gone is not waited for.
        let _ = tokio::time::timeout(Duration::from_secs(1), self.task).await;
    }

    /// The next event that means something.
    pub async fn next(&mut self) -> Option<io::Result<Msg>> {
        self.read.recv().await
    }
}

/// Forwards events until stopped, or until the receiver is gone.
async fn forward(
    mut stray: Option<Stray>,
    sender: UnboundedSender<io::Result<Msg>>,
    mut stopped: oneshot::Receiver<()>,
) {
    // A stream panics where this fails: the terminal is gone already.
    if let Err(error) = crossterm::event::poll(Duration::ZERO) {
        let _ = sender.send(Err(error));
        return;
    }
    let mut stream = EventStream::new();
    loop {
        let event = tokio::select! {
            event = stream.next() => event,
            _ = &mut stopped => break,
        };
        let msg = match event {
            None => break,
            Some(Err(error)) => Err(error),
            Some(Ok(Event::Key(key)))
                if stray
                    .as_mut()
                    .is_some_and(|s| s.takes(&key, Instant::now())) =>
            {
                continue;
            }
            Some(Ok(event)) => match message(event) {
                Some(msg) => Ok(msg),
                None => continue,
            },
        };
        if sender.send(msg).is_err() {
            break;
        }
    }
    drop(stream);
    // The stream's end wakes the waiter for events. With no waiter, crossterm would keep that for the next
    // stream, which takes the waking for its own and leaves a key of the same moment unread until another one comes.
    // Nothing is waited for; an error comes again where events are read.
    let _ = crossterm::event::poll(Duration::ZERO);
}

/// How long an answer of the terminal may be late.
const LATE: Duration = Duration::from_secs(5);

/// Characters that an answer may have.
const MAX_ANSWER_CHARACTERS: usize = 40;

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
                self.taken = (!ends && count < MAX_ANSWER_CHARACTERS).then_some(count + 1);
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
        // Keys pressed later are passed on, and keys are dropped for a limited time only.
        let mut stray = Stray::until(start + LATE);
        assert!(!stray.takes(&alt(']'), start + LATE));
        assert!(stray.takes(&alt(']'), start));
        let taken = (0..100).filter(|_| stray.takes(&plain('r'), start)).count();
        assert!(taken < 50);
    }
}
