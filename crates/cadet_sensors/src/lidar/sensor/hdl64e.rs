//! What KITTI's own HDL-64E does that another one would not: the scale of each laser's readings, and what the car hides.

use super::spec::BlindSector;

/// Where the receivers of its upper and its lower block are focused, fitted to KITTI's cars: at 5 to 12 m they return fewer
/// beams of the upper block, which scans them above a third of their height, than at 12 to 20 m. Of the lower one, which looks
/// down at the road, next to no beam is lost.
pub(super) const FOCUS_M: [f64; 2] = [20.0, 6.0];

/// Gain of each laser, from the top ring down: how the quantiles of its intensities (3 to 22 m, six KITTI frames) lie about
/// those of its neighbors. Rings 15, 21, 36 and 51 report the most zeros.
#[rustfmt::skip]
pub(super) const GAINS: [f64; 64] = [
    1.19, 0.98, 1.00, 0.67, 1.06, 0.83, 1.22, 0.93, 1.23, 0.82, 1.00, 1.20, 1.20, 1.01, 0.90, 0.77,
    0.84, 1.01, 1.11, 0.77, 1.07, 0.64, 1.02, 1.18, 0.81, 0.95, 1.05, 1.00, 1.02, 0.78, 1.08, 1.14,
    0.98, 0.98, 1.07, 0.71, 0.57, 1.05, 1.45, 1.29, 0.89, 1.00, 0.61, 1.02, 0.98, 1.01, 1.05, 0.93,
    0.81, 1.20, 1.38, 0.53, 1.02, 0.85, 0.82, 1.03, 1.09, 1.43, 0.73, 0.71, 0.69, 1.08, 1.29, 1.15,
];

/// By how much each laser measures too far, in millimeters, from the top ring down, their mean taken for 0.
///
/// By `cadet fit-lidar`'s method from 1,502 flat patches in 45 KITTI frames. The lowest lasers see nothing but road, and see it
/// too low.
#[rustfmt::skip]
pub(super) const RANGE_OFFSETS_MM: [f64; 64] = [
    2.0, -24.0, 23.0, -3.0, 0.0, -36.0, 47.0, -17.0, -32.0, 8.0, 19.0, -12.0, 23.0, 10.0, -20.0, -38.0,
    28.0, -19.0, 51.0, -18.0, -18.0, -48.0, -49.0, -47.0, 3.0, -34.0, -2.0, -57.0, 18.0, -16.0, -1.0, 0.0,
    -28.0, -22.0, -16.0, -13.0, -6.0, -52.0, 35.0, 20.0, 0.0, 36.0, -47.0, -41.0, 14.0, -44.0, -37.0, -42.0,
    2.0, 29.0, -5.0, -11.0, 25.0, 46.0, 1.0, 21.0, 28.0, 35.0, 46.0, 28.0, 17.0, 59.0, 84.0, 99.0,
];

/// (ring, from, to in degrees counter-clockwise from forward): where the car's own roof and its rig stand in the way.
///
/// In five KITTI frames of five drives no beam of these sectors returned, while the beams beside them nearly all did; the
/// sixth agrees. The returns from the car itself are nearer than the shortest range that is kept.
#[rustfmt::skip]
const CAR: [(u8, f64, f64); 104] = [
    (42, 157.8, 165.8), (42, 198.9, 206.7), (43, 154.4, 163.0), (43, 195.4, 204.0), (44, 156.7, 166.2),
    (44, 197.6, 207.1), (45, 154.1, 162.9), (45, 195.4, 203.6), (46, 157.6, 165.2), (46, 199.1, 205.9),
    (46, 297.8, 299.1), (47, 154.9, 161.2), (47, 196.7, 201.7), (47, 286.1, 294.5), (48, 159.8, 166.0),
    (48, 199.0, 204.4), (48, 286.1, 301.5), (49, 157.3, 163.2), (49, 195.6, 201.1), (49, 279.0, 296.9),
    (50, 160.8, 165.6), (50, 198.2, 203.1), (50, 283.4, 293.9), (50, 295.1, 303.5), (51, 158.1, 162.7),
    (51, 195.3, 199.3), (51, 276.0, 297.6), (52, 160.9, 165.1), (52, 169.4, 192.9), (52, 198.4, 202.4),
    (52, 281.5, 293.8), (52, 295.1, 303.1), (53, 156.4, 200.4), (53, 276.1, 297.9), (54, 160.2, 204.9),
    (54, 282.5, 305.2), (55, 126.8, 129.7), (55, 156.3, 201.8), (55, 277.8, 299.1), (56, 129.9, 136.2),
    (56, 158.6, 205.6), (56, 231.1, 236.5), (56, 282.6, 304.2), (57, 0.0, 9.9), (57, 124.9, 133.0),
    (57, 153.7, 203.7), (57, 225.1, 233.0), (57, 277.6, 296.9), (57, 349.3, 360.0), (58, 0.0, 15.4),
    (58, 128.2, 137.2), (58, 155.3, 207.9), (58, 228.7, 236.4), (58, 282.7, 303.3), (58, 346.8, 360.0),
    (59, 0.0, 13.0), (59, 13.1, 15.4), (59, 123.9, 133.2), (59, 151.3, 205.6), (59, 224.3, 233.4),
    (59, 277.2, 292.8), (59, 343.9, 360.0), (60, 0.0, 18.3), (60, 128.7, 139.0), (60, 154.5, 210.5),
    (60, 229.4, 238.6), (60, 283.9, 297.8), (60, 324.5, 327.4), (60, 331.6, 335.7), (60, 344.1, 360.0),
    (61, 0.0, 18.3), (61, 25.4, 29.3), (61, 33.3, 36.9), (61, 126.0, 134.1), (61, 136.3, 140.0), (61, 150.0, 207.7),
    (61, 225.3, 232.1), (61, 278.8, 285.7), (61, 287.0, 289.1), (61, 320.1, 325.0), (61, 327.3, 331.7),
    (61, 341.4, 360.0), (62, 0.0, 20.7), (62, 28.6, 33.0), (62, 35.5, 40.7), (62, 130.8, 138.1), (62, 139.9, 145.5),
    (62, 152.4, 212.2), (62, 222.1, 225.9), (62, 229.0, 236.2), (62, 284.6, 292.3), (62, 323.2, 328.8),
    (62, 330.4, 335.1), (62, 341.8, 360.0), (63, 0.0, 19.9), (63, 24.7, 29.3), (63, 31.1, 37.1), (63, 124.5, 142.1),
    (63, 144.5, 211.4), (63, 215.5, 221.8), (63, 223.4, 233.6), (63, 278.2, 283.1), (63, 319.7, 331.3),
    (63, 339.4, 360.0),
];

/// What KITTI's car hides from its LIDAR: a third of the 24 lowest rings, 6 % of all beams.
pub(super) fn car() -> Vec<BlindSector> {
    let sector = |(ring, from, to): (u8, f64, f64)| BlindSector {
        ring: usize::from(ring),
        from_rad: from.to_radians(),
        to_rad: to.to_radians(),
    };
    CAR.into_iter().map(sector).collect()
}

#[cfg(test)]
mod tests {
    use crate::lidar::{BlindSector, LidarSpec};

    #[test]
    fn the_car_hides_six_percent_of_the_beams_and_nothing_above_ring_42() {
        let spec = LidarSpec::hdl64e_kitti();
        spec.check().expect("valid");
        let hidden = |ring: usize| spec.blind_columns(ring).into_iter().filter(|b| *b).count();
        let share = (0..64).map(hidden).sum::<usize>() as f64 / spec.num_beams() as f64;
        assert!((0.055..0.07).contains(&share), "{share}");
        assert!((0..42).all(|ring| hidden(ring) == 0) && (42..64).all(|ring| hidden(ring) > 50));
        // In real frames the lowest ring has 1,116 returns of 2,152, whatever the street.
        assert!((950..1100).contains(&hidden(63)), "{}", hidden(63));
    }

    #[test]
    fn sectors_that_make_no_sense_are_refused() {
        for sector in [(64, 0.0, 1.0), (3, 1.0, 0.5), (3, -0.1, 1.0), (3, 0.0, 7.0), (3, 0.0, f64::NAN)] {
            let mut spec = LidarSpec::hdl64e_kitti();
            spec.blind_sectors = vec![BlindSector { ring: sector.0, from_rad: sector.1, to_rad: sector.2 }];
            assert!(spec.check().expect_err("bad").to_string().contains("blind sector"));
        }
    }
}
