//! Sets of small numbers without allocations.

/// Largest number of members of a set: of states of a machine, and of guards.
// Four words, so a set is copied freely and a change of state allocates nothing.
pub const MAX_MEMBERS: usize = 256;
const WORDS: usize = MAX_MEMBERS / 64;

/// A set of numbers below [`MAX_MEMBERS`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SmallSet([u64; WORDS]);

impl SmallSet {
    pub(crate) fn contains(&self, member: usize) -> bool {
        self.0
            .get(member / 64)
            .is_some_and(|word| word >> (member % 64) & 1 == 1)
    }

    /// Adds `member`; one beyond the limit is ignored.
    pub(crate) fn insert(&mut self, member: usize) {
        if let Some(word) = self.0.get_mut(member / 64) {
            *word |= 1 << (member % 64);
        }
    }

    pub(crate) fn remove(&mut self, member: usize) {
        if let Some(word) = self.0.get_mut(member / 64) {
            *word &= !(1 << (member % 64));
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.0 == [0; WORDS]
    }

    pub(crate) fn len(&self) -> u32 {
        self.0.iter().map(|word| word.count_ones()).sum()
    }

    pub(crate) fn union(mut self, other: &Self) -> Self {
        for (mine, theirs) in self.0.iter_mut().zip(&other.0) {
            *mine |= theirs;
        }
        self
    }

    pub(crate) fn intersection(mut self, other: &Self) -> Self {
        for (mine, theirs) in self.0.iter_mut().zip(&other.0) {
            *mine &= theirs;
        }
        self
    }

    pub(crate) fn difference(mut self, other: &Self) -> Self {
        for (mine, theirs) in self.0.iter_mut().zip(&other.0) {
            *mine &= !theirs;
        }
        self
    }

    /// Members in ascending order.
    pub(crate) fn iter(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        let mut at = 0;
        std::iter::from_fn(move || {
            while let Some(word) = rest.get_mut(at) {
                if *word != 0 {
                    let bit = word.trailing_zeros() as usize;
                    // Clears the lowest bit, so the loop runs once per member and not once per
                    // number.
                    *word &= *word - 1;
                    return Some(at * 64 + bit);
                }
                at += 1;
            }
            None
        })
    }
}

impl FromIterator<usize> for SmallSet {
    fn from_iter<I: IntoIterator<Item = usize>>(members: I) -> Self {
        let mut set = Self::default();
        members.into_iter().for_each(|member| set.insert(member));
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn members_come_back_in_rising_order_across_words() {
        let mut set: SmallSet = [200, 3, 64, 255, 63].into_iter().collect();
        set.insert(MAX_MEMBERS);
        set.remove(64);
        assert_eq!(set.iter().collect::<Vec<_>>(), [3, 63, 200, 255]);
        assert!(set.contains(200) && !set.contains(64) && set.len() == 4);
        let low: SmallSet = [3, 4].into_iter().collect();
        assert_eq!(set.intersection(&low).iter().collect::<Vec<_>>(), [3]);
        assert_eq!(set.difference(&low).iter().count(), 3);
        assert!(set.difference(&set).is_empty());
    }
}
