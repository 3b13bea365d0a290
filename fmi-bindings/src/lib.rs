//! The C edge of FMI, both ways: export of a model, import of any FMU
