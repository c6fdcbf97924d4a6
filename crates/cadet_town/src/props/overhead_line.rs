//! The overhead line of tracks: a contact wire over each, on masts between the tracks or on wires across the street.

use std::sync::Arc;

use crate::network::{Lane, RoadNetwork};
use crate::placement::Placer;
use cadet_assets::scenery::{WIRE_HEIGHT_M, contact_wire, span_wire, tram_mast};
use cadet_base::material::Palette;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::rng::StreamKey;

/// Distance between masts, and of the first from the street's end.
const SPACING_M: (f64, f64) = (30.0, 40.0);
const FROM_END_M: f64 = 4.0;
/// A wire is drawn in stretches about this long.
const STRETCH_M: f64 = 30.0;
/// Points of a contact wire: pulled over the track's middle by what holds it there.
const HELD_EVERY_M: f64 = 7.5;
/// Shares of streets with masts at the curbs, and how far their masts stand inside the sidewalk's outer edge.
const CURB_MASTS_SHARE: f64 = 0.5;
const INSET_M: f64 = 0.3;
/// Widest street that a wire spans from the middle to the mast.
const WIDEST_M: f64 = 18.0;
/// Height of a span wire at the masts, and how far it hangs lower in the middle.
const SPAN_WIRE_M: (f64, f64) = (7.4, 0.7);

/// Strings the wires of a network; an imported map's as well.
pub(crate) fn string(key: &StreamKey, network: &RoadNetwork, placer: &mut Placer) {
    let tracks: Vec<&Lane> = network.tracks().collect();
    if tracks.is_empty() {
        return;
    }
    let mut look = key.stream("overhead line");
    let (at_curbs, variant) = (look.chance(CURB_MASTS_SHARE), look.below(3));
    let palette = tram_mast(variant, 1.0).palette;
    for track in &tracks {
        wires_over(track, &palette, placer);
    }
    let streets = tracks.iter().filter(|l| l.junction.is_none());
    for track in streets {
        let other = tracks.iter().find(|o| o.road == track.road && o.id != track.id);
        if other.is_some_and(|o| o.id < track.id) {
            continue;
        }
        let mut s = key.indexed("masts", u64::from(track.road));
        let spacing_m = s.within(SPACING_M);
        let room_m = track.length_m() - 2.0 * FROM_END_M;
        let count = (room_m / spacing_m).ceil().max(1.0);
        for k in 0..=count as usize {
            let at_m = FROM_END_M + room_m.max(0.0) * k as f64 / count;
            let pose = track.pose_at(at_m);
            let along = (pose.rotation * DVec3::X).truncate().normalize_or(DVec2::X);
            let (here, left) = (pose.translation.truncate(), along.perp());
            let over = |lane: &Lane| lane.pose_at(lane.project(pose.translation).0).translation.truncate();
            let there = other.map_or(here, |o| over(o));
            let middle = (here + there) / 2.0;
            if !at_curbs || !span_street(middle, left, &palette, variant, placer) {
                let arm_m = ((there - here).length() / 2.0).max(0.4);
                // A single track has its mast beside it.
                let foot = if other.is_some() { middle } else { here + left * (track.width_at(at_m) / 2.0) };
                let mast = tram_mast(variant, if other.is_some() { arm_m } else { (foot - here).length() });
                placer.put_plain(&mast, foot, left);
            }
        }
    }
}

/// The contact wire over a track.
fn wires_over(track: &Lane, palette: &Arc<Palette>, placer: &mut Placer) {
    let count = (track.length_m() / STRETCH_M).ceil().max(1.0) as usize;
    for k in 0..count {
        let ends = [k, k + 1].map(|i| track.length_m() * i as f64 / count as f64);
        let pieces = ((ends[1] - ends[0]) / HELD_EVERY_M).ceil().max(1.0) as usize;
        let points: Vec<DVec3> = (0..=pieces)
            .map(|i| track.pose_at(ends[0] + (ends[1] - ends[0]) * i as f64 / pieces as f64).translation)
            .map(|p| placer.site.on_ground(p.truncate()) + DVec3::Z * WIRE_HEIGHT_M)
            .collect();
        placer.instances.push(contact_wire(&points, Arc::clone(palette)));
    }
}

/// Masts at both edges of the street and a wire between them; false where there is no place for them.
fn span_street(middle: DVec2, left: DVec2, palette: &Arc<Palette>, variant: usize, placer: &mut Placer) -> bool {
    let edge = |out: DVec2| {
        let steps = (0..(WIDEST_M / 0.25) as usize).map(|k| k as f64 * 0.25);
        // Beyond the sidewalk, if there is one.
        let reach = steps.into_iter().find(|m| placer.site.clearance_m(middle + out * *m) > 0.0)?;
        let foot = middle + out * (reach - INSET_M);
        (!placer.site.is_road(foot) && !placer.is_built(foot, 0.3)).then_some(foot)
    };
    let (Some(a), Some(b)) = (edge(left), edge(-left)) else { return false };
    for (foot, inwards) in [(a, -left), (b, left)] {
        let mast = tram_mast(variant, 0.0);
        placer.put_plain(&mast, foot, inwards);
    }
    let [a, b] = [a, b].map(|p| placer.site.on_ground(p) + DVec3::Z * SPAN_WIRE_M.0);
    placer.instances.push(span_wire(a, b, SPAN_WIRE_M.1, Arc::clone(palette)));
    true
}
