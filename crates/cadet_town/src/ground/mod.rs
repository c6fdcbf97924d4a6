//! The ground: one continuous surface of road, sidewalk and terrain.

mod bridge;
mod face_index;
pub(crate) mod flat_road;
mod height_field;
mod kind;
pub(crate) mod land;
mod mesh;
mod palette;
pub(crate) mod region;
mod road_section;
mod roughness;
mod surface;

use face_index::FaceIndex;
use height_field::FINEST_CELL_M;
pub(crate) use height_field::{FINEST_CELL_AT_BRIDGES_M, HeightField, road_heights};
pub use kind::GroundKind;
pub(crate) use mesh::{Cover, Fineness, PlanMesh};
pub(crate) use palette::{ASPHALT, Asphalt, MARKING, TERRAIN};
pub(crate) use road_section::{FARTHEST_M, Roadside};
pub use roughness::Roughness;
pub(crate) use surface::{Heights, Surface};

use std::sync::Arc;

use crate::ground::bridge::{Bridges, Deck, pieces_of_rings};
use crate::ground::land::{Crop, Land, Yards, yard_region};
use crate::ground::region::{Regions, Ring};
use crate::network::RoadNetwork;
use crate::paint::{Wear, rails, repairs, road_marking};
use crate::signals::Signals;
use cadet_base::error::Result;
use cadet_base::instance::Instance;
use cadet_base::math::{DVec2, DVec3, Vec3};
use cadet_base::plane::{DistanceFrom, bounds, edges};

/// The ground goes on this far beyond the outermost lane.
const MARGIN_M: f64 = 160.0;

/// The corners of the ground under and around a network.
pub(crate) fn extent(network: &RoadNetwork) -> (DVec2, DVec2) {
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
    /// Of the triangles that are not curb faces: first those of the ground, then those of the decks of bridges.
    kinds: Arc<Vec<GroundKind>>,
    num_on_ground: usize,
    index: Arc<FaceIndex>,
    walks: Arc<Vec<Vec<DVec3>>>,
    outlines: Arc<Regions>,
    bridges: Arc<Bridges>,
}

impl Ground {
    /// The ground under and around a network.
    ///
    /// # Errors
    /// [`cadet_base::Error::Map`] where the network has no carriageway or is larger than 40 km.
    pub fn new(network: &RoadNetwork) -> Result<Self> {
        Self::of_town(network, None, &Wear::default(), &Signals::default(), (None, &Yards::default()))
    }

    /// The ground under and around a network, with the bumps and dips that real streets have.
    ///
    /// # Errors
    /// As [`Ground::new`].
    pub fn rough(network: &RoadNetwork, roughness: &Roughness) -> Result<Self> {
        Self::of_town(network, Some(roughness), &Wear::default(), &Signals::default(), (None, &Yards::default()))
    }

    /// The ground of a town, with bumps and dips, and with its paint: worn, and with stop lines and fords where there
    /// are traffic lights; and with the land about its roads where it is open country.
    ///
    /// # Errors
    /// As [`Ground::new`].
    pub(crate) fn of_town(
        network: &RoadNetwork,
        roughness: Option<&Roughness>,
        wear: &Wear,
        signals: &Signals,
        (land, yards): (Option<&Land>, &Yards),
    ) -> Result<Self> {
        let bumps = |p: DVec2| roughness.map_or(0.0, |r| r.height_m(p));
        let bridges = Arc::new(Bridges::of(network));
        let decks = bridges.decks(network, &bumps)?;
        let lanes = bridges.on_ground(&network.lanes);
        let mut regions = Regions::of(network, &lanes, land)?;
        regions.yards = yard_region::regions(yards, &regions.sidewalk);
        let mut samples = road_heights(&lanes);
        samples.extend(bridges.beside_lanes(&lanes, regions.sidewalk_width_m));
        let (min, max) = extent(network);
        let finest_cell_m = if decks.is_empty() { FINEST_CELL_M } else { FINEST_CELL_AT_BRIDGES_M };
        let height = HeightField::fit(&samples, (min, max), finest_cell_m);
        let is_level = height.is_flat() && roughness.is_none();
        let fineness = if is_level { Fineness::FLAT } else { Fineness::HILLY };
        let cuts = bridges.outlines();
        let mut plan = mesh::triangulate((&regions, network.is_curbless()), &samples, (min, max), (fineness, &cuts))?;
        for face in 0..plan.faces.len() {
            let middle = plan.middle(face);
            if decks.iter().any(|deck| deck.hides(middle)) {
                plan.kinds[face] = Cover::Abutment;
            }
        }
        let ceiling_m = |p: DVec2| decks.iter().map(|deck| deck.ceiling_m(p)).fold(f64::INFINITY, f64::min);
        let surface = |p: DVec2| (height.height(p) + bumps(p)).min(ceiling_m(p));
        let raised = match land {
            Some(land) => {
                let outline = regions.carriageway.iter().flat_map(|ring| edges(ring));
                let from_road = DistanceFrom::new(outline, FARTHEST_M);
                let beside = |p: DVec2| land.roadside.height_m(p, from_road.distance_m(p).min(FARTHEST_M));
                Surface::raise(&plan, &Heights { road: &surface, beside: &beside, has_curbs: false })
            }
            None => Surface::raise(&plan, &Heights::beside_roads(&surface, network)),
        };
        let laid = Laid { plan: &plan, surface: raised, decks, bridges: Arc::clone(&bridges) };
        Ok(Self::assemble(laid, regions, (min, max), &Painted { network, wear, signals, yards }))
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
        let regions = Regions { carriageway: ring.clone(), curb: ring.clone(), sidewalk: ring, ..Regions::default() };
        let surface = Surface::raise(&plan, &Heights::town(&|_| 0.0));
        let laid = Laid { plan: &plan, surface, decks: Vec::new(), bridges: Arc::default() };
        let (network, wear, signals, yards) = Default::default();
        let bare = Painted { network: &network, wear: &wear, signals: &signals, yards: &yards };
        Self::assemble(laid, regions, (DVec2::splat(-half), DVec2::splat(half)), &bare)
    }

    /// Returns this ground's outlines and tiles over another surface, all of it carriageway.
    #[must_use]
    pub fn with_surface(mut self, vertices: Vec<Vec3>, faces: Vec<[u32; 3]>) -> Self {
        let bounds = cadet_base::geometry::Bounds::of(vertices.iter().copied());
        let [min, max] = [bounds.min, bounds.max].map(|p| p.as_dvec3().truncate());
        self.index = Arc::new(FaceIndex::new(&vertices, &faces, min, max));
        self.kinds = Arc::new(vec![GroundKind::Road; faces.len()]);
        self.num_on_ground = faces.len();
        (self.vertices, self.faces) = (Arc::new(vertices), Arc::new(faces));
        self
    }

    fn assemble(laid: Laid<'_>, regions: Regions, (min, max): (DVec2, DVec2), of: &Painted<'_>) -> Self {
        let Laid { plan, surface, decks, bridges } = laid;
        let all = || std::iter::once((plan, &surface)).chain(decks.iter().map(|d| (&d.plan, &d.surface)));
        // The first of each surface's vertices.
        let first = all().scan(0, |sum, (_, s)| Some(std::mem::replace(sum, *sum + s.corners.len() as u32)));
        let first: Vec<u32> = first.collect();
        let faces_of = |is_flat: bool| {
            all().zip(&first).flat_map(move |((plan, surface), first)| {
                let (flat, upright) = surface.faces.split_at(plan.faces.len());
                (if is_flat { flat } else { upright }).iter().map(move |f| f.map(|i| i + first))
            })
        };
        let vertices: Vec<Vec3> = all().flat_map(|(_, s)| &s.corners).map(|p| p.as_vec3()).collect();
        let faces: Vec<[u32; 3]> = faces_of(true).chain(faces_of(false)).collect();
        let index = FaceIndex::new(&vertices, &faces, min, max);
        let mut ground = Self {
            tiles: Vec::new(),
            vertices: Arc::new(vertices),
            faces: Arc::new(faces),
            sidewalk_width_m: regions.sidewalk_width_m,
            kinds: Arc::new(all().flat_map(|(plan, _)| &plan.kinds).map(|c| c.kind()).collect()),
            num_on_ground: plan.faces.len(),
            index: Arc::new(index),
            walks: Arc::default(),
            outlines: Arc::new(regions),
            bridges,
        };
        ground.walks = Arc::new(ground.walks(&decks));
        // Markings are no part of the surface that wheels touch.
        let surface_at = |p: DVec3| ground.surface_near(p).map(|(z, kind)| (z, kind == GroundKind::Road));
        let mut markings = road_marking::draw(of.network, of.signals, &surface_at);
        of.yards.paint(&surface_at, &mut markings);
        markings.append(&mut repairs::draw(of.network, of.wear, &surface_at));
        rails::draw(of.network, &|p| surface_at(p).map(|(z, _)| z), &mut markings);
        ground.tiles = surface.tiles(plan, &markings, of.wear);
        for deck in decks {
            ground.tiles.extend(deck.surface.tiles(&deck.plan, &[], of.wear));
            ground.tiles.push(deck.structure);
        }
        ground
    }

    /// The lines along the middles of all sidewalks, on the ground and on decks.
    fn walks(&self, decks: &[Deck]) -> Vec<Vec<DVec3>> {
        let on_ground = pieces_of_rings(&self.outlines.walks, |p| !decks.iter().any(|deck| deck.hides(p)));
        let on_ground = on_ground.iter().map(|line| {
            line.iter().map(|p| self.height_at(p.x, p.y).map(|z| p.extend(z))).collect::<Option<Vec<DVec3>>>()
        });
        let on_decks = decks.iter().flat_map(|deck| {
            let on_deck = |p: &DVec2| self.surface_near(p.extend(deck.height_m(*p))).map(|(z, _)| p.extend(z));
            deck.walks.iter().map(move |line| line.iter().map(on_deck).collect::<Option<Vec<DVec3>>>())
        });
        on_ground.chain(on_decks).flatten().collect()
    }

    /// Height and kind of the surface that lies nearest above or below a place: the ground or the deck of a bridge; `None`
    /// beyond the edge.
    #[must_use]
    pub fn surface_near(&self, p: DVec3) -> Option<(f64, GroundKind)> {
        let (mut face, mut z) = self.top_face(p.x, p.y)?;
        for (deck, deck_z) in self.faces_at(p.truncate()).skip_while(|(face, _)| *face < self.num_on_ground) {
            if (deck_z - p.z).abs() < (z - p.z).abs() {
                (face, z) = (deck, deck_z);
            }
        }
        Some((z, self.kinds[face]))
    }

    /// Height of the ground at a place, sidewalks included, decks of bridges left out; `None` beyond its edge.
    #[must_use]
    pub fn height_at(&self, x: f64, y: f64) -> Option<f64> {
        self.top_face(x, y).map(|(_, z)| z)
    }

    /// Unit normal of the ground's triangle at a place; `None` beyond the edge.
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
    pub(crate) fn fields(&self) -> &[(Crop, Vec<Ring>)] {
        &self.outlines.fields
    }

    /// Whether there are bridges over it.
    pub fn has_bridges(&self) -> bool {
        self.num_on_ground < self.kinds.len()
    }

    /// Lines along the middles of sidewalks; the last point of a closed one is its first.
    pub(crate) fn walk_lines(&self) -> &[Vec<DVec3>] {
        &self.walks
    }

    /// Whether a place is under a bridge or right beside.
    pub(crate) fn is_near_bridge(&self, p: DVec2) -> bool {
        self.bridges.are_near(p)
    }

    /// Every face that may lie over or under the rectangle from `min` to `max`, curb faces included; some come twice.
    #[inline]
    pub fn faces_about(&self, min: DVec2, max: DVec2) -> impl Iterator<Item = u32> {
        self.index.within(min, max)
    }

    fn corners(&self, face: usize) -> [DVec3; 3] {
        self.faces[face].map(|i| self.vertices[i as usize].as_dvec3())
    }

    /// The uppermost of the ground's triangles that hold a place, and the height there.
    fn top_face(&self, x: f64, y: f64) -> Option<(usize, f64)> {
        let on_ground = self.faces_at(DVec2::new(x, y)).take_while(|(face, _)| *face < self.num_on_ground);
        on_ground.reduce(|best, face| if face.1 > best.1 { face } else { best })
    }

    /// The triangles that hold a place, and their heights there: those of the ground, then those of decks.
    fn faces_at(&self, p: DVec2) -> impl Iterator<Item = (usize, f64)> {
        // Curb faces, which stand upright, come last.
        let flat = self.index.candidates(p).map(|f| f as usize).take_while(|f| *f < self.kinds.len());
        flat.filter_map(move |face| {
            let [a, b, c] = self.corners(face);
            let (u, v, w) = (b.truncate() - a.truncate(), c.truncate() - a.truncate(), p - a.truncate());
            let area = u.perp_dot(v);
            let (s, t) = (w.perp_dot(v) / area, u.perp_dot(w) / area);
            // A hair's breadth of tolerance, so that no point falls between two triangles.
            let holds = s >= -1e-5 && t >= -1e-5 && s + t <= 1.0 + 1e-5;
            holds.then_some((face, a.z + (b.z - a.z) * s + (c.z - a.z) * t))
        })
    }
}

/// A ground before it is put together: its surface, and those of bridges.
struct Laid<'a> {
    plan: &'a PlanMesh,
    surface: Surface,
    decks: Vec<Deck<'a>>,
    bridges: Arc<Bridges>,
}

/// Sources of the paint on a ground.
struct Painted<'a> {
    network: &'a RoadNetwork,
    wear: &'a Wear,
    signals: &'a Signals,
    yards: &'a Yards,
}
