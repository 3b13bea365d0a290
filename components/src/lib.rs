//! The plant library and the control laws: one file per component
