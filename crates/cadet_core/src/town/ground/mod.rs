//! The ground: one continuous surface of road, sidewalk and terrain.

pub(in crate::town) mod face_index;
pub(in crate::town) mod flat_road;
pub(in crate::town) mod height_field;
pub(in crate::town) mod kind;
pub(in crate::town) mod land;
pub(in crate::town) mod mesh;
pub(in crate::town) mod palette;
pub(in crate::town) mod region;
pub(in crate::town) mod road_section;
pub(in crate::town) mod roughness;
pub(in crate::town) mod surface;

use std::sync::Arc;

use crate::error::Result;
use crate::town::ground::face_index::FaceIndex;
use crate::town::ground::height_field::HeightField;
use crate::town::ground::kind::GroundKind;

use crate::town::ground::land::fields::{Crop, Land};
use crate::town::ground::land::yard_region;
use crate::town::ground::land::yards::Yards;
use crate::town::ground::mesh::{Cover, Fineness, PlanMesh};
use crate::town::ground::region::{Regions, Ring};
use crate::town::ground::road_section::DistanceFrom;
use crate::town::ground::roughness::Roughness;
use crate::town::ground::surface::{Heights, Surface};
use crate::town::network::road_network::{Lane, LaneKind, RoadNetwork};
use crate::town::paint::wear::Wear;
use crate::town::paint::{rails, repairs, road_marking};
use crate::town::signals::Signals;

use crate::instance::Instance;
use crate::math::{DVec2, DVec3, Vec3};
use crate::plane::bounds;

/// The ground goes on this far beyond the outermost lane.
const MARGIN_M: f64 = 160.0;
/// Heights are taken from lanes at least this far apart.
const SAMPLE_STEP_M: f64 = 1.7;

/// The corners of the ground under and around a network.
pub(in crate::town) fn extent(network: &RoadNetwork) -> (DVec2, DVec2) {
    let everything = network.lanes.iter().flat_map(|l| &l.center).map(|p| p.truncate());
    let (min, max) = bounds(everything);
    ((min - MARGIN_M).floor(), (max + MARGIN_M).ceil())
}

/// The surface that wheels and feet touch.
#[derive(Debug, Clone)]
pub struct Ground {
    /// Corners of the surface, for the physics.
    pub vertices: Arc<Vec<Vec3>>,
    /// Triangles of the surface, counter-clockwise from above; curb faces, which stand upright, come last.
    pub faces: Arc<Vec<[u32; 3]>>,
    /// The surface to look at, with road markings, in tiles of 50 m; their frames are axis-aligned, moved to the tile's
    /// corner.
    pub tiles: Vec<Instance>,
    /// Width of sidewalks, curb stone included, wherever the map does not say more.
    pub sidewalk_width_m: f64,
    kinds: Arc<Vec<GroundKind>>,
    index: Arc<FaceIndex>,
    outlines: Arc<Regions>,
}

impl Ground {
    /// The ground under and around a network.
    ///
    /// # Errors
    /// [`crate::Error::Map`] where the network has no carriageway or is larger than 40 km.
    pub fn new(network: &RoadNetwork) -> Result<Self> {
        Self::laid(network, None, &Wear::default(), &Signals::default(), (None, &Yards::default()))
    }

    /// The ground under and around a network, with the bumps and dips that real streets have.
    ///
    /// # Errors
    /// As [`Ground::new`].
    pub fn rough(network: &RoadNetwork, roughness: &Roughness) -> Result<Self> {
        Self::laid(network, Some(roughness), &Wear::default(), &Signals::default(), (None, &Yards::default()))
    }

    /// The ground of a town, with bumps and dips, and with its paint: worn, and with stop lines and fords where there
    /// are traffic lights; and with the land about its roads where it is open country.
    ///
    /// # Errors
    /// As [`Ground::new`].
    pub(in crate::town) fn of_town(
        network: &RoadNetwork,
        roughness: &Roughness,
        wear: &Wear,
        signals: &Signals,
        (land, yards): (Option<&Land>, &Yards),
    ) -> Result<Self> {
        Self::laid(network, Some(roughness), wear, signals, (land, yards))
    }

    fn laid(
        network: &RoadNetwork,
        roughness: Option<&Roughness>,
        wear: &Wear,
        signals: &Signals,
        (land, yards): (Option<&Land>, &Yards),
    ) -> Result<Self> {
        let mut regions = Regions::of(network, land)?;
        regions.yards = yard_region::regions(yards, &regions.sidewalk);
        let paved =
            |k: LaneKind| matches!(k, LaneKind::Driving | LaneKind::Parking | LaneKind::Biking | LaneKind::Tram);
        let samples: Vec<DVec3> = network.lanes.iter().filter(|l| paved(l.kind)).flat_map(spaced_points).collect();
        let (min, max) = extent(network);
        let height = HeightField::fit(&samples, min, max);
        let is_level = height.is_flat() && roughness.is_none();
        let fineness = if is_level { Fineness::FLAT } else { Fineness::HILLY };
        let plan = mesh::triangulate((&regions, network.is_curbless()), &samples, (min, max), fineness)?;
        let surface = |p: DVec2| height.height(p) + roughness.map_or(0.0, |r| r.height_m(p));
        let painted = Painted { network, wear, signals, yards };
        if network.is_curbless() {
            let heights = Heights { road: &surface, beside: &|_| 0.0, has_curbs: false };
            return Ok(Self::assemble(&plan, regions, &heights, (min, max), Some(&painted)));
        }
        if !network.is_rural() {
            return Ok(Self::assemble(&plan, regions, &Heights::town(&surface), (min, max), Some(&painted)));
        }
        let from_road = DistanceFrom::new(&regions.carriageway);
        let beside = |p: DVec2| land.map_or(0.0, |l| l.roadside.height_m(p, from_road.distance_m(p)));
        let heights = Heights { road: &surface, beside: &beside, has_curbs: false };
        Ok(Self::assemble(&plan, regions, &heights, (min, max), Some(&painted)))
    }

    /// A flat square of asphalt around the origin, for tests and for scenes without a map.
    #[must_use]
    pub fn flat(half_size_m: f64) -> Self {
        let half = half_size_m.clamp(1.0, 20_000.0);
        let corners = [[-half, -half], [half, -half], [half, half], [-half, half]].map(DVec2::from);
        let plan = PlanMesh {
            points: corners.to_vec(),
            faces: vec![[0, 1, 2], [0, 2, 3]],
            kinds: vec![Cover::Carriageway; 2],
        };
        let ring = vec![Ring::from(corners)];
        let regions = Regions {
            carriageway: ring.clone(),
            curb: ring.clone(),
            sidewalk: ring,
            walks: Vec::new(),
            green: Vec::new(),
            beds: Vec::new(),
            bed_edges: Vec::new(),
            sidewalk_width_m: 0.0,
            shoulder: Vec::new(),
            roadside: Vec::new(),
            fields: Vec::new(),
            yards: Vec::new(),
        };
        Self::assemble(&plan, regions, &Heights::town(&|_| 0.0), (DVec2::splat(-half), DVec2::splat(half)), None)
    }

    /// Returns this ground's outlines and tiles over another surface, all of it carriageway.
    #[cfg(test)]
    pub(crate) fn with_surface(mut self, vertices: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Self {
        let bounds = crate::geometry::Bounds::of(vertices.iter().copied());
        let [min, max] = [bounds.min, bounds.max].map(|p| p.as_dvec3().truncate());
        self.index = Arc::new(FaceIndex::new(&vertices, &faces, min, max));
        self.kinds = Arc::new(vec![GroundKind::Road; faces.len()]);
        (self.vertices, self.faces) = (Arc::new(vertices), Arc::new(faces));
        self
    }

    fn assemble(
        plan: &PlanMesh,
        regions: Regions,
        heights: &Heights<'_>,
        (min, max): (DVec2, DVec2),
        painted: Option<&Painted<'_>>,
    ) -> Self {
        let surface = Surface::raise(plan, heights);
        let kinds: Vec<GroundKind> = plan.kinds.iter().map(|c| c.kind()).collect();
        let vertices: Vec<Vec3> = surface.corners.iter().map(|p| p.as_vec3()).collect();
        let index = FaceIndex::new(&vertices, &surface.faces, min, max);
        let mut ground = Self {
            tiles: Vec::new(),
            vertices: Arc::new(vertices),
            faces: Arc::clone(&surface.faces),
            sidewalk_width_m: regions.sidewalk_width_m,
            kinds: Arc::new(kinds),
            index: Arc::new(index),
            outlines: Arc::new(regions),
        };
        // Markings are no part of the surface that wheels touch.
        let markings = painted.map(|of| {
            let mut quads = road_marking::draw(of.network, of.signals, &|x, y| ground.surface_at(x, y));
            of.yards.paint(&|x, y| ground.surface_at(x, y), &mut quads);
            quads.append(&mut repairs::draw(of.network, of.wear, &|x, y| ground.surface_at(x, y)));
            rails::draw(of.network, &|x, y| ground.height_at(x, y), &mut quads);
            quads
        });
        let wear = painted.map_or(Wear::default(), |of| *of.wear);
        ground.tiles = surface.tiles(plan, &markings.unwrap_or_default(), &wear);
        ground
    }

    /// Height of the surface at a place, and whether it is a road.
    fn surface_at(&self, x: f64, y: f64) -> Option<(f64, bool)> {
        self.top_face(x, y).map(|(face, z)| (z, self.kinds[face] == GroundKind::Road))
    }

    /// Height of the surface at a place, sidewalks included; `None` beyond its edge.
    #[must_use]
    pub fn height_at(&self, x: f64, y: f64) -> Option<f64> {
        self.top_face(x, y).map(|(_, z)| z)
    }

    /// Unit normal of the triangle at a place; `None` beyond the edge.
    #[must_use]
    pub fn normal_at(&self, x: f64, y: f64) -> Option<DVec3> {
        let (face, _) = self.top_face(x, y)?;
        let [a, b, c] = self.corners(face);
        Some((b - a).cross(c - a).normalize())
    }

    /// What the ground is at a place; `None` beyond the edge.
    #[must_use]
    pub fn kind_at(&self, x: f64, y: f64) -> Option<GroundKind> {
        self.top_face(x, y).map(|(face, _)| self.kinds[face])
    }

    /// Outline of the carriageway, where curbs stand: closed rings, outer ones counter-clockwise, holes clockwise, the
    /// first point not repeated.
    #[must_use]
    pub fn carriageway_outline(&self) -> &[Vec<DVec2>] {
        &self.outlines.carriageway
    }

    /// Outline of carriageway and sidewalks together, where gardens begin; rings as in
    /// [`Self::carriageway_outline`].
    #[must_use]
    pub fn sidewalk_outline(&self) -> &[Vec<DVec2>] {
        &self.outlines.sidewalk
    }

    /// What grows where in open country.
    pub(in crate::town) fn fields(&self) -> &[(Crop, Vec<Ring>)] {
        &self.outlines.fields
    }

    pub(in crate::town) fn walk_rings(&self) -> &[Ring] {
        &self.outlines.walks
    }

    /// Every face that may lie over or under the rectangle from `min` to `max`, curb faces included; some come twice.
    pub(crate) fn faces_about(&self, min: DVec2, max: DVec2) -> impl Iterator<Item = u32> {
        self.index.within(min, max)
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|i| self.vertices[i as usize].as_dvec3())
    }

    /// The uppermost of the triangles that hold a place, and the height there.
    fn top_face(&self, x: f64, y: f64) -> Option<(usize, f64)> {
        let p = DVec2::new(x, y);
        let mut best: Option<(usize, f64)> = None;
        // Curb faces, which stand upright, come last.
        for face in self.index.candidates(p).take_while(|f| (*f as usize) < self.kinds.len()) {
            let [a, b, c] = self.corners(face as usize);
            let (u, v, w) = (b.truncate() - a.truncate(), c.truncate() - a.truncate(), p - a.truncate());
            let area = u.perp_dot(v);
            let (s, t) = (w.perp_dot(v) / area, u.perp_dot(w) / area);
            // A hair's breadth of tolerance, so that no point falls between two triangles.
            if s < -1e-5 || t < -1e-5 || s + t > 1.0 + 1e-5 {
                continue;
            }
            let z = a.z + (b.z - a.z) * s + (c.z - a.z) * t;
            if best.is_none_or(|(_, top)| z > top) {
                best = Some((face as usize, z));
            }
        }
        best
    }
}

/// Sources of the paint on a ground.
struct Painted<'a> {
    network: &'a RoadNetwork,
    wear: &'a Wear,
    signals: &'a Signals,
    yards: &'a Yards,
}

/// The lane's points, without those that follow closer than [`SAMPLE_STEP_M`].
fn spaced_points(lane: &Lane) -> Vec<DVec3> {
    let mut next_s = 0.0;
    let spaced = lane.center.iter().zip(&lane.s_m).filter(|(_, s)| {
        let keep = **s >= next_s;
        next_s = if keep { **s + SAMPLE_STEP_M } else { next_s };
        keep
    });
    spaced.map(|(p, _)| *p).chain(lane.center.last().copied()).collect()
}
