//! Doors and tailgates that stand open: a leaf turned about its hinge, and the dark hole that it leaves in the closed body.

use std::sync::Arc;

use super::archetypes::Windows;
use super::glasshouse::Glasshouse;
use super::levels::CREASE_RAD;
use super::outline::Outline;
use super::paint::slot;
use super::surface::{Grid, Outward, Surface, grid, mirror_image, mirrored};
use cadet_base::geometry::{Bounds, LazyMesh, LodSet};
use cadet_base::math::{DVec3, Mat3, Quat, Vec3};

/// Nobody tells an open door from a closed one beyond this distance, meters.
const SEEN_TO_M: f32 = 90.0;
/// Thickness of leaves, and of their panes.
const THICK_M: f32 = 0.07;
const PANE_M: f32 = 0.008;
/// How far the hole's sheet stands out of the body: over its shut lines, and at the tail over plate, badge, and wiper.
const DOOR_PROUD_M: f32 = 0.004;
const GATE_PROUD_M: f32 = 0.014;
/// How far doors and tailgates are turned.
const DOOR_RAD: f32 = 1.05;
const GATE_RAD: f32 = 1.45;

/// What of a vehicle stands open.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Opening {
    /// The driver's door of a car, or its left one.
    LeftDoor,
    /// The door opposite.
    RightDoor,
    /// The lid of the trunk.
    Tailgate,
}

impl Opening {
    /// As in the names of models.
    pub fn name(self) -> &'static str {
        match self {
            Self::LeftDoor | Self::RightDoor => "open door",
            Self::Tailgate => "open tailgate",
        }
    }
}

/// A leaf when it is closed, in the box frame: rows from below to above of points from the hinge's side, and from the left.
#[derive(Debug, Clone)]
struct Leaf {
    rows: Grid,
    /// The material between each row and the next.
    slots: Vec<u8>,
    inward: Vec3,
    hinge: Vec3,
    proud_m: f32,
    /// Whether the hole is dark where the pane was; else the body's own pane stays, and what is seen through it.
    hides_pane: bool,
}

/// The leaves of a vehicle.
#[derive(Debug, Clone)]
pub struct Openings {
    /// The left front door; the right one is its mirror image.
    door: Leaf,
    gate: Option<Leaf>,
    /// Length, width, height of the design.
    size_lwh: Vec3,
}

impl Openings {
    /// Of a car or van, moved by `fit` as its body is.
    pub(super) fn of(o: &Outline, house: &Glasshouse<'_>, size_lwh: Vec3, fit: impl Fn(Vec3) -> Vec3) -> Self {
        let mut door = door(o, house);
        let is_hatch = o.d.boot_m < 0.1 && !o.d.is_van && o.d.windows != Windows::PanelVan;
        let mut gate = is_hatch.then(|| gate(o, house));
        for leaf in std::iter::once(&mut door).chain(&mut gate) {
            leaf.map(&fit);
        }
        Self { door, gate, size_lwh }
    }

    /// The leaf and the hole of a vehicle that is stretched to a size, if it has such a leaf.
    pub fn opened(&self, opening: Opening, size_lwh: DVec3) -> Option<Arc<LodSet>> {
        let mut surface = Surface::default();
        let scale = size_lwh.as_vec3() / self.size_lwh;
        match opening {
            Opening::LeftDoor => self.door.stretched(scale).add(&mut surface, Quat::from_rotation_z(-DOOR_RAD)),
            Opening::RightDoor => {
                self.door.stretched(scale).mirrored().add(&mut surface, Quat::from_rotation_z(DOOR_RAD))
            }
            Opening::Tailgate => {
                self.gate.as_ref()?.stretched(scale).add(&mut surface, Quat::from_rotation_y(GATE_RAD))
            }
        }
        let bounds = Bounds::of(surface.builder.positions().iter().copied());
        let mesh = LazyMesh::new(move || surface.builder.build("opening", CREASE_RAD));
        Some(Arc::new(LodSet { bounds, levels: vec![(SEEN_TO_M, mesh)], coarse_shadow_proxies: 0 }))
    }
}

fn door(o: &Outline, house: &Glasshouse<'_>) -> Leaf {
    let d = &o.d;
    let (front, back) = (o.screen_foot_x.min(d.axles_x[0] - 1.12 * d.arch_radius_m), house.b_pillar_x);
    let low = d.clearance_m + 0.10;
    let across = [0.0, 0.25, 0.5, 0.75, 1.0_f32];
    let mut rows = grid([0.0, 0.2, 0.45, 0.7, 0.88, 1.0_f32], across, |v, t| {
        let x = front + (back - front) * t;
        o.flank(x, low + (o.top_z(x) - 0.012 - low) * v)
    });
    let [(foot_a, top_a), (foot_b, top_b)] = house.front_pane();
    rows.extend(grid([0.06, 0.5, 0.90_f32], across, |v, t| {
        house.side(foot_a + (foot_b - foot_a) * t, top_a + (top_b - top_a) * t, v)
    }));
    let slots = [slot::PAINT; 5].into_iter().chain([slot::PLASTIC]).chain([slot::SIDE_GLASS; 2]).collect();
    let hinge = rows[0][0];
    Leaf { rows, slots, inward: Vec3::NEG_Y, hinge, proud_m: DOOR_PROUD_M, hides_pane: false }
}

fn gate(o: &Outline, house: &Glasshouse<'_>) -> Leaf {
    let across = [0.78, 0.66, 0.52, 0.34, 0.17, -0.17, -0.34, -0.52, -0.66, -0.78_f32];
    let turned = |p: Vec3, t: f32| if t < 0.0 { mirrored(p) } else { p };
    let panel = |v: f32, t: f32| turned(o.point(&o.end_column(t.abs(), false), v), t);
    let mut rows = grid([0.40, 0.50, 0.64, 0.78, 0.90, 0.97_f32], across, panel);
    rows.extend(grid([0.06, 0.5, 0.90, 0.99_f32], across, |s, t| turned(house.on_backlight(t.abs(), s), t)));
    let slots = [slot::PAINT; 6].into_iter().chain([slot::REAR_GLASS, slot::REAR_GLASS, slot::PAINT]).collect();
    let hinge = rows[rows.len() - 1][4];
    Leaf { rows, slots, inward: Vec3::X, hinge, proud_m: GATE_PROUD_M, hides_pane: true }
}

/// Points moved, by the number of their row.
fn moved(rows: &[Vec<Vec3>], to: impl Fn(usize, Vec3) -> Vec3) -> Grid {
    rows.iter().enumerate().map(|(i, row)| row.iter().map(|p| to(i, *p)).collect()).collect()
}

impl Leaf {
    fn map(&mut self, f: &dyn Fn(Vec3) -> Vec3) {
        for p in self.rows.iter_mut().flatten().chain([&mut self.hinge]) {
            *p = f(*p);
        }
    }

    fn stretched(&self, scale: Vec3) -> Self {
        let mut leaf = self.clone();
        leaf.map(&|p| p * scale);
        leaf
    }

    fn mirrored(&self) -> Self {
        Self {
            rows: mirror_image(&self.rows),
            inward: mirrored(self.inward),
            hinge: mirrored(self.hinge),
            ..self.clone()
        }
    }

    fn add(&self, surface: &mut Surface, turn: Quat) {
        let out = Outward::Along(-self.inward);
        let is_pane = |i: usize| matches!(self.slots[i], slot::SIDE_GLASS | slot::REAR_GLASS);
        let below_pane = (0..self.slots.len()).find(|i| is_pane(*i)).unwrap_or(self.slots.len());
        let covered = &self.rows[..=if self.hides_pane { self.slots.len() } else { below_pane }];
        let hole = moved(covered, |_, p| p - self.inward * self.proud_m);
        surface.panel(&hole, out, slot::LINER);
        let mut leaf = Surface::default();
        let thick = |i: usize| {
            let beside = |k: usize| is_pane(k.min(self.slots.len() - 1));
            if beside(i) || (i > 0 && beside(i - 1)) { PANE_M } else { THICK_M }
        };
        let inner = moved(&self.rows, |i, p| p + self.inward * thick(i));
        leaf.sheet(&self.rows, out, |i, _| Some(self.slots[i]));
        leaf.sheet(&inner, Outward::Along(self.inward), |i, _| {
            Some(if is_pane(i) { self.slots[i] } else { slot::DARK })
        });
        // The narrow faces round the leaf.
        let (last, end) = (self.rows.len() - 1, self.rows[0].len() - 1);
        let middle = self.rows[last / 2][end / 2] + self.inward * (0.5 * THICK_M);
        for k in [0, last] {
            leaf.panel(&[&self.rows[k], &inner[k]], Outward::From(middle), slot::PAINT);
        }
        for k in [0, end] {
            let edge = |rows: &Grid| rows.iter().map(|row| row[k]).collect::<Vec<Vec3>>();
            leaf.panel(&[edge(&self.rows), edge(&inner)], Outward::From(middle), slot::PAINT);
        }
        let rotation = Mat3::from_quat(turn);
        surface.builder.append(&leaf.builder, rotation, self.hinge - rotation * self.hinge);
    }
}
