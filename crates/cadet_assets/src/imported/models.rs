//! A user's models: those that traffic draws from, and those that are placed by name.

use std::sync::Arc;

use super::asset::MeshAsset;
use super::figure::FigureModel;
use crate::vehicle::VehicleModel;
use cadet_base::actor::ObjectClass;
use cadet_base::error::{Error, Result};
use cadet_base::math::DVec3;
use cadet_base::rng::Stream;

/// A user's vehicles, to be mixed among those that are built in, and people and riders, who appear where they are put.
#[derive(Debug, Clone, Default)]
pub struct UserModels {
    share: f64,
    vehicles: Vec<Arc<VehicleModel>>,
    figures: Vec<Arc<FigureModel>>,
    assumptions: Vec<String>,
}

/// One of a user's models.
#[derive(Debug, Clone, Copy)]
pub enum UserModel<'a> {
    /// A vehicle.
    Vehicle(&'a Arc<VehicleModel>),
    /// A person or a rider.
    Figure(&'a Arc<FigureModel>),
}

impl<'a> UserModel<'a> {
    /// The user's name for it.
    #[must_use]
    pub fn name(self) -> &'a str {
        match self {
            Self::Vehicle(model) => &model.name,
            Self::Figure(model) => &model.name,
        }
    }

    /// KITTI's class.
    #[must_use]
    pub fn class(self) -> ObjectClass {
        match self {
            Self::Vehicle(model) => model.class,
            Self::Figure(model) => model.class,
        }
    }

    /// Length, width, height of its box.
    #[must_use]
    pub fn size_lwh(self) -> DVec3 {
        match self {
            Self::Vehicle(model) => model.size_lwh,
            Self::Figure(model) => model.size_lwh,
        }
    }
}

impl UserModels {
    /// Models of whose vehicles traffic and parked vehicles get a share in 0..=1.
    ///
    /// # Errors
    /// As [`VehicleModel::from_asset`] and [`FigureModel::with_assumptions`], [`Error::OutOfRange`] for the share,
    /// [`Error::Mesh`] for a name used twice.
    pub fn new(share: f64, assets: &[MeshAsset]) -> Result<Self> {
        if !(0.0..=1.0).contains(&share) {
            let expected = "0 to 1".to_owned();
            return Err(Error::OutOfRange { what: "share of user vehicles", value: share.to_string(), expected });
        }
        let mut own = Self { share, ..Self::default() };
        for asset in assets {
            if own.models().any(|m| m.name() == asset.name) {
                let reason = format!("the name {:?} is taken", asset.name);
                return Err(Error::Mesh { name: asset.file.clone(), reason });
            }
            own.assumptions.extend(if asset.class.is_human() {
                let (figure, assumed) = FigureModel::with_assumptions(asset)?;
                own.figures.push(Arc::new(figure));
                assumed
            } else {
                let (vehicle, assumed) = VehicleModel::with_assumptions(asset)?;
                own.vehicles.push(Arc::new(vehicle));
                assumed
            });
        }
        Ok(own)
    }

    /// What was assumed of meshes that say too little: a line each, led by the file's name.
    #[must_use]
    pub fn assumptions(&self) -> &[String] {
        &self.assumptions
    }

    /// The vehicles, then the people and riders, each in the order given.
    pub fn models(&self) -> impl Iterator<Item = UserModel<'_>> {
        let figures = self.figures.iter().map(UserModel::Figure);
        self.vehicles.iter().map(UserModel::Vehicle).chain(figures)
    }

    /// The model of a name, which is to be of a class.
    ///
    /// # Errors
    /// [`Error::Unknown`], listing the names that exist, or [`Error::Scene`] for a model of another class.
    pub fn by_name(&self, class: ObjectClass, name: &str) -> Result<UserModel<'_>> {
        let model = self.models().find(|m| m.name() == name).ok_or_else(|| {
            let names: Vec<&str> = self.models().map(UserModel::name).collect();
            let known = if names.is_empty() { "none, the scene has no assets".to_owned() } else { names.join(", ") };
            Error::Unknown { what: "model", name: name.to_owned(), known }
        })?;
        if model.class() != class {
            let (found, wanted) = (model.class().kitti_name(), class.kitti_name());
            return Err(Error::Scene { reason: format!("model {name:?} is a {found}, not a {wanted}") });
        }
        Ok(model)
    }

    /// With the probability of the share one of the vehicles that `fits`, its class by `mix` as far as there are meshes
    /// of it. Draws nothing where there are no vehicles.
    pub fn draw(
        &self,
        stream: &mut Stream,
        mix: &[(ObjectClass, f64)],
        fits: impl Fn(&VehicleModel) -> bool,
    ) -> Option<Arc<VehicleModel>> {
        if self.vehicles.is_empty() || self.share <= 0.0 || !stream.chance(self.share) {
            return None;
        }
        let fitting: Vec<&Arc<VehicleModel>> = self.vehicles.iter().filter(|m| fits(m)).collect();
        let count = |class: ObjectClass| fitting.iter().filter(|m| m.class == class).count();
        let weight = |m: &VehicleModel| {
            mix.iter().find(|(class, _)| *class == m.class).map_or(0.0, |(_, w)| w / count(m.class) as f64)
        };
        let weights: Vec<f64> = fitting.iter().map(|m| weight(m)).collect();
        if !weights.iter().any(|w| *w > 0.0) {
            return None;
        }
        let model = fitting.get(stream.weighted(&weights))?;
        Some(Arc::new(VehicleModel::clone(model).annotated_by(stream.next_u64())))
    }
}
