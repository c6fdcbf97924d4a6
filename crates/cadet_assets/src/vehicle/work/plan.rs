//! What kind of commercial vehicle a seed draws, and its measures.

use super::super::paint::Livery;
use super::body::{Body, Load, Roof, Room, Size};
use crate::annotation::Margins;
use crate::annotation::sizes::{MISC, TRUCKS};
use cadet_base::math::DVec3;
use cadet_base::rng::Stream;

/// What a truck is built on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Chassis {
    Rigid,
    Semi,
    Bus,
}

/// The share of buses among long trucks. KITTI's boxes of 12.3 x 2.6 x 2.9 m are city buses, those of 16.4 m and more
/// semi-trailers.
const LONG_BUSES: f64 = 0.14;
/// The share of caravans among large trailers.
const CARAVANS: f64 = 0.6;

/// One truck's measures, meters in the box frame.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub chassis: Chassis,
    /// What it carries; nothing if it is a bus.
    pub body: Option<&'static Body>,
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
    /// What the body's draws come from.
    pub body_seed: u64,
}

impl Plan {
    /// Draws a truck.
    pub fn draw(s: &mut Stream) -> Self {
        let size = TRUCKS.draw(s) + DVec3::from_array(Margins::mean_of_vehicles());
        Self::of_size(size, s)
    }

    fn of_size(size: DVec3, s: &mut Stream) -> Self {
        let (l, h) = (size.x, size.z);
        let (chassis, body) = if l > 14.5 {
            (Chassis::Semi, Body::pick(Size::Semi, 0.0, s))
        } else if l > 11.2 && h < 3.4 {
            (Chassis::Bus, None)
        } else if l > 9.8 {
            Body::pick(Size::Long, LONG_BUSES, s).map_or((Chassis::Bus, None), |body| (Chassis::Rigid, Some(body)))
        } else {
            (Chassis::Rigid, Body::pick(if l > 6.8 { Size::Medium } else { Size::Short }, 0.0, s))
        };
        let detail = std::array::from_fn(|_| s.unit() as f32);
        let [length_m, width_m, height_m] = size.as_vec3().to_array();
        let half = length_m / 2.0;
        let is_small = length_m < 6.9;
        let wheel_radius_m = if is_small {
            0.36 + 0.05 * detail[0]
        } else if chassis == Chassis::Bus {
            0.48
        } else {
            0.46 + 0.05 * detail[0]
        };
        let deck_z = if is_small { 0.72 + 0.1 * detail[1] } else { 0.98 + 0.12 * detail[1] };
        let has_sleeper = chassis == Chassis::Semi || (length_m > 8.5 && detail[2] > 0.55);
        let cab_length_m = if is_small {
            1.60
        } else if has_sleeper {
            2.20
        } else {
            1.70 + 0.15 * detail[2]
        };
        let cab_height = if is_small {
            2.12 + 0.16 * detail[3]
        } else if chassis == Chassis::Semi {
            3.25 + 0.4 * detail[3]
        } else {
            2.62 + 0.28 * detail[3]
        };
        let is_open = body.is_some_and(|body| body.family.roof == Roof::None);
        // Of small ones that carry no body the cab is the highest.
        let cab_top_z = if is_open && is_small { height_m.min(2.6) } else { cab_height.min(height_m - 0.12) };
        let front = half
            - if chassis == Chassis::Bus {
                2.7
            } else if is_small {
                1.02
            } else {
                1.36
            };
        let (axles_x, twin) = match chassis {
            Chassis::Semi => {
                let last = -half + 1.6 + 0.9 * detail[4];
                let drive = front - 3.65;
                (vec![front, last + 1.31, last, last + 2.62, drive], vec![false, false, false, false, true])
            }
            Chassis::Bus => (vec![front, front - 0.48 * length_m], vec![false, true]),
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
            chassis,
            body,
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
            body_seed: s.next_u64(),
        }
    }

    pub fn name(&self) -> &'static str {
        match (self.chassis, self.body) {
            (Chassis::Rigid, Some(body)) => &body.name,
            (Chassis::Semi, _) => "semi_trailer",
            _ => "bus",
        }
    }

    pub fn livery(&self) -> Livery {
        self.body.map_or(Livery::Bus, |body| body.family.livery)
    }

    /// What it carries.
    pub fn load(&self) -> Load {
        Load { body: self.body, room: self.room(), seed: self.body_seed }
    }

    /// The room behind the cab.
    pub fn room(&self) -> Room {
        Room {
            front_x: self.load_front(),
            rear_x: -self.length_m / 2.0,
            half_y: self.width_m / 2.0,
            floor_z: self.deck_z,
            top_z: self.height_m,
        }
    }

    pub fn front_x(&self) -> f32 {
        self.length_m / 2.0
    }

    /// Where the load begins behind the cab.
    pub fn load_front(&self) -> f32 {
        let gap = if self.chassis == Chassis::Semi { 0.55 } else { 0.10 };
        self.front_x() - self.cab_length_m - gap
    }

    /// y of the outer wheels' centers.
    pub fn hub_y(&self) -> f32 {
        self.width_m.min(2.56) / 2.0 - self.tyre_width_m / 2.0 - 0.02
    }
}

/// What stands at the curb or is towed.
#[derive(Debug, Clone, Copy)]
pub(super) enum Towed {
    Motorbike,
    Caravan,
    Trailer(Size, &'static Body),
}

/// One trailer's or motorbike's measures.
#[derive(Debug, Clone)]
pub(super) struct TowedPlan {
    pub kind: Towed,
    pub length_m: f32,
    pub width_m: f32,
    pub height_m: f32,
    pub detail: [f32; 8],
    /// What the bed's draws come from.
    pub body_seed: u64,
}

impl TowedPlan {
    pub fn draw(s: &mut Stream) -> Self {
        let size = MISC.draw(s) + DVec3::from_array(Margins::mean_of_vehicles());
        let (l, w, h) = (size.x, size.y, size.z);
        let kind = if w < 0.95 && l < 2.6 {
            Towed::Motorbike
        } else {
            let size = if l > 4.2 && h < 1.5 {
                Size::Flat
            } else if l > 7.5 {
                Size::Heavy
            } else if h < 1.45 {
                Size::Low
            } else if l < 2.9 {
                Size::Small
            } else {
                Size::Large
            };
            let caravans = if size == Size::Large { CARAVANS } else { 0.0 };
            Body::pick(size, caravans, s).map_or(Towed::Caravan, |body| Towed::Trailer(size, body))
        };
        let [length_m, width_m, height_m] = size.as_vec3().to_array();
        let detail = std::array::from_fn(|_| s.unit() as f32);
        Self { kind, length_m, width_m, height_m, detail, body_seed: s.next_u64() }
    }

    pub fn name(&self) -> &'static str {
        match self.kind {
            Towed::Motorbike => "motorbike",
            Towed::Caravan => "caravan",
            Towed::Trailer(_, bed) => &bed.name,
        }
    }

    /// What it carries.
    pub fn bed(&self) -> Option<&'static Body> {
        if let Towed::Trailer(_, bed) = self.kind { Some(bed) } else { None }
    }

    pub fn livery(&self) -> Livery {
        match self.kind {
            Towed::Motorbike => Livery::Motorbike,
            Towed::Caravan => Livery::Caravan,
            Towed::Trailer(_, bed) => bed.family.livery,
        }
    }
}
