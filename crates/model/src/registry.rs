//! Lists of component types.

use crate::Component;

/// The list of all component types.
pub type Registry = &'static [&'static dyn Component];

/// Number of entries of all these lists.
#[must_use]
pub const fn count(lists: &[Registry]) -> usize {
    let (mut count, mut list) = (0, 0);
    while list < lists.len() {
        (count, list) = (count + lists[list].len(), list + 1);
    }
    count
}

/// The entries of all these lists, one list behind the other; `N` is their [`count`].
#[must_use]
pub const fn joined<const N: usize>(lists: &[Registry]) -> [&'static dyn Component; N] {
    let mut all = [lists[0][0]; N];
    let (mut at, mut list) = (0, 0);
    while list < lists.len() {
        let mut index = 0;
        while index < lists[list].len() {
            all[at] = lists[list][index];
            (at, index) = (at + 1, index + 1);
        }
        list += 1;
    }
    all
}
