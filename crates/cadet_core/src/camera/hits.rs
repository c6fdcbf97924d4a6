//! Hits that wait to be shaded: those of one kind together, lane by lane.

/// Hits that are shaded together.
pub const LANES: usize = 128;
/// Lanes that are filled together: neighbours often show one face.
pub const RUN: usize = 8;
/// Room for runs that end beyond the last lane; arrays a power of two apart would share the sets of the cache.
pub const STRIDE: usize = LANES + 16;
/// One number a lane.
pub type Lane = [f32; STRIDE];

/// Samples of a pixel that show the same face.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// Index of the face.
    pub face: u32,
    /// Index of the sky's visibility.
    pub open: u32,
    /// Pixel to which the colour is added.
    pub target: u32,
    /// Share of the pixel.
    pub weight: f32,
    /// Image point.
    pub u: f32,
    /// Image point.
    pub v: f32,
    /// Along the optical axis, metres.
    pub depth: f32,
}

/// Hits of one kind, one a lane. Lanes from `count` on mean nothing.
#[derive(Debug, Clone)]
pub struct Hits {
    pub count: usize,
    pub face: [u32; STRIDE],
    pub open: [u32; STRIDE],
    pub target: [u32; STRIDE],
    /// Of panes: the pixel that has the colour of what is seen through them.
    pub behind: [u32; STRIDE],
    pub weight: Lane,
    pub u: Lane,
    pub v: Lane,
    pub depth: Lane,
}

impl Hits {
    pub const NONE: Self = Self {
        count: 0,
        face: [0; STRIDE],
        open: [0; STRIDE],
        target: [0; STRIDE],
        behind: [0; STRIDE],
        weight: [0.0; STRIDE],
        u: [0.0; STRIDE],
        v: [0.0; STRIDE],
        depth: [1.0; STRIDE],
    };

    /// True if there is no room for another run.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.count > LANES - RUN
    }

    /// Adds one hit. There must be room.
    #[inline]
    pub fn push(&mut self, hit: &Hit) {
        let i = self.count.min(LANES - 1);
        self.face[i] = hit.face;
        self.open[i] = hit.open;
        self.target[i] = hit.target;
        self.weight[i] = hit.weight;
        (self.u[i], self.v[i], self.depth[i]) = (hit.u, hit.v, hit.depth);
        self.count = i + 1;
    }

    /// Adds a hit on one face for each of up to eight neighbouring pixels, of which `first` is the leftmost. There must be
    /// room.
    #[inline]
    pub fn push_run(&mut self, first: &Hit, depth: &[f32; RUN], count: usize) {
        const STEPS: [f32; RUN] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        let i = self.count.min(LANES - 1);
        set(&mut self.face, i, [first.face; RUN]);
        set(&mut self.open, i, [first.open; RUN]);
        set(&mut self.target, i, [0, 1, 2, 3, 4, 5, 6, 7].map(|k| first.target + k));
        set(&mut self.weight, i, [first.weight; RUN]);
        set(&mut self.u, i, STEPS.map(|k| first.u + k));
        set(&mut self.v, i, [first.v; RUN]);
        set(&mut self.depth, i, *depth);
        self.count = i + count;
    }
}

/// Sets eight lanes.
#[inline(always)]
pub fn set<T: Copy>(lane: &mut [T; STRIDE], start: usize, values: [T; RUN]) {
    if let Some(run) = lane[start..].first_chunk_mut::<RUN>() {
        *run = values;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_its_hits_one_by_one() {
        let first = Hit { face: 7, open: 9, target: 100, weight: 1.0, u: 40.25, v: 3.25, depth: 2.0 };
        let depth = [2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0, 5.5];
        let (mut run, mut single) = (Box::new(Hits::NONE), Box::new(Hits::NONE));
        for count in [8, 3, 1, 5] {
            run.push_run(&first, &depth, count);
            for k in 0..count {
                let hit = Hit { target: 100 + k as u32, u: 40.25 + k as f32, depth: depth[k], ..first };
                single.push(&hit);
            }
        }
        let n = run.count;
        assert_eq!((n, single.count), (17, 17));
        assert_eq!(run.target[..n], single.target[..n]);
        assert_eq!((&run.face[..n], &run.open[..n]), (&single.face[..n], &single.open[..n]));
        assert_eq!((&run.u[..n], &run.v[..n]), (&single.u[..n], &single.v[..n]));
        assert_eq!((&run.depth[..n], &run.weight[..n]), (&single.depth[..n], &single.weight[..n]));
    }

    #[test]
    fn there_is_room_for_a_run_until_it_is_full() {
        let hit = Hit { face: 0, open: 0, target: 0, weight: 1.0, u: 0.0, v: 0.0, depth: 1.0 };
        let mut hits = Box::new(Hits::NONE);
        while !hits.is_full() {
            let before = hits.count;
            hits.push_run(&hit, &[1.0; RUN], 7);
            assert_eq!(hits.count, before + 7);
        }
        assert!(hits.count <= LANES);
    }
}
