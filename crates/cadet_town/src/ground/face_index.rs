//! Finds the triangles at a place in the plane.

use cadet_base::math::{DVec2, Vec3};

/// Side of a cell.
const CELL_M: f64 = 4.0;

/// For each cell of a grid, the triangles whose bounds touch it.
#[derive(Debug)]
pub(crate) struct FaceIndex {
    min: DVec2,
    cell_m: f64,
    columns: usize,
    rows: usize,
    first: Vec<u32>,
    faces: Vec<Entry>,
}

/// A triangle and its bounds in the plane, a little wider than needed: most are told from a place by them alone.
#[derive(Debug, Clone, Copy, Default)]
struct Entry {
    min: [f32; 2],
    max: [f32; 2],
    face: u32,
}

impl Entry {
    fn new(face: u32, [a, b, c]: [Vec3; 3]) -> Self {
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        // Whoever asks allows a hundred-thousandth of a triangle's size; far out, single precision rounds by millimeters.
        let margin = 1e-3 + 3e-5 * (max - min).max_element() + 3e-7 * min.abs().max(max.abs()).max_element();
        Self { min: [min.x - margin, min.y - margin], max: [max.x + margin, max.y + margin], face }
    }

    #[inline]
    fn touches(&self, min: [f32; 2], max: [f32; 2]) -> bool {
        (self.min[0] <= max[0]) & (self.max[0] >= min[0]) & (self.min[1] <= max[1]) & (self.max[1] >= min[1])
    }
}

fn to_f32(p: DVec2) -> [f32; 2] {
    [p.x as f32, p.y as f32]
}

impl FaceIndex {
    pub(crate) fn new(vertices: &[Vec3], faces: &[[u32; 3]], min: DVec2, max: DVec2) -> Self {
        let cell_m = CELL_M.max((max - min).max_element() / 1500.0);
        let size = ((max - min) / cell_m).floor() + 1.0;
        let (columns, rows) = (size.x as usize, size.y as usize);
        let mut index = Self { min, cell_m, columns, rows, first: vec![0; columns * rows + 1], faces: Vec::new() };
        let spans: Vec<[usize; 4]> = faces
            .iter()
            .map(|f| {
                let [a, b, c] = f.map(|i| vertices[i as usize].as_dvec3().truncate());
                let (lo, hi) = (index.cell(a.min(b).min(c) - 1e-3), index.cell(a.max(b).max(c) + 1e-3));
                [lo.0, lo.1, hi.0, hi.1]
            })
            .collect();
        let cells = |s: &[usize; 4]| {
            let [i0, j0, i1, j1] = *s;
            (j0..=j1).flat_map(move |j| (i0..=i1).map(move |i| j * columns + i))
        };
        for cell in spans.iter().flat_map(cells) {
            index.first[cell + 1] += 1;
        }
        for i in 1..index.first.len() {
            index.first[i] += index.first[i - 1];
        }
        let mut next = index.first.clone();
        index.faces = vec![Entry::default(); next[next.len() - 1] as usize];
        for ((number, face), span) in (0..).zip(faces).zip(&spans) {
            let entry = Entry::new(number, face.map(|i| vertices[i as usize]));
            for cell in cells(span) {
                index.faces[next[cell] as usize] = entry;
                next[cell] += 1;
            }
        }
        index
    }

    fn cell(&self, p: DVec2) -> (usize, usize) {
        let c = ((p - self.min) / self.cell_m).max(DVec2::ZERO);
        ((c.x as usize).min(self.columns - 1), (c.y as usize).min(self.rows - 1))
    }

    /// The triangles that may hold a place, by rising number; none where it is not finite.
    #[inline]
    pub(crate) fn candidates(&self, p: DVec2) -> impl Iterator<Item = u32> {
        let (i, j) = self.cell(p);
        let cell = j * self.columns + i;
        let range = if p.is_finite() { self.first[cell] as usize..self.first[cell + 1] as usize } else { 0..0 };
        let p = to_f32(p);
        self.faces[range].iter().filter(move |e| e.touches(p, p)).map(|e| e.face)
    }

    /// The triangles that may touch a rectangle, some of them more than once; none where it is not finite.
    pub(crate) fn within(&self, min: DVec2, max: DVec2) -> impl Iterator<Item = u32> {
        let is_finite = min.is_finite() && max.is_finite();
        let ((i0, j0), (i1, j1)) = (self.cell(min), self.cell(max));
        let rows = if is_finite { j0..j1 + 1 } else { 0..0 };
        let (low, high) = (to_f32(min), to_f32(max));
        rows.flat_map(move |j| {
            let row = j * self.columns;
            let entries = &self.faces[self.first[row + i0] as usize..self.first[row + i1 + 1] as usize];
            entries.iter().filter(move |e| e.touches(low, high)).map(|e| e.face)
        })
    }
}
