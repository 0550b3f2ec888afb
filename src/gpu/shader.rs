//! Shader modules, composed from files at build time.

/// Files of `shaders/shared/`, one after the other.
macro_rules! shared {
    ($($file:literal),*) => {
        concat!($(include_str!(concat!("../../shaders/shared/", $file, ".wgsl")), "\n"),*)
    };
}

/// The BRDF of a paint and all it needs; group 0 is the paint. No entry points.
macro_rules! brdf {
    () => {
        shared!(
            "paint",
            "bands",
            "packed",
            "hash",
            "normal_f32",
            "knots",
            "lab_f32",
            "fresnel",
            "cook_torrance",
            "projected_half",
            "color_table",
            "grid",
            "exact",
            "draw",
            "surface",
            "cells",
            "draws",
            "flake_layout",
            "light_patches",
            "flakes",
            "angle",
            "shade",
            "disc"
        )
    };
}

/// A whole picture; groups 0 and 1 are paint and scene. No entry points.
macro_rules! image {
    () => {
        shared!(
            "camera",
            "shape",
            "mesh",
            "light",
            "bodies",
            "footprint",
            "softbox",
            "panorama",
            "environment",
            "proposal",
            "surroundings",
            "surroundings_flakes",
            "lamp",
            "scene",
            "image"
        )
    };
}

const EVALUATE: &str = concat!(brdf!(), include_str!("../../shaders/evaluate.wgsl"));

const PICTURE: &str = concat!(
    brdf!(),
    image!(),
    shared!("print"),
    include_str!("../../shaders/picture.wgsl"),
    include_str!("../../shaders/print.wgsl")
);

/// Frames; groups 2 and 3 are maps.
macro_rules! frame {
    () => {
        concat!(
            brdf!(),
            image!(),
            include_str!("../../shaders/kept.wgsl"),
            include_str!("../../shaders/frame.wgsl"),
            include_str!("../../shaders/prefilter.wgsl"),
            include_str!("../../shaders/rows.wgsl")
        )
    };
}

const FRAME: &str = frame!();

const RIVALS: &str = concat!(
    frame!(),
    include_str!("../../shaders/rivals/ggx.wgsl"),
    include_str!("../../shaders/rivals/raw.wgsl")
);

/// WGSL of the module of [`super::Rival`].
pub fn rivals_source() -> &'static str {
    RIVALS
}

const REALIZE: &str = concat!(
    shared!("paint", "bands", "packed", "lab_f32"),
    include_str!("../../shaders/realize.wgsl"),
    include_str!("../../shaders/realize/arc.wgsl"),
    include_str!("../../shaders/realize/box_moments.wgsl"),
    include_str!("../../shaders/realize/scatter.wgsl"),
    include_str!("../../shaders/realize/slice.wgsl")
);

/// WGSL of the module of [`super::GpuMix`].
pub fn realize_source() -> &'static str {
    REALIZE
}

/// WGSL of the module of [`super::FrameRenderer`].
pub fn frame_source() -> &'static str {
    FRAME
}

/// WGSL of the module of [`super::Renderer`] and [`super::PrintRenderer`].
pub fn picture_source() -> &'static str {
    PICTURE
}

/// WGSL of the module of [`super::Evaluator`].
pub fn evaluate_source() -> &'static str {
    EVALUATE
}
