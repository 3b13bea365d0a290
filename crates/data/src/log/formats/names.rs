//! Names that stand twice.

use std::collections::HashMap;

/// Names that were given so far.
#[derive(Default)]
pub(super) struct Names {
    seen: HashMap<String, usize>,
}

impl Names {
    /// The name, or `name_2`, `name_3`, … where it was given before.
    pub(super) fn free(&mut self, name: &str) -> String {
        let Some(count) = self.seen.get_mut(name) else {
            self.seen.insert(name.to_owned(), 1);
            return name.to_owned();
        };
        let mut number = *count;
        loop {
            number += 1;
            let candidate = format!("{name}_{number}");
            if !self.seen.contains_key(&candidate) {
                self.seen.insert(name.to_owned(), number);
                self.seen.insert(candidate.clone(), 1);
                return candidate;
            }
        }
    }
}
