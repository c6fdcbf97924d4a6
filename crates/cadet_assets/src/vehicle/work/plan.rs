//! What kind of commercial vehicle a seed draws, and its measures.

use super::super::paint::Livery;
use crate::annotation::Margins;
use crate::annotation::sizes::{MISC, TRUCKS};
use cadet_base::math::DVec3;
use cadet_base::rng::Stream;

/// What a chassis carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WorkKind {
    Box,
    Curtain,
    Tipper,
    Flatbed,
    Tank,
    Refuse,
    Fire,
    Semi,
    Bus,
}

/// Shares of the kinds among trucks that are as long and as high as the limits say. KITTI's boxes of 12.3 x 2.6 x 2.9 m
/// are city buses, those of 16.4 m and more semi-trailers.
const SHORT: [(WorkKind, f64); 4] =
    [(WorkKind::Box, 0.40), (WorkKind::Flatbed, 0.30), (WorkKind::Tipper, 0.22), (WorkKind::Fire, 0.14)];
const MEDIUM: [(WorkKind, f64); 7] = [
    (WorkKind::Box, 0.34),
    (WorkKind::Curtain, 0.16),
    (WorkKind::Tipper, 0.14),
    (WorkKind::Flatbed, 0.10),
    (WorkKind::Refuse, 0.14),
    (WorkKind::Tank, 0.06),
    (WorkKind::Fire, 0.13),
];
const LONG: [(WorkKind, f64); 5] = [
    (WorkKind::Box, 0.38),
    (WorkKind::Curtain, 0.28),
    (WorkKind::Refuse, 0.12),
    (WorkKind::Tank, 0.08),
    (WorkKind::Bus, 0.14),
];

/// One truck's measures, meters in the box frame.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub kind: WorkKind,
    pub length_m: f32,
    pub width_m: f32,
    pub height_m: f32,
    pub wheel_radius_m: f32,
    pub tyre_width_m: f32,
    /// x of the axles, the front one first, the one that the springs carry second.
    pub axles_x: Vec<f32>,
    /// The rear axles have twin tires, all but a trailer's.
    pub twin: Vec<bool>,
    /// From the front bumper to the cab's rear wall, its half width, and its roof.
    pub cab_length_m: f32,
    pub cab_half_y: f32,
    pub cab_top_z: f32,
    /// Upper edge of the frame.
    pub deck_z: f32,
    /// A random number per detail.
    pub detail: [f32; 8],
}

impl Plan {
    /// Draws a truck.
    pub fn draw(s: &mut Stream) -> Self {
        let size = TRUCKS.draw(s) + DVec3::from_array(Margins::mean_of_vehicles());
        Self::of_size(size, s)
    }

    fn of_size(size: DVec3, s: &mut Stream) -> Self {
        let (l, h) = (size.x, size.z);
        let kind = if l > 14.5 {
            WorkKind::Semi
        } else if l > 11.2 && h < 3.4 {
            WorkKind::Bus
        } else if l > 9.8 {
            pick(&LONG, s)
        } else if l > 6.8 {
            pick(&MEDIUM, s)
        } else {
            pick(&SHORT, s)
        };
        let detail = std::array::from_fn(|_| s.unit() as f32);
        let [length_m, width_m, height_m] = size.as_vec3().to_array();
        let half = length_m / 2.0;
        let is_small = length_m < 6.9;
        let wheel_radius_m = if is_small {
            0.36 + 0.05 * detail[0]
        } else if kind == WorkKind::Bus {
            0.48
        } else {
            0.46 + 0.05 * detail[0]
        };
        let deck_z = if is_small { 0.72 + 0.1 * detail[1] } else { 0.98 + 0.12 * detail[1] };
        let has_sleeper = kind == WorkKind::Semi || (length_m > 8.5 && detail[2] > 0.55);
        let cab_length_m = if is_small {
            1.60
        } else if has_sleeper {
            2.20
        } else {
            1.70 + 0.15 * detail[2]
        };
        let cab_height = if is_small {
            2.12 + 0.16 * detail[3]
        } else if kind == WorkKind::Semi {
            3.25 + 0.4 * detail[3]
        } else {
            2.62 + 0.28 * detail[3]
        };
        let is_open = matches!(kind, WorkKind::Tipper | WorkKind::Flatbed);
        // Of small ones that carry no body the cab is the highest.
        let cab_top_z = if is_open && is_small { height_m.min(2.6) } else { cab_height.min(height_m - 0.12) };
        let front = half
            - if kind == WorkKind::Bus {
                2.7
            } else if is_small {
                1.02
            } else {
                1.36
            };
        let (axles_x, twin) = match kind {
            WorkKind::Semi => {
                let last = -half + 1.6 + 0.9 * detail[4];
                let drive = front - 3.65;
                (vec![front, last + 1.31, last, last + 2.62, drive], vec![false, false, false, false, true])
            }
            WorkKind::Bus => (vec![front, front - 0.48 * length_m], vec![false, true]),
            _ => {
                let overhang = if is_small { 1.25 } else { 1.5 + 0.07 * length_m };
                let rear = -half + overhang;
                let is_tandem = length_m > 9.0 || (length_m > 7.6 && h > 3.2 && detail[4] > 0.6);
                if is_tandem {
                    (vec![front, rear + 1.0, rear - 0.35], vec![false, true, false])
                } else {
                    (vec![front, rear], vec![false, true])
                }
            }
        };
        Self {
            kind,
            length_m,
            width_m,
            height_m,
            wheel_radius_m,
            tyre_width_m: if is_small { 0.20 } else { 0.28 },
            axles_x,
            twin,
            cab_length_m,
            cab_half_y: (width_m / 2.0 - 0.02).min(if is_small { 1.02 } else { 1.24 }),
            cab_top_z,
            deck_z,
            detail,
        }
    }

    pub fn name(&self) -> &'static str {
        match self.kind {
            WorkKind::Box => "box_truck",
            WorkKind::Curtain => "curtain_sider",
            WorkKind::Tipper => "tipper",
            WorkKind::Flatbed => "flatbed",
            WorkKind::Tank => "tanker",
            WorkKind::Refuse => "refuse_truck",
            WorkKind::Fire => "fire_engine",
            WorkKind::Semi => "semi_trailer",
            WorkKind::Bus => "bus",
        }
    }

    pub fn livery(&self) -> Livery {
        match self.kind {
            WorkKind::Refuse => Livery::Municipal,
            WorkKind::Fire => Livery::Fire,
            WorkKind::Bus => Livery::Bus,
            _ => Livery::Freight,
        }
    }

    pub fn front_x(&self) -> f32 {
        self.length_m / 2.0
    }

    /// Where the load begins behind the cab.
    pub fn load_front(&self) -> f32 {
        let gap = if self.kind == WorkKind::Semi { 0.55 } else { 0.10 };
        self.front_x() - self.cab_length_m - gap
    }

    /// y of the outer wheels' centers.
    pub fn hub_y(&self) -> f32 {
        self.width_m.min(2.56) / 2.0 - self.tyre_width_m / 2.0 - 0.02
    }
}

fn pick<T: Copy>(shares: &[(T, f64)], s: &mut Stream) -> T {
    shares[s.weighted(&shares.iter().map(|k| k.1).collect::<Vec<_>>())].0
}

/// What stands at the curb or is towed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Towed {
    Motorbike,
    Open,
    Covered,
    Caravan,
    Container,
    Platform,
}

/// One trailer's or motorbike's measures.
#[derive(Debug, Clone)]
pub(super) struct TowedPlan {
    pub kind: Towed,
    pub length_m: f32,
    pub width_m: f32,
    pub height_m: f32,
    pub detail: [f32; 8],
}

impl TowedPlan {
    pub fn draw(s: &mut Stream) -> Self {
        let size = MISC.draw(s) + DVec3::from_array(Margins::mean_of_vehicles());
        let (l, w, h) = (size.x, size.y, size.z);
        let kind = if w < 0.95 && l < 2.6 {
            Towed::Motorbike
        } else if l > 4.2 && h < 1.5 {
            Towed::Platform
        } else if l > 7.5 {
            Towed::Container
        } else if h < 1.45 {
            pick(&[(Towed::Open, 0.8), (Towed::Covered, 0.2)], s)
        } else if l < 2.9 {
            pick(&[(Towed::Covered, 0.8), (Towed::Container, 0.2)], s)
        } else {
            pick(&[(Towed::Caravan, 0.6), (Towed::Container, 0.3), (Towed::Covered, 0.1)], s)
        };
        let [length_m, width_m, height_m] = size.as_vec3().to_array();
        Self { kind, length_m, width_m, height_m, detail: std::array::from_fn(|_| s.unit() as f32) }
    }

    pub fn name(&self) -> &'static str {
        match self.kind {
            Towed::Motorbike => "motorbike",
            Towed::Open => "open_trailer",
            Towed::Covered => "covered_trailer",
            Towed::Caravan => "caravan",
            Towed::Container => "box_trailer",
            Towed::Platform => "platform_trailer",
        }
    }

    pub fn livery(&self) -> Livery {
        match self.kind {
            Towed::Motorbike => Livery::Motorbike,
            Towed::Caravan => Livery::Caravan,
            _ => Livery::Trailer,
        }
    }
}
