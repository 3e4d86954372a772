//! Reports: one folder per run, derived from the record.
