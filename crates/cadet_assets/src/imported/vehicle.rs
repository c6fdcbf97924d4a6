//! Vehicles made of somebody else's meshes.

use std::sync::Arc;

use super::asset::{MeshAsset, Placed};
use super::materials::{Role, listed, material};
use super::windows::{Face, Windows};
use crate::vehicle::{Livery, VehicleModel};
use cadet_base::actor::{AnnotatedBox, ObjectClass};
use cadet_base::error::{Error, Result};
use cadet_base::geometry::{Bounds, LodSet, MeshBuilder};
use cadet_base::material::{Material, Palette, Pattern};
use cadet_base::math::Vec3;

/// Faces that meet at more than this angle show an edge.
pub(super) const CREASE_RAD: f32 = 0.6;
/// Points lower than this belong to a tire rather than to the body, meters.
const TYRE_FOOT_M: f32 = 0.15;

impl VehicleModel {
    /// The vehicle of a user's mesh: one level of detail, the wheels part of the body, the mesh's bounds its box;
    /// what annotators leave out is drawn for each actor ([`VehicleModel::annotated_by`]).
    ///
    /// # Errors
    /// [`Error::Mesh`], naming the file: no face with an area, a coordinate that is not finite, a rule that fits nothing,
    /// or a size that no vehicle has. [`Error::Scene`] for a class that no vehicle has.
    pub fn from_asset(asset: &MeshAsset) -> Result<Self> {
        Self::with_assumptions(asset).map(|(model, _)| model)
    }

    /// The vehicle, and a line each of what was assumed where the mesh says too little.
    ///
    /// # Errors
    /// As [`VehicleModel::from_asset`].
    pub fn with_assumptions(asset: &MeshAsset) -> Result<(Self, Vec<String>)> {
        if asset.class.is_human() {
            let name = asset.class.kitti_name();
            let reason = format!("no vehicle is of class {name}: Car, Van, Truck, Tram or Misc");
            return Err(Error::Scene { reason });
        }
        // Assumed glass and assumed seats.
        let Placed { mut faces, size, mut assumed } = asset.placed(2)?;
        let (semantic, materials) = (asset.class.semantic(), &asset.source.materials);
        let roles = asset.rules.roles(materials);
        let mut palette: Vec<_> =
            materials.iter().zip(&roles).map(|(m, role)| material(Some(m), *role, semantic)).collect();
        let tyre_corners: Vec<Vec3> = faces
            .iter()
            .filter(|(_, slot)| roles[*slot] == Some(Role::Tyre))
            .flat_map(|(corners, _)| *corners)
            .collect();
        let mut builder = MeshBuilder::new();
        let has = |role: Role| faces.iter().any(|(_, slot)| roles[*slot] == Some(role));
        // Trailers and motorbikes have no windows.
        if asset.class != ObjectClass::Misc && !has(Role::Glass) && !asset.rules.names(Role::Glass) {
            let has_seats = has(Role::Interior);
            let is_body = |slot: usize| roles[slot].is_none();
            let windows = Windows::find(&faces, asset.class, size.as_vec3());
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
        let wheels = Wheels::find(&tyre_corners, builder.positions(), size.as_vec3());
        let model = Self {
            name: asset.name.clone(),
            class: asset.class,
            size_lwh: size,
            annotated: AnnotatedBox::exact(size),
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
fn assumption(asset: &MeshAsset, faces: &[Face], is_glazed: bool) -> String {
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
