//! Right of way where a lane comes to a junction: the one answer of paint, signs and drivers.

use std::collections::BTreeMap;

use crate::network::{Lane, RightOfWay, RoadNetwork};
use crate::signals::Signals;

/// Streets at most this fast have no priority over others in towns.
const ZONE_30_MPS: f64 = 8.5;

impl RightOfWay {
    /// That of a lane; `None` where it ends at no junction.
    pub fn of(lane: &Lane, network: &RoadNetwork, signals: &Signals) -> Option<Self> {
        let junction = network.junction_after(lane)?;
        if signals.arm_of(lane.id).is_some() {
            return Some(Self::Signal);
        }
        if network.ends_at_roundabout(lane) {
            return Some(Self::Yield);
        }
        if let Some(says) = network.signs.get(&lane.id) {
            return Some(*says);
        }
        let arriving = || network.driving().filter(|o| network.leads_into(o, junction));
        // Beside approaches with signs one without has what theirs leave it.
        let mut signs = arriving().filter_map(|o| network.signs.get(&o.id)).peekable();
        if signs.peek().is_some() {
            let is_minor = |says: &Self| matches!(says, Self::Yield | Self::Stop);
            return Some(if signs.any(is_minor) { Self::Priority } else { Self::Yield });
        }
        if network.is_rural() {
            let is_faster = |a: &Lane, b: &Lane| a.speed_limit_mps > b.speed_limit_mps + 0.1;
            return Some(if arriving().any(|o| is_faster(o, lane)) {
                Self::Yield
            } else if arriving().any(|o| is_faster(lane, o)) {
                Self::Priority
            } else {
                Self::RightFirst
            });
        }
        // By street: of two lanes that arrive side by side, neither goes through because of the other.
        let is_fast = |l: &Lane| l.speed_limit_mps > ZONE_30_MPS;
        let streets: BTreeMap<u32, bool> = arriving().map(|o| (o.road, is_fast(o))).collect();
        let num_fast = streets.values().filter(|fast| **fast).count();
        // A fast street goes through; where one only ends, nobody has to give way to it.
        Some(match (is_fast(lane), num_fast) {
            // Nobody else arrives.
            _ if streets.len() == 1 => Self::RightFirst,
            _ if num_fast == streets.len() => Self::Stop,
            (true, 2..) => Self::Priority,
            (false, 2..) => Self::Yield,
            _ => Self::RightFirst,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::generate_suburb;
    use crate::paint::road_marking::{self, ACROSS};
    use crate::plan::SuburbConfig;
    use cadet_base::rng::StreamKey;

    #[test]
    fn at_every_junction_some_yield_to_others_with_priority_or_all_are_alike() {
        let mut counts = BTreeMap::new();
        for seed in 0..20 {
            let key = StreamKey::scene(seed);
            let config = SuburbConfig {
                main_share: f64::from(u8::from(seed % 2 == 0)),
                signal_share: 0.3,
                ..SuburbConfig::default()
            };
            let network = generate_suburb(&key, &config).unwrap().network;
            let signals = Signals::of(&network, &key);
            let quads = road_marking::draw(&network, &signals, &|_| Some((0.0, true)));
            let painted: BTreeSet<u32> = quads.iter().filter_map(|q| q.line.checked_sub(ACROSS)).collect();
            let mut by_junction: BTreeMap<u32, Vec<RightOfWay>> = BTreeMap::new();
            for lane in network.driving().filter(|l| l.junction.is_none()) {
                let right_of_way = RightOfWay::of(lane, &network, &signals);
                let junction = network.junction_after(lane);
                assert_eq!(right_of_way.is_some(), junction.is_some());
                let has_line = matches!(right_of_way, Some(RightOfWay::Yield | RightOfWay::Stop));
                let is_painted = painted.contains(&(lane.id.0 as u32));
                assert_eq!(is_painted, has_line && !signals.has_zebra(lane.id), "seed {seed}, {right_of_way:?}");
                if let (Some(right_of_way), Some(junction)) = (right_of_way, junction) {
                    by_junction.entry(junction).or_default().push(right_of_way);
                    *counts.entry(format!("{right_of_way:?}")).or_insert(0) += 1;
                }
            }
            for (junction, approaches) in by_junction {
                use RightOfWay::{Priority, RightFirst, Signal, Stop, Yield};
                let all = |allowed: &[RightOfWay]| approaches.iter().all(|a| allowed.contains(a));
                let has = |a| approaches.contains(&a);
                let is_alike =
                    all(&[Signal]) || all(&[Stop]) || all(&[RightFirst]) || network.roundabouts.contains(&junction);
                let yields = all(&[Priority, Yield]) && has(Priority) && has(Yield);
                assert!(is_alike || yields, "seed {seed}, junction {junction}: {approaches:?}");
            }
        }
        assert!(counts.len() == 5, "{counts:?}");
    }
}
