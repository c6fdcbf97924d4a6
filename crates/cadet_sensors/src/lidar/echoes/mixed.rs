//! Echoes of one beam that the receiver cannot tell apart.
//!
//! Echoes that return within one pulse length of another reach the receiver as one, at their common center: a mixed point
//! between two surfaces. What lies farther apart makes echoes of its own.

use super::echo::Echo;

/// The echoes of a beam by rising range, None behind the last: what its four quarters return, together where the receiver
/// cannot tell them apart.
pub(crate) fn echoes_of(quarters: [Option<Echo>; 4], pulse_m: f64) -> [Option<Echo>; 4] {
    let mut sorted = quarters;
    sorted.sort_by(|a, b| {
        let range_m = |e: &Option<Echo>| e.map_or(f64::INFINITY, |e| e.range_m);
        range_m(a).total_cmp(&range_m(b))
    });
    let mut rest = &sorted[..sorted.iter().filter(|e| e.is_some()).count()];
    let mut echoes = [None; 4];
    for echo in &mut echoes {
        let Some(first) = rest.first().copied().flatten() else { break };
        let joined = rest.iter().flatten().take_while(|e| e.range_m - first.range_m < pulse_m).count();
        *echo = Some(merged(&rest[..joined]));
        rest = &rest[joined..];
    }
    echoes
}

/// One echo of several that arrive together, each with a quarter of the pulse: their power adds up, their range is its
/// center, and the strongest gives its name.
fn merged(quarters: &[Option<Echo>]) -> Echo {
    let raw_power = |e: &Echo| e.reflectance / (e.range_m * e.range_m);
    let echoes = || quarters.iter().flatten();
    let mut out = *echoes().next().expect("at least one echo");
    let total: f64 = echoes().map(raw_power).sum();
    for echo in echoes() {
        if raw_power(echo) > raw_power(&out) {
            out = *echo;
        }
    }
    if total > 0.0 {
        out.range_m = echoes().map(|e| raw_power(e) * e.range_m).sum::<f64>() / total;
    }
    out.retro = echoes().any(|e| e.retro);
    out.reflectance = 0.25 * total * out.range_m * out.range_m;
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lidar::Receiver;
    use cadet_base::material::{Pattern, Semantic};

    fn echo(range_m: f64, reflectance: f64, actor_id: i32) -> Option<Echo> {
        Some(Echo {
            range_m,
            reflectance,
            cos_incidence: 1.0,
            normal_velo: [0.0; 3],
            pattern: Pattern::Render,
            retro: false,
            actor_id,
            semantic: Semantic::Building,
        })
    }

    /// By the pulse of KITTI's sensor.
    fn echoes(quarters: [Option<Echo>; 4]) -> Vec<Echo> {
        echoes_of(quarters, Receiver::default().pulse_m()).into_iter().flatten().collect()
    }

    #[test]
    fn what_lies_apart_makes_echoes_of_its_own() {
        let (near, far) = (echo(10.0, 0.3, 1), echo(14.0, 0.3, 2));
        let ids = |quarters| echoes(quarters).iter().map(|e| e.actor_id).collect::<Vec<_>>();
        assert_eq!(ids([far, near, far, near]), [1, 2]);
        assert_eq!(ids([None, None, near, None]), [1]);
        assert!(ids([None; 4]).is_empty());
        // The share of the spot is the share of the power.
        let half = echoes([near, far, near, far])[0];
        assert!((half.range_m - 10.0).abs() < 1e-12 && (half.reflectance - 0.15).abs() < 1e-12);
    }

    #[test]
    fn echoes_within_a_pulse_mix() {
        let two = [echo(20.0, 0.4, 1), echo(20.4, 0.2, 2), echo(20.4, 0.2, 2), echo(20.0, 0.4, 1)];
        let [mixed] = echoes(two)[..] else { panic!("one") };
        let (p, q) = (0.4 / 400.0, 0.2 / (20.4 * 20.4));
        assert!((mixed.range_m - (p * 20.0 + q * 20.4) / (p + q)).abs() < 1e-12);
        assert!((mixed.reflectance / (mixed.range_m * mixed.range_m) - 0.5 * (p + q)).abs() < 1e-12);
        assert_eq!(mixed.actor_id, 1);
        // A shorter pulse tells them apart.
        let apart = echoes_of(two, Receiver { pulse_s: 2e-9, ..Receiver::default() }.pulse_m());
        assert!((apart[1].expect("two").range_m - 20.4).abs() < 1e-12 && apart[2].is_none());
    }

    #[test]
    fn a_retroreflector_draws_a_mixed_echo_to_itself() {
        // A plate's corner in a quarter of a beam before a bumper: a thousandth of the power comes from the bumper.
        let plate = echo(20.4, 900.0, 3).map(|e| Echo { retro: true, ..e });
        let bumper = echo(20.0, 0.9, 3);
        let [mixed] = echoes([bumper, bumper, bumper, plate])[..] else { panic!("one") };
        assert!((mixed.range_m - 20.4).abs() < 0.002 && mixed.retro, "{}", mixed.range_m);
    }
}
