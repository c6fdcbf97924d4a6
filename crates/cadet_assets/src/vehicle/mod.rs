//! Vehicles: a lofted body with cut wheel arches and true glass over a furnished interior.

mod archetypes;
mod body;
mod details;
mod dimensions;
mod distant;
#[cfg(test)]
mod end_tests;
mod glasshouse;
mod interior;
mod lamps;
mod library;
#[cfg(test)]
mod opening_tests;
mod openings;
mod outline;
mod paint;
#[cfg(test)]
mod signal_tests;
mod signals;
mod surface;
#[cfg(test)]
mod tests;
pub mod tram;
mod wheels;
mod work;
mod work_paint;

use std::sync::Arc;

use crate::annotation::{self, Margins};
use cadet_base::actor::{AnnotatedBox, ObjectClass};
use cadet_base::error::Result;
use cadet_base::geometry::{Bounds, LazyMesh, LodSet};
use cadet_base::material::Palette;
use cadet_base::math::{DVec3, Vec3};
use cadet_base::rng::Stream;

pub use lamps::{HALOGEN, LitLamps, low_beams};
pub use openings::{Opening, Openings};
pub use paint::Livery;
pub(crate) use paint::{coated, glass};

use body::Styling;
use details::Fittings;
use dimensions::Dimensions;
use glasshouse::Glasshouse;
use interior::Seats;
use outline::Outline;
use paint::slot;
use surface::Surface;
use wheels::Rim;

/// Where the levels of detail end, meters from the ego: a car is a hundred pixels of KITTI's camera high at the first limit,
/// and looking through its windows shows nothing beyond the third.
const LEVEL_LIMITS_M: [f32; LEVELS] = [11.0, 32.0, 80.0, f32::INFINITY];
const LEVELS: usize = 4;
const DISTANT: usize = LEVELS - 1;
/// Nobody sees wheels beyond this distance (a wheel is 3 pixels tall there), meters.
const WHEELS_TO_M: f32 = 150.0;
/// Nobody sees who sits inside beyond this distance, meters.
const OCCUPANTS_TO_M: f32 = 70.0;
/// Faces that meet at more than this angle show an edge.
const CREASE_RAD: f32 = 0.55;
/// As [`CREASE_RAD`], of people, who are round.
const OCCUPANT_CREASE_RAD: f32 = 1.2;

/// A vehicle's shape, in its box frame: x forward, y left, z up, origin at the box's bottom center.
#[derive(Debug, Clone)]
pub struct VehicleModel {
    /// For example `"compact/12345"`.
    pub name: String,
    /// KITTI's class.
    pub class: ObjectClass,
    /// Length, width, height of the body's box; the body fills it, mirrors and aerials stick out.
    pub size_lwh: DVec3,
    /// What an annotator would draw instead.
    pub annotated: AnnotatedBox,
    /// Everything but the wheels.
    pub body: Arc<LodSet>,
    /// The driver, and a passenger in three of ten, in the box frame: shown in moving vehicles.
    pub driver: Option<Arc<LodSet>>,
    /// A wheel about its own center, axle along y, outer face toward +y (the left side); `None` where the wheels are
    /// part of the body.
    pub wheel: Option<Arc<LodSet>>,
    /// Wheel centers in the box frame: front left, front right, rear left, rear right.
    pub wheel_centers: [Vec3; 4],
    /// Tire radius: also the height of the wheel centers.
    pub wheel_radius_m: f64,
    /// The materials of body, driver and wheels.
    pub palette: Arc<Palette>,
    /// Whether head and tail lamps have materials of their own.
    pub has_lenses: bool,
    /// What of it can stand open.
    pub openings: Option<Arc<Openings>>,
    /// What its colors are drawn from.
    pub livery: Livery,
}

impl VehicleModel {
    /// The vehicle of a class and a seed.
    ///
    /// # Errors
    /// [`cadet_base::error::Error::Scene`] for a class other than Car, Van, Truck, Tram and Misc.
    pub fn generate(class: ObjectClass, model_seed: u64) -> Result<Self> {
        let mut s = Stream::from_seed("vehicle", model_seed);
        let made = match class {
            ObjectClass::Truck => work::truck(model_seed, &mut s)?,
            ObjectClass::Misc => work::towed(model_seed, &mut s)?,
            ObjectClass::Tram => tram::single_car(model_seed, &mut s),
            _ => {
                let d = Dimensions::draw(class, &mut s)?;
                Self::of_dimensions(class, model_seed, d, &mut s)
            }
        };
        Ok(made.annotated_by(model_seed))
    }

    /// A vehicle of traffic: its annotated size is drawn from KITTI's, its true extents follow, and its body is that of a
    /// design of about these extents, stretched to them.
    ///
    /// # Errors
    /// As [`VehicleModel::generate`].
    pub fn of_traffic(class: ObjectClass, actor_seed: u64) -> Result<Self> {
        let mut s = Stream::from_seed("traffic vehicle", actor_seed);
        let annotated_lwh = annotation::vehicle_size(class, &mut s)?;
        let margins = Margins::of_vehicle(class, &mut s);
        let true_lwh = margins.around(annotated_lwh);
        let design = library::design_near(class, true_lwh, &mut s)?;
        let annotated = margins.within(true_lwh);
        Ok(Self { annotated, ..design.stretched(true_lwh).painted(s.next_u64()) })
    }

    /// Returns this vehicle as another annotator would label it.
    #[must_use]
    pub fn annotated_by(self, annotator_seed: u64) -> Self {
        let margins = Margins::of_vehicle(self.class, &mut Stream::from_seed("annotated box", annotator_seed));
        Self { annotated: margins.within(self.size_lwh), ..self }
    }

    /// Distance between the axles.
    #[must_use]
    pub fn wheelbase_m(&self) -> f64 {
        f64::from(self.wheel_centers[0].x - self.wheel_centers[2].x)
    }

    /// Returns this vehicle with other extents. Its wheels stay round and on the ground: they grow with the height.
    fn stretched(&self, size_lwh: DVec3) -> Self {
        let scale = (size_lwh / self.size_lwh).as_vec3();
        let all = |shape: &Arc<LodSet>, scale: Vec3| Arc::new(shape.stretched(scale));
        Self {
            size_lwh,
            annotated: AnnotatedBox::exact(size_lwh),
            body: all(&self.body, scale),
            driver: self.driver.as_ref().map(|driver| all(driver, scale)),
            wheel: self.wheel.as_ref().map(|wheel| all(wheel, Vec3::splat(scale.z))),
            wheel_centers: self.wheel_centers.map(|c| c * scale),
            wheel_radius_m: self.wheel_radius_m * f64::from(scale.z),
            ..self.clone()
        }
    }

    /// Returns this vehicle in other colors, which `paint_seed` chooses.
    #[must_use]
    pub fn painted(&self, paint_seed: u64) -> Self {
        let palette = work_paint::palette(self.class, self.livery, &mut Stream::from_seed("vehicle paint", paint_seed));
        Self { palette: Arc::new(palette), ..self.clone() }
    }

    fn of_dimensions(class: ObjectClass, model_seed: u64, d: Dimensions, s: &mut Stream) -> Self {
        let palette = work_paint::palette(class, Livery::Private, s);
        let is_old = s.chance(0.2);
        let styling = Styling {
            black_bumpers: if d.is_van { s.chance(0.5) } else { is_old },
            side_strip: is_old || s.chance(0.25),
            lamp_from_fraction: s.range(0.50, 0.72) as f32,
            grille_to_fraction: s.range(0.25, 0.45) as f32,
            tail_lamp_from_fraction: if d.boot_m > 0.1 { 0.60 } else { s.range(0.45, 0.62) as f32 },
            tail_lamp_side_fraction: if d.boot_m > 0.1 { s.range(0.55, 0.70) } else { s.range(0.74, 0.84) } as f32,
        };
        let is_tall = matches!(d.name, "estate" | "mpv" | "suv");
        let fittings = Fittings {
            painted_mirrors: !styling.black_bumpers && s.chance(0.7),
            side_strip: styling.side_strip,
            roof_rails: is_tall && s.chance(0.4),
            aerial: s.chance(0.6),
            two_line_plate: s.chance(0.05),
            rear_plate_z: s.range(0.45, 0.78 * f64::from(d.belt_z)) as f32,
        };
        let rim = if s.chance(0.35) {
            Rim { spokes: 12, spoke_share: 0.62 }
        } else {
            Rim { spokes: 5 + s.below(6), spoke_share: s.range(0.30, 0.55) as f32 }
        };
        let has_sunroof = !d.is_van && s.chance(0.15);
        let has_passenger = s.chance(0.3);

        let outline = Outline::new(d.clone());
        let house = Glasshouse::new(&outline, slot::REAR_SIDE_GLASS);
        let seats = Seats::new(&outline, &house);
        let size_lwh = d.size_lwh();
        let shell = |level: usize| match level {
            DISTANT => distant::body(&outline, &house, &styling, &fittings),
            _ => Self::shell(&outline, &house, &styling, &fittings, has_sunroof, level),
        };
        let (body, fits) = fitted_levels(d.name, size_lwh.as_vec3(), shell, |surface, level| {
            if level != DISTANT {
                details::add_mirrors_and_aerial(surface, &outline, &house, &fittings, level);
                interior::add_interior(surface, &outline, &house, &seats, level);
            }
        });
        let driver = occupants_of(d.name, &fits, |k| interior::occupants(&outline, &seats, has_passenger, k));
        let wheel = wheels_of(d.name, d.wheel_radius_m, d.tyre_width_m, rim);
        let hub_y = |x: f32| outline.half_width(x, 0.2) - 0.022 - d.tyre_width_m / 2.0;
        let [front, rear] = d.axles_x;
        let wheel_centers = [(front, 1.0), (front, -1.0), (rear, 1.0), (rear, -1.0)]
            .map(|(x, side)| fits[0].point(Vec3::new(x, side * hub_y(x), d.wheel_radius_m)).with_z(d.wheel_radius_m));
        Self {
            name: format!("{}/{model_seed}", d.name),
            class,
            size_lwh,
            annotated: AnnotatedBox::exact(size_lwh),
            body,
            driver: Some(driver),
            wheel: Some(wheel),
            wheel_centers,
            wheel_radius_m: f64::from(d.wheel_radius_m),
            palette: Arc::new(palette),
            has_lenses: true,
            openings: Some(Arc::new(Openings::of(&outline, &house, size_lwh.as_vec3(), |p| fits[0].point(p)))),
            livery: Livery::Private,
        }
    }

    /// What fills the box: body, glasshouse and flat fittings.
    fn shell(
        o: &Outline,
        house: &Glasshouse,
        styling: &Styling,
        fittings: &Fittings,
        has_sunroof: bool,
        level: usize,
    ) -> Surface {
        let mut surface = Surface::default();
        body::add_lower_body(&mut surface, o, styling, level);
        house.add(&mut surface, level, has_sunroof);
        details::add_fittings(&mut surface, o, house, fittings, level);
        signals::add_signals(&mut surface, o, styling, &signals::ends_of(o, level), Outline::fractions(level));
        if level < 2 {
            signals::add_repeaters(&mut surface, o);
        }
        surface
    }
}

/// The levels of detail of a shape, as many as begin before `to_m`.
fn levels_of(name: &'static str, crease_rad: f32, to_m: f32, make: impl FnMut(usize) -> Surface) -> Arc<LodSet> {
    let count = 1 + LEVEL_LIMITS_M.iter().take_while(|limit| **limit < to_m).count();
    let builders: Vec<_> = (0..count).map(make).map(|surface| surface.builder.shrunk()).collect();
    let bounds = builders[0].bounds();
    let levels = builders.into_iter().zip(0..).map(|(builder, k)| {
        let limit = LEVEL_LIMITS_M[k].min(to_m);
        // Of few large faces, panes and panels would run into each other.
        let crease_rad = if k == DISTANT { 0.5 * crease_rad } else { crease_rad };
        (limit, LazyMesh::new(move || builder.build(name, crease_rad)))
    });
    Arc::new(LodSet { bounds, levels: levels.collect(), coarse_shadow_proxies: 2 })
}

/// The levels of detail of a body whose shell fills its box, and the fit of each; `add_more` adds what is not of the
/// shell.
fn fitted_levels(
    name: &'static str,
    size_lwh: Vec3,
    shell: impl Fn(usize) -> Surface,
    add_more: impl Fn(&mut Surface, usize),
) -> (Arc<LodSet>, Vec<Fit>) {
    let mut fits = Vec::with_capacity(LEVELS);
    let body = levels_of(name, CREASE_RAD, f32::INFINITY, |level| {
        let mut surface = shell(level);
        let fit = Fit::of(&surface, size_lwh);
        fits.push(fit);
        add_more(&mut surface, level);
        fit.apply(&mut surface);
        surface
    });
    (body, fits)
}

/// Meshes of the people inside of a body, fitted as it was.
fn occupants_of(name: &'static str, fits: &[Fit], occupants: impl Fn(usize) -> Surface) -> Arc<LodSet> {
    levels_of(name, OCCUPANT_CREASE_RAD, OCCUPANTS_TO_M, |level| {
        let mut surface = occupants(level);
        fits[level].apply(&mut surface);
        surface
    })
}

/// A wheel that turns.
fn wheels_of(name: &'static str, radius_m: f32, tyre_width_m: f32, rim: Rim) -> Arc<LodSet> {
    levels_of(name, CREASE_RAD, WHEELS_TO_M, |level| wheels::wheel(radius_m, tyre_width_m, rim, level))
}

/// Maps a built shell onto its box; the numbers are within a percent of the identity.
#[derive(Debug, Clone, Copy)]
struct Fit {
    scale: Vec3,
    shift_x: f32,
}

impl Fit {
    fn of(shell: &Surface, size_lwh: Vec3) -> Self {
        let bounds = Bounds::of(shell.builder.positions().iter().copied());
        let size = bounds.size();
        let scale = Vec3::new(size_lwh.x / size.x, size_lwh.y / size.y, size_lwh.z / bounds.max.z);
        Self { scale, shift_x: -bounds.center().x * scale.x }
    }

    fn point(self, p: Vec3) -> Vec3 {
        p * self.scale + Vec3::X * self.shift_x
    }

    fn apply(self, surface: &mut Surface) {
        for p in surface.builder.positions_mut() {
            *p = self.point(*p);
        }
    }
}
