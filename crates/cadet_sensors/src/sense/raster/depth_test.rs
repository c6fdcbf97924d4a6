//! The depth test of a block's rows, and bits of its samples.

use super::visibility_buffer::{BLOCK, Block};

/// The bits of a row and the next, before they are shifted to the row.
pub const ROW_BITS: [u32; 2 * BLOCK] = [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2];

/// Keeps what is nearer in an even row and the next: `bits` are those of positive numbers, or 0.
///
/// Numbers are compared by their bits, which rise as positive numbers do.
#[inline(always)]
pub(super) fn keep_nearer(
    block: &mut Block,
    row: usize,
    bits: &[u32; 2 * BLOCK],
    id: u32,
    nearer: &mut [u32; 2 * BLOCK],
) {
    let (Some(inverse_depth), Some(face)) = (
        block.inverse_depth_per_m.as_flattened_mut()[row * BLOCK..].first_chunk_mut::<{ 2 * BLOCK }>(),
        block.face.as_flattened_mut()[row * BLOCK..].first_chunk_mut::<{ 2 * BLOCK }>(),
    ) else {
        return;
    };
    let old_ids = *face;
    let (mut new, mut new_ids) = ([0.0; 2 * BLOCK], [0; 2 * BLOCK]);
    for i in 0..2 * BLOCK {
        let old = inverse_depth[i].to_bits();
        let is_nearer = bits[i] > old;
        new[i] = f32::from_bits(if is_nearer { bits[i] } else { old });
        new_ids[i] = if is_nearer { id } else { old_ids[i] };
        nearer[i] |= mask(is_nearer) & (ROW_BITS[i] << row);
    }
    (*inverse_depth, *face) = (new, new_ids);
}

#[inline(always)]
pub(super) fn mask(is: bool) -> u32 {
    u32::from(is).wrapping_neg()
}

#[inline(always)]
pub(super) fn any(lanes: &[u32; 2 * BLOCK]) -> bool {
    lanes.iter().fold(0, |all, lane| all | lane) != 0
}

/// The low bytes of eight columns, of even and of odd rows, as one number: column by column. The other bytes must be 0.
#[inline(never)]
#[must_use]
pub fn bits_by_column(lanes: &[u32; 2 * BLOCK]) -> u64 {
    let mut bytes = [0; BLOCK];
    for i in 0..BLOCK {
        bytes[i] = (lanes[i] | lanes[BLOCK + i]) as u8;
    }
    u64::from_le_bytes(bytes)
}
