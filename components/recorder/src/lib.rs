//! Writes a Tremie run to MCAP
