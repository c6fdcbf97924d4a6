//! Parametric shapes: every asset is a pure function of its parameters and a seed.

pub mod annotation;
pub mod belongings;
pub mod cyclist;
pub mod imported;
pub mod person;
pub mod props;
#[cfg(test)]
mod rays;
pub mod scenery;
pub mod source_mesh;
pub mod vehicle;
