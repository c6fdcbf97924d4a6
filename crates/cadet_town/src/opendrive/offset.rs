//! Moves maps that lie far from their coordinates' origin, such as those in UTM, nearer to it: single precision, in which
//! lanes are baked and seen, keeps millimeters within a few kilometers alone.

use std::borrow::Cow;

use roxmltree::{Document, Node};

use crate::opendrive::number;
use cadet_base::math::DVec2;
use cadet_base::plane::bounds;

/// Maps with their middle within this of the origin stay where they are.
const NEAR_M: f64 = 8192.0;
/// Offsets are whole multiples of this, so that a map moved by them is the same map.
const STEP_M: f64 = 1000.0;

/// The pieces of all roads.
fn pieces<'a>(map: &'a Document<'a>) -> impl Iterator<Item = Node<'a, 'a>> {
    map.descendants().filter(|node| node.has_tag_name("geometry"))
}

/// The offset that a map asks for: its own coordinates are the returned ones plus this; zero near the origin.
pub(crate) fn offset_m(map: &Document) -> DVec2 {
    let (min, max) = bounds(pieces(map).filter_map(|p| Some(DVec2::new(number(p, "x")?, number(p, "y")?))));
    let middle = (min + max) / 2.0;
    if middle.is_finite() && middle.abs().max_element() > NEAR_M {
        (middle / STEP_M).round() * STEP_M
    } else {
        DVec2::ZERO
    }
}

/// A map's text with its roads moved back by an offset. Nothing else in OpenDRIVE has a place of its own.
pub(crate) fn moved_back<'a>(map: &'a Document<'_>, offset_m: DVec2) -> Cow<'a, str> {
    let text = map.input_text();
    if offset_m == DVec2::ZERO {
        return text.into();
    }
    let mut moved = String::with_capacity(text.len());
    let mut copied = 0;
    for piece in pieces(map) {
        for attribute in piece.attributes() {
            let offset_m = match attribute.name() {
                "x" => offset_m.x,
                "y" => offset_m.y,
                _ => continue,
            };
            let (value, Some(number)) = (attribute.range_value(), number(piece, attribute.name())) else { continue };
            moved.push_str(&text[copied..value.start]);
            moved.push_str(&(number - offset_m).to_string());
            copied = value.end;
        }
    }
    moved.push_str(&text[copied..]);
    moved.into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(x: f64, y: f64) -> String {
        format!(
            "<m><!-- <geometry x='9e8'/> --><header north='{y}'/><geometry s=\"{x}\" y = '{y}' x=\" {x} \" hdg='1'/>\
             <object x='7'/>\n<geometry x='{}' y='{y}'/></m>",
            x + 400.0
        )
    }

    fn offset_of(text: &str) -> DVec2 {
        offset_m(&Document::parse(text).expect("XML"))
    }

    #[test]
    fn far_maps_are_moved_by_whole_kilometers_and_near_ones_stay() {
        for (x, y) in [(0.0, 0.0), (-8000.0, 8000.0), (7900.5, 12.25)] {
            assert_eq!(offset_of(&map(x, y)), DVec2::ZERO);
        }
        assert_eq!(offset_of("<m/>"), DVec2::ZERO);
        assert_eq!(offset_of(&map(602_800.0, 5_793_000.0)), DVec2::new(603_000.0, 5_793_000.0));
        assert_eq!(offset_of(&map(-20_000.0, 3.0)), DVec2::new(-20_000.0, 0.0));
        let far = map(602_800.25, 5_793_000.5);
        let document = Document::parse(&far).expect("XML");
        let moved = moved_back(&document, offset_m(&document));
        let places = "<geometry s=\"602800.25\" y = '0.5' x=\"-199.75\" hdg='1'/><object x='7'/>\n\
                      <geometry x='200.25' y='0.5'/></m>";
        assert!(moved.ends_with(places) && moved.starts_with("<m><!-- <geometry x='9e8'/> -->"), "{moved}");
        assert_eq!(moved_back(&document, DVec2::ZERO), far);
    }
}
