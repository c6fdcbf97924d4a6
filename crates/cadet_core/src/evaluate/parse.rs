//! Label and result files: one object a line, columns separated by white space. Blank lines, tabs, CRLF, a byte order
//! mark and a missing last newline are fine, as is what follows the columns of a label; anything else that KITTI's
//! readers would misread in silence is an error.

use super::objects::{BoxImg, Detection, MIN_SCORE, ObjectType, OtherNames, Truth};
use super::rotated_iou::RotatedBox;
use super::text;
use cadet_base::error::{Error, Result};

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

/// What a file holds.
#[derive(Debug, Clone, PartialEq)]
pub struct Parsed<T> {
    /// The objects, in file order.
    pub objects: Vec<T>,
    /// The names of their types that KITTI does not have.
    pub other_names: OtherNames,
}

impl<T> Default for Parsed<T> {
    fn default() -> Self {
        Self { objects: Vec::new(), other_names: OtherNames::default() }
    }
}

/// Reads the text of a label file; `file` names it in errors.
///
/// What follows the 15 columns is passed over: a score, or what other programs note there.
///
/// # Errors
/// [`Error::Format`] with file, line and column: no text, a column too few, a type that is no name, a number that is
/// none or not finite, an occlusion that is not whole.
pub fn parse_truths(text: &[u8], file: &str) -> Result<Parsed<Truth>> {
    let mut parsed = Parsed::default();
    for line in lines(text, file)? {
        let (name, n) = line.columns::<15>(Rest::PassedOver)?;
        let (box_img, box_cam) = boxes(&n);
        let occlusion_level = n[OCCLUDED];
        if occlusion_level.fract() != 0.0 {
            return Err(line.error(OCCLUDED, format!("expected a whole number, got {occlusion_level}")));
        }
        let kind = ObjectType::from_name(name);
        parsed.other_names.count(kind, name);
        let (truncation, alpha) = (n[1], n[3]);
        parsed.objects.push(Truth { kind, truncation, occlusion_level, alpha, box_img, box_cam, is_optional: false });
    }
    Ok(parsed)
}

/// Reads the text of a result file; `file` names it in errors.
///
/// # Errors
/// [`Error::Format`] as for labels, for a column too many, and for a score of -1e7 or less, which KITTI's program would
/// not match.
pub fn parse_detections(text: &[u8], file: &str) -> Result<Parsed<Detection>> {
    let mut parsed = Parsed::default();
    for line in lines(text, file)? {
        let (name, n) = line.columns::<16>(Rest::Refused)?;
        let kind = ObjectType::from_name(name);
        parsed.other_names.count(kind, name);
        let (box_img, box_cam) = boxes(&n);
        if n[SCORE] <= MIN_SCORE {
            return Err(line.error(SCORE, format!("expected a score above {MIN_SCORE:e}, got {}", n[SCORE])));
        }
        parsed.objects.push(Detection { kind, alpha: n[3], box_img, box_cam, score: n[SCORE], is_optional: false });
    }
    Ok(parsed)
}

fn boxes(n: &[f64]) -> (BoxImg, RotatedBox) {
    let box_img = BoxImg { left_px: n[4], top_px: n[5], right_px: n[6], bottom_px: n[7] };
    (box_img, RotatedBox::from_array([n[11], n[12], n[13], n[10], n[9], n[8], n[14]]))
}

/// What becomes of what follows the columns of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rest {
    PassedOver,
    Refused,
}

struct Line<'a> {
    file: &'a str,
    number: usize,
    text: &'a str,
}

/// The lines that are not blank.
fn lines<'a>(bytes: &'a [u8], file: &'a str) -> Result<impl Iterator<Item = Line<'a>>> {
    Ok(text::lines(text::decode(bytes, file)?).map(move |(number, text)| Line { file, number, text }))
}

impl<'a> Line<'a> {
    /// The type, and the other columns at their own places.
    fn columns<const N: usize>(&self, rest: Rest) -> Result<(&'a str, [f64; N])> {
        let mut numbers = [0.0; N];
        let mut parts = self.text.split_ascii_whitespace();
        let kind = parts.next().unwrap_or_default();
        if !text::is_name(kind) {
            return Err(self.error(0, format!("expected a name such as Car, got {kind:?}{}", self.hint())));
        }
        for (column, number) in numbers.iter_mut().enumerate().skip(1) {
            let remedy = if column == SCORE { ": a result ends with its score" } else { "" };
            let count = || format!("expected {N} columns, got {column}{remedy}");
            *number = self.number(column, parts.next().ok_or_else(|| self.error(column, count()))?)?;
        }
        let num_more = if rest == Rest::PassedOver { 0 } else { parts.count() };
        if num_more > 0 {
            return Err(self.error(N, format!("expected {N} columns, got {}", N + num_more)));
        }
        Ok((kind, numbers))
    }

    /// The remedy for a line of KITTI's tracking benchmark, whose third column is the type.
    fn hint(&self) -> &'static str {
        let mut parts = self.text.split_ascii_whitespace();
        let has_ids =
            [parts.next(), parts.next()].iter().all(|part| part.is_some_and(|part| part.parse::<i64>().is_ok()));
        if has_ids && parts.next().is_some_and(text::is_name) {
            "; a line of KITTI's tracking labels? Leave out its first two columns, and give each frame a file"
        } else {
            ""
        }
    }

    fn number(&self, column: usize, part: &str) -> Result<f64> {
        match part.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(number),
            _ => Err(self.error(column, format!("expected a finite number, got {part:?}"))),
        }
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
        let truth = parse_truths(CAR.as_bytes(), "").unwrap().objects[0];
        assert_eq!(
            (truth.kind, truth.truncation, truth.occlusion_level, truth.alpha),
            (ObjectType::Car, 0.10, 1.0, 1.85)
        );
        assert_eq!(truth.box_img, BoxImg { left_px: 387.63, top_px: 181.54, right_px: 423.81, bottom_px: 203.12 });
        assert_eq!(truth.box_cam.to_array(), [-16.53, 2.39, 58.49, 3.69, 1.87, 1.67, 1.57]);
        let text = format!("{CAR} -3.5e0\n{0} 1\n{1} 1", CAR.replace("Car", "Bus"), CAR.replace("Car", "bus"));
        let found = parse_detections(text.as_bytes(), "").unwrap();
        assert_eq!((found.objects[0].score, found.objects[1].kind), (-3.5, ObjectType::from_name("BUS")));
        assert_eq!(found.other_names.iter().collect::<Vec<_>>(), [(ObjectType::from_name("bus"), "Bus", 2)]);
        assert_eq!(found.other_names.name(found.objects[2].kind), "Bus");
        assert_ne!(ObjectType::from_name("bus"), ObjectType::from_name("sub"));
    }

    #[test]
    fn any_white_space_separates() {
        let tabs = CAR.replace(' ', "\t ");
        let text = format!("\r\n{tabs}\r\n\n  {CAR}  \n\t\n{CAR}");
        let read = |text: &str| parse_truths(text.as_bytes(), "").unwrap().objects;
        assert_eq!(read(&text).len(), 3);
        assert!(read("").is_empty());
        assert_eq!(read(&CAR.to_lowercase())[0].kind, ObjectType::Car);
        for same in [format!("\u{feff}{CAR}"), format!("{CAR}\r"), CAR.replace(" 1 ", " 1.0 ")] {
            assert_eq!(read(&same), read(CAR));
        }
        assert_eq!(read(&format!("{CAR} 0.9\r{CAR} 436 2018_03_07 0002\r")), [read(CAR), read(CAR)].concat());
    }

    #[test]
    fn what_is_malformed_is_named_by_line_and_column() {
        let second = |from: &str, to: &str| refused(&format!("{CAR}\n{}\n", CAR.replace(from, to)));
        assert_eq!(second("387.63", "abc"), (2, 5, "bbox_left: expected a finite number, got \"abc\"".to_owned()));
        assert_eq!(second("3.69", "nan").1, 11);
        assert_eq!(second("58.49", "1e999").1, 14);
        assert_eq!(second("0.10 1 ", "0.10 1.5 "), (2, 3, "occluded: expected a whole number, got 1.5".to_owned()));
        assert_eq!(second(" 1.57", ""), (2, 15, "rotation_y: expected 15 columns, got 14".to_owned()));
        assert_eq!(second("Car ", ""), (2, 1, "type: expected a name such as Car, got \"0.10\"".to_owned()));
        assert!(second("Car ", "0 17 Car ").2.contains("KITTI's tracking labels? Leave out its first two columns"));
        for name in ["nan", "#Car", "b'Car'", "-inf", "Car,"] {
            assert_eq!(second("Car ", &format!("{name} ")).1, 1);
        }
        let detection = |text: String| parse_detections(text.as_bytes(), "").unwrap_err().to_string();
        assert_eq!(
            detection(format!("\n{CAR}")),
            ":2: column 16: score: expected 16 columns, got 15: a result ends with its score"
        );
        assert_eq!(detection(format!("{CAR} 1 2")), ":1: column 17: expected 16 columns, got 17");
        assert!(detection(format!("{CAR} -1e7")).contains("above -1e7"));
    }

    #[test]
    fn bytes_that_are_no_text_are_named() {
        let mut bytes = format!("{CAR}\n{CAR}").into_bytes();
        let at = bytes.len() - 3;
        bytes[at] = 0xff;
        let error = parse_truths(&bytes, "a.txt").unwrap_err().to_string();
        let reason = "is not ASCII: write plain numbers, and names in ASCII letters";
        assert_eq!(error, format!("a.txt:2: column 15: byte 0xff {reason}"));
        let wide: Vec<u8> = CAR.encode_utf16().flat_map(u16::to_le_bytes).collect();
        for bytes in [[b"\xff\xfe", wide.as_slice()].concat(), wide] {
            assert!(parse_truths(&bytes, "a.txt").unwrap_err().to_string().contains("save it as UTF-8"));
        }
    }
}
