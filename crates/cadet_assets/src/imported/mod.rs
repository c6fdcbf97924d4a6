//! Vehicles, people, and riders made of a user's meshes.

mod asset;
mod figure;
mod fit;
mod materials;
mod models;
#[cfg(test)]
mod tests;
mod vehicle;
mod windows;

pub use asset::MeshAsset;
pub use figure::FigureModel;
pub use materials::{MaterialRules, Role};
pub use models::{UserModel, UserModels};
