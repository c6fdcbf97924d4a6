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
mod levels;
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
use cadet_base::geometry::LodSet;
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
use levels::{Blueprint, DISTANT, Fitted, wheels_of};
use outline::Outline;
use paint::slot;
use surface::Surface;
use wheels::Rim;

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
        let size_lwh = d.size_lwh();
        let car = CarBlueprint { outline, styling, fittings, has_sunroof, has_passenger };
        let fitted = Fitted::new(d.name, car, size_lwh.as_vec3());
        let body = fitted.body();
        let outline = &fitted.blueprint.outline;
        let hub_y = |x: f32| outline.half_width(x, 0.2) - 0.022 - d.tyre_width_m / 2.0;
        let [front, rear] = d.axles_x;
        let in_box = |p: Vec3| fitted.fit(0).point(p);
        let wheel_centers = [(front, 1.0), (front, -1.0), (rear, 1.0), (rear, -1.0)]
            .map(|(x, side)| in_box(Vec3::new(x, side * hub_y(x), d.wheel_radius_m)).with_z(d.wheel_radius_m));
        let openings = Openings::of(outline, &house_of(outline), size_lwh.as_vec3(), in_box);
        Self {
            name: format!("{}/{model_seed}", d.name),
            class,
            size_lwh,
            annotated: AnnotatedBox::exact(size_lwh),
            body,
            driver: Some(fitted.occupants()),
            wheel: Some(wheels_of(d.name, d.wheel_radius_m, d.tyre_width_m, rim)),
            wheel_centers,
            wheel_radius_m: f64::from(d.wheel_radius_m),
            palette: Arc::new(palette),
            has_lenses: true,
            openings: Some(Arc::new(openings)),
            livery: Livery::Private,
        }
    }
}

/// What a car or a van is drawn from.
struct CarBlueprint {
    outline: Outline,
    styling: Styling,
    fittings: Fittings,
    has_sunroof: bool,
    has_passenger: bool,
}

fn house_of(outline: &Outline) -> Glasshouse<'_> {
    Glasshouse::new(outline, slot::REAR_SIDE_GLASS)
}

impl Blueprint for CarBlueprint {
    /// Body, glasshouse and flat fittings.
    fn shell(&self, level: usize) -> Surface {
        let Self { outline, styling, fittings, .. } = self;
        let house = house_of(outline);
        if level == DISTANT {
            return distant::body(outline, &house, styling, fittings);
        }
        let mut surface = Surface::default();
        body::add_lower_body(&mut surface, outline, styling, level);
        house.add(&mut surface, level, self.has_sunroof);
        details::add_fittings(&mut surface, outline, &house, fittings, level);
        let ends = signals::ends_of(outline, level);
        signals::add_signals(&mut surface, outline, styling, &ends, Outline::fractions(level));
        if level < 2 {
            signals::add_repeaters(&mut surface, outline);
        }
        surface
    }

    fn add_more(&self, surface: &mut Surface, level: usize) {
        if level != DISTANT {
            let (outline, house) = (&self.outline, house_of(&self.outline));
            details::add_mirrors_and_aerial(surface, outline, &house, &self.fittings, level);
            interior::add_interior(surface, outline, &house, &Seats::new(outline, &house), level);
        }
    }

    fn occupants(&self, level: usize) -> Surface {
        let seats = Seats::new(&self.outline, &house_of(&self.outline));
        interior::occupants(&self.outline, &seats, self.has_passenger, level)
    }
}
