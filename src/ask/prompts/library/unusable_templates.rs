//! User templates that parse but turn out unusable: the shipped ones replace them.

use super::{Fallback, Library, Origin, Problem};
use crate::prompts::includes;

impl Library {
    /// Whether a file is the user's, template or fragment.
    #[must_use]
    pub fn is_users(&self, file: &str) -> bool {
        let origin = self.source(file).map(|(_, origin)| origin);
        matches!(origin, Some(Origin::User(_)))
    }

    /// The user's files that a template is made of: itself, and what it includes.
    #[must_use]
    pub fn users_in(&self, file: &str) -> Vec<String> {
        let Some((template, _)) = self.file(file) else {
            return Vec::new();
        };
        let included = includes::included(&template.source, &self.fragments);
        let all = std::iter::once(file).chain(included);
        all.filter(|one| self.is_users(one))
            .map(str::to_string)
            .collect()
    }

    /// Takes a file of the user out of use, with a problem that says why; the shipped one of its name is in its place,
    /// if there is one. Says whether there was such a file.
    pub fn set_aside(&mut self, file: &str, message: String) -> bool {
        let Some((_, Origin::User(path))) = self.source(file) else {
            return false;
        };
        let path = path.clone();
        let used = self.in_use(file);
        let front = self.file(file).map(|(template, _)| template.front.clone());
        self.templates.remove(file);
        self.fragments.remove(file);
        self.fragment_origins.remove(file);
        let others = |library: &Self| {
            let found = front.and_then(|f| library.find(&f.task, &f.frame).map(|_| ()));
            found.is_some()
        };
        let instead = match Self::shipped(file) {
            Some(source) => {
                // The shipped files are read by a test.
                let _ = self.put(file, source, Origin::Shipped);
                Fallback::Shipped
            }
            None if used && others(self) => Fallback::Usual,
            None => Fallback::Nothing,
        };
        self.problems.push(Problem {
            path,
            message,
            instead,
        });
        true
    }
}
