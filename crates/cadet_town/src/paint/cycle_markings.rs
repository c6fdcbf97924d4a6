//! Paint on lanes for bicycles: a bicycle every so often, and a red coat over junctions.

use crate::network::{Lane, LaneKind, LaneSurface, PaintColor, PaintedQuad, RoadNetwork};
use crate::paint::Paint;
use cadet_base::math::{DVec2, DVec3, TAU};
use cadet_base::plane::unit;

/// The first bicycle of a lane, and the way from one to the next.
const FIRST_M: f64 = 9.0;
const EVERY_M: f64 = 50.0;
/// Narrower lanes have none.
const LEAST_WIDTH_M: f64 = 1.0;
/// Size on the road: how wide it is across the lane, and how much longer it is drawn along it, for who looks along.
const ACROSS_M: f64 = 0.8;
const STRETCH: f64 = 1.7;
/// Strokes of the drawing, in shares of its width; corners of a wheel.
const STROKE: f64 = 0.055;
const WHEEL_CORNERS: usize = 10;
/// The coat keeps off the lines along it, which are painted half inside.
const OFF_LINE_M: f64 = 0.14;
/// These lines have numbers of their own.
const LINES: u32 = 3 << 28;

/// Paints all lanes for bicycles of a network.
pub(crate) fn draw(network: &RoadNetwork, paint: &mut Paint) {
    for lane in network.of_kind(LaneKind::Biking) {
        match lane.junction {
            Some(_) if lane.surface == LaneSurface::Red => coat(lane, paint),
            Some(_) => {}
            None if lane.width_at(lane.length_m() / 2.0) >= LEAST_WIDTH_M => {
                let mut s_m = FIRST_M;
                while s_m + FIRST_M < lane.length_m() {
                    bicycle(lane, s_m, paint);
                    s_m += EVERY_M;
                }
            }
            None => {}
        }
    }
}

/// A strip of quadrilaterals from the lane's beginning to its end.
fn coat(lane: &Lane, paint: &mut Paint) {
    let edges = |i: usize| {
        let pose = lane.pose_at(lane.s_m[i]);
        let half_m = lane.width_m[i] / 2.0 - OFF_LINE_M;
        [half_m, -half_m].map(|m| pose.transform_point(DVec3::Y * m))
    };
    for i in 1..lane.center.len() {
        let ([a, d], [b, c]) = (edges(i - 1), edges(i));
        let line = LINES + lane.id.0 as u32;
        paint.along(&PaintedQuad { corners: [d, c, b, a], color: PaintColor::Red, line });
    }
}

/// The side view of a bicycle that rides to the left of who rides toward it, its wheels nearest to them.
fn bicycle(lane: &Lane, s_m: f64, paint: &mut Paint) {
    let pose = lane.pose_at(s_m);
    let place = |p: DVec2| pose.transform_point(DVec3::new(p.y * ACROSS_M * STRETCH, -p.x * ACROSS_M, 0.0));
    let mut stroke = |a: DVec2, b: DVec2| {
        let aside = (b - a).normalize_or_zero().perp() * (STROKE / 2.0);
        let corners = [a - aside, b - aside, b + aside, a + aside].map(place);
        paint.along(&PaintedQuad { corners, color: PaintColor::White, line: LINES + lane.id.0 as u32 });
    };
    // In shares of its width: wheels, then bottom bracket, seat, head, saddle, and handlebar.
    let (rear, front, radius) = (DVec2::new(-0.29, 0.2), DVec2::new(0.29, 0.2), 0.19);
    for hub in [rear, front] {
        let rim = |k: usize| {
            let angle = TAU * k as f64 / WHEEL_CORNERS as f64;
            hub + unit(angle) * radius
        };
        (0..WHEEL_CORNERS).for_each(|k| stroke(rim(k), rim(k + 1)));
    }
    let (bracket, seat, head) = (DVec2::new(-0.04, 0.2), DVec2::new(-0.12, 0.47), DVec2::new(0.2, 0.47));
    for (a, b) in [(rear, bracket), (bracket, seat), (seat, rear), (seat, head), (bracket, head), (front, head)] {
        stroke(a, b);
    }
    stroke(DVec2::new(-0.19, 0.52), DVec2::new(-0.05, 0.52));
    stroke(head, DVec2::new(0.17, 0.57));
    stroke(DVec2::new(0.17, 0.57), DVec2::new(0.28, 0.57));
}
