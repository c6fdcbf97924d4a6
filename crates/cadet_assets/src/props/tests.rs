//! Every prop is sound; bad files are refused in one line.

use std::collections::BTreeMap;

use super::*;
use crate::scenery::{OVERHEAD_M, SceneryModel};
use cadet_base::geometry::Mesh;
use cadet_base::material::Pattern;
use cadet_base::math::Vec3;

/// All pieces of all props, with whether leaves are all that others see of it.
fn every_model() -> Vec<(&'static Prop, SceneryModel)> {
    let of = |prop: &'static std::sync::Arc<Prop>| {
        let pieces = (0..prop.num_variants()).flat_map(|v| (0..prop.num_pieces()).map(move |p| (v, p)));
        pieces.map(move |(variant, piece)| (&**prop, prop.piece(variant, piece)))
    };
    shipped().iter().flat_map(of).collect()
}

fn place(p: Vec3) -> [i64; 3] {
    p.to_array().map(|c| (c * 2e4).round() as i64)
}

/// The faces that are part of a solid: no panes, leaves, or sheets of signs.
fn solid_faces<'a>(model: &'a SceneryModel, mesh: &'a Mesh) -> impl Iterator<Item = [Vec3; 3]> + 'a {
    let is_solid = |slot: &u8| {
        let m = &model.palette.materials()[usize::from(*slot)];
        m.transmission == 0.0 && m.pattern != Pattern::Leaves && !m.lidar.retro
    };
    mesh.triangles().filter(move |(_, slot)| is_solid(slot)).map(|(corners, _)| corners)
}

/// Returns whether parts are no closed solids: cards in place of slats too thin to be seen as solids, and faces of boards.
fn has_cards(name: &str) -> bool {
    const CARDS: [&str; 7] = [
        "picket",
        "railing",
        "arrow-board",
        "diamond-sign",
        "motorway-board",
        "emergency-telephone",
        "kilometer-plate",
    ];
    CARDS.iter().any(|card| name.starts_with(card))
}

#[test]
fn solids_are_closed_at_every_level() {
    for (_, model) in every_model().into_iter().filter(|(prop, _)| !has_cards(prop.name())) {
        for (_, mesh) in &model.shape.levels {
            let mut passed: BTreeMap<([i64; 3], [i64; 3]), i32> = BTreeMap::new();
            for face in solid_faces(&model, mesh) {
                for k in 0..3 {
                    let (p, q) = (place(face[k]), place(face[(k + 1) % 3]));
                    *passed.entry((p.min(q), p.max(q))).or_default() += if p < q { 1 } else { -1 };
                }
            }
            let open = passed.values().filter(|n| **n != 0).count();
            assert!(open == 0, "{}: {open} open edges", model.name);
        }
    }
}

/// Each solid alone: a box that is turned inside out takes from the volume of the others.
#[test]
fn every_solid_is_turned_outwards() {
    fn root(above: &mut BTreeMap<[i64; 3], [i64; 3]>, mut p: [i64; 3]) -> [i64; 3] {
        while let Some(next) = above.get(&p).copied().filter(|next| *next != p) {
            p = next;
        }
        p
    }
    for (_, model) in every_model().into_iter().filter(|(prop, _)| !has_cards(prop.name())) {
        for (_, mesh) in &model.shape.levels {
            let mut above = BTreeMap::new();
            for face in solid_faces(&model, mesh) {
                for k in [1, 2] {
                    let (a, b) = (root(&mut above, place(face[0])), root(&mut above, place(face[k])));
                    above.insert(a.max(b), a.min(b));
                }
            }
            let mut volumes: BTreeMap<[i64; 3], f32> = BTreeMap::new();
            for face in solid_faces(&model, mesh) {
                let first = root(&mut above, place(face[0]));
                let origin = Vec3::from_array(first.map(|c| c as f32 / 2e4));
                let [a, b, c] = face.map(|p| p - origin);
                *volumes.entry(first).or_default() += a.dot(b.cross(c)) / 6.0;
            }
            assert!(volumes.values().all(|v| *v > 0.0), "{}: {volumes:?}", model.name);
        }
    }
}

#[test]
fn props_stand_on_the_ground_within_their_footprint_at_every_level() {
    for (_, model) in every_model() {
        let name = &model.name;
        let size = model.footprint_size();
        assert!(size.min_element() > 0.01 && size.max_element() < 10.0, "{name}: {size}");
        // Far leaves are large, and so are far posts and rails.
        let slack = if model.palette.materials()[0].pattern == Pattern::Leaves { 0.3 } else { 0.06 };
        for (_, mesh) in &model.shape.levels {
            assert!(mesh.places().all(|p| p.is_finite()), "{name}");
            assert!(mesh.normals().all(|n| (n.length() - 1.0).abs() < 1e-3), "{name}: normal");
            assert!(mesh.slots().all(|s| usize::from(s) < model.palette.materials().len()), "{name}: slot");
            // Bins stand on their wheels, which are not there at the far level.
            assert!(mesh.bounds.min.z < 0.09, "{name} floats at {}", mesh.bounds.min.z);
            let top = f64::from(mesh.bounds.max.z);
            assert!((top - model.height_m).abs() < slack + 0.24, "{name}: {top} of {}", model.height_m);
            let is_piece = model.footprint_min.x == 0.0;
            let is_low = |p: &Vec3| f64::from(p.z) < OVERHEAD_M && !is_piece;
            for p in mesh.places().filter(is_low) {
                let at = p.truncate().as_dvec2();
                let over = (at - model.footprint_max).max(model.footprint_min - at).max_element();
                assert!(over < slack, "{name}: {p} of {} to {}", model.footprint_min, model.footprint_max);
            }
        }
        let faces: Vec<usize> = model.shape.levels.iter().map(|l| l.1.num_faces()).collect();
        assert!(faces.windows(2).all(|f| f[1] <= f[0]) && faces[2] <= 700, "{name}: {faces:?}");
    }
}

#[test]
fn covered_cars_are_of_a_cars_size() {
    for k in 0..COVERED_CAR.num_variants() {
        let size: Vec3 = COVERED_CAR.model(k).shape.bounds.size();
        assert!((3.3..5.0).contains(&size.x) && (1.5..2.0).contains(&size.y) && (1.3..2.0).contains(&size.z), "{size}");
    }
}

#[test]
fn a_color_is_drawn_for_each_that_is_placed() {
    let s = &mut cadet_base::rng::Stream::from_seed("colors", 0);
    let colors: Vec<[f32; 3]> = (0..40).map(|_| SKIP.draw(s).palette.materials()[0].albedo).collect();
    let differ = |a: &[f32; 3], b: &[f32; 3]| a.iter().zip(b).any(|(x, y)| (x - y).abs() > 0.05);
    assert!(colors.iter().filter(|c| differ(c, &colors[0])).count() > 20, "{colors:?}");
    assert!(colors.iter().flatten().all(|c| (0.0..=0.92).contains(c)));
}

#[test]
fn seats_are_over_their_furniture() {
    for (prop, num_seats) in [(BENCH, 2), (BUS_SHELTER, 3), (CAFE_CHAIR, 1), (SKIP, 0)] {
        for variant in 0..prop.num_variants() {
            let drawn = prop.draw_variant(variant, &mut cadet_base::rng::Stream::from_seed("seats", 0));
            assert_eq!(drawn.seats.len(), num_seats, "{}", prop.name());
            for seat in drawn.seats {
                let on = seat.truncate();
                assert!((0.4..0.5).contains(&seat.z), "{seat}");
                assert!(
                    on.cmpgt(drawn.model.footprint_min).all() && on.cmplt(drawn.model.footprint_max).all(),
                    "{seat}"
                );
            }
        }
    }
}

const BIN: &str = r#"levels_m = [20, 40, 90]
variants = 2
let = ["w = range(0.4, 0.5)", "h = 1 + variant / 10"]
parts = [
    { of = "steel", block = "0.3, w, h", at = "0, 0, h / 2" },
    { of = "lid", when = "!far", mirror = "y", tube = "0, 0.1, h, 0.02; 0, 0.2, h, 0.02", sides = 6 },
]

[materials]
lid = { like = "paint", color = [0.5, 0.1, 0.1] }

[[place]]
where = "sidewalk"
every_m = 25
"#;

fn parsed(text: &str) -> cadet_base::Result<OwnProps> {
    OwnProps::parse(&[("own-bin.toml".to_owned(), text.to_owned())])
}

#[test]
fn a_users_file_is_a_prop() {
    let own = parsed(BIN).unwrap();
    let [bin] = own.props() else { panic!("{own:?}") };
    assert_eq!((bin.name(), bin.num_variants()), ("own-bin", 2));
    let (model, same) = (bin.model(1), bin.model(3));
    assert_eq!((model.name.as_str(), &same.name), ("own-bin/1", &model.name));
    // A box, and two tubes of six sides that end in a point of the far level.
    let faces: Vec<usize> = model.shape.levels.iter().map(|l| l.1.num_faces()).collect();
    assert_eq!(faces, [12 + 2 * 20, 12 + 2 * 20, 12]);
    assert!((model.height_m - 1.12).abs() < 1e-6, "{}", model.height_m);
    let width_m = model.footprint_size().y;
    assert!((0.4..0.5).contains(&width_m), "{width_m}");
    let at_sidewalks = own.placed(|place| if let Place::Sidewalk(rule) = place { Some(*rule) } else { None });
    assert!(at_sidewalks.iter().any(|(prop, rule)| prop.name() == "own-bin" && rule.every_m == 25.0));
    assert!(own == parsed(BIN).unwrap() && own != parsed(&BIN.replace("0.5,", "0.6,")).unwrap());
}

#[test]
fn a_sheet_is_seen_from_its_front_alone() {
    let (block, sheet) = (
        r#"block = "0.3, w, h", at = "0, 0, h / 2""#,
        r#"along = "i in 0..3", loft_let = "x = 0.1 * i", sheet = "x, 0.2 * j, h - 0.1 * x for j in 0..4""#,
    );
    let own = parsed(&BIN.replace(block, sheet)).unwrap();
    let model = own.props()[0].model(0);
    let mesh = model.shape.finest();
    let of_sheet: Vec<[Vec3; 3]> =
        mesh.triangles().filter(|(_, slot)| *slot == 0).map(|(corners, _)| corners).collect();
    assert_eq!(of_sheet.len(), 2 * 2 * 3);
    assert!(of_sheet.iter().all(|[a, b, c]| (*b - *a).cross(*c - *a).z > 0.0), "{of_sheet:?}");
    for (from, to, part) in [
        ("along = \"i in 0..3\", ", "", "missing key \"along\""),
        ("for j in 0..4", "for j in 0..1", "1 points, expected 2 or more"),
        ("for j in 0..4", "for j in i..4", "the same number of points for each value of along"),
    ] {
        let error = parsed(&BIN.replace(block, &sheet.replace(from, to))).expect_err(to).to_string();
        assert!(error.starts_with("own-bin.toml:5: ") && error.contains(part), "{to}: {error}");
    }
}

#[test]
fn bad_files_name_line_reason_and_remedy() {
    for (from, to, line, part) in [
        ("levels_m = [20, 40, 90]\n", "", 1, "missing key \"levels_m\""),
        ("[20, 40, 90]", "[20, 10, 90]", 1, "rising distances"),
        ("variants = 2", "variants = 0", 2, "variants: expected a number from 1 to 24"),
        ("variants = 2", "sizes = 2", 2, "unknown key \"sizes\"; known: semantic, variants, levels_m"),
        ("variants = 2", "variants = ", 2, ""),
        ("variant / 10\"", "variants / 10\"", 3, "unknown name \"variants\"; known here: variant, level"),
        ("\"w = ", "\"near = ", 3, "the name \"near\" is taken"),
        ("range(0.4, 0.5)", "rnge(0.4, 0.5)", 3, "unknown function \"rnge\"; known: sin"),
        ("\"steel\"", "\"gold\"", 5, "of: unknown material \"gold\"; known besides [materials]: "),
        ("of = \"steel\", ", "", 5, "missing key \"of\""),
        ("0.3, w, h", "0.3, w", 5, "block: expected 3 expressions with commas between, got 2"),
        ("0.3, w, h", "0.3, w, h - 1.05", 5, "a size is -0.05"),
        ("0.3, w, h", "0.3, w, h / variant", 5, "which is not finite"),
        ("h / 2\"", "99\"", 5, "99 m is farther than 60 m"),
        ("block =", "blck =", 5, "expected one of the solids: parts, block"),
        ("!far\"", "!farr\"", 6, "unknown name \"farr\""),
        ("sides = 6", "sides = 2", 6, "2 sides, expected a whole number from 3 to 96"),
        ("mirror = \"y\"", "mirror = \"z\"", 6, "mirror: unknown name \"z\"; known: x, y, xy"),
        ("mirror = \"y\"", "for = \"k in 0..9e9\"", 6, "repetitions, expected at most 200000"),
        ("mirror = \"y\"", "for = \"k in 0..9999\"", 6, "triangles, expected at most 20000"),
        ("lid = {", "lod = {", 10, "no part is made of it"),
        ("[0.5, 0.1, 0.1]", "[0.5, 0.1, 1.1]", 10, "color: expected a number from 0 to 1"),
        ("[0.5, 0.1, 0.1]", "\"rusty\"", 10, "unknown color \"rusty\"; known: "),
        ("like = \"paint\"", "lik = \"paint\"", 10, "expected color and reflectance, or like"),
        ("\"sidewalk\"", "\"roof\"", 13, "where: unknown place \"roof\"; known: sidewalk, bay, garden, yard"),
        ("every_m = 25", "every_m = 0", 14, "every_m: expected a number from 1 to 100000"),
        ("every_m = 25", "", 12, "missing key \"every_m\""),
    ] {
        assert!(BIN.contains(from), "{from}");
        let error = parsed(&BIN.replacen(from, to, 1)).expect_err(to).to_string();
        assert!(error.starts_with(&format!("own-bin.toml:{line}: ")) && error.contains(part), "{to}: {error}");
        assert!(!error.contains('\n'), "{error}");
    }
    let named =
        |file: &str, text: &str| OwnProps::parse(&[(file.to_owned(), text.to_owned())]).unwrap_err().to_string();
    assert!(named("skip.toml", BIN).contains("there is a prop of this name already; rename the file"));
    assert!(named("Own Bin.toml", BIN).contains("small letters"));
    let (shape, _) = BIN.split_once("[[place]]").unwrap();
    assert!(named("own-bin.toml", shape).contains("add a [[place]]"));
}

/// Damaged files are refused or drawn, whatever was done to them.
#[test]
fn damaged_files_do_no_harm() {
    let texts: Vec<&str> = FILES.iter().map(|(_, _, text)| *text).chain([BIN]).collect();
    let s = &mut cadet_base::rng::Stream::from_seed("damage", 0);
    let (mut num_bad, mut num_good) = (0, 0);
    for _ in 0..300 {
        let mut text: Vec<char> = texts[s.below(texts.len())].chars().collect();
        for _ in 0..1 + s.below(3) {
            let (at, other) = (s.below(text.len()), s.below(text.len()));
            match s.below(4) {
                0 => drop(text.remove(at)),
                1 => text[at] = text[other],
                2 => text.insert(at, text[other]),
                _ => {
                    let end = (at + s.below(40)).min(text.len());
                    text.drain(at..end);
                }
            }
        }
        match parsed(&text.into_iter().collect::<String>()) {
            Ok(_) => num_good += 1,
            Err(error) => {
                num_bad += 1;
                let line = error.to_string();
                assert!(line.starts_with("own-bin.toml:") && !line.contains('\n'), "{line}");
            }
        }
    }
    assert!(num_bad > 100 && num_good > 3, "{num_bad} bad, {num_good} good");
}
