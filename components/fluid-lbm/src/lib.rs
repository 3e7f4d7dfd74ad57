//! Lattice-Boltzmann fluid of Tremie: D3Q19 in place, moving boundaries
