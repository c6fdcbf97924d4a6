//! Towns for tests.

use crate::placement::PropFootprint;
use crate::{Layout, PropConfig, RoadNetwork, SuburbConfig, Town, generate_suburb};
use cadet_base::instance::Instance;
use cadet_base::rng::StreamKey;

/// A town with what it was made from.
pub(crate) fn town(seed: u64, suburb: &SuburbConfig, props: &PropConfig) -> (Town, Layout) {
    let network = generate_suburb(&StreamKey::scene(seed), suburb).unwrap().network;
    Town::laid_out(&StreamKey::scene(seed), "test", network, props).unwrap()
}

/// The shared map of a name, if it is there.
#[allow(clippy::print_stderr)]
pub(crate) fn shared_map(map: &str) -> Option<RoadNetwork> {
    let path = format!("{}/../../../shared/maps/{map}", env!("CARGO_MANIFEST_DIR"));
    let Ok(text) = std::fs::read_to_string(path) else {
        eprintln!("skipped: no ../shared/maps/{map}");
        return None;
    };
    Some(crate::load_map(map, &text).unwrap())
}

/// What stands on a town's ground.
pub(crate) fn things(town: &Town) -> &[Instance] {
    &town.scenery[town.ground.tiles.len()..]
}

/// Fails where two of some footprints overlap.
pub(crate) fn assert_apart(of: &[&PropFootprint], what: &str) {
    for (i, a) in of.iter().enumerate() {
        for b in &of[..i] {
            assert!(!a.rect.overlaps(&b.rect), "{what}: {a:?} and {b:?}");
        }
    }
}
