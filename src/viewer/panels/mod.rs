//! What stands around the picture: each panel draws a part of the state and changes it.

pub mod composition;
pub mod controls;
pub mod files;
pub mod help;
pub mod light;
pub mod measure;
pub mod mix;
pub mod pad;
pub mod picture;
pub mod status;
pub mod view;
