//! What the author of a Tremie component needs: handshake, step loop, deadlines, faults
