//! Label and result files: one object a line, columns separated by white space. Blank lines, tabs, CRLF and a missing
//! last newline are fine; anything else that KITTI's readers would misread in silence is an error.

use super::objects::{BoxImg, Detection, Kind, MIN_SCORE, Truth};
use super::rotated_iou::BoxCam;
use crate::error::{Error, Result};

/// The columns of a result file; a label file has all but the last.
const COLUMNS: [&str; 16] = [
    "type",
    "truncated",
    "occluded",
    "alpha",
    "bbox_left",
    "bbox_top",
    "bbox_right",
    "bbox_bottom",
    "height",
    "width",
    "length",
    "x",
    "y",
    "z",
    "rotation_y",
    "score",
];
const OCCLUDED: usize = 2;
const SCORE: usize = 15;

/// Reads the text of a label file; `file` names it in errors.
///
/// # Errors
/// [`Error::Format`] with file, line and column: no text, a column too few or too many, a type that is a number, a
/// number that is none or not finite, an occlusion that is not a whole number.
pub fn parse_truths(text: &[u8], file: &str) -> Result<Vec<Truth>> {
    let mut truths = Vec::new();
    for line in lines(text, file)? {
        let (kind, n) = line.columns::<15>()?;
        let (box_img, box_cam) = boxes(&n);
        let occluded = line.whole(OCCLUDED)?;
        truths.push(Truth {
            kind: Kind::from_name(kind),
            truncated: n[1],
            occluded,
            alpha: n[3],
            box_img,
            box_cam,
            is_optional: false,
        });
    }
    Ok(truths)
}

/// What a result file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ParsedDetections {
    /// The detections, in file order.
    pub detections: Vec<Detection>,
    /// Type names that KITTI does not have, each once; usually none.
    pub unknown_names: Vec<String>,
}

/// Reads the text of a result file; `file` names it in errors.
///
/// # Errors
/// [`Error::Format`] as for labels, and for a score of -1e7 or less, which KITTI's program would not match.
pub fn parse_detections(text: &[u8], file: &str) -> Result<ParsedDetections> {
    let mut parsed = ParsedDetections::default();
    for line in lines(text, file)? {
        let (name, n) = line.columns::<16>()?;
        let kind = Kind::from_name(name);
        if kind == Kind::Unknown && !parsed.unknown_names.iter().any(|known| known == name) {
            parsed.unknown_names.push(name.to_owned());
        }
        let (box_img, box_cam) = boxes(&n);
        if n[SCORE] <= MIN_SCORE {
            return Err(line.error(SCORE, format!("expected a score above {MIN_SCORE:e}, got {}", n[SCORE])));
        }
        parsed.detections.push(Detection { kind, alpha: n[3], box_img, box_cam, score: n[SCORE], is_optional: false });
    }
    Ok(parsed)
}

fn boxes(n: &[f64]) -> (BoxImg, BoxCam) {
    let box_img = BoxImg { x1: n[4], y1: n[5], x2: n[6], y2: n[7] };
    (box_img, BoxCam::from_array([n[11], n[12], n[13], n[10], n[9], n[8], n[14]]))
}

struct Line<'a> {
    file: &'a str,
    number: usize,
    text: &'a str,
}

/// The lines that are not blank.
fn lines<'a>(text: &'a [u8], file: &'a str) -> Result<impl Iterator<Item = Line<'a>>> {
    let text = std::str::from_utf8(text).map_err(|error| {
        let before = &text[..error.valid_up_to()];
        let line = 1 + before.iter().filter(|&&byte| byte == b'\n').count();
        let start = before.iter().rposition(|&byte| byte == b'\n').map_or(0, |at| at + 1);
        let ends_in_column = before[start..].last().is_some_and(|byte| !byte.is_ascii_whitespace());
        let begun = before[start..].split(u8::is_ascii_whitespace).filter(|part| !part.is_empty()).count();
        Error::Format {
            file: file.to_owned(),
            line,
            column: if ends_in_column { begun } else { begun + 1 },
            reason: format!("byte 0x{:02x} is not text", text[error.valid_up_to()]),
        }
    })?;
    let numbered = text.split('\n').enumerate().map(move |(index, text)| Line { file, number: index + 1, text });
    Ok(numbered.filter(|line| !line.text.bytes().all(|byte| byte.is_ascii_whitespace())))
}

impl<'a> Line<'a> {
    /// The type, and the other columns at their own places.
    fn columns<const N: usize>(&self) -> Result<(&'a str, [f64; N])> {
        let mut numbers = [0.0; N];
        let mut kind = "";
        let mut count = 0;
        for part in self.text.split_ascii_whitespace() {
            if count == N {
                return Err(self.error(N, format!("expected {N} columns, got {}", self.count())));
            } else if count == 0 {
                kind = part;
            } else {
                numbers[count] = self.number(count, part)?;
            }
            count += 1;
        }
        if kind.parse::<f64>().is_ok() {
            return Err(self.error(0, format!("expected a name, got {kind:?}")));
        }
        if count < N {
            return Err(self.error(count, format!("expected {N} columns, got {count}")));
        }
        Ok((kind, numbers))
    }

    fn number(&self, column: usize, part: &str) -> Result<f64> {
        match part.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(column, format!("expected a finite number, got {part:?}"))),
        }
    }

    /// A column that must be written as a whole number: KITTI's program reads "0.0" as 0 and takes ".0" for the next
    /// column.
    fn whole(&self, column: usize) -> Result<f64> {
        let part = self.text.split_ascii_whitespace().nth(column).unwrap_or_default();
        match part.parse::<i32>() {
            Ok(number) => Ok(f64::from(number)),
            Err(_) => Err(self.error(column, format!("expected a whole number, got {part:?}"))),
        }
    }

    fn count(&self) -> usize {
        self.text.split_ascii_whitespace().count()
    }

    /// `column` counts from 0 here and from 1 in the error.
    fn error(&self, column: usize, reason: String) -> Error {
        let reason = COLUMNS.get(column).map_or(reason.clone(), |name| format!("{name}: {reason}"));
        Error::Format { file: self.file.to_owned(), line: self.number, column: column + 1, reason }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CAR: &str = "Car 0.10 1 1.85 387.63 181.54 423.81 203.12 1.67 1.87 3.69 -16.53 2.39 58.49 1.57";

    fn refused(text: &str) -> (usize, usize, String) {
        match parse_truths(text.as_bytes(), "000007.txt") {
            Err(Error::Format { line, column, reason, .. }) => (line, column, reason),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn columns_land_where_kitti_documents_them() {
        let truth = parse_truths(CAR.as_bytes(), "").unwrap()[0];
        assert_eq!((truth.kind, truth.truncated, truth.occluded, truth.alpha), (Kind::Car, 0.10, 1.0, 1.85));
        assert_eq!(truth.box_img, BoxImg { x1: 387.63, y1: 181.54, x2: 423.81, y2: 203.12 });
        assert_eq!(truth.box_cam.to_array(), [-16.53, 2.39, 58.49, 3.69, 1.87, 1.67, 1.57]);
        let text = format!("{CAR} -3.5e0\n{} 1", CAR.replace("Car", "Bus"));
        let found = parse_detections(text.as_bytes(), "").unwrap();
        assert_eq!((found.detections[0].score, found.detections[1].kind), (-3.5, Kind::Unknown));
        assert_eq!(found.unknown_names, ["Bus"]);
    }

    #[test]
    fn any_white_space_separates() {
        let tabs = CAR.replace(' ', "\t ");
        let text = format!("\r\n{tabs}\r\n\n  {CAR}  \n\t\n{CAR}");
        assert_eq!(parse_truths(text.as_bytes(), "").unwrap().len(), 3);
        assert!(parse_truths(b"", "").unwrap().is_empty());
        assert_eq!(parse_truths(CAR.to_lowercase().as_bytes(), "").unwrap()[0].kind, Kind::Car);
    }

    #[test]
    fn what_is_malformed_is_named_by_line_and_column() {
        let second = |from: &str, to: &str| refused(&format!("{CAR}\n{}\n", CAR.replace(from, to)));
        assert_eq!(second("387.63", "abc"), (2, 5, "bbox_left: expected a finite number, got \"abc\"".to_owned()));
        assert_eq!(second("3.69", "nan").1, 11);
        assert_eq!(second("58.49", "1e999").1, 14);
        assert_eq!(second("0.10 1 ", "0.10 1.0 "), (2, 3, "occluded: expected a whole number, got \"1.0\"".to_owned()));
        assert_eq!(second(" 1.57", ""), (2, 15, "rotation_y: expected 15 columns, got 14".to_owned()));
        assert_eq!(second("1.57", "1.57 0.9"), (2, 16, "score: expected 15 columns, got 16".to_owned()));
        assert_eq!(second("Car ", ""), (2, 1, "type: expected a name, got \"0.10\"".to_owned()));
        let detection = |text: String| parse_detections(text.as_bytes(), "").unwrap_err().to_string();
        assert_eq!(detection(format!("\n{CAR}")), ":2: column 16: score: expected 16 columns, got 15");
        assert_eq!(detection(format!("{CAR} 1 2")), ":1: column 17: expected 16 columns, got 17");
        assert!(detection(format!("{CAR} -1e7")).contains("above -1e7"));
    }

    #[test]
    fn bytes_that_are_no_text_are_named() {
        let mut bytes = format!("{CAR}\n{CAR}").into_bytes();
        let at = bytes.len() - 3;
        bytes[at] = 0xff;
        let error = parse_truths(&bytes, "a.txt").unwrap_err().to_string();
        assert_eq!(error, "a.txt:2: column 15: byte 0xff is not text");
    }
}
