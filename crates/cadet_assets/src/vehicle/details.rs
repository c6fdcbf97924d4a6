//! Parts mounted on the shell: mirrors, plates, handles, shut lines, wipers, aerials, rails.

use super::archetypes::Windows;
use super::glasshouse::Glasshouse;
use super::outline::{Column, Outline};
use super::paint::slot;
use super::surface::{Outward, Surface, grid, mirrored, upright};
use cadet_base::math::{Mat3, Vec3};

/// What a vehicle has besides its shell.
#[derive(Debug, Clone)]
pub(super) struct Fittings {
    pub painted_mirrors: bool,
    pub side_strip: bool,
    pub roof_rails: bool,
    pub aerial: bool,
    pub two_line_plate: bool,
    /// Height of the rear plate's center, meters.
    pub rear_plate_z: f32,
}

/// Adds what lies inside the label's box.
pub(super) fn add_fittings(surface: &mut Surface, o: &Outline, house: &Glasshouse, fittings: &Fittings, level: usize) {
    add_plates(surface, o, fittings, level == 0);
    if level < 2 {
        add_shut_lines(surface, o, house, level);
        add_handles(surface, o, house);
    }
    if fittings.side_strip {
        let z = 0.52 * o.d.belt_z;
        let (from, to) = (o.d.axles_x[0] - 1.18 * o.d.arch_radius_m, o.d.axles_x[1] + 1.18 * o.d.arch_radius_m);
        flank_strip(surface, o, &[(from, z), (0.5 * (from + to), z), (to, z)], 0.03, 0.004, slot::PLASTIC);
    }
    if level == 0 {
        add_wipers(surface, house);
        add_end_lines(surface, o);
    }
    if level < 2 {
        add_tail_fittings(surface, o, house);
    }
    if fittings.roof_rails && level < 2 {
        add_rails(surface, house, level);
    }
}

/// Adds what sticks out of the label's box.
pub(super) fn add_mirrors_and_aerial(
    surface: &mut Surface,
    o: &Outline,
    house: &Glasshouse,
    fittings: &Fittings,
    level: usize,
) {
    let d = &o.d;
    let x = o.screen_foot_x - if d.is_van { 0.20 } else { 0.30 };
    let foot = o.glass_foot(x);
    let size = if d.is_van { Vec3::new(0.055, 0.10, 0.15) } else { Vec3::new(0.06, 0.10, 0.07) };
    let center = foot + Vec3::new(0.0, 0.045 + size.y, 0.02 + size.z);
    let shell = if fittings.painted_mirrors { slot::PAINT } else { slot::PLASTIC };
    surface.block_pair(center, size, Mat3::IDENTITY, [10, 6, 4][level], shell);
    let back = center.x - size.x - 0.001;
    let (w, h) = (0.8 * size.y, 0.62 * size.z);
    if level < 2 {
        let glass = upright(back, [center.y - w, center.y + w], [center.z - h, center.z + h]);
        surface.panel_pair(&glass, Outward::Along(Vec3::NEG_X), slot::CHROME);
        let arm_y = [foot.y - 0.02, center.y - 0.5 * size.y];
        surface.cuboid_pair([foot.x - 0.04, x + 0.04], arm_y, [foot.z, foot.z + 0.05], slot::PLASTIC);
    }
    if fittings.aerial && level == 0 {
        let root = Vec3::new(house.rear_header_x + 0.15, 0.0, house.roof_z(house.rear_header_x + 0.15) - 0.01);
        let tip = root + Vec3::new(-0.10, 0.0, 0.07);
        let section = [(1.0, 0.0), (-0.5, 0.87), (-0.5, -0.87)];
        let rings = grid([(root, 0.012), (tip, 0.004)], section, |(c, r), (x, y)| c + Vec3::new(x * r, y * r, 0.0));
        surface.builder.loft(&rings, slot::PLASTIC, true);
    }
}

/// A strip of constant width along (x, z) points of the left flank, mirrored too.
pub(super) fn flank_strip(
    surface: &mut Surface,
    o: &Outline,
    path: &[(f32, f32)],
    width_m: f32,
    proud_m: f32,
    slot: u8,
) {
    let n = path.len();
    let strip = grid(0..n, [-1.0, 1.0], |k, s| {
        let (a, b) = (path[k.saturating_sub(1)], path[(k + 1).min(n - 1)]);
        let (dx, dz) = (b.0 - a.0, b.1 - a.1);
        let length = (dx * dx + dz * dz).sqrt();
        let (nx, nz) = (-dz / length * width_m / 2.0, dx / length * width_m / 2.0);
        let (x, z) = path[k];
        o.flank(x + nx * s, z + nz * s) + Vec3::Y * proud_m
    });
    surface.panel_pair(&strip, Outward::Along(Vec3::Y), slot);
}

fn add_shut_lines(surface: &mut Surface, o: &Outline, house: &Glasshouse, level: usize) {
    let d = &o.d;
    let low = d.clearance_m + 0.10;
    let rows = if level == 0 { 6 } else { 2 };
    let upright = |surface: &mut Surface, x0: f32, x1: f32, low: f32| {
        let path: Vec<(f32, f32)> = (0..=rows)
            .map(|k| {
                let t = k as f32 / rows as f32;
                let x = x0 + (x1 - x0) * t;
                (x, low + (o.top_z(x) - 0.012 - low) * t)
            })
            .collect();
        flank_strip(surface, o, &path, 0.010, 0.0025, slot::LINER);
    };
    let front = o.screen_foot_x.min(d.axles_x[0] - 1.12 * d.arch_radius_m);
    let middle = house.b_pillar_x;
    upright(surface, front, front, low);
    upright(surface, middle, middle, low);
    let mut last = middle;
    if matches!(d.windows, Windows::FiveDoor | Windows::Estate) && !d.is_van {
        // The rear door's edge follows the arch.
        let edge = d.axles_x[1] + 0.35 * d.arch_radius_m;
        let arch_top = d.wheel_radius_m + 1.12 * d.arch_radius_m;
        last = d.axles_x[1] + 1.15 * d.arch_radius_m;
        let path = [
            (last, low),
            (last, d.wheel_radius_m + 0.05),
            (edge + 0.25 * d.arch_radius_m, arch_top),
            (edge, o.top_z(edge) - 0.012),
        ];
        flank_strip(surface, o, &path, 0.010, 0.0025, slot::LINER);
    }
    let path: Vec<(f32, f32)> = (0..=3).map(|k| (front + (last - front) * k as f32 / 3.0, low)).collect();
    flank_strip(surface, o, &path, 0.010, 0.0025, slot::LINER);
}

fn add_handles(surface: &mut Surface, o: &Outline, house: &Glasshouse) {
    let d = &o.d;
    let mut at = vec![house.b_pillar_x + 0.15];
    if matches!(d.windows, Windows::FiveDoor | Windows::Estate) && !d.is_van {
        at.push(d.axles_x[1] + 0.55 * d.arch_radius_m);
    }
    for x in at {
        let z = o.top_z(x) - 0.13;
        let p = o.flank(x, z);
        surface.block_pair(p - Vec3::Y * 0.0045, Vec3::new(0.085, 0.010, 0.016), Mat3::IDENTITY, 6, slot::PLASTIC);
    }
}

/// Number plates, lettered or not.
pub(super) fn add_plates(surface: &mut Surface, o: &Outline, fittings: &Fittings, has_letters: bool) {
    let d = &o.d;
    let columns = o.columns(0);
    let (nose, tail) = (&columns[0], &columns[columns.len() - 1]);
    for (column, z, is_front) in
        [(nose, 0.42_f32.max(d.clearance_m + 0.14), true), (tail, fittings.rear_plate_z, false)]
    {
        let is_short = fittings.two_line_plate && !is_front;
        let (half_w, half_h) = if is_short { (0.17, 0.10) } else { (0.26, 0.055) };
        let crown = o.top_z(column.x) + o.crown(column.x);
        let v = (z - d.clearance_m) / (crown - d.clearance_m);
        let dv = half_h / (crown - d.clearance_m);
        let out = if is_front { 1.0 } else { -1.0 };
        // Flat and upright, before what is behind it.
        let outermost = [v - dv, v, v + dv].map(|v| o.point(column, v).x * out).into_iter().fold(0.0, f32::max);
        let x = (outermost + 0.004) * out;
        let facing = Outward::Along(Vec3::new(out, 0.0, 0.0));
        surface.panel(&upright(x, [-half_w, half_w], [z - half_h, z + half_h]), facing, slot::PLATE);
        if has_letters {
            let x = x + 0.0005 * out;
            for k in 0..7 {
                let y = half_w * (0.72 - 0.26 * k as f32) + if k > 2 { -0.02 } else { 0.0 };
                if y.abs() < half_w - 0.02 {
                    let letter = upright(x, [y - 0.013, y + 0.013], [z - 0.55 * half_h, z + 0.55 * half_h]);
                    surface.panel(&letter, facing, slot::LETTERS);
                }
            }
        }
    }
}

/// A dark line on nose or tail through (lateral fraction, height fraction) points, and its mirror image.
fn end_line(surface: &mut Surface, o: &Outline, is_nose: bool, path: &[(f32, f32)]) {
    let out = if is_nose { 1.0 } else { -1.0 };
    let is_level = (path[0].1 - path[path.len() - 1].1).abs() < 0.1;
    let (df, dv) = if is_level { (0.0, 0.006) } else { (0.006, 0.0) };
    let line = grid([-1.0, 1.0], path, |sign, (f, v)| {
        let p = o.point(&o.end_column((f + sign * df).clamp(0.0, 1.0), is_nose), v + sign * dv);
        p + Vec3::new(0.003 * out, 0.002 * f, 0.0)
    });
    surface.panel_pair(&line, Outward::Along(Vec3::new(out, 0.0, 0.0)), slot::LINER);
}

/// Gaps of bumpers, bonnet and tailgate.
fn add_end_lines(surface: &mut Surface, o: &Outline) {
    let across = |to: f32, v: f32| -> Vec<(f32, f32)> { (0..=6).map(|k| (to * k as f32 / 6.0, v)).collect() };
    end_line(surface, o, true, &across(0.94, 0.615));
    end_line(surface, o, true, &across(0.72, 0.945));
    end_line(surface, o, false, &across(0.94, 0.37));
    let gate = if o.d.boot_m > 0.1 { 0.66 } else { 0.80 };
    let upright: Vec<(f32, f32)> = (0..=4).map(|k| (gate, 0.38 + 0.60 * k as f32 / 4.0)).collect();
    end_line(surface, o, false, &upright);
    // The bonnet's edge runs from the lamp to the windscreen.
    let is_edge = |c: &Column| c.x > o.screen_foot_x && !c.is_seam && c.face.lateral() > 0.75;
    let columns = o.columns(0).into_iter().filter(is_edge);
    let edge = grid(columns, [0.925, 0.940], |c, t| o.deck(&c, t) + Vec3::Z * 0.0025);
    surface.panel_pair(&edge, Outward::Along(Vec3::Z), slot::LINER);
}

/// Third brake light, rear wiper and the maker's badges.
fn add_tail_fittings(surface: &mut Surface, o: &Outline, house: &Glasshouse) {
    let back = Vec3::new(-0.005, 0.0, 0.003);
    let light = grid([0.90, 0.94], [0.0, 0.17], |s, t| house.on_backlight(t, s) + back);
    surface.panel_pair(&light, Outward::Along(Vec3::NEG_X), slot::TAIL_LAMP);
    if o.d.backlight_slope > 1.0 && o.d.windows != Windows::PanelVan {
        let (a, b) = (house.on_backlight(0.0, 0.21), mirrored(house.on_backlight(0.42, 0.27)));
        let up = Vec3::new(0.0, 0.0, 0.014);
        let wiper = [[a + back, b + back], [a + back + up, b + back + up]];
        surface.panel(&wiper, Outward::Along(Vec3::NEG_X), slot::PLASTIC);
    }
    for (is_nose, v) in [(true, 0.78), (false, 0.84)] {
        let p = o.point(&o.end_column(0.0, is_nose), v);
        let (out, half) = (if is_nose { 0.006 } else { -0.006 }, 0.04);
        let badge =
            grid([-1.0, 1.0], [(0.0, 1.0), (1.0, 0.4)], |sign, (y, z)| p + Vec3::new(out, y * half, sign * z * half));
        surface.panel_pair(&badge, Outward::Along(Vec3::X * out), slot::CHROME);
    }
}

fn add_wipers(surface: &mut Surface, house: &Glasshouse) {
    for (from, to) in [((0.15, 0.02), (0.75, 0.10)), ((-0.55, 0.02), (0.05, 0.10))] {
        let place = |(t, s): (f32, f32)| {
            let p = house.on_screen(t.abs(), s);
            Vec3::new(p.x, p.y * t.signum(), p.z) + Vec3::new(0.006, 0.0, 0.010)
        };
        let (a, b) = (place(from), place(to));
        let up = Vec3::new(-0.012, 0.0, 0.012);
        surface.panel(&[[a, b], [a + up, b + up]], Outward::Along(Vec3::new(1.0, 0.0, 1.0)), slot::PLASTIC);
    }
}

fn add_rails(surface: &mut Surface, house: &Glasshouse, level: usize) {
    let (from, to) = (house.header_x - 0.20, house.rear_header_x + 0.10);
    let n = if level == 0 { 6 } else { 3 };
    let section = [(0.0, 0.012), (-0.012, 0.0), (0.0, -0.012), (0.012, 0.0), (0.0, 0.012)];
    let rail = grid(0..=n, section, |k, (y, z)| {
        let x = from + (to - from) * k as f32 / n as f32;
        let edge = house.cant(x);
        let lift = if k == 0 || k == n { 0.0 } else { 0.028 };
        Vec3::new(x, edge.y - 0.06, edge.z + 0.025 + lift) + Vec3::new(0.0, y, z)
    });
    let middle = house.cant(0.5 * (from + to)) + Vec3::new(0.0, -0.06, 0.05);
    surface.panel_pair(&rail, Outward::From(middle), slot::PLASTIC);
}
