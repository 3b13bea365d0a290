//! Results as a typed context, a JSON file and one self-contained page
