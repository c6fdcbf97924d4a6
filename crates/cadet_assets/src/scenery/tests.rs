//! Properties of the prototypes, checked with plain ray casts.

use strum::VariantArray;

use super::draw::range;
use super::materials::{house_slot, plant_slot};
use super::tree::TreeDesign;
use super::*;
use crate::props::*;
use crate::rays::hits;
use cadet_base::math::{Vec3, cosf, sinf};
use cadet_base::rng::Stream;

fn every_model() -> Vec<SceneryModel> {
    let [houses, trees, hedges] = num_variants();
    let mut models = vec![garage(1), garage(2)];
    models.extend(HouseKind::VARIANTS.iter().flat_map(|k| (0..houses).map(|v| house(*k, v).model)));
    models.extend(TreeKind::VARIANTS.iter().flat_map(|k| (0..trees).map(|v| tree(*k, v))));
    models.extend(shipped().iter().flat_map(|p| (0..p.num_variants()).map(|v| p.model(v))));
    models.extend(
        CityKind::VARIANTS.iter().flat_map(|k| (0..NUM_CITY_HOUSES[*k as usize]).map(|v| city_house(*k, v).model)),
    );
    models.extend((0..CROP_VARIANTS).flat_map(|v| [herbs(v), maize(v)]));
    models.extend((0..hedges).map(|v| hedge(v, 1)));
    models
}

/// Casts rays from all around to the middles of buildings, up to a share of their heights: each meets a face, nearly
/// always one that looks at where the ray comes from.
pub(super) fn check_closed(
    stream_name: &str,
    models: impl Iterator<Item = SceneryModel>,
    num_rays: usize,
    height_share: f32,
) {
    let mut s = Stream::from_seed(stream_name, 0);
    let (mut num_all, mut num_backs) = (0, 0);
    for model in models {
        let half = (model.footprint_size() / 2.0).as_vec2();
        for (k, (_, mesh)) in model.shape.levels.iter().enumerate() {
            for _ in 0..num_rays {
                let aside = Vec3::new(range(&mut s, -0.3, 0.3) * half.x, range(&mut s, -0.3, 0.3) * half.y, 0.0);
                let target = aside + Vec3::Z * range(&mut s, 0.3, model.height_m as f32 * height_share);
                let angle = range(&mut s, 0.0, std::f32::consts::TAU);
                let from = target + Vec3::new(cosf(angle), sinf(angle), range(&mut s, -0.01, 0.8)) * 90.0;
                let first = hits(mesh, from, (target - from).normalize(), |_| true).first().copied();
                let hit = first.unwrap_or_else(|| panic!("{} level {k}: open from {from}", model.name));
                (num_all, num_backs) = (num_all + 1, num_backs + usize::from(!hit.is_outside));
            }
        }
    }
    // Panels lie a finger before walls, letters before boards: along the wall a ray may get behind one.
    assert!(500 * num_backs <= num_all, "{num_backs} of {num_all} rays meet the back of a face first");
}

#[test]
fn leaves_are_flat_so_that_each_is_drawn_as_one() {
    for &kind in TreeKind::VARIANTS {
        for (_, mesh) in &tree(kind, 0).shape.levels {
            let is_leaf = |slot: u8| slot != plant_slot::BARK;
            let leaves = mesh.slots().filter(|slot| is_leaf(*slot)).count();
            let pieces = mesh.clusters.iter().flat_map(|c| c.pieces.iter().map(|p| (c.faces[usize::from(p.first)], p)));
            let flat = pieces.filter(|(face, piece)| is_leaf(face.slot) && piece.is_quad()).count();
            assert!(200 * flat >= 95 * leaves, "{kind:?}: {flat} of {leaves}");
        }
    }
}

#[test]
fn every_mesh_is_sound_and_stands_in_the_ground() {
    for model in every_model() {
        for (_, mesh) in &model.shape.levels {
            let name = &model.name;
            assert!(mesh.slots().all(|s| usize::from(s) < model.palette.materials().len()), "{name}: slot");
            assert!(mesh.places().all(|v| v.is_finite()), "{name}: coordinate");
            assert!(mesh.normals().all(|n| (n.length() - 1.0).abs() < 1e-3), "{name}: normal");
            let tallest = f64::from(mesh.bounds.max.z);
            assert!(tallest <= model.height_m + 1.2 && tallest >= model.height_m * 0.7, "{name}: {tallest}");
            // Props may stand on wheels, all else is set into the ground.
            let is_prop = shipped().iter().any(|prop| name.starts_with(prop.name()));
            assert!(mesh.bounds.min.z < if is_prop { 0.09 } else { -0.05 }, "{name} floats");
            let out = model.footprint_max.max(-model.footprint_min).as_vec2().max_element() + 2.6;
            assert!(mesh.bounds.max.truncate().max_element() < out, "{name}: sticks out");
        }
        let counts: Vec<usize> = model.shape.levels.iter().map(|l| l.1.num_faces()).collect();
        assert!(counts.windows(2).all(|c| c[1] <= c[0]), "{}: {counts:?}", model.name);
        // Trees beside the ego show single leaves; the largest are those of woods and streets.
        let is_large = [TreeKind::Wood, TreeKind::Street].iter().any(|kind| model.name.starts_with(kind.as_ref()));
        assert!(counts[0] <= if is_large { 44_000 } else { 24_000 }, "{}: {counts:?}", model.name);
    }
}

#[test]
fn levels_of_detail_keep_the_silhouette() {
    for model in every_model() {
        let size = |k: usize| model.shape.levels[k].1.bounds.size();
        for k in 1..model.shape.levels.len() {
            let change = (size(k) - size(0)).abs().max_element();
            assert!(change < 0.25 * size(0).max_element() + 0.3, "{}: {} {}", model.name, size(0), size(k));
        }
    }
}

#[test]
fn windows_are_openings_with_rooms_behind() {
    for &kind in HouseKind::VARIANTS {
        let model = house(kind, 0).model;
        let mesh: &Mesh = &model.shape.levels[0].1;
        let mut panes = 0;
        for (corners, _) in mesh.triangles().filter(|(_, s)| *s == house_slot::GLASS) {
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
            let seen =
                hits(mesh, middle + normal * 0.6, -normal, |s| s != house_slot::SHUTTER && s != house_slot::FRAME);
            if seen.first().is_none_or(|h| h.slot != house_slot::GLASS) {
                continue; // A downpipe, a step or a balcony before it.
            }
            panes += 1;
            let behind = seen.iter().find(|h| h.slot != house_slot::GLASS).unwrap();
            assert!([house_slot::ROOM, house_slot::CURTAIN].contains(&behind.slot), "{kind:?}: {behind:?}");
            assert!(behind.range_m - seen[0].range_m > 0.05, "{kind:?}: {seen:?}");
        }
        assert!(panes >= 10, "{kind:?}: {panes} panes");
    }
}

#[test]
fn windows_keep_their_panes_nets_and_frames_at_every_level() {
    let area_m2 = |mesh: &Mesh, wanted: &[u8]| -> f32 {
        let faces = mesh.triangles().filter(|(_, slot)| wanted.contains(slot));
        faces.map(|([a, b, c], _)| (b - a).cross(c - a).length() / 2.0).sum()
    };
    let mut nets_m2 = 0.0;
    let variants = num_variants()[0];
    for (kind, variant) in HouseKind::VARIANTS.iter().flat_map(|k| (0..variants).map(|v| (*k, v))) {
        let model = house(kind, variant).model;
        let [near, mid, far] = [0, 1, 2].map(|k| &model.shape.levels[k].1);
        let panes_m2 = |mesh| area_m2(mesh, &[house_slot::GLASS, house_slot::DARK_GLASS, house_slot::NET_GLASS]);
        for (level, mesh) in [("middle", mid), ("far", far)] {
            let ratio = panes_m2(mesh) / panes_m2(near);
            assert!((0.88..1.02).contains(&ratio), "{}, {level}: {ratio} of the panes", model.name);
        }
        let [mid_m2, far_m2] = [mid, far].map(|mesh| area_m2(mesh, &[house_slot::NET_GLASS]));
        assert!((mid_m2 - far_m2).abs() < 0.01, "{}: nets of {mid_m2} and {far_m2} m²", model.name);
        assert!(mid_m2 <= area_m2(near, &[house_slot::CURTAIN]) + 0.01, "{}: nets before nothing", model.name);
        assert!(area_m2(far, &[house_slot::FRAME]) > panes_m2(far), "{}: frames behind all far panes", model.name);
        nets_m2 += far_m2;
    }
    assert!(nets_m2 > 10.0, "{nets_m2} m² of nets");
}

#[test]
fn house_walls_have_no_holes_but_windows() {
    let mut s = Stream::from_seed("walls", 0);
    for &kind in HouseKind::VARIANTS {
        let model = house(kind, 1).model;
        for level in &model.shape.levels {
            let mesh = &level.1;
            for _ in 0..150 {
                let y = (s.range(-0.49, 0.49) * model.footprint_size().y) as f32;
                let z = s.range(0.05, 0.5 * model.height_m) as f32;
                assert!(!hits(mesh, Vec3::new(40.0, y, z), -Vec3::X, |_| true).is_empty(), "{kind:?} at {y} {z}");
            }
        }
    }
}

#[test]
fn crowns_let_a_third_to_a_half_of_the_beams_through_a_meter() {
    for kind in [TreeKind::Street, TreeKind::Garden, TreeKind::Wood] {
        for (detail, level) in [(0, "finest"), (1, "next"), (2, "third")] {
            let (mut open, mut all) = (0_usize, 0_usize);
            for variant in 0..4 {
                let design = TreeDesign::new(kind, variant);
                let model = tree(kind, variant);
                let mesh = &model.shape.levels[detail].1;
                let mut s = Stream::from_seed("beams", variant as u64);
                for _ in 0..250 {
                    let blob = design.blobs[s.below(design.blobs.len())];
                    let p = blob.center + draw::direction(&mut s) * (blob.radius_m * 0.75 * s.unit() as f32);
                    let d = draw::direction(&mut s);
                    let near = hits(mesh, p - d * 0.5, d, |slot| slot != plant_slot::BARK);
                    open += usize::from(near.first().is_none_or(|h| h.range_m > 1.0));
                    all += 1;
                }
            }
            let gap = open as f64 / all as f64;
            assert!((0.25..0.6).contains(&gap), "{kind:?} {level}: gap fraction {gap:.2} per meter");
        }
    }
}

#[test]
fn every_part_of_a_crown_has_its_leaves_at_every_level() {
    for kind in [TreeKind::Street, TreeKind::Garden, TreeKind::Wood] {
        for variant in 0..num_variants()[1] {
            let (design, model) = (TreeDesign::new(kind, variant), tree(kind, variant));
            for (to_m, mesh) in &model.shape.levels {
                let leaves = mesh.triangles().filter(|(_, s)| *s != plant_slot::BARK);
                let middles: Vec<Vec3> = leaves.map(|(corners, _)| corners.into_iter().sum::<Vec3>() / 3.0).collect();
                let fewest = design.blobs.iter().map(|blob| {
                    let reach = blob.radius_m * 1.1;
                    middles.iter().filter(|m| m.distance(blob.center) < reach).count()
                });
                if middles.len() < 150 {
                    continue; // The horizon's.
                }
                // A fair share would be a twentieth or more of all.
                let least = (middles.len() / 40).max(1);
                let fewest = fewest.min().unwrap();
                assert!(fewest >= least, "{kind:?} {variant} to {to_m} m: {fewest} of {}", middles.len());
            }
        }
    }
}

#[test]
fn picket_fences_have_gaps_at_every_level() {
    let model = PICKET.piece(1, 1);
    for (_, mesh) in &model.shape.levels {
        let seen = (0..960).map(|i| Vec3::new(0.0025 + 0.005 * i as f32, -2.0, 0.6));
        let open = seen.filter(|p| hits(mesh, *p, Vec3::Y, |_| true).is_empty()).count();
        assert!((0.25..0.5).contains(&(open as f64 / 960.0)), "{open} of 960");
    }
}

#[test]
fn wire_fences_stop_few_beams() {
    for variant in 0..2 {
        let model = WIRE.piece(variant, 1);
        for (_, mesh) in &model.shape.levels {
            let seen = (0..960).map(|i| Vec3::new(0.0025 + 0.005 * i as f32, -2.0, 0.001 * i as f32));
            let open = seen.filter(|p| hits(mesh, *p, Vec3::Y, |_| true).is_empty()).count();
            assert!((0.92..0.999).contains(&(open as f64 / 960.0)), "{open} of 960");
        }
    }
}

#[test]
fn signs_are_retro_reflective_and_face_the_driver() {
    let model = ZONE_SIGN.model(0);
    let mesh: &Mesh = &model.shape.levels[0].1;
    let first = hits(mesh, Vec3::new(20.0, 0.35, 2.2), -Vec3::X, |_| true)[0];
    assert!(model.palette.materials()[usize::from(first.slot)].lidar.retro);
    let behind = hits(mesh, Vec3::new(-20.0, 0.35, 2.2), Vec3::X, |_| true)[0];
    assert!(!model.palette.materials()[usize::from(behind.slot)].lidar.retro);
}

#[test]
fn backs_of_signs_are_gray_metal() {
    let signs = [ROUND_SIGN, TRIANGLE_SIGN, DIAMOND_SIGN, ZONE_SIGN, PARKING_SIGN];
    for (kind, variant) in signs.into_iter().flat_map(|kind| (0..3).map(move |variant| (kind, variant))) {
        let sign = kind.model(variant);
        for (_, mesh) in &sign.shape.levels {
            // From behind, beside the post.
            let met = hits(mesh, Vec3::new(-5.0, 0.12, 2.42), Vec3::X, |_| true);
            let first = met.first().unwrap_or_else(|| panic!("{} has no back", sign.name));
            let [r, g, b] = sign.palette.materials()[usize::from(first.slot)].albedo;
            assert!(g > 0.25 && (r - g).abs().max((b - g).abs()) < 0.05, "{}: {r} {g} {b}", sign.name);
        }
    }
}

#[test]
fn leaves_beside_the_camera_are_no_plates() {
    for &kind in TreeKind::VARIANTS {
        for variant in 0..num_variants()[1] {
            let model = tree(kind, variant);
            let mesh = model.shape.select(4.0, 1.0).expect("near enough to be drawn");
            let leaves = mesh.triangles().filter(|(_, slot)| *slot != plant_slot::BARK);
            // A card is two triangles.
            let mut sides: Vec<f32> = leaves.map(|([a, b, c], _)| (b - a).cross(c - a).length().sqrt()).collect();
            sides.sort_by(f32::total_cmp);
            let [middle, large] = [0.5, 0.99].map(|share| sides[(share * sides.len() as f64) as usize]);
            // Without the finest levels those of the largest crowns were 0.33 to 0.5 m.
            assert!(middle < 0.3 && large < 0.33, "{}: leaf cards of {middle} m, some of {large} m", model.name);
        }
    }
}
