//! Vehicles made of somebody else's meshes.

use std::sync::Arc;

use super::VehicleModel;
use super::assumed_windows::{Face, Windows};
use super::imported_fit::{Fit, or_what_to_leave_out};
use super::imported_materials::{MaterialRules, Role, listed, matches, material};
use super::paint::{Livery, semantic_of};
use crate::source_mesh::{Placing, SourceMesh, SourceTriangle, check_num_materials, has_area};
use cadet_base::actor::{AnnotatedBox, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::geometry::{Bounds, LodSet, MeshBuilder};
use cadet_base::material::{Material, Palette, Pattern};
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

/// Faces that meet at more than this angle show an edge.
const CREASE_RAD: f32 = 0.6;
/// Points lower than this belong to a tire rather than to the body, meters.
const TYRE_FOOT_M: f32 = 0.15;

/// A user's mesh and what is to be known about it.
#[derive(Debug, Clone)]
pub struct VehicleAsset {
    /// The model's name in labels' metadata.
    pub name: String,
    /// `Car`, `Van` or `Truck`, which drive and park, or `Tram` or `Misc`, which stand where they are put.
    pub class: ObjectClass,
    /// The mesh's file, for messages.
    pub file: String,
    /// What the file holds.
    pub source: SourceMesh,
    /// Meters per unit of the file, above 0.
    pub scale: f64,
    /// Turns the mesh about the vertical, counter-clockwise seen from above, so that its front looks along +x.
    pub yaw_rad: f64,
    /// True where an OBJ file's y axis points up; else its z axis does.
    pub y_up: bool,
    /// Stretches the mesh to this length, width and height, meters.
    pub size_lwh: Option<DVec3>,
    /// Which materials are glass, tires, ...
    pub rules: MaterialRules,
    /// Patterns of the names of materials and parts that are none of the vehicle; `None` where nobody has thought of it.
    pub leave_out: Option<Vec<String>>,
}

impl VehicleModel {
    /// The vehicle of a user's mesh: one level of detail, the wheels part of the body, the mesh's bounds its box;
    /// what annotators leave out is drawn for each actor ([`VehicleModel::annotated_by`]).
    ///
    /// # Errors
    /// [`Error::Mesh`], naming the file: no face with an area, a coordinate that is not finite, a rule that fits nothing,
    /// or a size that no vehicle has. [`Error::Scene`] for a class that no vehicle has.
    pub fn from_asset(asset: &VehicleAsset) -> Result<Self> {
        Self::with_assumptions(asset).map(|(model, _)| model)
    }

    /// The vehicle, and a line each of what was assumed where the mesh says too little.
    ///
    /// # Errors
    /// As [`VehicleModel::from_asset`].
    pub fn with_assumptions(asset: &VehicleAsset) -> Result<(Self, Vec<String>)> {
        let fail = |reason: String| Error::Mesh { name: asset.file.clone(), reason };
        use ObjectClass::{Car, Misc, Tram, Truck, Van};
        if !matches!(asset.class, Car | Van | Truck | Tram | Misc) {
            let name = asset.class.kitti_name();
            let reason = format!("no vehicle is of class {name}: Car, Van, Truck, Tram or Misc");
            return Err(Error::Scene { reason });
        }
        let semantic = semantic_of(asset.class);
        let materials = &asset.source.materials;
        // Assumed glass and assumed seats.
        check_num_materials(&asset.file, materials.len() + 2)?;
        asset.rules.check(&asset.file, materials)?;
        let placing = Placing::new(asset.scale, asset.yaw_rad, asset.y_up)?;
        let is_left_out = asset.left_out().map_err(fail)?;
        let triangles = asset.source.placed(&asset.file, &placing, |triangle| !is_left_out(triangle))?;
        let roles = asset.rules.roles(materials);
        let mut palette: Vec<_> =
            materials.iter().zip(&roles).map(|(m, role)| material(Some(m), *role, semantic)).collect();

        let bounds = Bounds::of(triangles.iter().flat_map(|triangle| triangle.corners));
        let fit = Fit::new(&bounds, asset.size_lwh).map_err(|reason| match asset.size_lwh {
            None => fail(or_what_to_leave_out(reason, &asset.source, &triangles)),
            Some(_) => fail(reason),
        })?;
        let placed = triangles.iter().map(|t| (t.corners.map(|p| fit.point(p)), t.material as usize));
        // What a size that was asked for has pressed flat.
        let mut faces: Vec<Face> = placed.filter(|(corners, _)| has_area(corners)).collect();
        if faces.is_empty() {
            return Err(fail("no triangle with an area".to_owned()));
        }
        let tyre_corners: Vec<Vec3> = faces
            .iter()
            .filter(|(_, slot)| roles[*slot] == Some(Role::Tyre))
            .flat_map(|(corners, _)| *corners)
            .collect();
        let mut builder = MeshBuilder::new();
        let mut assumed = asset.shadow_kept(&triangles);
        let has = |role: Role| faces.iter().any(|(_, slot)| roles[*slot] == Some(role));
        // Trailers and motorbikes have no windows.
        if asset.class != Misc && !has(Role::Glass) && !asset.rules.names(Role::Glass) {
            let has_seats = has(Role::Interior);
            let is_body = |slot: usize| roles[slot].is_none();
            let windows = Windows::find(&faces, asset.class, fit.size.as_vec3());
            let glazed = windows.and_then(|p| p.glaze(&faces, is_body, palette.len()).map(|cut| (p, cut)));
            assumed.push(assumption(asset, &faces, glazed.is_some()));
            if let Some((windows, cut)) = glazed {
                faces = cut;
                let cloth = Material::matt(semantic, [0.05; 3], Pattern::Cloth, 0.25);
                palette.extend([material(None, Some(Role::Glass), semantic), cloth]);
                if !has_seats {
                    windows.add_seats(&mut builder, (palette.len() - 1) as u8);
                }
            }
        }
        for ([a, b, c], slot) in &faces {
            builder.triangle(*a, *b, *c, *slot as u8);
        }
        let wheels = Wheels::find(&tyre_corners, builder.positions(), fit.size.as_vec3());
        let model = Self {
            name: asset.name.clone(),
            class: asset.class,
            size_lwh: fit.size,
            annotated: AnnotatedBox::exact(fit.size),
            body: Arc::new(LodSet::single(builder.build(&asset.file, CREASE_RAD))),
            driver: None,
            wheel: None,
            wheel_centers: wheels.centers,
            wheel_radius_m: f64::from(wheels.radius_m),
            palette: Arc::new(Palette::new(palette)),
            has_lenses: false,
            openings: None,
            livery: Livery::Private,
        };
        Ok((model, assumed))
    }
}

impl VehicleAsset {
    /// Tells of a triangle whether its material or part is to be left out.
    ///
    /// # Errors
    /// A pattern that fits nothing.
    fn left_out(&self) -> std::result::Result<impl Fn(&SourceTriangle) -> bool, String> {
        let patterns = self.leave_out.as_deref().unwrap_or_default();
        let SourceMesh { materials, parts, .. } = &self.source;
        let fits = |name: &String| patterns.iter().any(|pattern| matches(pattern, name));
        let names = || materials.iter().map(|m| &m.name).chain(parts.iter().flatten());
        if let Some(lost) = patterns.iter().find(|pattern| !names().any(|name| matches(pattern, name))) {
            let known = listed(names());
            return Err(format!(
                "materials.leave_out: no material, node, object or group is named {lost:?}; known: {known}"
            ));
        }
        let of_material: Vec<bool> = materials.iter().map(|m| fits(&m.name)).collect();
        let of_part: Vec<bool> = parts.iter().map(|names| names.iter().any(fits)).collect();
        let is_set = |flags: &[bool], index: u32| flags.get(index as usize).copied().unwrap_or_default();
        Ok(move |t: &SourceTriangle| is_set(&of_material, t.material) || is_set(&of_part, t.part))
    }

    /// Says what is named like the shadow under a car, and belongs to its box since nobody has said otherwise.
    fn shadow_kept(&self, kept: &[SourceTriangle]) -> Vec<String> {
        let named = |t: &SourceTriangle| {
            let names = std::iter::once(&self.source.materials[t.material as usize].name);
            names.chain(&self.source.parts[t.part as usize]).find(|name| matches("*shadow*", name))
        };
        let shadow = if self.leave_out.is_none() { kept.iter().find_map(named) } else { None };
        let line = |name| {
            format!(
                "{}: {name:?} is taken as a part of the vehicle (materials.leave_out = [{name:?}] in assets.toml leaves it \
                 out, [] says that it is one)",
                self.file
            )
        };
        shadow.map(line).into_iter().collect()
    }
}

/// Says what a mesh does not, and what is assumed instead.
fn assumption(asset: &VehicleAsset, faces: &[Face], is_glazed: bool) -> String {
    let materials = asset.source.materials.iter().enumerate();
    let names = listed(materials.filter(|(i, _)| faces.iter().any(|(_, s)| s == i)).map(|(_, m)| &m.name));
    let lacks = if names.is_empty() {
        "no materials: gray paint is assumed".to_owned()
    } else {
        format!("no material for windows among {names}")
    };
    let windows = if is_glazed {
        "glass is assumed where windows usually are, with seats behind it"
    } else {
        "no glass is assumed, since nothing is where windows usually are"
    };
    format!(
        "{}: {lacks}; {windows} (materials.glass in assets.toml names windows, [] says that there are none)",
        asset.file
    )
}

/// Where a mesh's wheels stand, by the box frame: what the vehicle is sprung on.
struct Wheels {
    centers: [Vec3; 4],
    radius_m: f32,
}

impl Wheels {
    /// Finds the axles by what touches the ground, tires if the materials tell which these are.
    fn find(tyres: &[Vec3], all: &[Vec3], size: Vec3) -> Self {
        let feet = if tyres.is_empty() { all } else { tyres };
        let low = |ahead: bool| {
            let of_axle = feet.iter().copied().filter(move |p| p.z < TYRE_FOOT_M && (p.x > 0.0) == ahead);
            Some(Bounds::of(of_axle)).filter(|b| b.min.x <= b.max.x)
        };
        let top = tyres.iter().map(|p| p.z).fold(0.0, f32::max);
        let radius_m = if tyres.is_empty() { 0.07 * size.x } else { top / 2.0 }.clamp(0.15, 0.55).min(size.z / 3.0);
        // Where no ground contact shows: as far apart as most vehicles' are.
        let axle = |b: Option<Bounds>, usual: f32| b.map_or(usual, |b| b.center().x);
        let (mut front, mut rear) = (axle(low(true), 0.3 * size.x), axle(low(false), -0.3 * size.x));
        if front - rear < 0.3 * size.x {
            (front, rear) = (0.3 * size.x, -0.3 * size.x);
        }
        let outside = [low(true), low(false)].into_iter().flatten().map(|b| b.max.y.max(-b.min.y)).fold(0.0, f32::max);
        let side = (outside - 0.1).clamp(0.25 * size.y, 0.5 * size.y);
        let centers = [(front, side), (front, -side), (rear, side), (rear, -side)];
        Self { centers: centers.map(|(x, y)| Vec3::new(x, y, radius_m)), radius_m }
    }
}

/// A user's vehicles, to be mixed among those that are built in.
#[derive(Debug, Clone, Default)]
pub struct UserVehicles {
    share: f64,
    models: Vec<Arc<VehicleModel>>,
    assumptions: Vec<String>,
}

impl UserVehicles {
    /// Vehicles of which traffic and parked vehicles get a share in 0..=1.
    ///
    /// # Errors
    /// As [`VehicleModel::from_asset`], [`Error::OutOfRange`] for the share, [`Error::Mesh`] for a name used twice.
    pub fn new(share: f64, assets: &[VehicleAsset]) -> Result<Self> {
        if !(0.0..=1.0).contains(&share) {
            let expected = "0 to 1".to_owned();
            return Err(Error::OutOfRange { what: "share of user vehicles", value: share.to_string(), expected });
        }
        let mut models: Vec<Arc<VehicleModel>> = Vec::with_capacity(assets.len());
        let mut assumptions = Vec::new();
        for asset in assets {
            if models.iter().any(|m| m.name == asset.name) {
                let reason = format!("the name {:?} is taken", asset.name);
                return Err(Error::Mesh { name: asset.file.clone(), reason });
            }
            let (model, assumed) = VehicleModel::with_assumptions(asset)?;
            models.push(Arc::new(model));
            assumptions.extend(assumed);
        }
        Ok(Self { share, models, assumptions })
    }

    /// What was assumed of meshes that say too little: a line each, led by the file's name.
    #[must_use]
    pub fn assumptions(&self) -> &[String] {
        &self.assumptions
    }

    /// The models, in the order given.
    #[must_use]
    pub fn models(&self) -> &[Arc<VehicleModel>] {
        &self.models
    }

    /// The model of a name.
    ///
    /// # Errors
    /// [`Error::Unknown`], listing the names that exist.
    pub fn by_name(&self, name: &str) -> Result<&Arc<VehicleModel>> {
        self.models.iter().find(|m| m.name == name).ok_or_else(|| {
            let names: Vec<&str> = self.models.iter().map(|m| m.name.as_str()).collect();
            let known = if names.is_empty() { "none, the scene has no assets".to_owned() } else { names.join(", ") };
            Error::Unknown { what: "model", name: name.to_owned(), known }
        })
    }

    /// With the probability of the share one of the models that `fits`, its class by `mix` as far as there are meshes
    /// of it. Draws nothing where there are no models.
    pub fn draw(
        &self,
        stream: &mut Stream,
        mix: &[(ObjectClass, f64)],
        fits: impl Fn(&VehicleModel) -> bool,
    ) -> Option<Arc<VehicleModel>> {
        if self.models.is_empty() || self.share <= 0.0 || !stream.chance(self.share) {
            return None;
        }
        let fitting: Vec<&Arc<VehicleModel>> = self.models.iter().filter(|m| fits(m)).collect();
        let count = |class: ObjectClass| fitting.iter().filter(|m| m.class == class).count();
        let weight = |m: &VehicleModel| {
            mix.iter().find(|(class, _)| *class == m.class).map_or(0.0, |(_, w)| w / count(m.class) as f64)
        };
        let weights: Vec<f64> = fitting.iter().map(|m| weight(m)).collect();
        if !weights.iter().any(|w| *w > 0.0) {
            return None;
        }
        let model = fitting.get(stream.weighted(&weights))?;
        Some(Arc::new(VehicleModel::clone(model).annotated_by(stream.next_u64())))
    }
}
