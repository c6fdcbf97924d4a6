//! The camera: model, shading, sky, shadows, noise, PNG.
