//! What stands along the sidewalk's edge: lamps, signs, street trees, cabinets.

use crate::network::RightOfWay;
use crate::placement::Placer;
use crate::plots::{Frontage, StreetStyle};
use cadet_assets::props::{
    BOLLARD, DIAMOND_SIGN, DISTRIBUTION_CABINET, NAME_SIGN, PARKING_SIGN, POST_BOX, ROUND_SIGN, Shipped, TRIANGLE_SIGN,
    ZONE_SIGN,
};
use cadet_assets::scenery::{TreeKind, tree};
use cadet_base::math::DVec2;
use cadet_base::rng::Stream;

/// Lamps and signs stand this far inside the sidewalk's outer edge.
const POLE_INSET_M: f64 = 0.22;
/// Share of the approaches with priority that say so once more.
const PRIORITY_SIGN_SHARE: f64 = 0.55;

/// Whether a place is on a lot's bay or before a door of a closed row; elsewhere doors lie behind gardens.
fn is_before_door(placer: &Placer, style: &StreetStyle, place: DVec2, margin_m: f64) -> bool {
    let is_way = style.city.is_some() && placer.ways.iter().rev().take(400).any(|way| way.contains(place, margin_m));
    is_way || placer.is_bay(place, margin_m)
}

/// Furnishes one frontage; `right_of_way` is that of the traffic beside it at its end.
pub(crate) fn furnish(
    frontage: &Frontage,
    right_of_way: Option<RightOfWay>,
    style: &StreetStyle,
    s: &mut Stream,
    placer: &mut Placer,
) {
    let length = frontage.length_m();
    let put_pole = |placer: &mut Placer, kind: Shipped, variant: usize, at_s: f64, against_traffic: bool| {
        // On a narrow or missing sidewalk the pole goes behind its edge.
        let place = frontage.behind(at_s, if frontage.sidewalk_at(at_s) < 1.0 { 0.12 } else { -POLE_INSET_M });
        // Where streets meet at a sharp angle the edge of one may lie on the other.
        if placer.site.is_road(place) || is_before_door(placer, style, place, 0.3) {
            return;
        }
        let model = kind.model(variant);
        let facing = if against_traffic { -frontage.along(at_s) } else { -frontage.out(at_s) };
        placer.put(&model, kind.lit(style.street_light, variant, &model.palette), place, facing);
    };
    // Lamps on one side of the street: on the side whose stream says so.
    let lamps = style.lamps;
    let lit = s.chance(0.6) && style.city.is_none_or(|city| city.lamp_every_m.is_none());
    let mut at = s.range(4.0, 12.0);
    while lit && at < length - 3.0 {
        put_pole(placer, lamps.kind, lamps.variant, at, false);
        at += lamps.every_m * s.range(0.93, 1.07);
    }
    let repeats_priority = s.chance(PRIORITY_SIGN_SHARE);
    let sign = match right_of_way {
        Some(RightOfWay::Yield) => Some(TRIANGLE_SIGN),
        Some(RightOfWay::Priority) if repeats_priority => Some(DIAMOND_SIGN),
        _ => None,
    };
    if let Some(sign) = sign {
        put_pole(placer, sign, s.below(3), (length - 2.5).max(length / 2.0), true);
    }
    if length > 25.0 {
        let fast = frontage.speed_limit_mps > 10.0;
        // Aisles and campuses are no zones of 30 km/h.
        if s.chance(0.6) && frontage.speed_limit_mps > 6.0 {
            let kind = if fast { ROUND_SIGN } else { ZONE_SIGN };
            put_pole(placer, kind, s.below(3), 3.0, true);
        }
        if s.chance(0.5) {
            put_pole(placer, NAME_SIGN, 0, length - 1.2, true);
        }
        for _ in 0..s.poisson(length / 70.0) {
            let kind = [PARKING_SIGN, ROUND_SIGN, BOLLARD][s.below(3)];
            put_pole(placer, kind, s.below(6), s.range(8.0, length - 6.0), true);
        }
        for _ in 0..s.poisson(length / 110.0) {
            let kind = [DISTRIBUTION_CABINET, DISTRIBUTION_CABINET, POST_BOX][s.below(3)];
            let at = s.range(6.0, length - 6.0);
            let (out, place) = (frontage.out(at), frontage.behind(at, -0.25));
            let model = kind.model(s.below(kind.num_variants()));
            let corners = [-1.0, 0.0, 1.0].iter().flat_map(|k| [-0.45, 0.0, 0.45].map(|d| (0.7 * k, d)));
            let on_road =
                corners.into_iter().any(|(a, d)| placer.site.is_road(place + frontage.along(at) * a + out * d));
            if frontage.sidewalk_at(at) > 1.4 && !on_road && !is_before_door(placer, style, place, 0.9) {
                placer.put_plain(&model, place, -out);
            }
        }
    }
    if let Some(trees) = style.street_trees {
        let mut at = s.range(5.0, 10.0);
        while at < length - 6.0 {
            let place = frontage.behind(at, s.range(0.5, 0.9));
            let model = tree(TreeKind::Street, trees.variant + s.below(2));
            if placer.site.is_clear(place, 0.3) && !placer.is_built(place, 2.2) && !placer.is_bay(place, 0.5) {
                let _ = placer.plant_model(TreeKind::Street, &model, s, place);
            }
            at += trees.every_m * s.range(0.85, 1.2);
        }
    }
}
