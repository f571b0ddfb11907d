//! Orderly exit on signals, with the terminal restored.

use nearmiss_base::system::job_control::{JobSignal, Signals};

/// A signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TerminationSignal {
    /// The program is to end, or the terminal is gone.
    End,
    /// Ctrl-C or Ctrl-\ from elsewhere: they are keys here, and mean another program while that has the terminal.
    Interrupt,
    /// A shell's signal.
    Job(JobSignal),
}

#[cfg(unix)]
type Ends = [(tokio::signal::unix::Signal, TerminationSignal); 4];

#[cfg(unix)]
fn ends() -> std::io::Result<Ends> {
    use tokio::signal::unix::{SignalKind, signal};
    Ok([
        (signal(SignalKind::terminate())?, TerminationSignal::End),
        (signal(SignalKind::hangup())?, TerminationSignal::End),
        (
            signal(SignalKind::interrupt())?,
            TerminationSignal::Interrupt,
        ),
        (signal(SignalKind::quit())?, TerminationSignal::Interrupt),
    ])
}

/// Listens to the signals that ask the program to end or to stop for a while.
pub struct Ending {
    job: Signals,
    #[cfg(unix)]
    signals: Ends,
}

impl Ending {
    /// Begins to listen; an end that was asked for before is not heard.
    ///
    /// # Errors
    /// The system refuses, or job control was not taken over.
    pub fn listen() -> std::io::Result<Self> {
        Ok(Self {
            job: Signals::listen()?,
            #[cfg(unix)]
            signals: ends()?,
        })
    }

    /// Forgets what asked the program to end until now.
    ///
    /// # Errors
    /// The system refuses.
    pub fn forget(&mut self) -> std::io::Result<()> {
        #[cfg(unix)]
        {
            self.signals = ends()?;
        }
        Ok(())
    }

    /// Waits for the next one.
    pub async fn wait(&mut self) -> TerminationSignal {
        #[cfg(unix)]
        {
            let signals = &mut self.signals;
            let ended = std::future::poll_fn(|context| {
                let mut signals = signals.iter_mut();
                let heard = signals.find_map(|(signal, heard)| {
                    signal.poll_recv(context).is_ready().then_some(*heard)
                });
                heard.map_or(std::task::Poll::Pending, std::task::Poll::Ready)
            });
            tokio::select! {
                biased;
                heard = ended => heard,
                job = self.job.wait() => TerminationSignal::Job(job),
            }
        }
        #[cfg(not(unix))]
        TerminationSignal::Job(self.job.wait().await)
    }
}
