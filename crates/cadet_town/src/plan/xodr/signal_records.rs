//! The traffic lights of a street plan as OpenDRIVE: signals along the streets, and the controllers of junctions.

use crate::plan::xodr::put;
use crate::plan::{StreetPlan, WhichEnd};
use cadet_base::math::{PI, wrap_angle};

/// Lights stand so far before the end of a street.
const BEFORE_END_M: f64 = 4.2;
/// Arms that lie opposite each other within this have one controller.
const FACING_RAD: f64 = 0.8;
const ENDS: [WhichEnd; 2] = [WhichEnd::Start, WhichEnd::Finish];

/// Number of a light: streets have two ends.
fn signal_id(street: usize, end: WhichEnd) -> usize {
    2 * street + end as usize + 1
}

/// The lights at the ends of a street.
pub(crate) fn write_signals(out: &mut String, plan: &StreetPlan, index: usize) {
    let street = &plan.streets[index];
    let lit: Vec<WhichEnd> = ENDS.into_iter().filter(|end| plan.has_signals[street.junctions[*end as usize]]).collect();
    if lit.is_empty() {
        return;
    }
    let length_m = street.curve.length_m();
    let half_m = street.style.half_width_m() + 0.45;
    out.push_str("<signals>\n");
    for end in lit {
        // Traffic arrives at the finish along s, on the right, and at the start against it, on the left.
        let (s, t, orientation) = match end {
            WhichEnd::Start => (BEFORE_END_M, half_m, '-'),
            WhichEnd::Finish => (length_m - BEFORE_END_M, -half_m, '+'),
        };
        put!(
            out,
            "<signal s=\"{s:.6}\" t=\"{t:.6}\" id=\"{}\" name=\"\" dynamic=\"yes\" orientation=\"{orientation}\" \
                 zOffset=\"2.25\" country=\"DE\" type=\"1000001\" subtype=\"-1\" value=\"-1\" height=\"0.9\" \
                 width=\"0.3\"/>\n",
            signal_id(index, end)
        );
    }
    out.push_str("</signals>\n");
}

/// The arms of a junction with lights: light and direction out of the junction.
fn arms(plan: &StreetPlan, junction: usize) -> Vec<(usize, f64)> {
    let mut arms = Vec::new();
    for (index, street) in plan.streets.iter().enumerate() {
        for end in ENDS.into_iter().filter(|end| street.junctions[*end as usize] == junction) {
            let heading_rad = match end {
                WhichEnd::Start => street.curve.pose_at(0.0).heading_rad,
                WhichEnd::Finish => street.curve.pose_at(street.curve.length_m()).heading_rad + PI,
            };
            arms.push((signal_id(index, end), heading_rad));
        }
    }
    arms
}

/// The lights that show the same, for each junction with lights.
fn groups(plan: &StreetPlan, junction: usize) -> Vec<Vec<usize>> {
    let mut groups: Vec<(f64, Vec<usize>)> = Vec::new();
    for (light, heading_rad) in arms(plan, junction) {
        let faces = |(other, lights): &&mut (f64, Vec<usize>)| {
            lights.len() == 1 && wrap_angle(heading_rad - *other - PI).abs() < FACING_RAD
        };
        match groups.iter_mut().find(faces) {
            Some((_, lights)) => lights.push(light),
            None => groups.push((heading_rad, vec![light])),
        }
    }
    groups.into_iter().map(|(_, lights)| lights).collect()
}

/// Numbers of the controllers of a junction: those of the junctions before it come first.
fn first_controller(plan: &StreetPlan, junction: usize) -> usize {
    (0..junction).filter(|j| plan.has_signals[*j]).map(|j| groups(plan, j).len()).sum::<usize>() + 1
}

/// All controllers.
pub(crate) fn write_controllers(out: &mut String, plan: &StreetPlan) {
    for junction in (0..plan.num_junctions).filter(|j| plan.has_signals[*j]) {
        let first = first_controller(plan, junction);
        for (k, lights) in groups(plan, junction).iter().enumerate() {
            put!(out, "<controller id=\"{}\" name=\"\" sequence=\"{k}\">", first + k);
            for light in lights {
                put!(out, "<control signalId=\"{light}\" type=\"\"/>");
            }
            out.push_str("</controller>\n");
        }
    }
}

/// The controllers of a junction, inside its element.
pub(crate) fn write_junction_controllers(out: &mut String, plan: &StreetPlan, junction: usize) {
    if !plan.has_signals[junction] {
        return;
    }
    let first = first_controller(plan, junction);
    for k in 0..groups(plan, junction).len() {
        put!(out, "<controller id=\"{}\" type=\"\" sequence=\"{k}\"/>", first + k);
    }
    out.push('\n');
}
