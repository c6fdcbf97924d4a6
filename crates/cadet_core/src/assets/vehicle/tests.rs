use super::*;

#[test]
#[allow(clippy::print_stderr)]
fn dump() {
    let Ok(dir) = std::env::var("CADET_DUMP") else { return };
    let names = [
        "micro",
        "city",
        "small",
        "compact",
        "saloon",
        "estate",
        "mpv",
        "suv",
        "coupe",
        "high_roof",
        "small_van",
        "transporter",
        "high_van",
    ];
    for (i, name) in names.iter().enumerate() {
        let seed = i as u64 + std::env::var("CADET_SEED").map_or(0, |v| v.parse().unwrap());
        let mut s = Stream::from_seed("vehicle", seed);
        let d = Dimensions::named(name, &mut s).unwrap();
        let class = if d.is_van { ObjectClass::Van } else { ObjectClass::Car };
        let t0 = std::time::Instant::now();
        let m = VehicleModel::of_dimensions(class, seed, d, &mut s);
        let dt = t0.elapsed();
        for lod in 0..3 {
            let mut out = String::new();
            for (k, p) in m.palette.0.iter().enumerate() {
                out += &format!(
                    "m {k} {} {} {} {} {} {}\n",
                    p.albedo[0], p.albedo[1], p.albedo[2], p.transmission, p.specular, p.roughness
                );
            }
            let mut base = 0;
            let mut add = |mesh: &crate::geometry::Mesh, f: &dyn Fn(Vec3) -> Vec3, g: &dyn Fn(Vec3) -> Vec3| {
                for (v, n) in mesh.vertices.iter().zip(&mesh.normals) {
                    let (v, n) = (f(*v), g(*n));
                    out += &format!("v {} {} {} {} {} {}\n", v.x, v.y, v.z, n.x, n.y, n.z);
                }
                for (t, s) in mesh.faces.iter().zip(&mesh.slots) {
                    out += &format!("f {} {} {} {s}\n", t[0] + base, t[1] + base, t[2] + base);
                }
                base += mesh.vertices.len() as u32;
            };
            add(&m.body.levels[lod].1, &|v| v, &|v| v);
            if i % 2 == 0 {
                add(&m.driver.as_ref().unwrap().levels[lod].1, &|v| v, &|v| v);
            }
            let w = &m.wheel.levels[lod].1;
            for (k, c) in m.wheel_centers.iter().enumerate() {
                let turn = move |v: Vec3| if k % 2 == 0 { v } else { Vec3::new(-v.x, -v.y, v.z) };
                add(w, &|v| turn(v) + *c, &turn);
            }
            std::fs::write(format!("{dir}/{name}_{lod}.txt"), out).unwrap();
            eprintln!(
                "{name} lod {lod}: body {} wheel {} driver {} ({:?}) {}",
                m.body.levels[lod].1.faces.len(),
                w.faces.len(),
                m.driver.as_ref().unwrap().levels[lod].1.faces.len(),
                dt,
                m.size_lwh
            );
        }
    }
}
