//! Turn signals: who shows which, and when they are lit.

use super::LampLight;

/// Flashes a second, 90 a minute: ECE R6 allows 60 to 120.
const FLASHES_HZ: f64 = 1.5;
/// Share of the time that a flashing lamp is lit.
const LIT_SHARE: f64 = 0.5;

/// What a vehicle's turn signals say.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum TurnSignal {
    #[default]
    Off,
    Left,
    Right,
    /// Both sides: it stands where others do not expect it.
    Hazard,
}

impl TurnSignal {
    /// The side of a number that is positive to the left.
    pub fn toward(side: f64) -> Self {
        if side > 0.0 { Self::Left } else { Self::Right }
    }

    /// Whether the lamps of the left side and of the right are lit: a function of the time and of the agent's own phase.
    pub fn lit_sides(self, agent_id: i32, light: &LampLight) -> [bool; 2] {
        let sides = match self {
            Self::Off => return [false; 2],
            Self::Left => [true, false],
            Self::Right => [false, true],
            Self::Hazard => [true; 2],
        };
        let phase = light.key.indexed("turn signals", agent_id as u64).unit();
        let is_lit = (FLASHES_HZ * light.time_s + phase).fract() < LIT_SHARE;
        sides.map(|flashes| flashes && is_lit)
    }
}
