//! Empty: nothing here calls bindgen.
