//! Disjoint sets of things that are counted from 0.

/// Disjoint sets, each known by its root.
///
/// # Cost
/// All operations amortized O(log n), by halving the paths on the way to the root.
///
/// # Source
/// R. E. Tarjan, J. van Leeuwen, Worst-case analysis of set union algorithms, Journal of the ACM 31, 1984.
#[derive(Debug, Clone, Default)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// As many sets of one.
    pub fn new(count: usize) -> Self {
        DisjointSets { parent: (0..count as u32).collect() }
    }

    /// Adds a set of one, the next number, and returns it.
    pub fn grow(&mut self) -> u32 {
        let next = self.parent.len() as u32;
        self.parent.push(next);
        next
    }

    /// The root of the set of `a`: its least member if sets were joined by [`Self::join`] only.
    pub fn root(&mut self, mut a: u32) -> u32 {
        while self.parent[a as usize] != a {
            let up = self.parent[self.parent[a as usize] as usize];
            self.parent[a as usize] = up;
            a = up;
        }
        a
    }

    /// Makes one set of two and returns its root, the lesser of the two; so the order of joining leaves no trace.
    pub fn join(&mut self, a: u32, b: u32) -> u32 {
        let (a, b) = (self.root(a), self.root(b));
        self.hang(a.max(b), a.min(b));
        a.min(b)
    }

    /// Hangs one root below another, which stays.
    pub fn hang(&mut self, lost: u32, kept: u32) {
        self.parent[lost as usize] = kept;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joined_sets_have_their_least_member_for_root() {
        let mut sets = DisjointSets::new(6);
        assert_eq!(sets.join(4, 2), 2);
        assert_eq!(sets.join(5, 3), 3);
        assert_eq!(sets.join(5, 4), 2);
        assert_eq!([0, 1, 2, 3, 4, 5].map(|a| sets.root(a)), [0, 1, 2, 2, 2, 2]);
        assert_eq!(sets.grow(), 6);
        sets.hang(2, 6);
        assert_eq!(sets.root(3), 6);
    }
}
