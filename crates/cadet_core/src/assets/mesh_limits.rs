//! What a user's mesh may hold: refused before the OBJ reader, which stops on some of it, or before it takes minutes.

use std::collections::HashMap;

use crate::math::Vec3;

/// The most triangles of a mesh.
const MAX_TRIANGLES: usize = 2_000_000;
/// The most triangles that meet in one place: normals are made from all pairs of those.
const MAX_TRIANGLES_IN_A_PLACE: usize = 1_000;

/// Refuses a color of a material library that is not three numbers.
///
/// # Errors
/// The line and what is wrong there.
pub(super) fn check_library(text: &str) -> Result<(), String> {
    for (number, line) in (1..).zip(text.lines()) {
        let mut words = line.split_whitespace();
        let Some(key) = words.next().filter(|key| ["Ka", "Kd", "Ks", "Ke"].contains(key)) else { continue };
        let values: Vec<&str> = words.take(3).collect();
        if values.len() < 3 || values.iter().any(|value| value.parse::<f32>().is_err()) {
            let shown: String = values.join(" ").chars().take(40).collect();
            return Err(format!("line {number}: {key}: expected three numbers, got {shown:?}"));
        }
    }
    Ok(())
}

/// Refuses more triangles than a mesh may have, or more in one place.
///
/// # Errors
/// The number and its limit.
pub(super) fn check_triangles(triangles: &[([Vec3; 3], usize)]) -> Result<(), String> {
    if triangles.len() > MAX_TRIANGLES {
        return Err(format!("{} triangles, at most {MAX_TRIANGLES}", triangles.len()));
    }
    // Looked up and never walked through, so its order does not matter.
    let mut in_place: HashMap<[u32; 3], usize> = HashMap::new();
    for corner in triangles.iter().flat_map(|(corners, _)| corners) {
        // Adding zero makes -0 a 0.
        let count = in_place.entry(corner.to_array().map(|v| (v + 0.0).to_bits())).or_default();
        *count += 1;
        if *count > MAX_TRIANGLES_IN_A_PLACE {
            let [x, y, z] = corner.to_array();
            return Err(format!("more than {MAX_TRIANGLES_IN_A_PLACE} triangles meet in one place, ({x}, {y}, {z})"));
        }
    }
    Ok(())
}
