//! What a user's materials are made of: the part of a body that their names tell, and the color that they state.

use strum::{AsRefStr, VariantArray};

use crate::source_mesh::SourceMaterial;
use crate::vehicle::{coated, glass};
use cadet_base::actor::ObjectClass;
use cadet_base::error::{Error, Result, variant};
use cadet_base::material::{LidarMaterial, Material, Pattern, Semantic};

/// What frames a pane.
const TRIM: &[&str] = &["*trim*", "*frame*", "*seal*", "*rubber*"];

/// The part of a body that a material covers, in the order of trial; what is none of these is painted metal, or cloth of
/// people and riders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, AsRefStr, VariantArray)]
#[strum(serialize_all = "lowercase")]
pub enum Role {
    /// Panes: camera and laser look through.
    Glass,
    /// Tires, and wheels where they have one material with them.
    Tyre,
    /// Number plates, which throw the laser straight back.
    Plate,
    /// Lamps.
    Lamp,
    /// Seats, dashboard, steering wheel.
    Interior,
}

impl Role {
    /// The role of a name.
    ///
    /// # Errors
    /// [`Error::Unknown`], listing the names that exist.
    pub fn from_name(name: &str) -> Result<Self> {
        variant("material role", name, |known| known == name)
    }

    /// The patterns that hold where a user gives none.
    fn default_patterns(self) -> &'static [&'static str] {
        match self {
            Self::Glass => &["*glass*", "*windscreen*", "*windshield*"],
            Self::Tyre => &["*tire*", "*tyre*", "*wheel*", "*rubber*"],
            Self::Plate => &["*licen?e*", "*plate*"],
            Self::Lamp => &["*lamp*", "*light*"],
            Self::Interior => &["*interior*", "*seat*", "*dashboard*", "*steering*"],
        }
    }
}

/// Which materials have which role: patterns with `*` and `?`, in any letter case. A role's own patterns replace its
/// default ones.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MaterialRules(pub Vec<(Role, Vec<String>)>);

impl MaterialRules {
    /// The role of each of a mesh's materials. The user's patterns come first; then what is dissolved is glass; then the
    /// default patterns say. An opaque window is a pane only in a mesh that has no other.
    #[must_use]
    pub fn roles(&self, materials: &[SourceMaterial]) -> Vec<Option<Role>> {
        let roles: Vec<Option<Role>> = materials.iter().map(|m| self.role(m)).collect();
        let is_pane = |(m, role): (&SourceMaterial, &Option<Role>)| {
            *role == Some(Role::Glass) && !fits_any(Role::Lamp.default_patterns(), &m.name)
        };
        if self.names(Role::Glass) || materials.iter().zip(&roles).any(is_pane) {
            return roles;
        }
        let is_window = |m: &SourceMaterial| fits_any(&["*window*"], &m.name) && !fits_any(TRIM, &m.name);
        let or_glass = |(m, role): (&SourceMaterial, Option<Role>)| {
            if role.is_none() && is_window(m) { Some(Role::Glass) } else { role }
        };
        materials.iter().zip(roles).map(or_glass).collect()
    }

    /// The role of each of a figure's materials: what the user says, and a rider's tires; all else is cloth. Hair may
    /// be dissolved, and light is a color, too.
    #[must_use]
    pub(super) fn roles_of_figure(&self, class: ObjectClass, materials: &[SourceMaterial]) -> Vec<Option<Role>> {
        let rides = class == ObjectClass::Cyclist && !self.names(Role::Tyre);
        let is_tyre = |name: &str| rides && fits_any(Role::Tyre.default_patterns(), name);
        let role = |m: &SourceMaterial| self.own_role(&m.name).or(is_tyre(&m.name).then_some(Role::Tyre));
        materials.iter().map(role).collect()
    }

    /// The role that the user gives a name.
    fn own_role(&self, name: &str) -> Option<Role> {
        let is_of = |role: &Role| self.0.iter().any(|(r, patterns)| r == role && fits_any(patterns, name));
        Role::VARIANTS.iter().copied().find(is_of)
    }

    fn role(&self, material: &SourceMaterial) -> Option<Role> {
        let name = &material.name;
        if let Some(role) = self.own_role(name) {
            return Some(role);
        }
        if material.opacity < 0.99 {
            return Some(Role::Glass);
        }
        // The rubber around a pane is neither the pane nor a tire.
        if fits_any(TRIM, name) && (fits_any(Role::Glass.default_patterns(), name) || fits_any(&["*window*"], name)) {
            return None;
        }
        Role::VARIANTS.iter().copied().find(|role| !self.names(*role) && fits_any(role.default_patterns(), name))
    }

    /// True where the user says what is of a role, even if it is nothing.
    #[must_use]
    pub fn names(&self, role: Role) -> bool {
        self.0.iter().any(|(named, _)| *named == role)
    }

    /// Refuses a pattern that names none of a file's materials.
    ///
    /// # Errors
    /// [`Error::Mesh`], listing the materials that exist.
    pub(crate) fn check(&self, file: &str, materials: &[SourceMaterial]) -> Result<()> {
        let lost = self.0.iter().flat_map(|(role, patterns)| patterns.iter().map(move |p| (role, p)));
        for (role, pattern) in lost {
            if !materials.iter().any(|m| matches(pattern, &m.name)) {
                let (role, known) = (role.as_ref(), listed(materials.iter().map(|m| &m.name)));
                let reason = format!("materials.{role}: no material is named {pattern:?}; known: {known}");
                return Err(Error::Mesh { name: file.to_owned(), reason });
            }
        }
        Ok(())
    }
}

fn fits_any(patterns: &[impl AsRef<str>], name: &str) -> bool {
    patterns.iter().any(|pattern| matches(pattern.as_ref(), name))
}

/// Whether a name fits a pattern of letters, `*` (any text) and `?` (any letter).
pub(super) fn matches(pattern: &str, name: &str) -> bool {
    let lower = |text: &str| -> Vec<char> { text.chars().flat_map(char::to_lowercase).collect() };
    let (pattern, name) = (lower(pattern), lower(name));
    // Where the pattern's last star is, and the text from which it is tried next.
    let (mut p, mut n, mut retry) = (0, 0, None);
    while n < name.len() {
        if pattern.get(p) == Some(&'*') {
            retry = Some((p, n));
            p += 1;
        } else if pattern.get(p).is_some_and(|c| *c == '?' || *c == name[n]) {
            (p, n) = (p + 1, n + 1);
        } else if let Some((star, from)) = retry {
            retry = Some((star, from + 1));
            (p, n) = (star + 1, from + 1);
        } else {
            return false;
        }
    }
    pattern[p..].iter().all(|c| *c == '*')
}

/// Names, each once, as many as one line can take.
pub(super) fn listed<'a>(names: impl Iterator<Item = &'a String>) -> String {
    const MOST: usize = 30;
    let mut known: Vec<&str> = Vec::new();
    for name in names.filter(|name| !name.is_empty()) {
        if !known.contains(&name.as_str()) {
            known.push(name);
            if known.len() > MOST {
                known[MOST] = "...";
                break;
            }
        }
    }
    known.join(", ")
}

/// A material for eye and laser: the color is the file's, the rest follows from the role.
pub(super) fn material(source: Option<&SourceMaterial>, role: Option<Role>, semantic: Semantic) -> Material {
    let stated = source.and_then(|m| m.albedo).unwrap_or([0.4; 3]);
    let albedo = stated.map(|c| if c.is_finite() { c.clamp(0.008, 0.85) } else { 0.4 });
    let luma = 0.2126 * albedo[0] + 0.7152 * albedo[1] + 0.0722 * albedo[2];
    match role {
        Some(Role::Glass) => {
            // A file's panes state how much they dissolve; panes known by their name alone are clear.
            let opacity = source.map_or(1.0, |m| m.opacity);
            let eye = if opacity < 0.99 { (0.87 * (1.0 - opacity)).clamp(0.15, 0.80) } else { 0.76 };
            glass(semantic, [0.83, 0.90, 0.86], eye, (eye * 1.04).min(0.80))
        }
        Some(Role::Tyre) => coated(semantic, [0.035; 3], 0.75, 0.02, 0.06),
        Some(Role::Plate) => {
            let mut plate = coated(semantic, albedo, 0.5, 0.03, 0.9);
            plate.lidar.retro = true;
            plate
        }
        Some(Role::Lamp) => coated(semantic, albedo, 0.09, 0.07, 0.35),
        // Cloth and dyed plastic are clearer at 905 nm than they look.
        Some(Role::Interior) => Material::matt(semantic, albedo, Pattern::Plain, (0.10 + 0.6 * luma).min(0.7)),
        // Dyes are clear at 905 nm: somebody's clothes and skin return much whatever the eye sees.
        None if matches!(semantic, Semantic::Person | Semantic::Cyclist) => {
            Material::matt(semantic, albedo, Pattern::Cloth, (0.35 + 0.5 * luma).min(0.7))
        }
        None => {
            // Clear coat; red paints are as bright to the laser as their red is to the eye.
            let reflectance = (0.03 + 0.85 * luma.max(albedo[0])).min(0.8);
            let mut paint = coated(semantic, albedo, 0.08, 0.05, reflectance);
            paint.lidar.coat_index = LidarMaterial::LACQUER_INDEX;
            paint
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_as_in_a_shell() {
        for (pattern, name) in [("*glass*", "Front_GLASS_01"), ("w?ndow", "Window"), ("*a*b*", "xaayyb"), ("*", "")] {
            assert!(matches(pattern, name), "{pattern} {name}");
        }
        for (pattern, name) in [("glass", "glasses"), ("w?ndow", "wndow"), ("*a*b", "ba"), ("", "x"), ("?", "")] {
            assert!(!matches(pattern, name), "{pattern} {name}");
        }
    }

    #[test]
    fn names_and_opacity_tell_the_role_and_own_patterns_win() {
        let role = |rules: &MaterialRules, name: &str, opacity| {
            rules.roles(&[SourceMaterial { name: name.to_owned(), albedo: None, opacity }])[0]
        };
        let none = MaterialRules::default();
        assert_eq!(role(&none, "SUV_Wheels", 1.0), Some(Role::Tyre));
        assert_eq!(role(&none, "Hybrid_Interior", 1.0), Some(Role::Interior));
        assert_eq!(role(&none, "Body", 0.1), Some(Role::Glass));
        assert_eq!(role(&none, "Body", 1.0), None);
        assert_eq!(role(&none, "LicensePlate", 1.0), Some(Role::Plate));
        let own = MaterialRules(vec![(Role::Lamp, vec!["Body".into()]), (Role::Tyre, vec!["Gummi".into()])]);
        assert_eq!(role(&own, "body", 0.1), Some(Role::Lamp));
        assert_eq!(role(&own, "SUV_Wheels", 1.0), None, "a role's own patterns replace its default ones");
        assert_eq!(role(&own, "Windows", 1.0), Some(Role::Glass));
    }

    #[test]
    fn a_window_that_is_opaque_is_a_pane_only_where_there_is_no_other() {
        let glass = Some(Role::Glass);
        for (materials, expected) in [
            (vec![("Window", 1.0)], vec![glass]),
            (vec![("window_trim", 1.0), ("glass", 0.3)], vec![None, glass]),
            (vec![("Window", 1.0), ("Pane", 0.3)], vec![None, glass]),
            (vec![("Window", 1.0), ("Headlight_Glass", 0.3)], vec![glass, glass]),
            (vec![("WindowSeal", 1.0), ("Window", 1.0)], vec![None, glass]),
            (vec![("Glass_Frame", 1.0), ("Windshield", 1.0)], vec![None, glass]),
            (vec![("window rubber", 1.0), ("Rubber", 1.0)], vec![None, Some(Role::Tyre)]),
            (vec![("window_frame", 0.5)], vec![glass]),
        ] {
            let sources: Vec<SourceMaterial> = materials
                .iter()
                .map(|(name, opacity)| SourceMaterial { name: (*name).to_owned(), albedo: None, opacity: *opacity })
                .collect();
            assert_eq!(MaterialRules::default().roles(&sources), expected, "{materials:?}");
        }
    }
}
