//! The lower body: nose, flanks with wheel arches, tail, floor, bonnet and boot lid.

use super::outline::{Column, Face, Outline};
use super::paint::slot;
use super::surface::{Outward, Surface, grid, level_sheet};
use cadet_base::math::Vec3;

/// What the styling varies on the nose and the tail.
#[derive(Debug, Clone)]
pub(super) struct Styling {
    /// Bumpers of bare plastic.
    pub black_bumpers: bool,
    /// A rubbing strip along the doors.
    pub side_strip: bool,
    /// Lateral fraction where the head lamps begin.
    pub lamp_from_fraction: f32,
    /// Half width of the grille as a lateral fraction.
    pub grille_to_fraction: f32,
    /// Height fraction where the tail lamps begin.
    pub tail_lamp_from_fraction: f32,
    /// Lateral fraction where the tail lamps begin.
    pub tail_lamp_side_fraction: f32,
}

/// Adds the lower body.
pub(super) fn add_lower_body(surface: &mut Surface, o: &Outline, styling: &Styling, level: usize) {
    let columns = o.columns(level);
    let fractions = Outline::fractions(level);
    let shell = grid(&columns, fractions, |c, v| o.point(c, *v));
    let inside = Vec3::new(0.0, 0.0, 0.5 * o.d.height_m);
    // The orientation is the whole ring's; the seams only leave cells open.
    surface.pair(&shell, Outward::From(inside), |i, j| {
        let (a, b) = (&columns[i], &columns[i + 1]);
        (!b.is_seam).then(|| shell_slot(a, b, 0.5 * (fractions[j] + fractions[j + 1]), styling, o.d.length_m / 2.0))
    });
    if level < 2 {
        add_arches_and_floor(surface, o, &columns);
    } else {
        add_coarse_floor(surface, o);
    }
    let lateral: &[f32] = [&[0.0, 0.3, 0.6, 0.82, 0.94, 1.0][..], &[0.0, 0.5, 0.85, 1.0], &[0.0, 0.7, 1.0]][level];
    add_decks(surface, o, &columns, lateral, |c| level < 2 || c.arch_z.is_none());
}

/// The material of the cell between two columns at a height fraction.
pub(super) fn shell_slot(a: &Column, b: &Column, v: f32, styling: &Styling, half_length_m: f32) -> u8 {
    let f = 0.5 * (a.face.lateral() + b.face.lateral());
    let is_nose = matches!(a.face, Face::Nose(_));
    let is_tail = matches!(b.face, Face::Tail(_));
    if v < 0.08 {
        return slot::PLASTIC;
    }
    if is_nose {
        if f > styling.lamp_from_fraction
            && f < 0.97
            && 0.5 * (a.x + b.x) > half_length_m - 0.38
            && v > 0.64
            && v < 0.93
        {
            return slot::LAMP;
        }
        if f < styling.grille_to_fraction && v > 0.64 && v < 0.90 {
            return slot::GRILLE;
        }
        if f < 0.62 && v < 0.36 {
            return slot::GRILLE;
        }
        if styling.black_bumpers && v < 0.50 {
            return slot::PLASTIC;
        }
    } else if is_tail {
        if f > styling.tail_lamp_side_fraction
            && 0.5 * (a.x + b.x) < -half_length_m + 0.30
            && v > styling.tail_lamp_from_fraction
            && v < 0.97
        {
            return slot::TAIL_LAMP;
        }
        if (styling.black_bumpers && v < 0.50) || v < 0.22 {
            return slot::PLASTIC;
        }
    }
    slot::PAINT
}

fn add_arches_and_floor(surface: &mut Surface, o: &Outline, columns: &[Column]) {
    let d = &o.d;
    let inner_y = d.width_m / 2.0 - 0.30;
    let floor_z = d.clearance_m;
    let low = |c: &Column| o.point(c, 0.0);
    let inner = |c: &Column, z: f32| {
        let p = low(c);
        Vec3::new(p.x, p.y.min(inner_y), z)
    };
    let middle = grid(columns, [0.0, 1.0], |c, side| inner(c, floor_z) * Vec3::new(1.0, side, 1.0));
    let down = Outward::Along(Vec3::NEG_Z);
    surface.panel_pair(&middle, down, slot::LINER);
    for pair in columns.windows(2) {
        let [a, b] = [&pair[0], &pair[1]];
        let axle = if a.x > 0.0 { d.axles_x[0] } else { d.axles_x[1] };
        let hub = Vec3::new(axle, d.width_m, d.wheel_radius_m);
        if b.is_seam {
            // The upright edge of the arch.
            let (full, cut) = if a.arch_z.is_some() { (b, a) } else { (a, b) };
            let (p, q) = (low(full), low(cut));
            let wall = [[p, q], [inner(full, p.z), inner(cut, q.z)]];
            surface.panel_pair(&wall, Outward::Along(Vec3::new(axle - a.x, 0.0, 0.0)), slot::LINER);
        } else if a.arch_z.is_some() {
            let (p, q) = (low(a), low(b));
            let roof = [[p, q], [inner(a, p.z), inner(b, q.z)]];
            surface.panel_pair(&roof, Outward::Along(hub - p.midpoint(q)), slot::LINER);
            let wall = [[inner(a, p.z), inner(b, q.z)], [inner(a, floor_z), inner(b, floor_z)]];
            surface.panel_pair(&wall, Outward::Along(Vec3::Y), slot::LINER);
        } else if low(a).y > inner_y || low(b).y > inner_y {
            let strip = [[low(a), low(b)], [inner(a, floor_z), inner(b, floor_z)]];
            surface.panel_pair(&strip, down, slot::LINER);
        }
    }
}

/// Far away a dark wall behind each arch and one panel below do.
fn add_coarse_floor(surface: &mut Surface, o: &Outline) {
    let d = &o.d;
    let y = d.width_m / 2.0 - 0.16;
    let floor = level_sheet([o.nose_x, o.tail_x], [0.0, y], d.clearance_m);
    surface.panel_pair(&floor, Outward::Along(Vec3::NEG_Z), slot::LINER);
    for axle in d.axles_x {
        let top = d.wheel_radius_m + d.arch_radius_m + 0.02;
        let ends = [axle + d.arch_radius_m, axle - d.arch_radius_m];
        let wall = grid(ends, [d.clearance_m, top], |x, z| Vec3::new(x, y, z));
        surface.panel_pair(&wall, Outward::Along(Vec3::Y), slot::LINER);
    }
}

/// Adds bonnet and boot lid, whose bonnet has a row at each column that is wanted.
pub(super) fn add_decks(
    surface: &mut Surface,
    o: &Outline,
    columns: &[Column],
    lateral: &[f32],
    is_wanted: impl Fn(&Column) -> bool,
) {
    let up = Outward::Along(Vec3::Z);
    let bonnet = columns
        .iter()
        .filter(|c| c.x >= o.screen_foot_x - 1e-3 && !c.is_seam)
        .filter(|c| is_wanted(c) || (c.x - o.screen_foot_x).abs() < 1e-3);
    surface.panel_pair(&grid(bonnet, lateral, |c, t| o.deck(c, *t)), up, slot::PAINT);
    let first = columns.iter().position(|c| o.point(c, 1.0).x < o.backlight_foot_x).unwrap_or(columns.len() - 1);
    let boot = grid(&columns[first.saturating_sub(1)..], lateral, |c, t| o.deck(c, *t));
    surface.pair(&boot, up, |i, _| Some(if i == 0 && o.d.boot_m < 0.1 { slot::DARK } else { slot::PAINT }));
}
