//! What a ray met, and what the beams of a grid met.

/// The instance and the face of a beam that meets nothing.
pub const NO_HIT: u32 = u32::MAX;

/// A triangle that a ray met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FaceHit {
    /// Distance from the ray's origin.
    pub range_m: f64,
    /// Index into [`crate::sense::PosedScene::instances`].
    pub instance: u32,
    /// Face of the instance's mesh.
    pub face: u32,
    /// Cosine of the incidence angle, 0..1.
    pub cos_incidence: f32,
}

impl FaceHit {
    /// Nearer, or of two equally near ones the earlier instance and face.
    pub(crate) fn is_before(&self, other: &Self) -> bool {
        (self.range_m, self.instance, self.face) < (other.range_m, other.instance, other.face)
    }
}

/// What a ray met.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceHits {
    /// The first opaque triangle.
    pub opaque: Option<FaceHit>,
    /// The first transparent one before it.
    pub transparent: Option<FaceHit>,
}

/// What the beams of a grid met, row-major.
#[derive(Debug, Clone, PartialEq)]
pub struct Hits {
    /// Number of rows.
    pub rows: usize,
    /// Number of columns.
    pub columns: usize,
    /// The grid's depth in meters: range for a LIDAR, z along the optical axis for a camera; infinite for a miss.
    pub depth_m: Vec<f32>,
    /// Index into [`crate::sense::PosedScene::instances`], [`NO_HIT`] for a miss.
    pub instance: Vec<u32>,
    /// Face of the instance's mesh, [`NO_HIT`] for a miss.
    pub face: Vec<u32>,
    /// Cosine of the incidence angle, 0..1, of a LIDAR's beams; NaN for a miss, and for a camera's.
    pub cos_incidence: Vec<f32>,
}

impl Hits {
    /// No hit yet.
    #[must_use]
    pub fn new(rows: usize, columns: usize) -> Self {
        let n = rows * columns;
        let (depth_m, cos_incidence) = (vec![f32::INFINITY; n], vec![f32::NAN; n]);
        Self { rows, columns, depth_m, instance: vec![NO_HIT; n], face: vec![NO_HIT; n], cos_incidence }
    }

    /// Forgets every hit.
    pub fn clear(&mut self) {
        self.depth_m.fill(f32::INFINITY);
        self.instance.fill(NO_HIT);
        self.face.fill(NO_HIT);
        self.cos_incidence.fill(f32::NAN);
    }

    /// Notes what a beam meets.
    pub(crate) fn put(&mut self, at: usize, hit: &FaceHit) {
        self.depth_m[at] = hit.range_m as f32;
        self.instance[at] = hit.instance;
        self.face[at] = hit.face;
        self.cos_incidence[at] = hit.cos_incidence;
    }

    /// Takes over the hits of a grid that has some of the columns.
    pub(crate) fn put_columns(&mut self, part: &Self, columns: &[usize]) {
        for row in 0..part.rows {
            for (k, column) in columns.iter().enumerate() {
                let (to, from) = (row * self.columns + column, row * part.columns + k);
                self.depth_m[to] = part.depth_m[from];
                self.instance[to] = part.instance[from];
                self.face[to] = part.face[from];
                self.cos_incidence[to] = part.cos_incidence[from];
            }
        }
    }

    /// Keeps the nearer hit; of two equal ones the earlier instance and face.
    #[inline(always)]
    pub(crate) fn keep_nearer(&mut self, at: usize, [depth_m, cos_incidence]: [f32; 2], [instance, face]: [u32; 2]) {
        let nearest = self.depth_m[at];
        if depth_m < nearest || (depth_m == nearest && (instance, face) < (self.instance[at], self.face[at])) {
            self.depth_m[at] = depth_m;
            self.instance[at] = instance;
            self.face[at] = face;
            self.cos_incidence[at] = cos_incidence;
        }
    }
}
