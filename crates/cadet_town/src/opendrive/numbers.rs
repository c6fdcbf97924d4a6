//! Looks over the numbers of an OpenDRIVE text before it is read: the reader drops what it can't build without saying
//! why, and stops on the largest numbers.

use roxmltree::{Document, Node};

use crate::opendrive::{Said, in_one_line, line_of, number, road_of};

/// Numbers of coefficients and places are at most this large.
const MAX_NUMBER: f64 = 1e9;
/// The longest road or piece of one.
const MAX_LENGTH_M: f64 = 100_000.0;
/// The widest painted line: paint goes down in pieces of the ground's size.
const MAX_PAINT_WIDTH_M: f64 = 20.0;
/// Shorter pieces of a road than this are passed over where they can't be built.
const NEGLIGIBLE_M: f64 = 0.01;

/// What shapes a piece of a road.
const SHAPES: [&str; 5] = ["line", "arc", "spiral", "poly3", "paramPoly3"];

/// The attributes of an element that are numbers, and whether they have to be there.
fn numbers_of(element: &str) -> (bool, &'static [&'static str]) {
    match element {
        "road" => (true, &["length"]),
        "geometry" => (true, &["s", "x", "y", "hdg", "length"]),
        "arc" => (true, &["curvature"]),
        "spiral" => (true, &["curvStart", "curvEnd"]),
        "paramPoly3" => (false, &["aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV"]),
        "poly3" => (false, &["a", "b", "c", "d"]),
        "elevation" | "superelevation" | "laneOffset" => (false, &["s", "a", "b", "c", "d"]),
        "shape" => (false, &["s", "t", "a", "b", "c", "d"]),
        "laneSection" => (false, &["s"]),
        "width" | "border" => (false, &["sOffset", "a", "b", "c", "d"]),
        "roadMark" | "line" => (false, &["width"]),
        _ => (false, &[]),
    }
}

/// A piece of a road, or a whole one, that the reader passes over, since it can't be built and is too short to matter.
#[derive(Debug, PartialEq)]
pub(crate) struct PassedOver {
    pub road: String,
    /// Where it begins, as the text says; `None` for a whole road, too.
    pub s_m: Option<f64>,
    pub line: usize,
    /// Why it can't be built, and how long it is.
    pub reason: String,
}

impl PassedOver {
    fn of(node: Node, s_m: Option<f64>, line: usize, reason: String) -> Self {
        Self { road: road_of(node).unwrap_or("").to_owned(), s_m, line, reason }
    }

    /// Says what was passed over, and why.
    pub fn said(self) -> Said {
        let Self { road, s_m, line, reason } = self;
        let kind = if s_m.is_some() { "piece passed over" } else { "road passed over" };
        Said { kind: kind.to_owned(), line: Some(line), text: format!("road {road}: {reason}"), road }
    }
}

/// Refuses a map in which a number that shapes a road or its paint is missing, none, not finite or too large, or a
/// length is negative. Returns the roads, and the pieces of others, that can't be built and are shorter than 1 cm.
///
/// # Errors
/// The line and what is wrong there, with the road's id.
pub(crate) fn check(map: &Document) -> Result<Vec<PassedOver>, (usize, String)> {
    let mut passed_over = Vec::new();
    for node in map.descendants().filter(Node::is_element) {
        check_values(node)?;
        if node.has_tag_name("geometry") {
            passed_over.extend(check_piece(node)?);
        } else if !node.parent().is_some_and(|parent| parent.has_tag_name("geometry")) {
            missing(node).map_or(Ok(()), |reason| Err(fault(node, &reason)))?;
        }
    }
    let is_empty = |road: &Node| {
        let mut pieces = road.descendants().filter(|n| n.has_tag_name("geometry"));
        number(*road, "length") == Some(0.0)
            && pieces.all(|piece| number(piece, "length").is_some_and(|m| m < NEGLIGIBLE_M))
    };
    for road in map.descendants().filter(|n| n.has_tag_name("road")).filter(is_empty) {
        let reason = "<road> of length 0: passed over, with the links that lead over it".to_owned();
        passed_over.push(PassedOver::of(road, None, line_of(road), reason));
    }
    Ok(passed_over)
}

/// The line of a node, and what is wrong there with its road.
fn fault(node: Node, reason: &str) -> (usize, String) {
    let road = road_of(node).map_or(String::new(), |road| format!("road {}: ", in_one_line(road)));
    (line_of(node), format!("{road}{reason}"))
}

/// Refuses an element's numbers that are none.
fn check_values(node: Node) -> Result<(), (usize, String)> {
    let element = node.tag_name().name();
    for key in numbers_of(element).1 {
        if let Some(value) = node.attribute(*key) {
            check_number(element, key, value).map_err(|reason| fault(node, &format!("<{element} {key}>: {reason}")))?;
        }
    }
    Ok(())
}

/// Says which of the numbers that an element needs are not there.
fn missing(node: Node) -> Option<String> {
    let (is_needed, keys) = numbers_of(node.tag_name().name());
    let missing: Vec<&str> = keys.iter().copied().filter(|key| !node.has_attribute(*key)).collect();
    (is_needed && !missing.is_empty()).then(|| format!("<{}> without {}", node.tag_name().name(), missing.join(", ")))
}

/// Refuses a piece of a road that can't be built, unless it is too short to matter.
fn check_piece(piece: Node) -> Result<Option<PassedOver>, (usize, String)> {
    let shape = piece.children().find(|child| SHAPES.contains(&child.tag_name().name()));
    let length_m = number(piece, "length");
    let reason = if let Some((shape, reason)) = shape.and_then(|shape| Some((shape, missing(shape)?))) {
        Some((shape, reason))
    } else if let Some(reason) = missing(piece) {
        Some((piece, reason))
    } else if length_m == Some(0.0) {
        Some((piece, "<geometry> of length 0".to_owned()))
    } else if shape.is_none() {
        Some((piece, "<geometry> without <line>, <arc>, <spiral>, <poly3> or <paramPoly3>".to_owned()))
    } else {
        None
    };
    let Some((node, reason)) = reason else { return Ok(None) };
    let Some(length_m) = length_m.filter(|m| *m < NEGLIGIBLE_M) else { return Err(fault(node, &reason)) };
    let reason = format!("{reason}: a piece of {length_m} m passed over");
    Ok(Some(PassedOver::of(piece, number(piece, "s"), line_of(node), reason)))
}

/// Refuses what is no number or beyond the limits of its kind; the width of paint may be no number.
fn check_number(element: &str, key: &str, value: &str) -> Result<(), String> {
    let is_paint = matches!(element, "roadMark" | "line");
    let (range, expected) = match key {
        "length" => (0.0..=MAX_LENGTH_M, format!("from 0 to {MAX_LENGTH_M} m")),
        _ if is_paint => (-MAX_PAINT_WIDTH_M..=MAX_PAINT_WIDTH_M, format!("at most {MAX_PAINT_WIDTH_M} m")),
        _ => (-MAX_NUMBER..=MAX_NUMBER, format!("a number from -{MAX_NUMBER:e} to {MAX_NUMBER:e}")),
    };
    let is_fine = match value.trim().parse::<f64>() {
        Ok(number) => range.contains(&number) || (is_paint && number.is_nan()),
        Err(_) => is_paint,
    };
    let shown: String = value.chars().take(40).collect();
    if is_fine { Ok(()) } else { Err(format!("expected {expected}, got {shown:?}")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(text: &str) -> Result<Vec<PassedOver>, (usize, String)> {
        super::check(&Document::parse(text).expect("XML"))
    }

    fn map(planview: &str) -> String {
        format!(
            "<?xml version='1.0'?>\n<!-- <road length=\"nan\"/>\n -->\n<OpenDRIVE>\n<road name=\"a > b\" id=\"7\" \
             length='60'>\n<userData value=\"nan\"/><planView>{planview}</planView><lanes/></road></OpenDRIVE>"
        )
    }

    #[test]
    fn numbers_that_shape_roads_are_refused_with_their_line_and_road() {
        let good = "<geometry s=\"0\" x='1' y = \"-2.5e3\" hdg=\"0\" length=\" 60 \"><line/></geometry>\
                    <roadMark width='none'/><roadMark width='nan'/><line width='0.12'/>";
        assert_eq!(check(&map(good)), Ok(vec![]));
        let number = "expected a number from -1e9 to 1e9, got";
        for (planview, expected) in [
            ("<paramPoly3 bV=\"1e308\"/>", format!("<paramPoly3 bV>: {number} \"1e308\"")),
            ("<geometry\n x=\"NaN\"/>", format!("<geometry x>: {number} \"NaN\"")),
            ("<arc curvature='inf'></arc>", format!("<arc curvature>: {number} \"inf\"")),
            ("<width a=\"1_0\"/>", format!("<width a>: {number} \"1_0\"")),
            ("<geometry length=\"-60\"/>", "<geometry length>: expected from 0 to 100000 m, got \"-60\"".to_owned()),
            ("<roadMark width='1e8'/>", "<roadMark width>: expected at most 20 m, got \"1e8\"".to_owned()),
            ("<line width='-inf'/>", "<line width>: expected at most 20 m, got \"-inf\"".to_owned()),
        ] {
            assert_eq!(check(&map(planview)), Err((6, format!("road 7: {expected}"))));
        }
    }

    #[test]
    fn what_a_piece_of_road_lacks_is_said_and_passed_over_where_it_is_short() {
        let place = "s='3' x='0' y='0' hdg='0'";
        for (shape, line, reason) in [
            ("<spiral curvEnd='0'/>", 7, "<spiral> without curvStart"),
            ("<spiral/>", 7, "<spiral> without curvStart, curvEnd"),
            ("<arc/>", 7, "<arc> without curvature"),
            ("<clothoid/>", 6, "<geometry> without <line>, <arc>, <spiral>, <poly3> or <paramPoly3>"),
            ("", 6, "<geometry> without <line>, <arc>, <spiral>, <poly3> or <paramPoly3>"),
        ] {
            for next in ["", "<geometry s='4' x='0' y='0' hdg='0' length='1'><line/></geometry>"] {
                let piece = |length: &str| format!("<geometry {place} length='{length}'>\n{shape}</geometry>{next}");
                assert_eq!(check(&map(&piece("9"))), Err((line, format!("road 7: {reason}"))));
                let passed = check(&map(&piece("1e-4"))).expect("a tenth of a millimeter");
                let reason = format!("{reason}: a piece of 0.0001 m passed over");
                assert_eq!(passed, [PassedOver { road: "7".to_owned(), s_m: Some(3.0), line, reason }]);
            }
        }
        let lacking = "<geometry s='3' x='0' length='9'><line/></geometry>";
        assert_eq!(check(&map(lacking)), Err((6, "road 7: <geometry> without y, hdg".to_owned())));
        let empty = check(&map(&format!("<geometry {place} length='0'><line/></geometry>"))).expect("no length");
        assert_eq!(empty[0].reason, "<geometry> of length 0: a piece of 0 m passed over");
        assert_eq!(check("<road id='x'/>"), Err((1, "road x: <road> without length".to_owned())));
        let empty =
            format!("<road id='x' length='0'><geometry {place} length='1e-9'><line/></geometry><lanes/></road>");
        assert_eq!(
            check(&empty).expect("no length")[0].reason,
            "<road> of length 0: passed over, with the links that lead over it"
        );
        assert_eq!(check(&empty.replace("1e-9", "40")), Ok(vec![]));
    }
}
