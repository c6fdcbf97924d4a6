//! Poses, and the conversions between the world's, the LIDAR's and the camera's axes.

use crate::error::{Error, Result, finite};
use crate::math::{DMat3, DPose3, DQuat, DVec3};

/// The pose of a thing that stands upright at a place, turned by `yaw_rad` about z.
#[inline]
#[must_use]
pub fn upright(position: DVec3, yaw_rad: f64) -> DPose3 {
    DPose3 { rotation: DQuat::from_rotation_z(yaw_rad), translation: position }
}

/// The pose of a sensor at `position`, first rolled about its x axis (left side up), then pitched about y (nose down),
/// then turned by `yaw_rad` about z.
#[must_use]
pub fn mounted(position: DVec3, roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> DPose3 {
    let about_z = DQuat::from_rotation_z(yaw_rad);
    let rotation = about_z * DQuat::from_rotation_y(pitch_rad) * DQuat::from_rotation_x(roll_rad);
    DPose3 { rotation, translation: position }
}

/// The pose at `position` whose x axis follows `forward` and whose z axis is as near to `up` as that allows.
///
/// `forward` and `up` must not be parallel.
#[must_use]
pub fn facing(position: DVec3, forward: DVec3, up: DVec3) -> DPose3 {
    let x = forward.normalize();
    let y = up.cross(x).normalize();
    let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)));
    DPose3 { rotation, translation: position }
}

/// The pose of a 3 x 4 matrix whose rotation has only the digits of a file: it is made orthonormal again, x first.
///
/// # Errors
/// An entry that is not finite, or what is no rotation to four digits.
pub fn rigid(what: &'static str, rows: &[[f64; 4]; 3]) -> Result<DPose3> {
    for value in rows.iter().flatten() {
        let _ = finite(what, *value)?;
    }
    let column = |j: usize| DVec3::new(rows[0][j], rows[1][j], rows[2][j]);
    let given = [column(0), column(1), column(2)];
    let determinant = given[0].cross(given[1]).dot(given[2]);
    let is_orthonormal =
        (0..3).all(|i| (0..3).all(|j| (given[i].dot(given[j]) - f64::from(u8::from(i == j))).abs() < 1e-4));
    if !is_orthonormal || determinant <= 0.0 {
        let value = format!("determinant {determinant:.6}");
        return Err(Error::OutOfRange { what, value, expected: "a rotation".to_owned() });
    }
    let x = given[0].normalize();
    let y = (given[1] - x * x.dot(given[1])).normalize();
    let rotation = DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)));
    Ok(DPose3 { rotation, translation: column(3) })
}

/// The heading of a pose's x axis about the world's z, in radians.
#[inline]
#[must_use]
pub fn yaw_of(pose: &DPose3) -> f64 {
    let x = pose.rotation * DVec3::X;
    crate::math::atan2(x.y, x.x)
}

/// Turns the LIDAR's axes (x forward, y left, z up) into the camera's (x right, y down, z forward).
#[must_use]
pub fn cam_axes_from_velo_axes() -> DMat3 {
    DMat3::from_cols(DVec3::new(0.0, 0.0, 1.0), DVec3::new(-1.0, 0.0, 0.0), DVec3::new(0.0, -1.0, 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn matrices_of_files_become_poses_and_mirrors_are_refused() {
        let rows = [[0.0, -1.0, 0.0, 0.1], [0.0, 0.0, -1.0, -0.08], [1.0, 0.0, 0.0, -0.27]];
        let pose = rigid("matrix", &rows).expect("rigid");
        let ahead = pose.rotation * DVec3::new(10.0, 2.0, 1.0) + pose.translation;
        assert!((ahead - DVec3::new(-1.9, -1.08, 9.73)).length() < 1e-9, "{ahead}");
        let mut mirror = rows;
        mirror[0][1] = 1.0;
        let mut hole = rows;
        hole[2][3] = f64::NAN;
        assert!(rigid("matrix", &mirror).is_err() && rigid("matrix", &hole).is_err());
    }

    #[test]
    fn a_mounts_angles_have_the_signs_that_they_are_said_to_have() {
        let at = DVec3::new(0.3, -0.1, 1.7);
        let nose_down = mounted(at, 0.0, 0.02, 0.0);
        assert_eq!(nose_down.translation, at);
        assert!(((nose_down.rotation * DVec3::X).z + crate::math::sin(0.02)).abs() < 1e-12);
        let left_up = mounted(at, 0.02, 0.0, 0.0);
        assert!(((left_up.rotation * DVec3::Y).z - crate::math::sin(0.02)).abs() < 1e-12);
        let turned = mounted(at, 0.02, 0.03, 0.5);
        assert!((yaw_of(&turned) - 0.5).abs() < 1e-12, "roll and pitch leave the heading as it is");
        assert!(((turned.rotation * DVec3::X).z + crate::math::sin(0.03)).abs() < 1e-12);
    }
}
