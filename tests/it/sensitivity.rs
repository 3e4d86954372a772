//! Sensitivity: estimators on functions whose indices are known, elasticities against differences
//! on a machine, dead keys against `arch-configs/inert.toml`, and the command.

mod estimators;
