//! A whole vehicle beyond the distance at which anybody looks through its windows: they are dark panes, wheel arches are dark
//! panels, and what is smaller than a pixel of KITTI's camera is left out.

use super::archetypes::Windows;
use super::body::{Styling, add_decks, shell_slot};
use super::details::{Fittings, add_plates};
use super::glasshouse::{Cell, Glasshouse, SCREEN_TO_M, SIDE_PANES_TO_M};
use super::outline::{Column, Face, Outline};
use super::paint::slot;
use super::signals::add_signals;
use super::surface::{Outward, Surface, grid};
use cadet_base::math::Vec3;

/// Lateral fractions of nose and tail.
const ENDS: [f32; 3] = [0.0, 0.58, 0.90];
/// Height fractions: the bumpers' upper edge, and about that of the arches.
const ARCH_TO: f32 = 0.58;
const HEIGHTS: [f32; 4] = [0.0, 0.43, ARCH_TO, 1.0];
/// Lateral fractions of the screens and of the roof between them: a screen's last cell is the pillar.
const ACROSS: [f32; 3] = [0.0, 0.93, 1.0];

/// The body with all that lies within the label's box.
pub(super) fn body(o: &Outline, house: &Glasshouse, styling: &Styling, fittings: &Fittings) -> Surface {
    let mut surface = Surface::default();
    add_lower_body(&mut surface, o, styling);
    add_house(&mut surface, o, house);
    add_plates(&mut surface, o, fittings, false);
    add_signals(&mut surface, o, styling, &ENDS, &HEIGHTS);
    surface
}

fn add_lower_body(surface: &mut Surface, o: &Outline, styling: &Styling) {
    let columns = columns(o);
    let shell = grid(&columns, HEIGHTS, |c, v| o.point(c, v));
    let inside = Vec3::new(0.0, 0.0, 0.5 * o.d.height_m);
    surface.pair(&shell, Outward::From(inside), |i, j| {
        let (a, b) = (&columns[i], &columns[i + 1]);
        let is_arch = o.d.axles_x.iter().any(|axle| (0.5 * (a.x + b.x) - axle).abs() < o.d.arch_radius_m);
        let is_flank = a.face == Face::Side && b.face == Face::Side;
        let v = 0.5 * (HEIGHTS[j] + HEIGHTS[j + 1]);
        Some(if HEIGHTS[j + 1] <= ARCH_TO && is_arch && is_flank {
            slot::LINER
        } else {
            shell_slot(a, b, v, styling, o.d.length_m / 2.0)
        })
    });
    add_decks(surface, o, &columns, &[0.0, 1.0], |_| true);
}

/// The half ring, from the middle of the nose to the tail's.
fn columns(o: &Outline) -> Vec<Column> {
    let d = &o.d;
    let arches = d.axles_x.iter().flat_map(|axle| [axle + d.arch_radius_m, axle - d.arch_radius_m]);
    let mut xs: Vec<f32> = arches.chain([o.nose_x, o.tail_x, o.screen_foot_x, o.backlight_foot_x]).collect();
    xs.retain(|x| (o.tail_x..=o.nose_x).contains(x));
    xs.sort_by(|a, b| b.total_cmp(a));
    let side = xs.into_iter().map(|x| Column::whole(x, Face::Side));
    let nose = ENDS.iter().map(|f| o.end_column(*f, true));
    nose.chain(side).chain(ENDS.iter().rev().map(|f| o.end_column(*f, false))).collect()
}

fn add_house(surface: &mut Surface, o: &Outline, house: &Glasshouse) {
    let d = &o.d;
    let limit = |height_m: f32| (height_m / (d.height_m - d.belt_z)).min(0.91);
    let posts = house.outer_posts();
    let sides = grid(&posts, [0.0, limit(SIDE_PANES_TO_M), 1.0], |(foot, top, _), v| house.side(*foot, *top, v));
    surface.pair(&sides, Outward::From(Vec3::Z * d.belt_z), |i, j| {
        Some(if j == 0 && matches!(posts[i].2, Cell::Pane(_)) { slot::DARK_GLASS } else { slot::PAINT })
    });
    let roof = grid(house.roof_stations(&posts), ACROSS, |x, t| house.roof(x, t));
    surface.panel_pair(&roof, Outward::Along(Vec3::Z), slot::PAINT);
    for is_front in [true, false] {
        let up = [0.0, limit(if is_front { SCREEN_TO_M } else { SIDE_PANES_TO_M }), 1.0];
        let screen = grid(ACROSS, up, |t, s| house.screen(is_front, t, s));
        let is_blind = !is_front && d.windows == Windows::PanelVan;
        let outward = Outward::Along(Vec3::new(if is_front { 1.0 } else { -1.0 }, 0.0, 0.3));
        surface.pair(&screen, outward, |i, j| {
            Some(if i == 0 && j == 0 && !is_blind { slot::DARK_GLASS } else { slot::PAINT })
        });
    }
}
