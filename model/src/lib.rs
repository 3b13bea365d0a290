//! What a quantity, a component and a chain of components are
