//! What a map's reader passed over, in lines that a person can read.

use roxmltree::{Document, Node};

use crate::opendrive::number;
use cadet_base::math::DVec2;

/// Further roads that a line names.
const MAX_NAMED: usize = 5;
/// Lines of a map.
const MAX_LINES: usize = 20;

/// Something to be said of a map.
pub(crate) struct Said {
    /// What makes several one line.
    pub kind: String,
    /// Where the text says so, from 1; `None` where the map as a whole does.
    pub line: Option<usize>,
    /// The road that it is about; empty for none.
    pub road: String,
    pub text: String,
}

impl Said {
    /// What the reader says, of a kind with what differs from it in names and numbers alone.
    pub fn by_reader(warning: &xodr::Warning) -> Self {
        let text = warning.to_string();
        Self { kind: without_numbers(&text), line: None, road: warning.road_id().to_owned(), text }
    }

    /// A line about a road.
    pub fn of_road(kind: &str, road: String, text: String) -> Self {
        Self { kind: kind.to_owned(), line: None, road, text }
    }

    /// What holds for the map as a whole.
    pub fn of_map(kind: &str, text: String) -> Self {
        Self::of_road(kind, String::new(), text)
    }
}

/// What those who drive on a left-hand map should know.
pub(crate) fn of_left_hand_traffic() -> Said {
    let text = "left-hand traffic (rule=\"LHT\"): all keep left, but low beams, signs, poles of lights and steering \
                wheels are those of right-hand traffic";
    Said::of_map("left-hand traffic", text.to_owned())
}

/// What RoadRunner's maps of left-hand traffic should say: before OpenDRIVE 1.5 they have the direction in user data alone.
pub(crate) fn of_travel_direction(map: &Document) -> Option<Said> {
    let (mut with_rule, mut against_rule) = (0, 0);
    for node in map.descendants().filter(|n| n.has_tag_name("vectorLane")) {
        let lane = node.ancestors().find(|n: &Node| n.has_tag_name("lane"));
        let is_right = lane.and_then(|lane| number(lane, "id")).is_some_and(|id| id < 0.0);
        match node.attribute("travelDir") {
            Some("forward") if is_right => with_rule += 1,
            Some("backward") if !is_right => with_rule += 1,
            Some("forward" | "backward") => against_rule += 1,
            _ => {}
        }
    }
    let text = "its <vectorLane travelDir> say that traffic keeps left, but its roads have no rule=\"LHT\": read as \
                right-hand traffic; add that to each <road> for the other";
    (against_rule > with_rule).then(|| Said::of_map("travelDir", text.to_owned()))
}

/// What those who use a far map's coordinates should know.
pub(crate) fn of_offset(offset_m: DVec2) -> Said {
    let DVec2 { x, y } = offset_m;
    let text = format!(
        "far from its origin: all places are relative to x = {x}, y = {y} m of the map (map_offset_m in the metadata)"
    );
    Said::of_map("offset", text)
}

/// Quotes a text of the file in a line: control characters as escapes.
pub(crate) fn in_one_line(text: &str) -> String {
    let shown = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(shown).collect()
}

/// Lines that name a map, one for each kind of warning.
pub(crate) fn lines(map_name: &str, warnings: Vec<Said>) -> Vec<String> {
    let mut kinds: Vec<Vec<Said>> = Vec::new();
    for said in warnings {
        match kinds.iter_mut().find(|kind| kind[0].kind == said.kind) {
            Some(kind) => kind.push(said),
            None => kinds.push(vec![said]),
        }
    }
    let line = |kind: &Vec<Said>| {
        let place = kind[0].line.map_or(String::new(), |line| format!(":{line}"));
        format!("{map_name}{place}: {}", in_one_line(&text_of(&kind[0], &kind[1..])))
    };
    let mut lines: Vec<String> = kinds.iter().map(line).collect();
    if kinds.len() > MAX_LINES {
        lines.truncate(MAX_LINES - 1);
        lines.push(format!("{map_name}: {} more kinds of warnings", kinds.len() - lines.len()));
    }
    lines
}

/// Warnings of one kind: the first in its own words, the others by their roads.
fn text_of(first: &Said, others: &[Said]) -> String {
    if others.is_empty() {
        return first.text.clone();
    }
    let mut roads: Vec<&str> = Vec::new();
    for Said { road, .. } in others.iter().filter(|said| !said.road.is_empty() && said.road != first.road) {
        if roads.len() <= MAX_NAMED && !roads.contains(&road.as_str()) {
            roads.push(road);
        }
    }
    let named: Vec<String> = roads.iter().take(MAX_NAMED).map(|road| format!("{road:?}")).collect();
    let at = match (named.len(), roads.len() > MAX_NAMED) {
        (0, _) => String::new(),
        (1, _) => format!(", road {}", named[0]),
        (_, false) => format!(", roads {}", named.join(", ")),
        (_, true) => format!(", roads {} and others", named.join(", ")),
    };
    format!("{} (and {} more such{at})", first.text, others.len())
}

/// A warning's words, without names in quotes and numbers.
fn without_numbers(text: &str) -> String {
    let words = text.split('"').step_by(2);
    words.flat_map(str::chars).filter(|c| !(c.is_ascii_digit() || *c == '.' || *c == '-')).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(road: usize) -> Said {
        Said::by_reader(&xodr::Warning::GeometryDropped { road_id: road.to_string(), s: Some(road as f64) })
    }

    #[test]
    fn each_kind_is_one_line_that_names_map_and_roads() {
        assert_eq!(lines("a.xodr", Vec::new()), Vec::<String>::new());
        assert_eq!(lines("a.xodr", vec![gap(3)]), ["a.xodr: road \"3\": <geometry> at s 3.00 m dropped"]);
        let other = Said::by_reader(&xodr::Warning::JunctionIdRepeated { junction_id: "x-1".to_owned() });
        let both = lines("a.xodr", vec![gap(3), other, gap(4), gap(3)]);
        assert_eq!(both.len(), 2);
        assert_eq!(both[0], "a.xodr: road \"3\": <geometry> at s 3.00 m dropped (and 2 more such, road \"4\")");
        assert!(both[1].starts_with("a.xodr: junction \"x-1\": "), "{}", both[1]);
        let many = lines("a.xodr", (1..=40).map(gap).collect());
        assert!(
            many[0].ends_with("dropped (and 39 more such, roads \"2\", \"3\", \"4\", \"5\", \"6\" and others)"),
            "{}",
            many[0]
        );
    }
}
