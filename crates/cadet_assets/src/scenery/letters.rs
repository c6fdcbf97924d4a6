//! Letters of five rows, for shops and boards.

use cadet_base::geometry::MeshBuilder;
use cadet_base::math::Vec3;

/// Rows of a letter, a digit, a space, or a comma from the top, the leftmost of three to five columns in the highest used bit.
pub(super) fn rows(letter: char) -> ([u8; 5], usize) {
    match letter {
        'A' => ([0b0110, 0b1001, 0b1111, 0b1001, 0b1001], 4),
        'B' => ([0b1110, 0b1001, 0b1110, 0b1001, 0b1110], 4),
        'C' => ([0b0111, 0b1000, 0b1000, 0b1000, 0b0111], 4),
        'D' => ([0b1110, 0b1001, 0b1001, 0b1001, 0b1110], 4),
        'E' => ([0b111, 0b100, 0b110, 0b100, 0b111], 3),
        'F' => ([0b111, 0b100, 0b110, 0b100, 0b100], 3),
        'G' => ([0b0111, 0b1000, 0b1011, 0b1001, 0b0111], 4),
        'H' => ([0b1001, 0b1001, 0b1111, 0b1001, 0b1001], 4),
        'I' => ([0b1, 0b1, 0b1, 0b1, 0b1], 1),
        'K' => ([0b1001, 0b1010, 0b1100, 0b1010, 0b1001], 4),
        'L' => ([0b100, 0b100, 0b100, 0b100, 0b111], 3),
        'M' => ([0b10001, 0b11011, 0b10101, 0b10001, 0b10001], 5),
        'N' => ([0b1001, 0b1101, 0b1011, 0b1001, 0b1001], 4),
        'O' => ([0b0110, 0b1001, 0b1001, 0b1001, 0b0110], 4),
        'P' => ([0b1110, 0b1001, 0b1110, 0b1000, 0b1000], 4),
        'R' => ([0b1110, 0b1001, 0b1110, 0b1010, 0b1001], 4),
        'S' => ([0b0111, 0b1000, 0b0110, 0b0001, 0b1110], 4),
        'T' => ([0b111, 0b010, 0b010, 0b010, 0b010], 3),
        'U' => ([0b1001, 0b1001, 0b1001, 0b1001, 0b0110], 4),
        'W' => ([0b10001, 0b10001, 0b10101, 0b11011, 0b10001], 5),
        '0' => ([0b111, 0b101, 0b101, 0b101, 0b111], 3),
        '1' => ([0b01, 0b11, 0b01, 0b01, 0b01], 2),
        '2' => ([0b111, 0b001, 0b111, 0b100, 0b111], 3),
        '3' => ([0b111, 0b001, 0b111, 0b001, 0b111], 3),
        '4' => ([0b101, 0b101, 0b111, 0b001, 0b001], 3),
        '5' => ([0b111, 0b100, 0b111, 0b001, 0b111], 3),
        '6' => ([0b111, 0b100, 0b111, 0b101, 0b111], 3),
        '7' => ([0b111, 0b001, 0b010, 0b010, 0b010], 3),
        '8' => ([0b111, 0b101, 0b111, 0b101, 0b111], 3),
        '9' => ([0b111, 0b101, 0b111, 0b001, 0b111], 3),
        ' ' => ([0; 5], 2),
        ',' => ([0, 0, 0, 0b1, 0b1], 1),
        _ => ([0b1111, 0b0001, 0b0110, 0b1000, 0b1111], 4),
    }
}

/// From and to which column a row is written without a gap, one pair after the other.
pub(super) fn strokes(row: u8, columns: usize) -> impl Iterator<Item = [usize; 2]> {
    let is_set = move |k: usize| k < columns && row >> (columns - 1 - k) & 1 == 1;
    let mut at = 0;
    std::iter::from_fn(move || {
        let from = (at..columns).find(|k| is_set(*k))?;
        at = (from..=columns).find(|k| !is_set(*k)).unwrap_or(columns);
        Some([from, at])
    })
}

/// Width of a word over its height.
pub(crate) fn width(word: &str) -> f32 {
    let columns: usize = word.chars().map(|c| rows(c).1 + 1).sum();
    columns.saturating_sub(1) as f32 * 0.17
}

/// Writes a word on a plane that faces +x: from `at` to the right as who looks at it sees it, `at` half way up.
pub(crate) fn write(b: &mut MeshBuilder, word: &str, at: Vec3, height_m: f32, slot: u8) {
    let (dy, dz) = (0.17 * height_m, height_m / 5.0);
    let mut left = at.y;
    for letter in word.chars() {
        let (rows, columns) = rows(letter);
        for (row, bits) in rows.into_iter().enumerate() {
            let top = at.z + height_m / 2.0 - dz * row as f32;
            for [from, to] in strokes(bits, columns) {
                let (from, to) = (left + dy * from as f32, left + dy * to as f32);
                let corner = |y: f32, z: f32| Vec3::new(at.x, y, z);
                b.quad(corner(from, top - dz), corner(to, top - dz), corner(to, top), corner(from, top), slot);
            }
        }
        left += dy * (columns + 1) as f32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strokes_are_the_runs_of_set_bits() {
        let of = |row, columns| strokes(row, columns).collect::<Vec<_>>();
        assert_eq!(of(0b1001, 4), [[0, 1], [3, 4]]);
        assert_eq!(of(0b11011, 5), [[0, 2], [3, 5]]);
        assert_eq!(of(0b0110, 4), [[1, 3]]);
        assert!(of(0, 5).is_empty());
    }
}
