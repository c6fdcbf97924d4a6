//! Turn signals of cars and vans: in the outer corners of head and tail lamps, and on the fenders.

use super::body::Styling;
use super::details::flank_strip;
use super::outline::{Face, Outline};
use super::paint::slot;
use super::surface::{Outward, Surface, grid};
use cadet_base::math::Vec3;

/// Lateral and height fractions of the front signals: the lower outer corners of the head lamps.
const FRONT: ([f32; 2], [f32; 2]) = ([0.84, 0.955], [0.66, 0.80]);
/// Of the rear ones: where they begin at most outside, where they end, and the height of their band.
const REAR_FROM: f32 = 0.78;
const REAR_TO: f32 = 0.965;
const REAR_BAND: f32 = 0.11;
/// How far lenses stand out of the shell.
const PROUD_M: f32 = 0.004;

/// Adds the signals that lie inside the label's box over a shell whose cells end at these lateral and height fractions.
pub(super) fn add_signals(surface: &mut Surface, o: &Outline, styling: &Styling, ends: &[f32], heights: &[f32]) {
    let (across, up) = FRONT;
    add_lens(surface, o, true, &cuts(across, ends), &cuts(up, heights));
    let from = (styling.tail_lamp_side_fraction + 0.02).max(REAR_FROM);
    let low = (styling.tail_lamp_from_fraction + 0.04).max(0.66);
    add_lens(surface, o, false, &cuts([from, REAR_TO], ends), &cuts([low, low + REAR_BAND], heights));
}

/// The lateral fractions of the ends' columns at a level of detail.
pub(super) fn ends_of(o: &Outline, level: usize) -> Vec<f32> {
    let of_nose = |face| if let Face::Nose(f) = face { Some(f) } else { None };
    o.columns(level).iter().filter_map(|c| of_nose(c.face)).collect()
}

/// Adds the repeaters on the front fenders.
pub(super) fn add_repeaters(surface: &mut Surface, o: &Outline) {
    let x = o.d.axles_x[0] - 0.85 * o.d.arch_radius_m;
    let z = o.top_z(x) - 0.15;
    flank_strip(surface, o, &[(x + 0.035, z), (x - 0.035, z)], 0.024, PROUD_M, slot::LEFT_SIGNAL);
}

/// From the first fraction to the last, with what the shell has between: a lens follows its bends.
fn cuts([from, to]: [f32; 2], of_shell: &[f32]) -> Vec<f32> {
    let between = of_shell.iter().copied().filter(|f| (from + 0.01..to - 0.005).contains(f));
    std::iter::once(from).chain(between).chain([to]).collect()
}

fn add_lens(surface: &mut Surface, o: &Outline, is_nose: bool, across: &[f32], up: &[f32]) {
    let out = if is_nose { 1.0 } else { -1.0 };
    let proud = Vec3::new(PROUD_M * out, PROUD_M, 0.0);
    let lens = grid(across, up, |f, v| o.point(&o.end_column(*f, is_nose), *v) + proud);
    surface.panel_pair(&lens, Outward::Along(Vec3::new(out, 0.5, 0.0)), slot::LEFT_SIGNAL);
}
