//! What ranks need of each other: the seam behind which MPI is.

/// Bytes to or from another rank.
#[derive(Clone, Debug, Default)]
pub struct Parcel {
    /// The other rank.
    pub rank: usize,
    /// What goes there, or came from there: as many as both know beforehand.
    pub bytes: Vec<u8>,
}

/// The way to the other ranks of a lattice that is computed in parts. All ranks make the same calls in the same
/// order. Rank 0 is the one that the rest of the run knows.
///
/// None of these fails: where a rank is lost, whoever implements this ends the process and says which, for no part
/// of a lattice can go on without the others.
pub trait Communicator: Send {
    /// Number of this rank.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn ranks(&self) -> usize;

    /// Adds up numbers over all ranks, each by itself.
    fn add_up(&mut self, numbers: &mut [i64]);

    /// Finds the largest of numbers over all ranks, each by itself.
    fn largest(&mut self, numbers: &mut [i64]);

    /// Begins to send parcels to other ranks, and to receive theirs. Parcels to and from one rank keep their order. The
    /// bytes of all parcels must keep their place in memory, and sent ones their values, until `end_swap` is back.
    fn begin_swap(&mut self, sends: &[Parcel], receives: &mut [Parcel]);

    /// Ends it: the parcels that come are there.
    fn end_swap(&mut self, receives: &mut [Parcel]);

    /// Gives rank 0 the bytes of all ranks, in their order; others get nothing.
    fn gather(&mut self, bytes: &[u8]) -> Vec<Vec<u8>>;

    /// Gives all ranks the bytes of rank 0.
    fn broadcast(&mut self, bytes: &mut Vec<u8>);

    /// Gives all ranks the bytes of all, one after the other in the order of the ranks.
    fn gather_to_all(&mut self, bytes: &[u8]) -> Vec<u8> {
        let mut all = self.gather(bytes).concat();
        self.broadcast(&mut all);
        all
    }
}
