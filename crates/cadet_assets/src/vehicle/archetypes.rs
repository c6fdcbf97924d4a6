//! The kinds of vehicle that a street shows: how common each is, and its proportions.

/// How the side windows are laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Windows {
    /// One door and a fixed pane behind it, if any.
    ThreeDoor,
    /// Front and rear door.
    FiveDoor,
    /// Front and rear door and a pane beside the luggage.
    Estate,
    /// Glass in the front doors only.
    PanelVan,
}

/// The mean shape of a kind of vehicle; `_l_ratio` and `_h_ratio` are of the drawn length and height.
#[derive(Debug)]
pub(super) struct Archetype {
    pub name: &'static str,
    pub share: f64,
    /// Mean and standard deviation of length, width, and height as KITTI's annotators label them, to which the mean
    /// margins of labels are added.
    pub size_m: [(f64, f64); 3],
    pub wheels: Wheels,
    pub clearance_m: f64,
    pub glass: Glass,
    pub ends: Ends,
    pub three_door_share: f64,
    pub is_estate: bool,
}

/// Where the wheels are, and how large.
#[derive(Debug)]
pub(super) struct Wheels {
    pub wheelbase_l_ratio: f64,
    pub front_overhang_l_ratio: f64,
    pub diameter_m: f64,
}

/// The belt line and the slopes of the panes above it.
#[derive(Debug)]
pub(super) struct Glass {
    pub belt_h_ratio: f64,
    pub screen_deg: f64,
    pub backlight_deg: f64,
    pub tumblehome_deg: f64,
}

/// Bonnet and boot.
#[derive(Debug)]
pub(super) struct Ends {
    pub bonnet_edge_z: f64,
    pub cowl_z: f64,
    pub cowl_l_ratio: f64,
    pub boot_l_ratio: f64,
}

pub(super) const CARS: [Archetype; 10] = [
    Archetype {
        name: "micro",
        share: 3.0,
        size_m: [(2.62, 0.15), (1.52, 0.06), (1.54, 0.04)],
        wheels: Wheels { wheelbase_l_ratio: 0.66, front_overhang_l_ratio: 0.17, diameter_m: 0.57 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.62, screen_deg: 36.0, backlight_deg: 56.0, tumblehome_deg: 14.0 },
        ends: Ends { bonnet_edge_z: 0.78, cowl_z: 1.05, cowl_l_ratio: 0.19, boot_l_ratio: 0.005 },
        three_door_share: 1.0,
        is_estate: false,
    },
    Archetype {
        name: "city",
        share: 13.0,
        size_m: [(3.40, 0.17), (1.55, 0.07), (1.50, 0.06)],
        wheels: Wheels { wheelbase_l_ratio: 0.67, front_overhang_l_ratio: 0.19, diameter_m: 0.57 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.62, screen_deg: 32.0, backlight_deg: 53.0, tumblehome_deg: 16.0 },
        ends: Ends { bonnet_edge_z: 0.72, cowl_z: 1.02, cowl_l_ratio: 0.222, boot_l_ratio: 0.005 },
        three_door_share: 0.5,
        is_estate: false,
    },
    Archetype {
        name: "small",
        share: 21.5,
        size_m: [(3.70, 0.18), (1.59, 0.09), (1.48, 0.06)],
        wheels: Wheels { wheelbase_l_ratio: 0.63, front_overhang_l_ratio: 0.205, diameter_m: 0.60 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.62, screen_deg: 31.0, backlight_deg: 47.5, tumblehome_deg: 17.0 },
        ends: Ends { bonnet_edge_z: 0.70, cowl_z: 1.00, cowl_l_ratio: 0.252, boot_l_ratio: 0.005 },
        three_door_share: 0.45,
        is_estate: false,
    },
    Archetype {
        name: "compact",
        share: 20.5,
        size_m: [(3.98, 0.18), (1.65, 0.09), (1.48, 0.06)],
        wheels: Wheels { wheelbase_l_ratio: 0.62, front_overhang_l_ratio: 0.21, diameter_m: 0.63 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.61, screen_deg: 30.0, backlight_deg: 46.5, tumblehome_deg: 18.0 },
        ends: Ends { bonnet_edge_z: 0.70, cowl_z: 1.00, cowl_l_ratio: 0.262, boot_l_ratio: 0.005 },
        three_door_share: 0.3,
        is_estate: false,
    },
    Archetype {
        name: "saloon",
        share: 10.0,
        size_m: [(4.40, 0.20), (1.65, 0.10), (1.44, 0.06)],
        wheels: Wheels { wheelbase_l_ratio: 0.60, front_overhang_l_ratio: 0.19, diameter_m: 0.63 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.63, screen_deg: 29.0, backlight_deg: 27.0, tumblehome_deg: 20.0 },
        ends: Ends { bonnet_edge_z: 0.68, cowl_z: 0.99, cowl_l_ratio: 0.275, boot_l_ratio: 0.115 },
        three_door_share: 0.0,
        is_estate: false,
    },
    Archetype {
        name: "estate",
        share: 9.5,
        size_m: [(4.42, 0.20), (1.66, 0.10), (1.50, 0.07)],
        wheels: Wheels { wheelbase_l_ratio: 0.60, front_overhang_l_ratio: 0.20, diameter_m: 0.63 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.61, screen_deg: 29.0, backlight_deg: 47.5, tumblehome_deg: 18.0 },
        ends: Ends { bonnet_edge_z: 0.68, cowl_z: 1.00, cowl_l_ratio: 0.275, boot_l_ratio: 0.005 },
        three_door_share: 0.0,
        is_estate: true,
    },
    Archetype {
        name: "mpv",
        share: 12.5,
        size_m: [(4.08, 0.25), (1.67, 0.10), (1.68, 0.08)],
        wheels: Wheels { wheelbase_l_ratio: 0.62, front_overhang_l_ratio: 0.20, diameter_m: 0.64 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.57, screen_deg: 31.0, backlight_deg: 55.0, tumblehome_deg: 13.0 },
        ends: Ends { bonnet_edge_z: 0.76, cowl_z: 1.10, cowl_l_ratio: 0.2, boot_l_ratio: 0.005 },
        three_door_share: 0.0,
        is_estate: true,
    },
    Archetype {
        name: "suv",
        share: 5.0,
        size_m: [(4.10, 0.30), (1.72, 0.12), (1.74, 0.11)],
        wheels: Wheels { wheelbase_l_ratio: 0.61, front_overhang_l_ratio: 0.20, diameter_m: 0.71 },
        clearance_m: 0.24,
        glass: Glass { belt_h_ratio: 0.60, screen_deg: 33.0, backlight_deg: 53.0, tumblehome_deg: 13.0 },
        ends: Ends { bonnet_edge_z: 0.92, cowl_z: 1.18, cowl_l_ratio: 0.27, boot_l_ratio: 0.005 },
        three_door_share: 0.1,
        is_estate: true,
    },
    Archetype {
        name: "coupe",
        share: 2.5,
        size_m: [(3.98, 0.22), (1.62, 0.10), (1.33, 0.05)],
        wheels: Wheels { wheelbase_l_ratio: 0.60, front_overhang_l_ratio: 0.20, diameter_m: 0.63 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.66, screen_deg: 27.0, backlight_deg: 24.0, tumblehome_deg: 24.0 },
        ends: Ends { bonnet_edge_z: 0.66, cowl_z: 0.95, cowl_l_ratio: 0.295, boot_l_ratio: 0.075 },
        three_door_share: 1.0,
        is_estate: false,
    },
    Archetype {
        name: "high_roof",
        share: 2.5,
        size_m: [(4.08, 0.22), (1.70, 0.09), (1.88, 0.10)],
        wheels: Wheels { wheelbase_l_ratio: 0.64, front_overhang_l_ratio: 0.20, diameter_m: 0.62 },
        clearance_m: 0.175,
        glass: Glass { belt_h_ratio: 0.56, screen_deg: 36.0, backlight_deg: 76.0, tumblehome_deg: 8.0 },
        ends: Ends { bonnet_edge_z: 0.80, cowl_z: 1.14, cowl_l_ratio: 0.22, boot_l_ratio: 0.005 },
        three_door_share: 0.0,
        is_estate: true,
    },
];

pub(super) const VANS: [Archetype; 4] = [
    Archetype {
        name: "small_van",
        share: 30.0,
        size_m: [(4.22, 0.25), (1.76, 0.08), (1.88, 0.08)],
        wheels: Wheels { wheelbase_l_ratio: 0.64, front_overhang_l_ratio: 0.20, diameter_m: 0.66 },
        clearance_m: 0.20,
        glass: Glass { belt_h_ratio: 0.57, screen_deg: 38.0, backlight_deg: 84.0, tumblehome_deg: 8.0 },
        ends: Ends { bonnet_edge_z: 0.82, cowl_z: 1.09, cowl_l_ratio: 0.23, boot_l_ratio: 0.003 },
        three_door_share: 0.0,
        is_estate: true,
    },
    Archetype {
        name: "transporter",
        share: 27.0,
        size_m: [(4.78, 0.28), (1.86, 0.09), (2.02, 0.10)],
        wheels: Wheels { wheelbase_l_ratio: 0.61, front_overhang_l_ratio: 0.19, diameter_m: 0.66 },
        clearance_m: 0.20,
        glass: Glass { belt_h_ratio: 0.57, screen_deg: 42.0, backlight_deg: 84.0, tumblehome_deg: 7.0 },
        ends: Ends { bonnet_edge_z: 0.92, cowl_z: 1.20, cowl_l_ratio: 0.165, boot_l_ratio: 0.003 },
        three_door_share: 0.0,
        is_estate: true,
    },
    Archetype {
        name: "medium_van",
        share: 23.0,
        size_m: [(5.60, 0.35), (1.97, 0.11), (2.36, 0.14)],
        wheels: Wheels { wheelbase_l_ratio: 0.61, front_overhang_l_ratio: 0.175, diameter_m: 0.66 },
        clearance_m: 0.20,
        glass: Glass { belt_h_ratio: 0.51, screen_deg: 45.0, backlight_deg: 84.0, tumblehome_deg: 5.0 },
        ends: Ends { bonnet_edge_z: 0.98, cowl_z: 1.25, cowl_l_ratio: 0.15, boot_l_ratio: 0.003 },
        three_door_share: 0.0,
        is_estate: true,
    },
    Archetype {
        name: "high_van",
        share: 20.0,
        size_m: [(6.15, 0.40), (2.03, 0.09), (2.64, 0.12)],
        wheels: Wheels { wheelbase_l_ratio: 0.60, front_overhang_l_ratio: 0.165, diameter_m: 0.66 },
        clearance_m: 0.20,
        glass: Glass { belt_h_ratio: 0.475, screen_deg: 46.0, backlight_deg: 84.0, tumblehome_deg: 4.0 },
        ends: Ends { bonnet_edge_z: 1.00, cowl_z: 1.28, cowl_l_ratio: 0.145, boot_l_ratio: 0.003 },
        three_door_share: 0.0,
        is_estate: true,
    },
];
