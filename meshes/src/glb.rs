//! GLB container.
