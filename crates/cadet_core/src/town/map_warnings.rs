//! What a map's reader passed over, in lines that a person can read.

/// Further roads that a line names.
const MAX_NAMED: usize = 5;
/// Lines of a map.
const MAX_LINES: usize = 20;

/// Warnings of one kind: the first in its own words, the others by their roads.
struct Kind {
    key: String,
    first: String,
    first_road: String,
    num_others: usize,
    other_roads: Vec<String>,
}

/// Lines that name a map, one for each kind of warning.
pub(super) fn lines(map_name: &str, warnings: &[xodr::Warning]) -> Vec<String> {
    let mut kinds: Vec<Kind> = Vec::new();
    for warning in warnings {
        let (text, road) = (warning.to_string(), warning.road_id());
        let key = without_numbers(&text);
        let Some(kind) = kinds.iter_mut().find(|kind| kind.key == key) else {
            let (first_road, other_roads) = (road.to_owned(), Vec::new());
            kinds.push(Kind { key, first: text, first_road, num_others: 0, other_roads });
            continue;
        };
        kind.num_others += 1;
        let is_new = !road.is_empty() && road != kind.first_road && !kind.other_roads.iter().any(|known| known == road);
        if is_new && kind.other_roads.len() <= MAX_NAMED {
            kind.other_roads.push(road.to_owned());
        }
    }
    let num_kinds = kinds.len();
    let mut lines: Vec<String> = kinds.iter().map(|kind| format!("{map_name}: {}", kind.line())).collect();
    if num_kinds > MAX_LINES {
        lines.truncate(MAX_LINES - 1);
        lines.push(format!("{map_name}: {} more kinds of warnings", num_kinds - lines.len()));
    }
    lines
}

impl Kind {
    fn line(&self) -> String {
        if self.num_others == 0 {
            return self.first.clone();
        }
        let named = self.other_roads.len().min(MAX_NAMED);
        let roads: Vec<String> = self.other_roads[..named].iter().map(|road| format!("{road:?}")).collect();
        let at = match (named, self.other_roads.len() > MAX_NAMED) {
            (0, _) => String::new(),
            (1, _) => format!(", road {}", roads[0]),
            (_, false) => format!(", roads {}", roads.join(", ")),
            (_, true) => format!(", roads {} and others", roads.join(", ")),
        };
        format!("{} (and {} more such{at})", self.first, self.num_others)
    }
}

/// A warning's words, without names in quotes and numbers.
fn without_numbers(text: &str) -> String {
    let words = text.split('"').step_by(2);
    words.flat_map(str::chars).filter(|c| !(c.is_ascii_digit() || *c == '.' || *c == '-')).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(road: usize) -> xodr::Warning {
        xodr::Warning::GeometryDropped { road_id: road.to_string(), s: Some(road as f64) }
    }

    #[test]
    fn each_kind_is_one_line_that_names_map_and_roads() {
        assert_eq!(lines("a.xodr", &[]), Vec::<String>::new());
        assert_eq!(lines("a.xodr", &[gap(3)]), ["a.xodr: road \"3\": <geometry> at s 3.00 m dropped"]);
        let other = xodr::Warning::JunctionIdRepeated { junction_id: "x-1".to_owned() };
        let both = lines("a.xodr", &[gap(3), other, gap(4), gap(3)]);
        assert_eq!(both.len(), 2);
        assert_eq!(both[0], "a.xodr: road \"3\": <geometry> at s 3.00 m dropped (and 2 more such, road \"4\")");
        assert!(both[1].starts_with("a.xodr: junction \"x-1\": "), "{}", both[1]);
        let many: Vec<xodr::Warning> = (1..=40).map(gap).collect();
        let many = lines("a.xodr", &many);
        assert!(
            many[0].ends_with("dropped (and 39 more such, roads \"2\", \"3\", \"4\", \"5\", \"6\" and others)"),
            "{}",
            many[0]
        );
    }
}
