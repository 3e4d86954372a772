//! The forward rasteriser: images and counters from a scene and a camera.
