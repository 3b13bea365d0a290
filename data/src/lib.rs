//! Logs and blueprints: read, write, check, resample
