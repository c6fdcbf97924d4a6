//! Where the lights stand: on posts beside the stop lines, over main roads on masts, at both ends of fords.

use crate::placement::Placer;
use crate::signals::{ArmId, FORD_M, JunctionArm, SignalHead, Signals};
use cadet_assets::scenery::{
    HEAD_OFF_POST_M, HeadKind, MAST_ARMS_M, MAST_HEAD_M, POST_HEAD_M, SignalPost, WALK_HEAD_M, signal_post,
};
use cadet_base::frames;
use cadet_base::math::{DVec2, DVec3};
use cadet_base::plane::{OrientedRect, heading_rad};
use cadet_base::rng::StreamKey;

/// Posts stand so far before the junction, and so far behind the curb; farther where that is still a road.
const POST_BEFORE_M: f64 = FORD_M.1 - 0.1;
const BEHIND_CURB_M: f64 = 0.45;
const ASIDE_M: [f64; 6] = [0.0, 0.4, 0.8, 1.4, 2.0, 3.0];
/// Share of the main roads with one lane a direction that have a mast.
const MAST_SHARE: f64 = 0.35;
/// Share of the heads on posts with a board behind.
const BOARD_SHARE: f64 = 0.2;
/// Half the side of what people keep off.
const POST_HALF_M: f64 = 0.09;

/// Sets up the lights of a town; returns what people keep off.
pub(crate) fn place(signals: &mut Signals, key: &StreamKey, placer: &mut Placer) -> Vec<OrientedRect> {
    let (mut heads, mut obstacles) = (Vec::new(), Vec::new());
    for (j, junction) in signals.junctions.iter().enumerate() {
        let s = &mut key.indexed("signals/posts", u64::from(junction.junction));
        for (a, arm) in junction.arms.iter().enumerate() {
            let (has_mast, has_board) = (s.chance(MAST_SHARE), s.chance(BOARD_SHARE));
            let has_mast = arm.is_main() && (has_mast || arm.lanes.len() > 1);
            let mut posts =
                Posts { placer, heads: &mut heads, obstacles: &mut obstacles, arm: ArmId { junction: j, arm: a } };
            posts.beside(arm, has_mast, has_board);
        }
    }
    signals.heads = heads;
    obstacles
}

struct Posts<'a, 'b> {
    placer: &'a mut Placer<'b>,
    heads: &'a mut Vec<SignalHead>,
    obstacles: &'a mut Vec<OrientedRect>,
    arm: ArmId,
}

impl Posts<'_, '_> {
    fn beside(&mut self, arm: &JunctionArm, has_mast: bool, has_board: bool) {
        let left = arm.along.perp();
        let right_curb = |aside_m: f64| arm.place(POST_BEFORE_M, arm.right_m - BEHIND_CURB_M - aside_m);
        if let Some((at, aside_m)) = self.free(&right_curb) {
            // The first lane's middle is at 0, so over one lane the arm ends there, over several between them.
            let reach_m = BEHIND_CURB_M + aside_m - arm.right_m + 1.5 * (arm.lanes.len() as f64 - 1.0);
            let mast = MAST_ARMS_M.iter().rposition(|m| *m <= reach_m + 0.6).filter(|_| has_mast);
            let post = mast.map_or(SignalPost::Post, SignalPost::Mast);
            let kind = if has_board { HeadKind::Backed } else { HeadKind::Vehicle };
            self.post(post, at, -arm.along);
            self.head(kind, at - arm.along * HEAD_OFF_POST_M, -arm.along, POST_HEAD_M);
            if let Some(mast) = mast {
                let end = at + left * (MAST_ARMS_M[mast] - 0.1);
                self.head(HeadKind::Backed, end - arm.along * 0.06, -arm.along, MAST_HEAD_M);
            }
            if arm.has_ford() {
                self.head(HeadKind::Walk, at + left * HEAD_OFF_POST_M, left, WALK_HEAD_M);
            }
        }
        let left_curb = |aside_m: f64| arm.place(POST_BEFORE_M, arm.left_m + BEHIND_CURB_M + aside_m);
        if let Some((at, _)) = self.free(&left_curb).filter(|_| arm.has_ford()) {
            self.post(SignalPost::Post, at, -left);
            self.head(HeadKind::Walk, at - left * HEAD_OFF_POST_M, -left, WALK_HEAD_M);
        }
    }

    /// The first place beside a curb that is not on a road, and how far aside it is.
    fn free(&self, place: &dyn Fn(f64) -> DVec2) -> Option<(DVec2, f64)> {
        ASIDE_M.into_iter().map(|aside_m| (place(aside_m), aside_m)).find(|(at, _)| !self.placer.site.is_road(*at))
    }

    fn post(&mut self, kind: SignalPost, at: DVec2, facing: DVec2) {
        let model = signal_post(kind);
        self.placer.put_plain(&model, at, facing);
        self.obstacles.push(OrientedRect { center: at, axis: facing, half: DVec2::splat(POST_HALF_M) });
    }

    fn head(&mut self, kind: HeadKind, at: DVec2, facing: DVec2, height_m: f64) {
        let foot = self.placer.site.on_ground(at);
        let world_from_head = frames::upright(foot + DVec3::Z * height_m, heading_rad(facing));
        self.heads.push(SignalHead { kind, arm: self.arm, world_from_head });
    }
}
