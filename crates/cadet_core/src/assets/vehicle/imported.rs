//! Vehicles made of somebody else's meshes.

use std::sync::Arc;

use super::VehicleModel;
use super::assumed_windows::{Face, Windows};
use super::imported_materials::{MaterialRules, Role, material};
use super::paint::Livery;
use crate::actor::{AnnotatedBox, ObjectClass};
use crate::assets::import::{ImportOptions, MeshSource, SourceMaterial, check_num_materials, triangles};
use crate::error::{Error, Result};
use crate::geometry::{Bounds, LodSet, MeshBuilder};
use crate::material::{Material, Palette, Pattern, Semantic};
use crate::math::{DVec3, Vec3};
use crate::rng::Stream;

/// Faces that meet at more than this angle show an edge.
const CREASE_RAD: f32 = 0.6;
/// What can pass for a vehicle: length, width, height in meters.
const LIMITS_M: [(&str, f64, f64); 3] = [("long", 1.0, 30.0), ("wide", 0.3, 5.0), ("high", 0.3, 6.0)];
/// What is lower than this belongs to a tire rather than to the body, meters.
const TYRE_FOOT_M: f32 = 0.15;

/// A user's mesh and what is to be known about it.
#[derive(Debug, Clone)]
pub struct VehicleAsset {
    /// The model's name in labels' metadata.
    pub name: String,
    /// `Car`, `Van` or `Truck`.
    pub class: ObjectClass,
    /// The mesh's file, for messages.
    pub file: String,
    /// What the file holds.
    pub source: MeshSource,
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
}

impl VehicleModel {
    /// The vehicle of a user's mesh: one level of detail, the wheels part of the body, the mesh's bounds its box;
    /// what annotators leave out is drawn for each actor ([`VehicleModel::annotated_by`]).
    ///
    /// # Errors
    /// [`Error::Mesh`], naming the file: not of its format, no face with an area, a coordinate that is not finite, a missing
    /// material library, a rule that fits no material, or a size that no vehicle has. [`Error::Scene`] for a class that
    /// no vehicle has.
    pub fn from_asset(asset: &VehicleAsset) -> Result<Self> {
        Self::with_assumptions(asset).map(|(model, _)| model)
    }

    /// The vehicle, and in one line what was assumed where the mesh says too little of its materials.
    ///
    /// # Errors
    /// As [`VehicleModel::from_asset`].
    pub fn with_assumptions(asset: &VehicleAsset) -> Result<(Self, Option<String>)> {
        let fail = |reason: String| Error::Mesh { name: asset.file.clone(), reason };
        let semantic = match asset.class {
            ObjectClass::Car => Semantic::Car,
            ObjectClass::Van => Semantic::Van,
            ObjectClass::Truck => Semantic::Truck,
            other => {
                let reason = format!("no vehicle is of class {}: Car, Van or Truck", other.kitti_name());
                return Err(Error::Scene { reason });
            }
        };
        let options =
            ImportOptions { scale: asset.scale, y_up: asset.y_up, yaw_rad: asset.yaw_rad, on_ground: false, semantic };
        let read = triangles(&asset.file, &asset.source, &options)?;
        // One for faces that name none, assumed glass and assumed seats.
        check_num_materials(&asset.file, read.materials.len() + 3)?;
        asset.rules.check(&asset.file, &read.materials)?;
        let roles: Vec<Option<Role>> =
            read.materials.iter().map(|m| asset.rules.role(&m.name, m.opacity)).chain([None]).collect();
        let sources = read.materials.iter().map(Some).chain([None]);
        let mut palette: Vec<_> = sources.zip(&roles).map(|(m, role)| material(m, *role, semantic)).collect();

        let bounds = Bounds::of(read.triangles.iter().flat_map(|(corners, _)| *corners));
        let fit = Fit::new(&bounds, asset.size_lwh).map_err(fail)?;
        let placed = read.triangles.iter().map(|(corners, slot)| (corners.map(|p| fit.point(p)), *slot));
        // What a size that was asked for has pressed flat.
        let has_area = |([a, b, c], _): &Face| (*b - *a).cross(*c - *a).length_squared() > 1e-15;
        let mut faces: Vec<Face> = placed.filter(has_area).collect();
        if faces.is_empty() {
            return Err(fail("no triangle with an area".to_owned()));
        }
        let tyre_corners: Vec<Vec3> = faces
            .iter()
            .filter(|(_, slot)| roles[*slot] == Some(Role::Tyre))
            .flat_map(|(corners, _)| *corners)
            .collect();
        let mut builder = MeshBuilder::new();
        let mut assumed = None;
        let has = |role: Role| faces.iter().any(|(_, slot)| roles[*slot] == Some(role));
        if !has(Role::Glass) && !asset.rules.names(Role::Glass) {
            let has_seats = has(Role::Interior);
            let is_body = |slot: usize| roles[slot].is_none();
            let windows = Windows::find(&faces, asset.class, fit.size.as_vec3());
            let glazed = windows.and_then(|p| p.glaze(&faces, is_body, palette.len()).map(|cut| (p, cut)));
            assumed = Some(assumption(asset, &read.materials, &faces, glazed.is_some()));
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

/// Says what a mesh does not, and what is assumed instead.
fn assumption(asset: &VehicleAsset, materials: &[SourceMaterial], faces: &[Face], is_glazed: bool) -> String {
    let names: Vec<&str> = materials
        .iter()
        .enumerate()
        .filter(|(i, _)| faces.iter().any(|(_, s)| s == i))
        .map(|(_, m)| m.name.as_str())
        .collect();
    let lacks = if names.is_empty() {
        "no materials: gray paint is assumed".to_owned()
    } else {
        format!("no material for windows among {}", names.join(", "))
    };
    let windows = if is_glazed {
        "glass is assumed where windows usually are, with seats behind it"
    } else {
        "no glass is assumed, since nothing stands where windows usually are"
    };
    format!(
        "{}: {lacks}; {windows} (materials.glass in assets.toml names windows, [] says that there are none)",
        asset.file
    )
}

/// Moves a mesh into its box frame.
struct Fit {
    foot: Vec3,
    scale: Vec3,
    size: DVec3,
}

impl Fit {
    /// Checks the size; the reason where it is none of a vehicle.
    fn new(bounds: &Bounds, wanted: Option<DVec3>) -> std::result::Result<Self, String> {
        let found = bounds.size();
        let is_flat = found.min_element() < 1e-4 * found.max_element();
        if !found.is_finite() || is_flat {
            return Err(format!("no body: its bounds are {:.3} x {:.3} x {:.3}", found.x, found.y, found.z));
        }
        let size = wanted.unwrap_or(found.as_dvec3());
        for ((side, lo, hi), value) in LIMITS_M.iter().zip(size.to_array()) {
            if !(*lo..=*hi).contains(&value) {
                let which = if wanted.is_some() { "size_lwh" } else { "scale" };
                return Err(format!("{value:.3} m {side}, expected {lo} to {hi} m: check {which}"));
            }
        }
        if found.y > found.x {
            let (x, y) = (found.x, found.y);
            return Err(format!("wider ({y:.2} m) than long ({x:.2} m): turn its front to +x with yaw_deg"));
        }
        let foot = Vec3::new(bounds.center().x, bounds.center().y, bounds.min.z);
        Ok(Self { foot, scale: wanted.map_or(Vec3::ONE, |w| w.as_vec3() / found), size })
    }

    fn point(&self, p: Vec3) -> Vec3 {
        (p - self.foot) * self.scale
    }
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
