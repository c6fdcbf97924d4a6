//! Paint on the road lies where the OpenDRIVE puts it, in its colors.

#![allow(clippy::unwrap_used)]

use cadet_core::geometry::Mesh;
use cadet_core::material::Semantic;
use cadet_core::math::DVec3;
use cadet_core::rng::StreamKey;
use cadet_core::town::{Ground, PaintColor, RoadNetwork, SuburbConfig, generate_suburb, load_map};

const LENGTH_M: f64 = 84.0;

/// A straight road along x with one lane of 4 m either side, and these marks on its center line.
fn road(center_marks: &str) -> RoadNetwork {
    let lane = |id: i32| {
        format!("<lane id=\"{id}\" type=\"driving\"><width sOffset=\"0\" a=\"4\" b=\"0\" c=\"0\" d=\"0\"/></lane>")
    };
    let text = format!(
        "<OpenDRIVE><header revMajor=\"1\" revMinor=\"7\"/><road id=\"1\" length=\"{LENGTH_M}\" junction=\"-1\">\
         <planView><geometry s=\"0\" x=\"0\" y=\"0\" hdg=\"0\" length=\"{LENGTH_M}\"><line/></geometry></planView>\
         <lanes><laneSection s=\"0\"><left>{}</left>\
         <center><lane id=\"0\" type=\"none\">{center_marks}</lane></center><right>{}</right></laneSection></lanes>\
         </road></OpenDRIVE>",
        lane(1),
        lane(-1)
    );
    load_map("marks.xodr", &text).unwrap()
}

fn area_m2([a, b, c, d]: [DVec3; 4]) -> f64 {
    ((b - a).cross(c - a).z + (c - a).cross(d - a).z) / 2.0
}

/// Area of the painted triangles of a ground, their albedos, and the painted stretches of x at y = `y`.
fn painted(ground: &Ground, y: f64) -> (f64, Vec<[f32; 3]>, Vec<(f64, f64)>) {
    let (mut area, mut colors, mut spans) = (0.0, Vec::new(), Vec::new());
    for tile in &ground.tiles {
        let mesh: &Mesh = &tile.shape.levels[0].1;
        for (corners, slot) in mesh.triangles() {
            let material = &tile.palette.materials()[usize::from(slot)];
            if material.semantic != Semantic::RoadMarking {
                continue;
            }
            let [a, b, c] = corners.map(|p| p.as_dvec3() + tile.world_from_local.translation);
            area += (b - a).cross(c - a).z / 2.0;
            if !colors.contains(&material.albedo) {
                colors.push(material.albedo);
            }
            let (lo, hi) = (a.min(b).min(c), a.max(b).max(c));
            if lo.y < y && y < hi.y {
                spans.push((lo.x, hi.x));
            }
        }
    }
    spans.sort_by(|p, q| p.0.total_cmp(&q.0));
    let mut joined: Vec<(f64, f64)> = Vec::new();
    for (from, to) in spans {
        match joined.last_mut() {
            Some(last) if from <= last.1 + 1e-3 => last.1 = last.1.max(to),
            _ => joined.push((from, to)),
        }
    }
    (area, colors, joined)
}

#[test]
fn a_solid_line_and_a_broken_one_cover_what_the_map_says() {
    let ground = |marks: &str| Ground::new(&road(marks)).unwrap();
    let solid = "<roadMark sOffset=\"0\" type=\"solid\" color=\"white\" width=\"0.15\"/>";
    let (area, colors, spans) = painted(&ground(solid), 0.03);
    // At both ends a piece may reach over the end of the carriageway, where it is left out.
    let expected_m2 = 0.15 * LENGTH_M;
    assert!(area < expected_m2 + 0.02 && area > expected_m2 - 2.0 * 0.75 * 0.15 - 0.02, "{area}");
    assert_eq!(colors.len(), 1);
    assert_eq!(spans.len(), 1, "{spans:?}");

    let broken = "<roadMark sOffset=\"0\" type=\"broken\" color=\"yellow\" width=\"0.12\"><type name=\"broken\" width=\"0.12\">\
                  <line length=\"4\" space=\"8\" tOffset=\"0\" sOffset=\"2\" width=\"0.12\"/></type></roadMark>";
    let (area, yellow, spans) = painted(&ground(broken), 0.03);
    let expected: Vec<(f64, f64)> = (0..7).map(|k| (2.0 + 12.0 * f64::from(k), 6.0 + 12.0 * f64::from(k))).collect();
    assert_eq!(spans.len(), expected.len(), "{spans:?}");
    for ((from, to), (a, b)) in spans.iter().zip(&expected) {
        assert!((from - a).abs() < 0.01 && (to - b).abs() < 0.01, "{spans:?}");
    }
    assert!((area - 7.0 * 4.0 * 0.12).abs() < 0.02, "{area}");
    assert!(yellow[0][2] < 0.3 * yellow[0][0] && colors[0][2] > 0.9 * colors[0][0], "{yellow:?} {colors:?}");

    let (area, ..) = painted(&ground("<roadMark sOffset=\"0\" type=\"none\" color=\"white\" width=\"0.12\"/>"), 0.03);
    assert_eq!(area, 0.0);
}

#[test]
fn a_double_line_is_two_lines_beside_the_middle() {
    let network = road("<roadMark sOffset=\"0\" type=\"solid solid\" color=\"white\" width=\"0.12\"/>");
    let ground = Ground::new(&network).unwrap();
    let [left, middle, right] = [0.12, 0.0, -0.12].map(|y| painted(&ground, y).2);
    assert_eq!((left.len(), middle.len(), right.len()), (1, 0, 1));
}

#[test]
fn center_lines_of_a_suburb_are_three_meters_of_paint_and_six_of_none() {
    let mut total_m = 0.0;
    for seed in 0..4 {
        let network = generate_suburb(&StreamKey::scene(seed), &SuburbConfig::default()).unwrap().network;
        for mark in &network.lane_marks {
            assert_eq!(mark.color, PaintColor::White);
            assert!(area_m2(mark.corners) > 0.0, "clockwise: {mark:?}");
        }
        let painted_m = network.lane_marks.iter().map(|m| area_m2(m.corners)).sum::<f64>() / 0.12;
        let fast_m: f64 = network
            .driving()
            .filter(|l| l.junction.is_none() && l.speed_limit_mps > 10.0 && 2.0 * l.width_at(0.0) > 5.5)
            .map(|l| l.length_m() / 2.0)
            .sum();
        assert!((painted_m / fast_m - 1.0 / 3.0).abs() < 0.03, "seed {seed}: {painted_m} of {fast_m}");
        total_m += painted_m;
    }
    assert!(total_m > 100.0);
}
