//! Bodies that move: poses, rasters, flags of cells.

pub mod body;
pub mod body_list;
pub mod body_memory;
pub mod body_shapes;
pub mod change_blocks;
pub mod deformable_shape;
pub mod deformable_surface;
pub mod events;
pub mod facet_sums;
pub mod mass_account;
pub mod mesh_body;
pub mod mesh_raster;
pub mod near_cells;
pub mod pose_rounding;
pub mod ridges;
pub mod sphere_raster;
