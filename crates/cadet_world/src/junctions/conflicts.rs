//! Which lanes across a junction can't be used at once, since they come too near to each other.

use crate::params::LEVEL_M;
use crate::params::junctions::{BENDS_RAD, BESIDE_CYCLES_M, BETWEEN_CYCLES_M, CLEARANCE_IN_BENDS_M, CLEARANCE_M};
use cadet_base::math::DVec3;
use cadet_town::{Lane, LaneId, LaneKind};

/// For each lane the lanes that can't be used with it, and how far along it they come too near.
#[derive(Debug, Default)]
pub(super) struct Conflicts(Vec<Vec<(LaneId, f64)>>);

impl Conflicts {
    pub fn of(lanes: &[Lane]) -> Self {
        let crossing: Vec<&Lane> = lanes.iter().filter(|l| is_crossed(l)).collect();
        let mut conflicts = vec![Vec::new(); lanes.len()];
        for (i, a) in crossing.iter().enumerate() {
            for b in &crossing[i + 1..] {
                // Vehicles from one lane go in turn, but a bicycle's way crosses those of the cars beside it.
                let siblings = a.kind == b.kind && a.predecessors.iter().any(|p| b.predecessors.contains(p));
                if a.junction == b.junction
                    && !siblings
                    && let (Some(until_a_m), Some(until_b_m)) = (conflict_until_m(a, b), conflict_until_m(b, a))
                {
                    conflicts[a.id.0].push((b.id, until_a_m));
                    conflicts[b.id.0].push((a.id, until_b_m));
                }
            }
        }
        Self(conflicts)
    }

    /// Lanes that can't be used together with this one, and how far along this one they come too near.
    pub fn with(&self, lane: LaneId) -> &[(LaneId, f64)] {
        &self.0[lane.0]
    }

    /// Whether two ways across a junction come too near to each other.
    pub fn cross(&self, ways: [&[LaneId]; 2]) -> bool {
        ways[0].iter().any(|lane| self.with(*lane).iter().any(|(other, _)| ways[1].contains(other)))
    }
}

fn is_crossed(lane: &Lane) -> bool {
    matches!(lane.kind, LaneKind::Driving | LaneKind::Tram | LaneKind::Biking) && lane.junction.is_some()
}

/// How far along lane `a` a car has to be before another may use lane `b`; `None` if they never come too near.
fn conflict_until_m(a: &Lane, b: &Lane) -> Option<f64> {
    let has_bend = [a, b].iter().any(|lane| lane.turn_rad().abs() > BENDS_RAD);
    let limit_m = match (a.kind, b.kind) {
        (LaneKind::Biking, LaneKind::Biking) => BETWEEN_CYCLES_M,
        (LaneKind::Biking, LaneKind::Driving) | (LaneKind::Driving, LaneKind::Biking) if has_bend => BESIDE_CYCLES_M.1,
        (LaneKind::Biking, LaneKind::Driving) | (LaneKind::Driving, LaneKind::Biking) => BESIDE_CYCLES_M.0,
        _ if has_bend => CLEARANCE_IN_BENDS_M,
        _ => CLEARANCE_M,
    };
    let near = |p: &DVec3| {
        b.center.windows(2).any(|w| {
            let (q, d) = ((*p - w[0]).truncate(), (w[1] - w[0]).truncate());
            let is_level = (p.z - w[0].z).abs() < LEVEL_M;
            is_level && (q - d * (q.dot(d) / d.length_squared()).clamp(0.0, 1.0)).length() < limit_m
        })
    };
    // Points lie at most 2 m apart, less than the limit: no crossing slips between two of them.
    let last = a.center.iter().rposition(near)?;
    Some(a.s_m.get(last + 1).copied().unwrap_or(f64::INFINITY))
}
