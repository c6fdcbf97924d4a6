//! The text of label and result files, by the same rules as `cadet.kitti.text`, which reads them elsewhere.

use cadet_base::error::{Error, Result};

const MARK: &[u8] = b"\xef\xbb\xbf";
const MAX_NAME: usize = 64;

/// The text of a file: ASCII, with or without a byte order mark.
///
/// # Errors
/// [`Error::Format`] for UTF-16, and for any other byte beyond ASCII, which is named with line and column.
pub(super) fn decode<'a>(bytes: &'a [u8], file: &str) -> Result<&'a str> {
    let refusal =
        |line, column, reason: &str| Error::Format { file: file.to_owned(), line, column, reason: reason.to_owned() };
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") || bytes.contains(&0) {
        return Err(refusal(1, 1, "UTF-16, or no text: save it as UTF-8, as iconv -f UTF-16 -t UTF-8 does"));
    }
    let bytes = bytes.strip_prefix(MARK).unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) if text.is_ascii() => Ok(text),
        _ => {
            let at = bytes.iter().position(|byte| !byte.is_ascii()).unwrap_or_default();
            let before = &bytes[..at];
            let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
            let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
            let ends_in_column = before[start..].last().is_some_and(|byte| !byte.is_ascii_whitespace());
            let begun = before[start..].split(u8::is_ascii_whitespace).filter(|part| !part.is_empty()).count();
            let column = if ends_in_column { begun } else { begun + 1 };
            let reason =
                format!("byte 0x{:02x} is not ASCII: write plain numbers, and names in ASCII letters", bytes[at]);
            Err(refusal(line, column, &reason))
        }
    }
}

/// The lines that are not blank, each with its number from 1.
pub(super) fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    // Text without a newline may be an old Macintosh's. The carriage return before a newline is white space.
    let end = if text.contains('\n') { '\n' } else { '\r' };
    let numbered = text.split(end).enumerate().map(|(index, line)| (index + 1, line));
    numbered.filter(|(_, line)| !line.bytes().all(|byte| byte.is_ascii_whitespace()))
}

/// Whether a word can be a type's name: letters, digits and `_ . : / + ( ) -`, no number, and not too long.
pub(super) fn is_name(word: &str) -> bool {
    let is_first = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    word.bytes().next().is_some_and(is_first)
        && word.bytes().all(|byte| is_first(byte) || b".:/+()-".contains(&byte))
        && word.len() <= MAX_NAME
        && word.parse::<f64>().is_err()
}
