//! The integration tests of this package, in one program: it links once.

mod hostile_cell;
mod hostile_urdf;
mod load;
mod ur10;
