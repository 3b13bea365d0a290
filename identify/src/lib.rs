//! From a measured log to a blueprint
