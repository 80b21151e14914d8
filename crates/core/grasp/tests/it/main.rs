//! Grasps, by the robots of the checkout.

#[cfg(test)]
mod grasps;
