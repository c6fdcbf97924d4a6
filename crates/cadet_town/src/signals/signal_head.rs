//! A light of a traffic signal: which lenses are lit when.

use crate::signals::{ArmId, Aspect, Signals};
use cadet_assets::scenery::{HeadKind, signal_head};
use cadet_base::instance::Instance;
use cadet_base::math::DPose3;

/// A light.
#[derive(Debug, Clone)]
pub struct SignalHead {
    /// What it is like.
    pub kind: HeadKind,
    /// The arm that it holds.
    pub arm: ArmId,
    /// The middle of its back's bottom edge; it faces x.
    pub world_from_head: DPose3,
}

impl SignalHead {
    /// Which lenses are lit: red, yellow, green.
    #[must_use]
    pub fn lenses(&self, signals: &Signals, time_s: f64) -> [bool; 3] {
        if self.kind == HeadKind::Walk {
            let walks = signals.may_walk(self.arm, time_s);
            return [!walks, false, walks];
        }
        let junction = &signals.junctions[self.arm.junction];
        match junction.plan.aspect(junction.arms[self.arm.arm].stage, time_s) {
            Aspect::Red => [true, false, false],
            Aspect::RedYellow => [true, true, false],
            Aspect::Yellow => [false, true, false],
            Aspect::Green => [false, false, true],
        }
    }

    pub(super) fn lit(&self, signals: &Signals, time_s: f64) -> Instance {
        let (shape, palette) = signal_head(self.kind, self.lenses(signals, time_s));
        Instance::new(shape, palette, self.world_from_head, 0)
    }
}
