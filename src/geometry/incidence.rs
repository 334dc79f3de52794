//! Which elements a particle belongs to.

/// For each particle the corners of elements that are its own, in the order of the elements.
pub struct Incidence {
    starts: Vec<u32>,
    /// `N * element + corner`.
    slots: Vec<u32>,
}

impl Incidence {
    pub fn new<const N: usize>(particle_count: usize, elements: impl Iterator<Item = [u32; N]> + Clone) -> Self {
        let mut starts = vec![0u32; particle_count + 1];
        for p in elements.clone().flatten() {
            starts[p as usize + 1] += 1;
        }
        for i in 0..particle_count {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut slots = vec![0; starts[particle_count] as usize];
        for (slot, p) in elements.flatten().enumerate() {
            slots[next[p as usize] as usize] = slot as u32;
            next[p as usize] += 1;
        }
        Self { starts, slots }
    }

    pub fn slots(&self, particle: usize) -> &[u32] {
        &self.slots[self.starts[particle] as usize..self.starts[particle + 1] as usize]
    }
}
