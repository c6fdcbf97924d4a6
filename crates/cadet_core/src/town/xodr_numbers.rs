//! Looks over the numbers of an OpenDRIVE text before it is read: the reader drops roads whose numbers it can't use, and
//! stops on the largest ones.

/// Numbers of coefficients and places are at most this large.
const MAX_NUMBER: f64 = 1e9;
/// The longest road or piece of one.
const MAX_LENGTH_M: f64 = 100_000.0;

/// The attributes of an element that are numbers.
fn numbers_of(element: &str) -> &'static [&'static str] {
    match element {
        "road" => &["length"],
        "geometry" => &["s", "x", "y", "hdg", "length"],
        "arc" => &["curvature"],
        "spiral" => &["curvStart", "curvEnd"],
        "paramPoly3" => &["aU", "bU", "cU", "dU", "aV", "bV", "cV", "dV"],
        "poly3" => &["a", "b", "c", "d"],
        "elevation" | "superelevation" | "laneOffset" => &["s", "a", "b", "c", "d"],
        "shape" => &["s", "t", "a", "b", "c", "d"],
        "laneSection" => &["s"],
        "width" | "border" => &["sOffset", "a", "b", "c", "d"],
        _ => &[],
    }
}

/// Refuses a text in which a number that shapes a road is none, not finite or too large, or a length is negative.
///
/// What is no well-formed XML passes: the reader says what is wrong with it. Returns the road and the place of each piece
/// of road without a length: the reader may drop those.
///
/// # Errors
/// The line and what is wrong there, with the road's id.
pub(super) fn check(text: &str) -> Result<Vec<(String, f64)>, (usize, String)> {
    let (mut road, mut empty) = (String::new(), Vec::new());
    let mut tags = Tags { text, at: 0, line: 1 };
    while let Some((line, tag)) = tags.next_tag() {
        let name = tag.split(|c: char| c.is_whitespace() || c == '/').next().unwrap_or("");
        let numbers = numbers_of(name);
        if numbers.is_empty() {
            continue;
        }
        let attributes = attributes_of(&tag[name.len()..]);
        let value_of = |key: &str| attributes.iter().find(|(k, _)| *k == key).map(|(_, value)| *value);
        if name == "road" {
            road = value_of("id").unwrap_or("").to_owned();
        }
        for key in numbers {
            let Some(value) = value_of(key) else { continue };
            let number = number_from(key, value);
            let number = number.map_err(|reason| (line, format!("road {road:?}: <{name} {key}>: {reason}")))?;
            if (name, *key, number) == ("geometry", "length", 0.0) {
                let place = value_of("s").and_then(|s| s.trim().parse().ok());
                empty.extend(place.map(|s| (road.clone(), s)));
            }
        }
    }
    Ok(empty)
}

fn number_from(key: &str, value: &str) -> Result<f64, String> {
    let number = value.trim().parse::<f64>().ok().filter(|v| v.is_finite() && v.abs() <= MAX_NUMBER);
    let expected = match (number, key) {
        (Some(number), "length") if !(0.0..=MAX_LENGTH_M).contains(&number) => format!("from 0 to {MAX_LENGTH_M} m"),
        (None, _) => format!("a number from -{MAX_NUMBER:e} to {MAX_NUMBER:e}"),
        (Some(number), _) => return Ok(number),
    };
    let shown: String = value.chars().take(40).collect();
    Err(format!("expected {expected}, got {shown:?}"))
}

/// Start tags, one after the other, with their lines; comments and character data are passed over.
struct Tags<'a> {
    text: &'a str,
    at: usize,
    line: usize,
}

impl<'a> Tags<'a> {
    fn next_tag(&mut self) -> Option<(usize, &'a str)> {
        loop {
            self.pass_to("<")?;
            let rest = &self.text[self.at..];
            let skipped = [("!--", "-->"), ("![CDATA[", "]]>"), ("?", "?>"), ("!", ">"), ("/", ">")];
            if let Some((_, end)) = skipped.into_iter().find(|(start, _)| rest.starts_with(start)) {
                self.pass_to(end)?;
                continue;
            }
            let (start, line) = (self.at, self.line);
            let mut quote = None;
            let length = rest.find(|c| match quote {
                Some(q) => {
                    if c == q {
                        quote = None;
                    }
                    false
                }
                None => {
                    if c == '"' || c == '\'' {
                        quote = Some(c);
                    }
                    c == '>'
                }
            })?;
            self.pass(length + 1);
            return Some((line, &self.text[start..start + length]));
        }
    }

    /// Goes on behind the next `mark`.
    fn pass_to(&mut self, mark: &str) -> Option<()> {
        let length = self.text[self.at..].find(mark)?;
        self.pass(length + mark.len());
        Some(())
    }

    fn pass(&mut self, length: usize) {
        let passed = &self.text.as_bytes()[self.at..self.at + length];
        self.line += passed.iter().filter(|b| **b == b'\n').count();
        self.at += length;
    }
}

/// The names and values of what stands behind a tag's name.
fn attributes_of(mut rest: &str) -> Vec<(&str, &str)> {
    let mut found = Vec::new();
    while let Some((name, behind)) = rest.split_once('=') {
        let behind = behind.trim_start();
        let Some(quote) = behind.chars().next().filter(|c| *c == '"' || *c == '\'') else { break };
        let Some((value, next)) = behind[1..].split_once(quote) else { break };
        found.push((name.trim(), value));
        rest = next;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_that_shape_roads_are_refused_with_their_line_and_road() {
        let map = |geometry: &str| {
            format!(
                "<?xml version='1.0'?>\n<!-- <road length=\"nan\"/>\n -->\n<OpenDRIVE>\n<road name=\"a > b\" id=\"7\" \
                 length='60'>\n<userData value=\"nan\"/><planView>{geometry}</planView></road></OpenDRIVE>"
            )
        };
        let good = "<geometry s=\"0\" x='1' y = \"-2.5e3\" hdg=\"0\" length=\" 60 \"><line/></geometry>";
        assert_eq!(check(&map(good)), Ok(vec![]));
        assert_eq!(check(&map("<geometry s='3' length='0'/>")), Ok(vec![("7".to_owned(), 3.0)]));
        let refuse = |geometry: &str| check(&map(geometry)).unwrap_err();
        let number = "expected a number from -1e9 to 1e9, got";
        for (geometry, expected) in [
            ("<paramPoly3 bV=\"1e308\"/>", format!("<paramPoly3 bV>: {number} \"1e308\"")),
            ("<geometry\n x=\"NaN\"/>", format!("<geometry x>: {number} \"NaN\"")),
            ("<arc curvature='inf'></arc>", format!("<arc curvature>: {number} \"inf\"")),
            ("<width a=\"1_0\"/>", format!("<width a>: {number} \"1_0\"")),
            ("<geometry length=\"-60\"/>", "<geometry length>: expected from 0 to 100000 m, got \"-60\"".to_owned()),
        ] {
            assert_eq!(refuse(geometry), (6, format!("road \"7\": {expected}")));
        }
    }

    #[test]
    fn any_text_is_passed_over_without_a_stop() {
        let start = ["", "<", "<road", "<road length", "<road length=", "<road length=\"", "<!--", "<é ü='"];
        for text in
            start.into_iter().chain(["<road length=x>", "< >", "<=\"\">", "<road =\"é\"/>", "<road length='é\"'>"])
        {
            assert!(check(text).is_ok_and(|empty| empty.is_empty()) || text.ends_with("'>"), "{text}");
        }
    }
}
