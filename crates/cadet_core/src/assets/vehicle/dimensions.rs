//! Sizes and proportions: the kinds of vehicle that a street shows, and one draw from a kind.

use crate::actor::ObjectClass;
use crate::assets::annotation::{Margins, no_such_vehicle};
use crate::error::Result;
use crate::math::{self, DVec3};
use crate::rng::Stream;

/// How the side windows are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Windows {
    /// One door and a fixed pane behind it, if any.
    ThreeDoor,
    /// Front and rear door.
    FiveDoor,
    /// Front and rear door and a pane beside the luggage.
    Estate,
    /// Glass in the front doors only.
    PanelVan,
}

/// The mean shape of a kind of vehicle. Length, width and height in meters as KITTI's annotators label it, to which the
/// mean margins of labels are added; fractions of the drawn length or height where named so.
#[derive(Debug)]
pub(super) struct Archetype {
    pub name: &'static str,
    share: f64,
    length: (f64, f64),
    width: (f64, f64),
    height: (f64, f64),
    wheelbase_of_l: f64,
    front_overhang_of_l: f64,
    wheel_diameter: f64,
    belt_of_h: f64,
    screen_deg: f64,
    backlight_deg: f64,
    tumblehome_deg: f64,
    bonnet_edge: f64,
    cowl: f64,
    cowl_of_l: f64,
    boot_of_l: f64,
    three_door: f64,
    estate: bool,
    clearance: f64,
}

const HATCH: Archetype = Archetype {
    name: "compact",
    share: 20.5,
    length: (3.98, 0.18),
    width: (1.65, 0.09),
    height: (1.48, 0.06),
    wheelbase_of_l: 0.62,
    front_overhang_of_l: 0.21,
    wheel_diameter: 0.63,
    belt_of_h: 0.61,
    screen_deg: 29.0,
    backlight_deg: 60.0,
    tumblehome_deg: 18.0,
    bonnet_edge: 0.70,
    cowl: 0.93,
    cowl_of_l: 0.275,
    boot_of_l: 0.005,
    three_door: 0.3,
    estate: false,
    clearance: 0.175,
};

const CARS: [Archetype; 10] = [
    Archetype {
        name: "micro",
        share: 3.0,
        length: (2.62, 0.15),
        width: (1.52, 0.06),
        height: (1.54, 0.04),
        wheelbase_of_l: 0.69,
        front_overhang_of_l: 0.15,
        wheel_diameter: 0.57,
        belt_of_h: 0.62,
        screen_deg: 36.0,
        backlight_deg: 62.0,
        tumblehome_deg: 14.0,
        bonnet_edge: 0.78,
        cowl: 0.98,
        cowl_of_l: 0.20,
        three_door: 1.0,
        ..HATCH
    },
    Archetype {
        name: "city",
        share: 13.0,
        length: (3.40, 0.17),
        width: (1.55, 0.07),
        height: (1.50, 0.06),
        wheelbase_of_l: 0.67,
        front_overhang_of_l: 0.18,
        wheel_diameter: 0.57,
        belt_of_h: 0.62,
        screen_deg: 32.0,
        backlight_deg: 68.0,
        tumblehome_deg: 16.0,
        bonnet_edge: 0.72,
        cowl: 0.95,
        cowl_of_l: 0.235,
        three_door: 0.5,
        ..HATCH
    },
    Archetype {
        name: "small",
        share: 21.5,
        length: (3.70, 0.18),
        width: (1.59, 0.09),
        wheelbase_of_l: 0.63,
        front_overhang_of_l: 0.20,
        wheel_diameter: 0.60,
        belt_of_h: 0.62,
        screen_deg: 30.0,
        backlight_deg: 62.0,
        tumblehome_deg: 17.0,
        cowl_of_l: 0.265,
        three_door: 0.45,
        ..HATCH
    },
    HATCH,
    Archetype {
        name: "saloon",
        share: 10.0,
        length: (4.40, 0.20),
        width: (1.65, 0.10),
        height: (1.44, 0.06),
        wheelbase_of_l: 0.60,
        front_overhang_of_l: 0.19,
        belt_of_h: 0.63,
        screen_deg: 28.0,
        backlight_deg: 30.0,
        tumblehome_deg: 20.0,
        bonnet_edge: 0.68,
        cowl: 0.92,
        cowl_of_l: 0.295,
        boot_of_l: 0.125,
        three_door: 0.0,
        ..HATCH
    },
    Archetype {
        name: "estate",
        share: 9.5,
        length: (4.42, 0.20),
        width: (1.66, 0.10),
        height: (1.50, 0.07),
        wheelbase_of_l: 0.60,
        front_overhang_of_l: 0.20,
        screen_deg: 28.0,
        backlight_deg: 62.0,
        bonnet_edge: 0.68,
        cowl_of_l: 0.29,
        three_door: 0.0,
        estate: true,
        ..HATCH
    },
    Archetype {
        name: "mpv",
        share: 12.5,
        length: (4.08, 0.25),
        width: (1.67, 0.10),
        height: (1.68, 0.08),
        front_overhang_of_l: 0.20,
        wheel_diameter: 0.64,
        belt_of_h: 0.57,
        screen_deg: 31.0,
        backlight_deg: 70.0,
        tumblehome_deg: 13.0,
        bonnet_edge: 0.76,
        cowl: 1.03,
        cowl_of_l: 0.215,
        three_door: 0.0,
        estate: true,
        ..HATCH
    },
    Archetype {
        name: "suv",
        share: 5.0,
        length: (4.10, 0.30),
        width: (1.72, 0.12),
        height: (1.74, 0.11),
        wheelbase_of_l: 0.61,
        front_overhang_of_l: 0.20,
        wheel_diameter: 0.71,
        belt_of_h: 0.60,
        screen_deg: 33.0,
        backlight_deg: 68.0,
        tumblehome_deg: 13.0,
        bonnet_edge: 0.92,
        cowl: 1.12,
        cowl_of_l: 0.285,
        three_door: 0.1,
        estate: true,
        clearance: 0.24,
        ..HATCH
    },
    Archetype {
        name: "coupe",
        share: 2.5,
        length: (3.98, 0.22),
        width: (1.62, 0.10),
        height: (1.33, 0.05),
        wheelbase_of_l: 0.60,
        front_overhang_of_l: 0.20,
        belt_of_h: 0.66,
        screen_deg: 26.0,
        backlight_deg: 24.0,
        tumblehome_deg: 24.0,
        bonnet_edge: 0.66,
        cowl: 0.88,
        cowl_of_l: 0.31,
        boot_of_l: 0.075,
        three_door: 1.0,
        ..HATCH
    },
    Archetype {
        name: "high_roof",
        share: 2.5,
        length: (4.08, 0.22),
        width: (1.70, 0.09),
        height: (1.88, 0.10),
        wheelbase_of_l: 0.64,
        front_overhang_of_l: 0.20,
        wheel_diameter: 0.62,
        belt_of_h: 0.56,
        screen_deg: 36.0,
        backlight_deg: 82.0,
        tumblehome_deg: 8.0,
        bonnet_edge: 0.80,
        cowl: 1.08,
        cowl_of_l: 0.235,
        three_door: 0.0,
        estate: true,
        ..HATCH
    },
];

const TRANSPORTER: Archetype = Archetype {
    name: "transporter",
    share: 27.0,
    length: (4.78, 0.28),
    width: (1.86, 0.09),
    height: (2.02, 0.10),
    wheelbase_of_l: 0.61,
    front_overhang_of_l: 0.19,
    wheel_diameter: 0.66,
    belt_of_h: 0.57,
    screen_deg: 42.0,
    backlight_deg: 84.0,
    tumblehome_deg: 7.0,
    bonnet_edge: 0.92,
    cowl: 1.20,
    cowl_of_l: 0.165,
    boot_of_l: 0.003,
    three_door: 0.0,
    estate: true,
    clearance: 0.20,
};

const VANS: [Archetype; 4] = [
    Archetype {
        name: "small_van",
        share: 30.0,
        length: (4.22, 0.25),
        width: (1.76, 0.08),
        height: (1.88, 0.08),
        wheelbase_of_l: 0.64,
        front_overhang_of_l: 0.20,
        screen_deg: 38.0,
        tumblehome_deg: 8.0,
        bonnet_edge: 0.82,
        cowl: 1.09,
        cowl_of_l: 0.23,
        ..TRANSPORTER
    },
    TRANSPORTER,
    Archetype {
        name: "medium_van",
        share: 23.0,
        length: (5.60, 0.35),
        width: (1.97, 0.11),
        height: (2.36, 0.14),
        front_overhang_of_l: 0.175,
        belt_of_h: 0.51,
        screen_deg: 45.0,
        tumblehome_deg: 5.0,
        bonnet_edge: 0.98,
        cowl: 1.25,
        cowl_of_l: 0.15,
        ..TRANSPORTER
    },
    Archetype {
        name: "high_van",
        share: 20.0,
        length: (6.15, 0.40),
        width: (2.03, 0.09),
        height: (2.64, 0.12),
        wheelbase_of_l: 0.60,
        front_overhang_of_l: 0.165,
        belt_of_h: 0.475,
        screen_deg: 46.0,
        tumblehome_deg: 4.0,
        bonnet_edge: 1.00,
        cowl: 1.28,
        cowl_of_l: 0.145,
        ..TRANSPORTER
    },
];

/// One vehicle's measures, meters in the box frame.
#[derive(Debug, Clone)]
pub(super) struct Dimensions {
    pub name: &'static str,
    pub length: f32,
    pub width: f32,
    pub height: f32,
    /// x of the front and the rear axle.
    pub axles_x: [f32; 2],
    pub wheel_radius: f32,
    pub tyre_width: f32,
    /// Radius of the cut in the flank.
    pub arch_radius: f32,
    /// Lower edge of the flanks and floor.
    pub clearance: f32,
    /// Side window sill at the windscreen's foot.
    pub belt: f32,
    /// Rise of the belt line from the windscreen's foot to the tail.
    pub belt_rise: f32,
    /// Height of the bonnet's front edge at the corners.
    pub bonnet_edge: f32,
    /// Height of the windscreen's foot in the middle.
    pub cowl: f32,
    /// x of the windscreen's foot in the middle.
    pub cowl_x: f32,
    /// Length of the boot lid behind the backlight.
    pub boot: f32,
    /// Tangents of the slopes from the horizontal.
    pub screen_slope: f32,
    pub backlight_slope: f32,
    /// Tangent of the side windows' lean from the vertical.
    pub tumblehome: f32,
    /// Drop of the roof from its apex to the front and to the rear header.
    pub roof_sag: [f32; 2],
    /// Exponents of the nose's and the tail's plan: larger is squarer.
    pub corner_exponent: [f32; 2],
    pub windows: Windows,
    pub is_van: bool,
}

impl Dimensions {
    /// Draws a vehicle of a class.
    ///
    /// # Errors
    /// [`Error::Scene`] for a class other than Car and Van.
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
        DVec3::new(f64::from(self.length), f64::from(self.width), f64::from(self.height))
    }

    fn of_kind(kind: &Archetype, is_van: bool, s: &mut Stream) -> Self {
        // A longer car of a kind is a wider one: correlation 0.25.
        let z_length = s.clipped_normal(0.0, 1.0);
        let z_width = 0.25 * z_length + (1.0_f64 - 0.0625).sqrt() * s.clipped_normal(0.0, 1.0);
        let z_height =
            if is_van { 0.8 * z_length + 0.6 * s.clipped_normal(0.0, 1.0) } else { s.clipped_normal(0.0, 1.0) };
        let [over_l, over_w, over_h] = Margins::mean_of_vehicles();
        let l = kind.length.0 + kind.length.1 * z_length + over_l;
        let w = kind.width.0 + kind.width.1 * z_width + over_w;
        let h = kind.height.0 + kind.height.1 * z_height + over_h;
        let tall = h / kind.height.0;
        let front_axle = l / 2.0 - (kind.front_overhang_of_l + s.range(-0.008, 0.008)) * l;
        let rear_axle = front_axle - kind.wheelbase_of_l * l;
        let wheel_radius = (kind.wheel_diameter / 2.0 * s.range(0.97, 1.03)).min(0.225 * h);
        let slope = |deg: f64| math::tan(deg.to_radians()) as f32;
        let estate = kind.estate && (kind.name != "high_roof" || s.chance(0.8));
        let windows = if is_van && s.chance(if matches!(kind.name, "medium_van" | "high_van") { 0.75 } else { 0.4 }) {
            Windows::PanelVan
        } else if s.chance(kind.three_door) {
            Windows::ThreeDoor
        } else if estate {
            Windows::Estate
        } else {
            Windows::FiveDoor
        };
        let fast_back = kind.backlight_deg < 40.0;
        Self {
            name: kind.name,
            length: l as f32,
            width: w as f32,
            height: h as f32,
            axles_x: [front_axle as f32, rear_axle as f32],
            wheel_radius: wheel_radius as f32,
            tyre_width: s.range(0.165, if w > 1.6 { 0.215 } else { 0.185 }) as f32,
            arch_radius: (wheel_radius * 1.10) as f32,
            clearance: (kind.clearance * s.range(0.93, 1.07)) as f32,
            belt: (kind.belt_of_h * h + s.range(-0.015, 0.015)) as f32,
            belt_rise: s.range(0.015, if kind.estate { 0.04 } else { 0.07 }) as f32,
            bonnet_edge: (kind.bonnet_edge * tall + s.range(-0.02, 0.02)) as f32,
            cowl: (kind.cowl * tall) as f32,
            cowl_x: (l / 2.0 - (kind.cowl_of_l + s.range(-0.012, 0.012)) * l) as f32,
            boot: (kind.boot_of_l * l) as f32,
            screen_slope: slope(kind.screen_deg + s.range(-1.5, 1.5)),
            backlight_slope: slope(kind.backlight_deg + s.range(-3.0, 3.0)),
            tumblehome: slope(kind.tumblehome_deg + s.range(-1.5, 1.5)),
            roof_sag: [
                s.range(0.03, 0.05) as f32,
                if fast_back { s.range(0.07, 0.11) } else { s.range(0.04, 0.09) } as f32,
            ],
            corner_exponent: [
                s.range(2.2, 3.0) as f32,
                if is_van { s.range(5.0, 7.0) } else { s.range(2.8, 4.2) } as f32,
            ],
            windows,
            is_van,
        }
    }
}
