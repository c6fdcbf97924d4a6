//! Moves maps that lie far from their coordinates' origin, such as those in UTM, nearer to it: single precision, in which
//! lanes are baked and seen, keeps millimeters within a few kilometers alone.

use crate::math::DVec2;
use crate::town::opendrive::tags::Tags;

/// Maps with their middle within this of the origin stay where they are.
const NEAR_M: f64 = 8192.0;
/// Offsets are whole multiples of this, so that a map moved by them is the same map.
const STEP_M: f64 = 1000.0;

/// The offset that a map's text asks for: its own coordinates are the returned ones plus this; zero near the origin.
pub(in crate::town) fn offset_m(xodr_text: &str) -> DVec2 {
    let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for tag in Tags::of(xodr_text).filter(|tag| tag.name == "geometry") {
        if let (Some(x), Some(y)) = (tag.number("x"), tag.number("y")) {
            (min, max) = (min.min(DVec2::new(x, y)), max.max(DVec2::new(x, y)));
        }
    }
    let middle = (min + max) / 2.0;
    if middle.is_finite() && middle.abs().max_element() > NEAR_M {
        (middle / STEP_M).round() * STEP_M
    } else {
        DVec2::ZERO
    }
}

/// A map's text with its roads moved back by an offset. Nothing else in OpenDRIVE has a place of its own.
pub(in crate::town) fn moved_back(xodr_text: &str, offset_m: DVec2) -> String {
    let mut moved = String::with_capacity(xodr_text.len());
    let mut copied = 0;
    for tag in Tags::of(xodr_text).filter(|tag| tag.name == "geometry") {
        let mut places: Vec<(usize, usize, f64)> = [("x", offset_m.x), ("y", offset_m.y)]
            .into_iter()
            .filter_map(|(key, offset_m)| {
                let (value, number) = (tag.value(key)?, tag.number(key)?);
                let start = value.as_ptr() as usize - xodr_text.as_ptr() as usize;
                Some((start, start + value.len(), number - offset_m))
            })
            .collect();
        places.sort_by_key(|(start, ..)| *start);
        for (start, end, number) in places {
            moved.push_str(&xodr_text[copied..start]);
            moved.push_str(&number.to_string());
            copied = end;
        }
    }
    moved.push_str(&xodr_text[copied..]);
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(x: f64, y: f64) -> String {
        format!(
            "<!-- <geometry x='9e8'/> --><header north='{y}'/><geometry s=\"{x}\" y = '{y}' x=\" {x} \" hdg='1'/>\
             <object x='7'/>\n<geometry x='{}' y='{y}'/>",
            x + 400.0
        )
    }

    #[test]
    fn far_maps_are_moved_by_whole_kilometers_and_near_ones_stay() {
        for (x, y) in [(0.0, 0.0), (-8000.0, 8000.0), (7900.5, 12.25)] {
            assert_eq!(offset_m(&map(x, y)), DVec2::ZERO);
        }
        assert_eq!(offset_m("no map"), DVec2::ZERO);
        assert_eq!(offset_m(&map(602_800.0, 5_793_000.0)), DVec2::new(603_000.0, 5_793_000.0));
        assert_eq!(offset_m(&map(-20_000.0, 3.0)), DVec2::new(-20_000.0, 0.0));
        let far = map(602_800.25, 5_793_000.5);
        let moved = moved_back(&far, offset_m(&far));
        let places = "<geometry s=\"602800.25\" y = '0.5' x=\"-199.75\" hdg='1'/><object x='7'/>\n\
                      <geometry x='200.25' y='0.5'/>";
        assert!(moved.ends_with(places) && moved.starts_with("<!-- <geometry x='9e8'/> -->"), "{moved}");
        assert_eq!(
            moved_back(&far, DVec2::ZERO).replace("\" 602800.25 \"", "\"602800.25\""),
            far.replace("\" 602800.25 \"", "\"602800.25\"")
        );
    }
}
