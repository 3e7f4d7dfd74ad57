//! Discrete elements of Tremie: spheres, walls, contacts with friction
