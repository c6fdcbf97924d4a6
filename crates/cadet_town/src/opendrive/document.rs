//! A map's XML, with the lines on which its elements stand.

use roxmltree::{Document, Node};

/// Parses a map's text; its root element is `<OpenDRIVE>`.
///
/// # Errors
/// The line of what is wrong, where the text is not well-formed, and what it is.
pub(crate) fn parse(text: &str) -> Result<Document<'_>, (Option<usize>, String)> {
    let map = Document::parse(text).map_err(|e| (Some(e.pos().row as usize), format!("not readable as XML: {e}")))?;
    let root = map.root_element().tag_name().name().to_owned();
    if root == "OpenDRIVE" {
        Ok(map)
    } else {
        Err((None, format!("not OpenDRIVE: expected the element <OpenDRIVE> first, got {root}")))
    }
}

/// The line on which an element begins, from 1.
pub(crate) fn line_of(node: Node) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

/// The number that an attribute is.
pub(crate) fn number(node: Node, key: &str) -> Option<f64> {
    node.attribute(key)?.trim().parse().ok()
}

/// The id of the road that an element belongs to; `None` outside of roads.
pub(crate) fn road_of<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    let road = node.ancestors().find(|n| n.has_tag_name("road"))?;
    Some(road.attribute("id").unwrap_or(""))
}
