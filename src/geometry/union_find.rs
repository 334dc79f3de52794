//! Disjoint sets, for points that are sewn to one.

/// Disjoint sets over `0..len`; the smallest member represents its set, so the outcome does not
/// depend on the order of the unions.
pub struct UnionFind {
    parent: Vec<u32>,
}

impl UnionFind {
    pub fn new(len: usize) -> Self {
        Self { parent: (0..len as u32).collect() }
    }

    /// The smallest member of the set of `member`.
    pub fn find(&mut self, member: u32) -> u32 {
        let mut at = member;
        while self.parent[at as usize] != at {
            let grandparent = self.parent[self.parent[at as usize] as usize];
            self.parent[at as usize] = grandparent;
            at = grandparent;
        }
        at
    }

    pub fn union(&mut self, a: u32, b: u32) {
        let (a, b) = (self.find(a), self.find(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chained_unions_share_the_smallest_member() {
        let mut sets = UnionFind::new(6);
        sets.union(4, 5);
        sets.union(2, 4);
        sets.union(5, 3);
        assert_eq!([2, 3, 4, 5].map(|i| sets.find(i)), [2; 4]);
        assert_eq!((sets.find(0), sets.find(1)), (0, 1));
    }
}
