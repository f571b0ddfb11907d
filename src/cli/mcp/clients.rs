//! The sessions of clients over HTTP.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::session::Session;
use super::token::random;

/// Most sessions at once; the one that was silent for the longest time gives way.
const MOST: usize = 64;

/// Sessions by their ids, the one that spoke last at the end.
#[derive(Debug, Default)]
pub struct Clients(Mutex<Known>);

#[derive(Debug, Default)]
struct Known {
    sessions: Vec<(String, Arc<Session>)>,
    begun: u64,
}

impl Clients {
    fn known(&self) -> MutexGuard<'_, Known> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A new session with its id. `works` says whether a session has jobs, which keep it.
    ///
    /// # Errors
    /// In words: the system gives no random numbers, or all sessions work.
    pub fn begin(&self, works: impl Fn(u64) -> bool) -> Result<(String, Arc<Session>), String> {
        let id = random()?;
        let mut known = self.known();
        if known.sessions.len() >= MOST {
            let idle = { known.sessions.iter() }
                .position(|(_, session)| !works(session.number))
                .ok_or("too many sessions; end one of them")?;
            known.sessions.remove(idle);
        }
        known.begun += 1;
        let session = Arc::new(Session::new(known.begun));
        known.sessions.push((id.clone(), Arc::clone(&session)));
        Ok((id, session))
    }

    /// The session with an id.
    pub fn of(&self, id: &str) -> Option<Arc<Session>> {
        let mut known = self.known();
        let place = known.sessions.iter().position(|(known, _)| known == id)?;
        let found = known.sessions.remove(place);
        let session = Arc::clone(&found.1);
        known.sessions.push(found);
        Some(session)
    }

    /// Ends a session.
    pub fn end(&self, id: &str) -> Option<Arc<Session>> {
        let mut known = self.known();
        let place = known.sessions.iter().position(|(known, _)| known == id)?;
        Some(known.sessions.remove(place).1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_silent_session_without_jobs_gives_way() {
        let clients = Clients::default();
        let all: Vec<String> = (0..MOST)
            .map(|_| {
                clients
                    .begin(|_| false)
                    .map(|(id, _)| id)
                    .unwrap_or_default()
            })
            .collect();
        assert!(clients.of(&all[0]).is_some());
        // The second one works, so that the third one goes.
        assert!(clients.begin(|number| number == 2).is_ok());
        let there: Vec<bool> = all
            .iter()
            .take(4)
            .map(|id| clients.of(id).is_some())
            .collect();
        assert_eq!(there, [true, true, false, true]);
        assert!(clients.begin(|_| true).is_err());
        assert!(clients.end(&all[0]).is_some() && clients.of(&all[0]).is_none());
    }
}
