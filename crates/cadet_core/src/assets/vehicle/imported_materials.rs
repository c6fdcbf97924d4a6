//! What a user's materials are made of: the part of a vehicle that their names tell, and the color that they state.

use super::paint::{coated, glass};
use crate::assets::import::SourceMaterial;
use crate::error::{Error, Result};
use crate::material::{Material, Pattern, Semantic};

/// The part of a vehicle that a material covers; what is none of these is painted metal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
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
    /// Every role, in the order in which they are tried.
    pub const ALL: [Self; 5] = [Self::Glass, Self::Tyre, Self::Plate, Self::Lamp, Self::Interior];

    /// The role's name in rules.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Glass => "glass",
            Self::Tyre => "tyre",
            Self::Plate => "plate",
            Self::Lamp => "lamp",
            Self::Interior => "interior",
        }
    }

    /// The role of a name.
    ///
    /// # Errors
    /// [`Error::Unknown`], listing the names that exist.
    pub fn from_name(name: &str) -> Result<Self> {
        Self::ALL.into_iter().find(|role| role.name() == name).ok_or_else(|| Error::Unknown {
            what: "material role",
            name: name.to_owned(),
            known: Self::ALL.map(Self::name).join(", "),
        })
    }

    /// The patterns that hold where a user gives none.
    fn default_patterns(self) -> &'static [&'static str] {
        match self {
            Self::Glass => &["*glass*", "*window*", "*windscreen*", "*windshield*"],
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
    /// The role of a material: what is dissolved is glass unless a pattern says otherwise.
    #[must_use]
    pub fn role(&self, name: &str, opacity: f32) -> Option<Role> {
        let own = |role: &Role| self.0.iter().find(|(r, _)| r == role).map(|(_, patterns)| patterns);
        let is_own = |role: &Role| own(role).is_some_and(|patterns| patterns.iter().any(|p| matches(p, name)));
        let is_default = |role: &Role| own(role).is_none() && role.default_patterns().iter().any(|p| matches(p, name));
        let by_name = || Role::ALL.into_iter().find(is_default);
        Role::ALL.into_iter().find(is_own).or_else(|| if opacity < 0.99 { Some(Role::Glass) } else { by_name() })
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
                let known: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
                let (role, known) = (role.name(), known.join(", "));
                let reason = format!("materials.{role}: no material is named {pattern:?}; known: {known}");
                return Err(Error::Mesh { name: file.to_owned(), reason });
            }
        }
        Ok(())
    }
}

/// Whether a name fits a pattern of letters, `*` (any text) and `?` (any letter).
fn matches(pattern: &str, name: &str) -> bool {
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
        None => {
            // Clear coat; red paints are as bright to the laser as their red is to the eye.
            let reflectance = (0.03 + 0.85 * luma.max(albedo[0])).min(0.8);
            let mut paint = coated(semantic, albedo, 0.08, 0.05, reflectance);
            paint.lidar.lobe_exponent = 2.5;
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
        let none = MaterialRules::default();
        assert_eq!(none.role("SUV_Wheels", 1.0), Some(Role::Tyre));
        assert_eq!(none.role("Hybrid_Interior", 1.0), Some(Role::Interior));
        assert_eq!(none.role("Body", 0.1), Some(Role::Glass));
        assert_eq!(none.role("Body", 1.0), None);
        assert_eq!(none.role("LicensePlate", 1.0), Some(Role::Plate));
        let own = MaterialRules(vec![(Role::Lamp, vec!["Body".into()]), (Role::Tyre, vec!["Gummi".into()])]);
        assert_eq!(own.role("body", 0.1), Some(Role::Lamp));
        assert_eq!(own.role("SUV_Wheels", 1.0), None, "a role's own patterns replace its default ones");
        assert_eq!(own.role("Windows", 1.0), Some(Role::Glass));
    }
}
