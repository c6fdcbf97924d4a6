//! What closed rows have on and over their sidewalks: lamps on wires, trees in pits, rows of bicycles, cafes and shops.

use crate::placement::footprint;
use crate::plots::{CityStyle, Frontage, Plot};
use crate::street_things::{Furnisher, cafes};
use cadet_assets::props::{BICYCLE, CYCLE_HOOP, TREE_PIT};
use cadet_assets::scenery::{SPAN_LENS_M, StreetLight, TreeKind, num_variants, span_lamp, tree};
use cadet_base::frames;
use cadet_base::math::DVec2;
use cadet_base::plane::{OrientedRect, heading_rad};
use cadet_base::rng::Stream;

/// Nothing stands so near to the ends of a frontage.
const CORNER_M: f64 = 5.0;
/// The widest street with lamps on wires, and how deep the wires go into the walls.
const WIDEST_STREET_M: f64 = 31.0;
const IN_WALL_M: f64 = 0.2;
/// From the curb to the middle of a trunk, and what a crown may reach beyond the wall's line: it is pruned there.
const TRUNK_M: f64 = 0.75;
const PRUNED_M: f64 = 1.2;
/// From the curb to the front wheels of bicycles in a row, and the narrowest sidewalk for them.
const CYCLES_M: f64 = 0.35;
const SIDEWALK_FOR_CYCLES_M: f64 = 3.1;
/// Share of the houses with tables before them, and of those with a shop's boards and plants.
const CAFE_SHARE: f64 = 0.16;
const SHOP_FRONT_SHARE: f64 = 0.3;

/// Furnishes one frontage; lamps hang once over a street, where there is a `light` for them.
pub(super) fn furnish(
    f: &mut Furnisher,
    frontage: &Frontage,
    style: &CityStyle,
    plots: &[&Plot],
    light: Option<StreetLight>,
    s: &mut Stream,
) {
    let length_m = frontage.length_m();
    if let (Some(spacing_m), Some(light)) = (style.lamp_every_m, light) {
        let mut at_m = s.range(6.0, 14.0);
        while at_m < length_m - 4.0 {
            hang_lamp(f, frontage, at_m, light);
            at_m += spacing_m;
        }
    }
    if let Some(spacing_m) = style.tree_every_m {
        let variant = s.below(num_variants()[1]);
        let mut at_m = s.range(CORNER_M, CORNER_M + 6.0);
        while at_m < length_m - CORNER_M {
            plant(f, frontage, at_m, variant, s);
            at_m += spacing_m * s.range(0.9, 1.1);
        }
    }
    for plot in plots.iter().filter(|p| p.house.is_some()) {
        let (has_cafe, has_cycles, has_shop_front) = (s.chance(CAFE_SHARE), s.chance(0.25), s.chance(SHOP_FRONT_SHARE));
        let Some(middle_m) = frontage.line.s_of_nearest_point(plot.front) else { continue };
        if has_cafe && (CORNER_M..length_m - CORNER_M).contains(&middle_m) {
            cafes::terrace(f, frontage, (middle_m - 0.35 * plot.length_m).max(CORNER_M), s);
        } else if has_shop_front {
            cafes::shop_front(f, frontage, middle_m + s.range(-0.35, 0.35) * plot.length_m, s);
        }
        if has_cycles {
            cycles(f, frontage, middle_m + s.range(-4.0, 2.0), s);
        }
    }
}

/// A lamp on a wire to the opposite wall, if both walls are there.
fn hang_lamp(f: &mut Furnisher, frontage: &Frontage, at_m: f64, light: StreetLight) {
    let (edge, out) = (frontage.at(at_m), frontage.out(at_m));
    let is_wall = |p: DVec2| f.placer.row_walls.iter().any(|wall| wall.contains(p, 0.0));
    let here = edge + out * 0.5;
    if !is_wall(here) {
        return;
    }
    let mut far_m = 4.0;
    while far_m < WIDEST_STREET_M && !is_wall(edge - out * far_m) {
        far_m += 0.25;
    }
    let (from, to) = (edge + out * IN_WALL_M, edge - out * (far_m + IN_WALL_M));
    let Some(model) = span_lamp((to - from).length()).filter(|_| far_m < WIDEST_STREET_M) else { return };
    // The wire is up to a meter longer: its ends must not come out of a cut corner.
    let (middle, half_m) = (from.midpoint(to), (to - from).length().ceil() / 2.0);
    if !is_wall(middle + out * half_m) || !is_wall(middle - out * half_m) {
        return;
    }
    let pose = frames::upright(f.placer.site.on_ground(middle), heading_rad(out.perp()));
    f.placer.instances.push(model.with_palette(light.on_wire(SPAN_LENS_M, &model.palette), pose));
}

/// A tree at the curb, if people and doors of cars have room beside it.
fn plant(f: &mut Furnisher, frontage: &Frontage, at_m: f64, variant: usize, s: &mut Stream) {
    let (out, sidewalk_m) = (frontage.out(at_m), frontage.sidewalk_at(at_m));
    let at = frontage.behind(at_m, TRUNK_M - sidewalk_m);
    let room_m = sidewalk_m - TRUNK_M + PRUNED_M;
    let models = (0..num_variants()[1]).map(|k| tree(TreeKind::Street, variant + k));
    let Some(model) = models.into_iter().find(|m| m.footprint_max.x <= room_m) else { return };
    let trunk = OrientedRect { center: at, axis: out, half: DVec2::splat(0.22) };
    if !(f.is_free(&trunk) && f.is_passable(&trunk) && f.parked.is_free(&trunk.grown(0.25))) {
        return;
    }
    let pit = TREE_PIT.model(0);
    if f.placer.plant_model(TreeKind::Street, &model, s, at) {
        let pose = frames::upright(f.placer.site.on_ground(at), heading_rad(out));
        f.placer.instances.push(pit.at(pose));
        f.taken.take(trunk);
        f.out.obstacles.push(trunk);
    }
}

/// A row of bicycles at the curb, most of their hoops taken.
fn cycles(f: &mut Furnisher, frontage: &Frontage, from_m: f64, s: &mut Stream) {
    let count = 3 + s.below(6);
    for k in 0..count {
        let at_m = from_m + 0.75 * k as f64;
        let has_cycle = s.chance(0.7);
        if !(CORNER_M..frontage.length_m() - CORNER_M).contains(&at_m) {
            continue;
        }
        let (along, out, sidewalk_m) = (frontage.along(at_m), frontage.out(at_m), frontage.sidewalk_at(at_m));
        if sidewalk_m < SIDEWALK_FOR_CYCLES_M {
            return;
        }
        let curb = frontage.behind(at_m, -sidewalk_m);
        for (prop, is_hoop) in [(CYCLE_HOOP, true), (BICYCLE, false)] {
            if !is_hoop && !has_cycle {
                continue;
            }
            let drawn = prop.draw(s);
            let size = drawn.model.footprint_size();
            // Hoops stand across their x axis, bicycles head along theirs.
            let (deep_m, facing) = if is_hoop { (size.y, along) } else { (size.x, -out) };
            let aside_m = if is_hoop { 0.0 } else { 0.3 };
            let at = curb + out * (CYCLES_M + deep_m.max(1.6) / 2.0) + along * aside_m;
            let rect = footprint(&drawn.model, at, facing);
            if f.is_free(&rect) && f.parked.is_free(&rect.grown(0.3)) && f.is_passable(&rect) {
                f.stand_in_the_way(&drawn, at, facing, rect);
            }
        }
    }
}
