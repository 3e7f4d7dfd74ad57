//! Shared-memory channels of Tremie: the only code that touches iceoryx2
