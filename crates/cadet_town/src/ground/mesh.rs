//! Cuts the plane into triangles along the outlines of carriageway, curb and sidewalk, fine near streets.

use std::collections::HashMap;

use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use strum::VariantArray;

use crate::ground::GroundKind;
use crate::ground::land::{Crop, YardSurface};
use crate::ground::region::{Inside, Regions, Ring, with_crossings, with_steps};
use crate::network::LaneSurface;
use cadet_base::error::{Error, Result};
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane;

/// How finely the plane is cut.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Fineness {
    /// Longest piece of an outline.
    pub(crate) outline_m: f64,
    /// Spacing of points within [`NEAR_M`] of a lane; twice that and four times that further out.
    pub(crate) near_m: f64,
}

impl Fineness {
    /// Fine enough that triangles follow hills with bends of 400 m radius within 1 cm.
    pub(crate) const HILLY: Self = Self { outline_m: 3.5, near_m: 4.0 };
    /// Flat ground needs fewer.
    pub(crate) const FLAT: Self = Self { outline_m: 8.0, near_m: 8.0 };
}

/// Points this near to a lane get the finest spacing, points within [`MIDDLE_M`] the next.
const NEAR_M: f64 = 10.0;
const MIDDLE_M: f64 = 40.0;
/// Inner points keep this distance from outlines.
const CLEAR_M: f64 = 0.9;

/// Triangles in plan, each of one kind; curb stones are told from sidewalks.
pub(crate) struct PlanMesh {
    pub(crate) points: Vec<DVec2>,
    /// Counter-clockwise.
    pub(crate) faces: Vec<[u32; 3]>,
    pub(crate) kinds: Vec<Cover>,
}

impl PlanMesh {
    /// The middle of a triangle.
    pub(crate) fn middle(&self, face: usize) -> DVec2 {
        self.faces[face].iter().map(|i| self.points[*i as usize]).sum::<DVec2>() / 3.0
    }

    /// The triangles with what covers them.
    pub(crate) fn covered(&self) -> impl Iterator<Item = (&[u32; 3], Cover)> {
        self.faces.iter().zip(self.kinds.iter().copied())
    }

    /// The triangles that are kept, by their middles.
    pub(crate) fn retain(mut self, is_kept: impl Fn(DVec2) -> bool) -> Self {
        let kept: Vec<usize> = (0..self.faces.len()).filter(|face| is_kept(self.middle(*face))).collect();
        self.faces = kept.iter().map(|face| self.faces[*face]).collect();
        self.kinds = kept.iter().map(|face| self.kinds[*face]).collect();
        self
    }
}

/// What covers a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Cover {
    Carriageway,
    CurbStone,
    Sidewalk,
    Terrain,
    /// The bed of a track, and the stones along it: level with the carriageway.
    Bed(LaneSurface),
    BedEdge,
    /// Below the ends of bridges: it begins level with the road that leads onto them.
    Abutment,
    /// What grows in open country.
    Field(Crop),
    /// Gravel and dry grass along the asphalt of country roads.
    Shoulder,
    /// A carriageway of setts without curbs.
    Setts,
    /// Paved ground beside streets.
    Yard(YardSurface),
}

impl Cover {
    /// Whether it lies as low as the carriageway, without a curb between.
    pub(crate) fn is_low(self) -> bool {
        self.kind() == GroundKind::Road || self == Self::Abutment
    }

    pub(crate) fn kind(self) -> GroundKind {
        match self {
            Self::Carriageway | Self::Setts | Self::Bed(_) | Self::BedEdge => GroundKind::Road,
            Self::CurbStone | Self::Sidewalk => GroundKind::Sidewalk,
            Self::Terrain | Self::Field(_) | Self::Shoulder | Self::Yard(_) | Self::Abutment => GroundKind::Terrain,
        }
    }
}

/// Cuts the rectangle from `min` to `max` along the regions' outlines, and along further ones which may cross those;
/// `lanes` says where fine triangles are needed.
///
/// # Errors
/// [`Error::Map`] where the outlines can't be triangulated.
pub(crate) fn triangulate(
    (regions, is_curbless): (&Regions, bool),
    lanes: &[DVec3],
    (min, max): (DVec2, DVec2),
    (fineness, cuts): (Fineness, &[Ring]),
) -> Result<PlanMesh> {
    let mut cloud = Cloud::default();
    let mut edges = Vec::new();
    let mut near_outline = Raster::new(min, max, CLEAR_M);
    let beds = regions.beds.iter().flat_map(|(_, rings)| rings).chain(&regions.bed_edges);
    let fields = regions.fields.iter().flat_map(|(_, rings)| rings).chain(&regions.roadside).chain(&regions.shoulder);
    let fields = fields.chain(regions.yards.iter().flat_map(|(_, rings)| rings));
    let outlines = regions.carriageway.iter().chain(&regions.curb).chain(&regions.sidewalk).chain(beds).chain(fields);
    let outlines: Vec<&Ring> = outlines.collect();
    let cut = outlines.iter().map(|ring| with_crossings(ring, &mut cuts.iter()));
    for ring in cut.chain(cuts.iter().map(|ring| with_crossings(ring, &mut outlines.iter().copied()))) {
        let ring = with_steps(&ring, fineness.outline_m);
        with_steps(&ring, CLEAR_M / 2.0).iter().for_each(|p| near_outline.mark(*p));
        let indices: Vec<usize> = ring.iter().map(|p| cloud.add(*p)).collect();
        edges.extend(plane::edges(&indices).filter(|[a, b]| a != b));
    }
    add_rectangle(&mut cloud, min, max, 4.0 * fineness.near_m);
    for p in inner_points(lanes, min, max, fineness.near_m) {
        if !near_outline.is_marked_around(p) {
            cloud.add(p);
        }
    }
    let vertices: Vec<Point2<f64>> = cloud.points.iter().map(|p| Point2::new(p.x, p.y)).collect();
    // Outlines never cross, so no edge is refused; were one refused, its neighbors' triangles would only be coarser.
    let mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(vertices, edges, |_| {})
        .map_err(|e| Error::Map { map: "ground".to_owned(), reason: e.to_string() })?;
    let [inside_carriageway, inside_curb, inside_sidewalk, inside_green] =
        [&regions.carriageway, &regions.curb, &regions.sidewalk, &regions.green].map(|r| Inside::new(r));
    let inside_edges = Inside::new(&regions.bed_edges);
    let inside_beds = insides(&regions.beds);
    let inside_shoulder = Inside::new(&regions.shoulder);
    let inside_yards = insides(&regions.yards);
    let inside_fields: Vec<(Crop, Inside)> = Crop::VARIANTS.iter().map(|c| (*c, inside_crop(regions, *c))).collect();
    let points: Vec<DVec2> = mesh.vertices().map(|v| DVec2::new(v.position().x, v.position().y)).collect();
    let (mut faces, mut kinds) = (Vec::new(), Vec::new());
    for face in mesh.inner_faces() {
        let corners = face.vertices().map(|v| v.fix().index() as u32);
        let [a, b, c] = corners.map(|i| points[i as usize]);
        if (b - a).perp_dot(c - a) < 1e-7 {
            continue;
        }
        let middle = (a + b + c) / 3.0;
        // Each region lies inside of the next, and most of the plane outside of all.
        let cover = if !inside_sidewalk.contains(middle) {
            match held(&inside_fields, middle) {
                Some(crop) => Cover::Field(crop),
                None if inside_shoulder.contains(middle) => Cover::Shoulder,
                None => held(&inside_yards, middle).map_or(Cover::Terrain, Cover::Yard),
            }
        } else if inside_carriageway.contains(middle) {
            match held(&inside_beds, middle) {
                Some(surface) => Cover::Bed(surface),
                None if inside_edges.contains(middle) => Cover::BedEdge,
                None if is_curbless => Cover::Setts,
                None => Cover::Carriageway,
            }
        } else if inside_curb.contains(middle) {
            Cover::CurbStone
        } else if inside_green.contains(middle) {
            Cover::Terrain
        } else {
            Cover::Sidewalk
        };
        faces.push(corners);
        kinds.push(cover);
    }
    Ok(PlanMesh { points, faces, kinds })
}

/// What lies inside of each of some regions.
fn insides<T: Copy>(regions: &[(T, Vec<Ring>)]) -> Vec<(T, Inside)> {
    regions.iter().map(|(what, rings)| (*what, Inside::new(rings))).collect()
}

/// The first region that holds a place.
fn held<T: Copy>(regions: &[(T, Inside)], p: DVec2) -> Option<T> {
    regions.iter().find(|(_, inside)| inside.contains(p)).map(|(what, _)| *what)
}

/// The fields with a crop; no two of them overlap.
fn inside_crop(regions: &Regions, crop: Crop) -> Inside {
    let of_crop = regions.fields.iter().filter(|(c, _)| *c == crop);
    Inside::new(&of_crop.flat_map(|(_, rings)| rings.clone()).collect::<Vec<Ring>>())
}

/// Points on a grid of 0.1 mm, each once.
#[derive(Default)]
struct Cloud {
    points: Vec<DVec2>,
    /// Looked up and never walked through, so its order does not matter.
    index: HashMap<(i64, i64), usize>,
}

impl Cloud {
    fn add(&mut self, p: DVec2) -> usize {
        let q = (p * 1e4).round();
        *self.index.entry((q.x as i64, q.y as i64)).or_insert_with(|| {
            self.points.push(q / 1e4);
            self.points.len() - 1
        })
    }
}

fn add_rectangle(cloud: &mut Cloud, min: DVec2, max: DVec2, step_m: f64) {
    let corners = [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)];
    with_steps(&corners, step_m).into_iter().for_each(|p| {
        cloud.add(p);
    });
}

/// A square lattice that is dense near lanes and thins out away from them.
fn inner_points(lanes: &[DVec3], min: DVec2, max: DVec2, step_m: f64) -> Vec<DVec2> {
    let mut near = Raster::new(min, max, NEAR_M);
    let mut middle = Raster::new(min, max, MIDDLE_M);
    for p in lanes {
        near.mark(p.truncate());
        middle.mark(p.truncate());
    }
    let count = ((max - min) / step_m).floor();
    let mut out = Vec::new();
    for j in 1..count.y as usize {
        for i in 1..count.x as usize {
            let p = min + DVec2::new(i as f64, j as f64) * step_m;
            let keep = if near.is_marked_around(p) {
                true
            } else if middle.is_marked_around(p) {
                i % 2 == 0 && j % 2 == 0
            } else {
                i % 4 == 0 && j % 4 == 0
            };
            if keep {
                out.push(p);
            }
        }
    }
    out
}

/// Square cells that are marked or not.
struct Raster {
    min: DVec2,
    cell_m: f64,
    columns: usize,
    rows: usize,
    marked: Vec<bool>,
}

impl Raster {
    fn new(min: DVec2, max: DVec2, cell_m: f64) -> Self {
        let cell_m = cell_m.max((max - min).max_element() / 4000.0);
        let size = ((max - min) / cell_m).floor() + 1.0;
        let (columns, rows) = (size.x as usize, size.y as usize);
        Self { min, cell_m, columns, rows, marked: vec![false; columns * rows] }
    }

    fn cell(&self, p: DVec2) -> (usize, usize) {
        let c = ((p - self.min) / self.cell_m).max(DVec2::ZERO);
        ((c.x as usize).min(self.columns - 1), (c.y as usize).min(self.rows - 1))
    }

    fn mark(&mut self, p: DVec2) {
        let (i, j) = self.cell(p);
        self.marked[j * self.columns + i] = true;
    }

    /// True where the cell of `p` or one of its eight neighbors is marked.
    fn is_marked_around(&self, p: DVec2) -> bool {
        let (i, j) = self.cell(p);
        (j.saturating_sub(1)..=(j + 1).min(self.rows - 1)).any(|row| {
            (i.saturating_sub(1)..=(i + 1).min(self.columns - 1)).any(|column| self.marked[row * self.columns + column])
        })
    }
}
