//! Blueprints of the papers' machines
