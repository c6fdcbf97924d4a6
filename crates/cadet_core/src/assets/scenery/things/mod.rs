//! Things along a street that look a little like cars, bicycles or people and are none: what stands at curbs, in bays, on
//! vacant plots and in front gardens.

mod adverts;
mod colors;
mod containers;
mod covered;
mod cycles;
mod greens;
mod heap;
mod huts;
mod seats;
mod shapes;
mod site;
mod small;

pub use colors::thing_palette;
pub use seats::{BENCH_SEAT_M, CHAIR_SEAT_M, SHELTER_SEAT_M};

use super::{Detail, Mesh};

/// How many sizes a kind comes in; each is drawn from the kind's range.
pub const THING_VARIANTS: usize = 6;

/// What it is; its front faces +x, its length lies along y. Covered vehicles and bicycles head along x.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum ThingKind {
    /// A four-wheeled container of 770 to 1100 l.
    LargeContainer,
    /// A bottle bank.
    GlassBank,
    /// A container for clothes.
    ClothesBank,
    /// An open container for rubble.
    Skip,
    /// A site's or storage container.
    SiteContainer,
    /// A cabinet of the telephone or electricity network.
    Cabinet,
    /// A transformer's house.
    Transformer,
    /// A parked bicycle; it heads along +x.
    Bicycle,
    /// A hoop that bicycles lean on, across +x.
    CycleHoop,
    /// A bus stop's shelter with glass panes.
    BusShelter,
    /// A column with posters.
    AdvertColumn,
    /// A large poster on posts.
    Billboard,
    /// A shop's board on the sidewalk.
    AdvertStand,
    /// A car under a tarpaulin; it heads along +x.
    CoveredCar,
    /// A motorcycle under a tarpaulin; it heads along +x.
    CoveredCycle,
    /// A stack of wood under a tarpaulin.
    WoodPile,
    /// Building material on pallets.
    Pallets,
    /// Red and white boards about a site.
    Barrier,
    /// A heap of earth or gravel.
    Heap,
    /// A mound with grass on it.
    Mound,
    /// A bush clipped to a block or a cushion.
    ClippedBush,
    /// A bed of low shrubs.
    ShrubBed,
    /// A planted tub.
    Tub,
    /// A pot with a plant of a man's height.
    TallPlant,
    /// A garden's shed.
    Shed,
    /// A roof on posts for a car, which heads along +x.
    Carport,
    /// A cafe's table.
    CafeTable,
    /// A cafe's chair; who sits on it looks along +x.
    CafeChair,
    /// A parasol.
    Parasol,
}

impl ThingKind {
    /// Every kind.
    pub const ALL: [Self; 29] = [
        Self::LargeContainer,
        Self::GlassBank,
        Self::ClothesBank,
        Self::Skip,
        Self::SiteContainer,
        Self::Cabinet,
        Self::Transformer,
        Self::Bicycle,
        Self::CycleHoop,
        Self::BusShelter,
        Self::AdvertColumn,
        Self::Billboard,
        Self::AdvertStand,
        Self::CoveredCar,
        Self::CoveredCycle,
        Self::WoodPile,
        Self::Pallets,
        Self::Barrier,
        Self::Heap,
        Self::Mound,
        Self::ClippedBush,
        Self::ShrubBed,
        Self::Tub,
        Self::TallPlant,
        Self::Shed,
        Self::Carport,
        Self::CafeTable,
        Self::CafeChair,
        Self::Parasol,
    ];

    /// A short name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LargeContainer => "large-container",
            Self::GlassBank => "glass-bank",
            Self::ClothesBank => "clothes-bank",
            Self::Skip => "skip",
            Self::SiteContainer => "site-container",
            Self::Cabinet => "network-cabinet",
            Self::Transformer => "transformer",
            Self::Bicycle => "bicycle",
            Self::CycleHoop => "cycle-hoop",
            Self::BusShelter => "bus-shelter",
            Self::AdvertColumn => "advert-column",
            Self::Billboard => "billboard",
            Self::AdvertStand => "advert-stand",
            Self::CoveredCar => "covered-car",
            Self::CoveredCycle => "covered-cycle",
            Self::WoodPile => "wood-pile",
            Self::Pallets => "pallets",
            Self::Barrier => "barrier",
            Self::Heap => "heap",
            Self::Mound => "mound",
            Self::ClippedBush => "clipped-bush",
            Self::ShrubBed => "shrub-bed",
            Self::Tub => "tub",
            Self::TallPlant => "tall-plant",
            Self::Shed => "shed",
            Self::Carport => "carport",
            Self::CafeTable => "cafe-table",
            Self::CafeChair => "cafe-chair",
            Self::Parasol => "parasol",
        }
    }

    /// Where its levels of detail end, meters from the ego.
    pub(super) fn limits_m(self) -> [f32; 3] {
        match self {
            Self::Bicycle | Self::CafeChair | Self::CafeTable | Self::CycleHoop => [14.0, 32.0, 90.0],
            Self::ClippedBush | Self::ShrubBed | Self::Tub | Self::TallPlant => [14.0, 35.0, 140.0],
            Self::AdvertStand | Self::Barrier | Self::Cabinet | Self::CoveredCycle => [20.0, 45.0, 110.0],
            Self::Transformer | Self::BusShelter | Self::Billboard | Self::SiteContainer | Self::Shed => {
                [25.0, 60.0, 250.0]
            }
            _ => [22.0, 50.0, 160.0],
        }
    }
}

/// Draws one.
pub(super) fn mesh(kind: ThingKind, variant: usize, detail: Detail) -> Mesh {
    match kind {
        ThingKind::LargeContainer => containers::large(variant, detail),
        ThingKind::GlassBank => containers::glass_bank(variant, detail),
        ThingKind::ClothesBank => containers::clothes_bank(variant, detail),
        ThingKind::Skip => containers::skip(variant, detail),
        ThingKind::SiteContainer => containers::site_container(variant, detail),
        ThingKind::Cabinet => small::cabinet(variant, detail),
        ThingKind::Transformer => huts::transformer(variant, detail),
        ThingKind::Bicycle => cycles::bicycle(variant, detail),
        ThingKind::CycleHoop => cycles::hoop(variant, detail),
        ThingKind::BusShelter => huts::bus_shelter(variant, detail),
        ThingKind::AdvertColumn => adverts::column(variant, detail),
        ThingKind::Billboard => adverts::billboard(variant, detail),
        ThingKind::AdvertStand => adverts::stand(variant, detail),
        ThingKind::CoveredCar => covered::car(variant, detail),
        ThingKind::CoveredCycle => covered::cycle(variant, detail),
        ThingKind::WoodPile => covered::wood_pile(variant, detail),
        ThingKind::Pallets => site::pallets(variant, detail),
        ThingKind::Barrier => site::barrier(variant, detail),
        ThingKind::Heap => heap::heap("heap", variant, detail),
        ThingKind::Mound => heap::heap("mound", variant, detail),
        ThingKind::ClippedBush => greens::clipped_bush(variant, detail),
        ThingKind::ShrubBed => greens::shrub_bed(variant, detail),
        ThingKind::Tub => greens::tub(variant, detail),
        ThingKind::TallPlant => greens::tall_plant(variant, detail),
        ThingKind::Shed => huts::shed(variant, detail),
        ThingKind::Carport => huts::carport(variant, detail),
        ThingKind::CafeTable => seats::table(variant, detail),
        ThingKind::CafeChair => seats::chair(variant, detail),
        ThingKind::Parasol => seats::parasol(variant, detail),
    }
}

#[cfg(test)]
mod tests;
