//! What light and shadow have to know of a face beside its place.

/// Bits of what is known of a face.
pub struct Flags;

impl Flags {
    /// Lies on the ground, level.
    pub const GROUND: u32 = 1;
    /// Vehicles near by hide the sky: not of leaves, which are above them or few.
    pub const CONTACT: u32 = 2;
    /// Snow does not lie on it.
    pub const SHEDS_SNOW: u32 = 4;
    /// Water soaks into it.
    pub const ABSORBS: u32 = 8;
    /// Throws the light of lamps back to where it comes from.
    pub const RETRO: u32 = 16;
}
