//! The edges of a mesh, those between the same two corners together.

/// An edge as one of its faces passes it: the higher corner, the face, and the direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Edge(u64);

impl Edge {
    pub fn face(self) -> u32 {
        (self.0 as u32) >> 1
    }

    /// True if the face passes it from the lower corner to the higher.
    pub fn is_forth(self) -> bool {
        self.0 & 1 == 1
    }

    fn higher(self) -> u32 {
        (self.0 >> 32) as u32
    }
}

/// The edges of faces, sorted by lower corner, higher corner and face.
pub(super) struct Edges {
    /// The first edge of each lower corner, and the end.
    first: Vec<u32>,
    edges: Vec<Edge>,
}

impl Edges {
    /// Of fewer than 2^31 faces between so many corners; those from a corner to itself are left out.
    pub fn of(num_corners: usize, faces: impl Iterator<Item = [u32; 3]> + Clone) -> Self {
        // A corner has few edges, so counting comes first and sorting has little to do.
        let of_face = |[a, b, c]: [u32; 3]| [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to);
        let mut first = vec![0_u32; num_corners + 1];
        for (from, to) in faces.clone().flat_map(of_face) {
            first[from.min(to) as usize + 1] += 1;
        }
        for i in 0..num_corners {
            first[i + 1] += first[i];
        }
        let mut next = first.clone();
        let mut edges = vec![Edge(0); first[num_corners] as usize];
        for (face, corners) in (0_u64..).zip(faces) {
            for (from, to) in of_face(corners) {
                let place = &mut next[from.min(to) as usize];
                edges[*place as usize] = Edge(u64::from(from.max(to)) << 32 | face << 1 | u64::from(from < to));
                *place += 1;
            }
        }
        for pair in first.windows(2) {
            edges[pair[0] as usize..pair[1] as usize].sort_unstable();
        }
        Self { first, edges }
    }

    /// The edges between each two corners, by rising corners.
    pub fn by_corners(&self) -> impl Iterator<Item = &[Edge]> {
        let of_lower = self.first.windows(2).map(|pair| &self.edges[pair[0] as usize..pair[1] as usize]);
        of_lower.flat_map(|edges| edges.chunk_by(|a, b| a.higher() == b.higher()))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn edges_stand_together_and_by_rising_corners() {
        let faces = [[5, 1, 4], [1, 5, 2], [4, 1, 0], [2, 2, 5], [1, 4, 5]];
        let mut expected: BTreeMap<(u32, u32), Vec<(u32, bool)>> = BTreeMap::new();
        for (face, [a, b, c]) in (0..).zip(faces) {
            for (from, to) in [(a, b), (b, c), (c, a)].into_iter().filter(|(from, to)| from != to) {
                expected.entry((from.min(to), from.max(to))).or_default().push((face, from < to));
            }
        }
        // A face that passes an edge twice does so backwards first.
        expected.values_mut().for_each(|group| group.sort_unstable());
        let edges = Edges::of(6, faces.into_iter());
        let found: Vec<Vec<(u32, bool)>> =
            edges.by_corners().map(|group| group.iter().map(|e| (e.face(), e.is_forth())).collect()).collect();
        assert_eq!(found, expected.into_values().collect::<Vec<_>>());
    }
}
