//! Keeping cloth clear of the body and of itself.

mod body_contact;
mod distance_bounds;
mod self_contact;

pub use body_contact::{BodyContact, BodyContactSettings, sag};
pub use distance_bounds::{DistanceBounds, below};
pub use self_contact::{Meets, PairHessian, SELF_STIFFNESS, SelfContact, SelfContactSettings};
