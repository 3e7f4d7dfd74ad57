//! Streams a Tremie run into Rerun
