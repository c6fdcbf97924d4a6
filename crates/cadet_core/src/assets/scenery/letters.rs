//! Letters of five rows, for shops and boards.

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
