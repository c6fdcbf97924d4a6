//! Houses, plants, fences and street furniture.
