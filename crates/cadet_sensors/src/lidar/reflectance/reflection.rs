//! How much of a laser pulse a surface throws back to where it came from.

use cadet_base::material::LidarMaterial;
use cadet_base::math::{exp, lerp};

/// Reflectance back to the sensor at an incidence angle, as a multiple of what a white Lambertian surface that faces
/// the sensor returns.
///
/// A diffuse surface keeps its brightness towards grazing angles (Lommel and Seeliger's law: asphalt looks the same from
/// 4 m to 25 m), and so do pigments under a clear coat, of which Fresnel's share of the light gets in, and out again. A
/// coat's face or metal flakes add a lobe about the normal, F exp(-tan^2 / a^2) / (4 a^2) for Fresnel reflectance F and
/// roughness a: Cook and Torrance's model (1982) with Beckmann's distribution, seen from where the light comes from, near
/// the normal. Dust lies on every coat: it is why roofs and hoods return at all.
pub(crate) fn reflectance(lidar: &LidarMaterial, cos_incidence: f64) -> f64 {
    let rough = (1.0 + ROUGH) * cos_incidence / (cos_incidence + ROUGH);
    let below = f64::from(lidar.reflectance) * rough * through_coat(f64::from(lidar.coat_index), cos_incidence);
    let diffuse = if lidar.coat_index > 1.0 { below + dust(cos_incidence) } else { below };
    if lidar.gloss <= 0.0 {
        return diffuse;
    }
    diffuse + f64::from(lidar.gloss) * lobe(f64::from(lidar.roughness).max(SMOOTHEST), cos_incidence)
}

/// What of the light comes back through a coat, against what does at normal incidence.
fn through_coat(index: f64, cos_incidence: f64) -> f64 {
    if index <= 1.0 {
        return 1.0;
    }
    let share = (1.0 - fresnel(index, cos_incidence)) / (1.0 - fresnel(index, 1.0));
    share * share
}

/// What a layer of dust on a coat returns: a layer of optical depth t is as bright as a thick one times 1 - exp(-2 t / cos)
/// (Lommel and Seeliger's law for a thin layer), so that it is hardly seen on doors and covers roofs.
fn dust(cos_incidence: f64) -> f64 {
    DUST * (1.0 - exp(-2.0 * DUST_DEPTH / cos_incidence.max(1e-3)))
}

/// Lommel and Seeliger's term: the cosine at which a diffuse surface has lost half of its brightness. Road that is seen at
/// 1.7 degrees (60 m ahead of KITTI's car) still returns.
const ROUGH: f64 = 0.03;
/// What thick dust returns, and the optical depth of what lies on cars: fitted to how many beams KITTI's cars return by
/// height, and how deep in their boxes.
const DUST: f64 = 0.013;
const DUST_DEPTH: f64 = 0.05;
/// No painted sheet is flatter than this over the width of a beam.
const SMOOTHEST: f64 = 0.03;

fn lobe(roughness: f64, cos_incidence: f64) -> f64 {
    let (square, alpha2) = (cos_incidence * cos_incidence, roughness * roughness);
    // exp(-x) as (1 + x/8)^-8: cheap, the same bits everywhere, and with the long tail of real coats (GGX).
    let x = (1.0 - square) / (square.max(1e-6) * alpha2);
    let base = 1.0 / (1.0 + 0.125 * x);
    let falling = base * base * (base * base);
    falling * falling / (4.0 * alpha2)
}

/// Fresnel's reflectance for light without polarization of a face to what has a refractive index, from the air.
pub(super) fn fresnel(refractive_index: f64, cos_incidence: f64) -> f64 {
    let cos = cos_incidence.clamp(0.0, 1.0);
    let inside = (1.0 - (1.0 - cos * cos) / (refractive_index * refractive_index)).sqrt();
    let s = (cos - refractive_index * inside) / (cos + refractive_index * inside);
    let p = (inside - refractive_index * cos) / (inside + refractive_index * cos);
    lerp(s * s, p * p, 0.5)
}

/// The reflectance of a pane of glass: both faces, and what goes to and fro between them.
pub(crate) fn pane(cos_incidence: f64) -> f64 {
    let face = fresnel(f64::from(LidarMaterial::LACQUER_INDEX), cos_incidence);
    2.0 * face / (1.0 + face)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coat_shines_about_its_normal_alone_and_grazing_paint_is_dark() {
        let silver = LidarMaterial { coat_index: 1.5, gloss: 0.3, roughness: 0.35, ..LidarMaterial::diffuse(0.2) };
        let at = |degrees: f64| reflectance(&silver, cadet_base::math::cos(degrees.to_radians()));
        assert!((at(0.0) - (0.2 + 0.3 / (4.0 * 0.35 * 0.35) + 0.013 * 0.0952)).abs() < 1e-6, "{}", at(0.0));
        assert!(at(0.0) > 3.0 * at(30.0) && at(30.0) > at(60.0) && at(60.0) > at(80.0), "{} {}", at(30.0), at(80.0));
        // Of n = 1.5 the face lets 0.61 through at 80 degrees and 0.39 at 85, 0.96 at normal incidence.
        // The dust on it adds 1 - exp(-2 * 0.05 / cos) of what thick dust returns.
        for (degrees, through, dusty) in [(80.0, 0.61, 0.438), (85.0, 0.39, 0.683)] {
            let cos = cadet_base::math::cos(f64::to_radians(degrees));
            let bare = reflectance(&LidarMaterial::diffuse(0.2), cos);
            let coated = reflectance(&LidarMaterial { coat_index: 1.5, ..LidarMaterial::diffuse(0.2) }, cos);
            let expected = through * through / (0.96 * 0.96) + 0.013 * dusty / bare;
            assert!((coated / bare - expected).abs() < 0.01, "{} at {degrees}", coated / bare);
        }
        let black = LidarMaterial { coat_index: 1.5, ..LidarMaterial::diffuse(0.0) };
        let roof = reflectance(&black, cadet_base::math::cos(88_f64.to_radians()));
        assert!(roof > 6.0 * reflectance(&black, 1.0), "dust is seen on roofs, hardly on doors: {roof}");
        // Two faces of glass: 8 % at normal incidence, 16 % at 60 degrees, 56 % at 80.
        for (degrees, mirrored) in [(0.0, 0.077), (60.0, 0.164), (80.0, 0.558)] {
            assert!((pane(cadet_base::math::cos(f64::to_radians(degrees))) - mirrored).abs() < 0.003, "{degrees}");
        }
        let matt = LidarMaterial::diffuse(0.2);
        let cos85 = cadet_base::math::cos(85_f64.to_radians());
        assert!(reflectance(&matt, cos85) > 0.13, "asphalt at 20 m is nearly as bright as below the car");
    }
}
