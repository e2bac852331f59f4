//! Tables, from a mesh to what a fit takes from them.

mod datasheet;
mod determinism;
mod deviations;
mod elements;
mod expected_table;
mod front;
mod optimise;
mod rough;
mod sheets;
mod wave;
