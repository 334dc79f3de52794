//! Keeping cloth clear of the body and of itself.

mod body_contact;
mod self_contact;

pub use body_contact::{BodyContact, BodyContactSettings, sag};
pub use self_contact::{Meets, PairHessian, SELF_STIFFNESS, SelfContact, SelfContactSettings};
