//! How finely a tree is drawn at which distance: by how large its leaf cards look.

/// How a tree is drawn up to a distance from the ego.
#[derive(Debug, Clone, Copy)]
pub(super) struct Level {
    pub to_m: f32,
    /// Triangles of leaves, at most.
    pub leaf_triangles: f32,
    /// Cards that hang together.
    pub per_cluster: usize,
    /// Corners around the trunk.
    pub sides: usize,
    pub limbs: usize,
    /// The trunk bends.
    pub is_bent: bool,
}

/// Near levels end where the next one's cards are so many times their own width away: twelve pixels of KITTI's camera.
const NEAR_WIDTHS: f32 = 60.0;
/// Beyond [`NEAR_M`], levels end where the next one's cards are so many times their own width away: 23 pixels.
const FAR_WIDTHS: f32 = 32.0;
/// Beyond this the eye sees a crown rather than its leaves, and a LIDAR gets hardly an echo from it, meters.
const NEAR_M: f32 = 80.0;
/// No crown has fewer triangles.
const FEWEST: f32 = 40.0;

/// A shrub's levels.
pub(super) fn of_shrub() -> Vec<Level> {
    let levels = [(25.0, 900.0, 10), (55.0, 200.0, 4), (160.0, 20.0, 1)].map(|(to_m, leaf_triangles, per_cluster)| {
        Level { to_m, leaf_triangles, per_cluster, sides: 3, limbs: 0, is_bent: false }
    });
    levels.to_vec()
}

/// The levels of a tree with `most` triangles of leaves at most, each with half as many as the one before.
///
/// `card_width_m`: how large cards look if there are so many triangles.
pub(super) fn of_tree(most: f32, card_width_m: impl Fn(f32) -> f32) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    let mut leaves = most;
    while leaves >= FEWEST {
        let coarser = leaves / 2.0;
        let width_m = card_width_m(coarser);
        let to_m = match width_m * NEAR_WIDTHS {
            _ if coarser < FEWEST => f32::INFINITY,
            near if near < NEAR_M => near,
            _ => (width_m * FAR_WIDTHS).max(NEAR_M),
        };
        // Small crowns have no use for so many.
        let is_finer = card_width_m(leaves) < width_m;
        if is_finer && levels.last().is_none_or(|last| last.to_m < to_m) {
            levels.push(level(to_m, leaves));
        }
        leaves = coarser;
    }
    levels
}

fn level(to_m: f32, leaf_triangles: f32) -> Level {
    let (per_cluster, sides, limbs, is_bent) = match leaf_triangles {
        3000.0.. => (10, 8, 8, true),
        1500.0.. => (6, 6, 6, true),
        800.0.. => (4, 6, 5, true),
        400.0.. => (2, 5, 4, true),
        200.0.. => (1, 4, 2, true),
        _ => (1, 3, 0, false),
    };
    Level { to_m, leaf_triangles, per_cluster, sides, limbs, is_bent }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cards_look_about_as_large_where_each_level_begins() {
        // 100 and 900 m^2 of leaves; cards of 0.2 m at least.
        for area in [100.0_f32, 900.0] {
            let width_m = |leaves: f32| (2.0 * area / leaves).sqrt().max(0.2);
            let levels = of_tree(5200.0, width_m);
            assert!(levels.last().is_some_and(|last| last.to_m == f32::INFINITY && last.leaf_triangles < 2.0 * FEWEST));
            for pair in levels.windows(2) {
                let ([level, next], to_m) = ([pair[0].leaf_triangles, pair[1].leaf_triangles], pair[0].to_m);
                assert!(next <= level / 2.0 && to_m < pair[1].to_m);
                // Pixels of KITTI's camera, whose focal length is 721 of them.
                let px = 721.0 * width_m(next) / to_m;
                assert!(px < if to_m < 80.0 { 12.1 } else { 23.0 }, "{level} triangles to {to_m} m: {px} px");
            }
        }
    }

    #[test]
    fn small_crowns_have_no_more_cards_than_fit() {
        // 20 m^2 in cards of 0.2 m are 1,000 triangles: of 5,200, 2,600 and 1,300 the last is enough.
        let levels = of_tree(5200.0, |leaves| (2.0 * 20.0 / leaves).sqrt().max(0.2));
        assert_eq!(levels[0].leaf_triangles, 1300.0);
    }
}
