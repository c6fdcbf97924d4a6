//! The depth test of a block's rows, and bits of its samples.

use super::visibility_buffer::{BLOCK, Block};

/// The bits of a row and the next, before they are shifted to the row.
pub(super) const ROW_BITS: [u32; 2 * BLOCK] = [1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2];

/// Keeps what is nearer in an even row and the next: `bits` are those of positive numbers, or 0.
///
/// Numbers are compared by their bits: the compiler would make slow masked stores of a choice.
#[inline(always)]
pub(super) fn keep_nearer(
    block: &mut Block,
    row: usize,
    bits: &[u32; 2 * BLOCK],
    id: u32,
    nearer: &mut [u32; 2 * BLOCK],
) {
    let (Some(inverse_depth), Some(face)) = (
        block.inverse_depth.as_flattened_mut()[row * BLOCK..].first_chunk_mut::<{ 2 * BLOCK }>(),
        block.face.as_flattened_mut()[row * BLOCK..].first_chunk_mut::<{ 2 * BLOCK }>(),
    ) else {
        return;
    };
    // One step a loop: so the compiler takes whole registers. `map` might become a function of its own.
    let (mut old, old_ids) = ([0; 2 * BLOCK], *face);
    for i in 0..2 * BLOCK {
        old[i] = inverse_depth[i].to_bits();
    }
    let (mut is_nearer, mut new, mut new_ids) = ([0; 2 * BLOCK], [0.0; 2 * BLOCK], [0; 2 * BLOCK]);
    for i in 0..2 * BLOCK {
        is_nearer[i] = (old[i].wrapping_sub(bits[i]) as i32 >> 31) as u32;
    }
    for i in 0..2 * BLOCK {
        new[i] = f32::from_bits(if bits[i] > old[i] { bits[i] } else { old[i] });
    }
    for i in 0..2 * BLOCK {
        new_ids[i] = (id ^ old_ids[i]) & is_nearer[i] ^ old_ids[i];
    }
    for i in 0..2 * BLOCK {
        nearer[i] |= is_nearer[i] & (ROW_BITS[i] << row);
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
