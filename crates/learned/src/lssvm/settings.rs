//! The two numbers that a training needs.

use crate::Error;

/// γ and σ².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Weight of the errors against smoothness; 1/γ stands on the diagonal.
    pub gamma: f64,
    /// Square of the kernel's width.
    pub sigma2: f64,
}

impl Settings {
    pub(crate) fn check(self) -> Result<(), Error> {
        let rule = "must be positive and finite";
        for (name, value) in [("gamma", self.gamma), ("sigma^2", self.sigma2)] {
            // Also refuses NaN.
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Setting { name, value, rule });
            }
        }
        Ok(())
    }
}
