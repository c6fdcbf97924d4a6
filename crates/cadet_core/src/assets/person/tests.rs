use super::*;

#[test]
#[allow(clippy::print_stderr)]
fn dump() {
    let Ok(dir) = std::env::var("CADET_DUMP") else { return };
    let first: u64 = std::env::var("CADET_SEED").map_or(0, |v| v.parse().unwrap());
    for seed in first..first + 8 {
        let t0 = std::time::Instant::now();
        let m = PersonModel::generate(seed);
        let t1 = std::time::Instant::now();
        for q in 0..6 {
            let shape = m.pose(f64::from(q) / 6.0);
            for lod in 0..3 {
                let mut out = String::new();
                for (k, p) in m.palette.0.iter().enumerate() {
                    out += &format!(
                        "m {k} {} {} {} {} {} {}\n",
                        p.albedo[0], p.albedo[1], p.albedo[2], p.transmission, p.specular, p.roughness
                    );
                }
                let mesh = &shape.levels[lod].1;
                for (v, n) in mesh.vertices.iter().zip(&mesh.normals) {
                    out += &format!("v {} {} {} {} {} {}\n", v.x, v.y, v.z, n.x, n.y, n.z);
                }
                for (t, s) in mesh.faces.iter().zip(&mesh.slots) {
                    out += &format!("f {} {} {} {s}\n", t[0], t[1], t[2]);
                }
                std::fs::write(format!("{dir}/p{}_{q}_{lod}.txt", seed - first), out).unwrap();
            }
        }
        let faces: Vec<usize> = m.pose(0.0).levels.iter().map(|l| l.1.faces.len()).collect();
        let t2 = std::time::Instant::now();
        let _ = m.pose(0.51);
        eprintln!(
            "{} {} v {} cycle {} faces {faces:?} generate {:?} pose {:?}",
            m.name,
            m.size_lwh,
            m.walking_speed_mps,
            m.cycle_length_m,
            t1 - t0,
            t2.elapsed()
        );
    }
}
