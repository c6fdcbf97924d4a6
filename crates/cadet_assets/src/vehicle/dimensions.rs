//! Sizes and proportions of one vehicle, drawn from its kind.

use super::archetypes::{Archetype, CARS, VANS, Windows};
use crate::annotation::{Margins, no_such_vehicle};
use cadet_base::actor::ObjectClass;
use cadet_base::error::Result;
use cadet_base::math::{self, DVec3};
use cadet_base::rng::Stream;

/// One vehicle's measures, meters in the box frame.
#[derive(Debug, Clone)]
pub(super) struct Dimensions {
    pub name: &'static str,
    pub length_m: f32,
    pub width_m: f32,
    pub height_m: f32,
    /// x of the front and the rear axle.
    pub axles_x: [f32; 2],
    pub wheel_radius_m: f32,
    pub tyre_width_m: f32,
    /// Radius of the cut in the flank.
    pub arch_radius_m: f32,
    /// Lower edge of the flanks and floor.
    pub clearance_m: f32,
    /// Side window sill at the windscreen's foot.
    pub belt_z: f32,
    /// Rise of the belt line from the windscreen's foot to the tail.
    pub belt_rise_m: f32,
    /// Height of the bonnet's front edge at the corners.
    pub bonnet_edge_z: f32,
    /// Height of the windscreen's foot in the middle.
    pub cowl_z: f32,
    /// x of the windscreen's foot in the middle.
    pub cowl_x: f32,
    /// Length of the boot lid behind the backlight.
    pub boot_m: f32,
    /// Tangents of the slopes from the horizontal.
    pub screen_slope: f32,
    pub backlight_slope: f32,
    /// Tangent of the side windows' lean from the vertical.
    pub tumblehome_tangent: f32,
    /// Drop of the roof from its apex to the front and to the rear header.
    pub roof_sag_m: [f32; 2],
    /// Exponents of the nose's and the tail's plan: larger is squarer.
    pub corner_exponent: [f32; 2],
    /// Depth of the ledge over the rear bumper.
    pub tail_ledge_m: f32,
    pub windows: Windows,
    pub is_van: bool,
}

/// The bumper stands out from the tailgate by so much: of 56 cars seen from behind, returns above it lie 2 cm deeper.
const TAIL_LEDGE_M: (f64, f64) = (0.0, 0.02);
/// Nose and tail end at least so far beyond the wheel arches.
const LEAST_BEYOND_ARCH_M: f64 = 0.14;

impl Dimensions {
    /// Draws a vehicle of a class.
    ///
    /// # Errors
    /// [`cadet_base::Error::Scene`] for a class other than Car and Van.
    pub fn draw(class: ObjectClass, s: &mut Stream) -> Result<Self> {
        let kinds: &[Archetype] = match class {
            ObjectClass::Car => &CARS,
            ObjectClass::Van => &VANS,
            other => return Err(no_such_vehicle(other)),
        };
        let shares: Vec<f64> = kinds.iter().map(|k| k.share).collect();
        let kind = &kinds[s.weighted(&shares)];
        Ok(Self::of_kind(kind, class != ObjectClass::Car, s))
    }

    /// The dimensions of the vehicle that [`super::VehicleModel::generate`] makes.
    ///
    /// # Errors
    /// As [`Dimensions::draw`].
    pub fn of_seed(class: ObjectClass, model_seed: u64) -> Result<Self> {
        Self::draw(class, &mut Stream::from_seed("vehicle", model_seed))
    }

    /// Length, width, height.
    pub fn size_lwh(&self) -> DVec3 {
        DVec3::new(f64::from(self.length_m), f64::from(self.width_m), f64::from(self.height_m))
    }

    fn of_kind(kind: &Archetype, is_van: bool, s: &mut Stream) -> Self {
        // A longer car of a kind is a wider one: correlation 0.25.
        let z_length = s.clipped_normal(0.0, 1.0);
        let z_width = 0.25 * z_length + (1.0_f64 - 0.0625).sqrt() * s.clipped_normal(0.0, 1.0);
        let z_height =
            if is_van { 0.8 * z_length + 0.6 * s.clipped_normal(0.0, 1.0) } else { s.clipped_normal(0.0, 1.0) };
        let [over_l, over_w, over_h] = Margins::mean_of_vehicles();
        let Archetype { size_m: [length_m, width_m, height_m], wheels, glass, ends, .. } = kind;
        let l = length_m.0 + length_m.1 * z_length + over_l;
        let w = width_m.0 + width_m.1 * z_width + over_w;
        let h = height_m.0 + height_m.1 * z_height + over_h;
        let tall = h / height_m.0;
        let front_overhang = (wheels.front_overhang_l_ratio + s.range(-0.008, 0.008)) * l;
        let wheel_radius_m = (wheels.diameter_m / 2.0 * s.range(0.97, 1.03)).min(0.225 * h);
        let arch_radius_m = 1.10 * wheel_radius_m;
        let least_overhang = arch_radius_m + LEAST_BEYOND_ARCH_M;
        let front_axle = l / 2.0 - front_overhang.max(least_overhang);
        let rear_axle = (front_axle - wheels.wheelbase_l_ratio * l).max(least_overhang - l / 2.0);
        let slope = |deg: f64| math::tan(deg.to_radians()) as f32;
        let estate = kind.is_estate && (kind.name != "high_roof" || s.chance(0.8));
        let windows = if is_van && s.chance(if matches!(kind.name, "medium_van" | "high_van") { 0.75 } else { 0.4 }) {
            Windows::PanelVan
        } else if s.chance(kind.three_door_share) {
            Windows::ThreeDoor
        } else if estate {
            Windows::Estate
        } else {
            Windows::FiveDoor
        };
        Self {
            name: kind.name,
            length_m: l as f32,
            width_m: w as f32,
            height_m: h as f32,
            axles_x: [front_axle as f32, rear_axle as f32],
            wheel_radius_m: wheel_radius_m as f32,
            tyre_width_m: s.range(0.165, if w > 1.6 { 0.215 } else { 0.185 }) as f32,
            arch_radius_m: arch_radius_m as f32,
            clearance_m: (kind.clearance_m * s.range(0.93, 1.07)) as f32,
            belt_z: (glass.belt_h_ratio * h + s.range(-0.015, 0.015)) as f32,
            belt_rise_m: s.range(0.015, if kind.is_estate { 0.04 } else { 0.07 }) as f32,
            bonnet_edge_z: (ends.bonnet_edge_z * tall + s.range(-0.02, 0.02)) as f32,
            cowl_z: (ends.cowl_z * tall) as f32,
            cowl_x: (l / 2.0 - (ends.cowl_l_ratio + s.range(-0.012, 0.012)) * l) as f32,
            boot_m: (ends.boot_l_ratio * l) as f32,
            screen_slope: slope(glass.screen_deg + s.range(-1.5, 1.5)),
            backlight_slope: slope(glass.backlight_deg + s.range(-3.0, 3.0)),
            tumblehome_tangent: slope(glass.tumblehome_deg + s.range(-1.5, 1.5)),
            roof_sag_m: [s.range(0.03, 0.05) as f32, s.range(0.06, 0.10) as f32],
            corner_exponent: if is_van { [(2.2, 3.0), (5.0, 7.0)] } else { [(1.9, 2.65), (3.4, 4.6)] }
                .map(|(from, to)| s.range(from, to) as f32),
            tail_ledge_m: s.range(TAIL_LEDGE_M.0, TAIL_LEDGE_M.1) as f32,
            windows,
            is_van,
        }
    }
}
