//! Bandwidth of the memory, measured by loops like those of the solvers.
//!
//! A lattice that streams in place reads and writes the same lines, so its limit is the bandwidth
//! of an update in place. Copy and triad write lines that they have not read: the processor reads
//! these lines first.

use std::time::Instant;
use tremie_sdk::benchmark::{Benchmark, Measurement, Quantity};
use tremie_team::{Cut, Team};

/// Numbers in an array: three of them are far larger than caches.
const LENGTH: usize = 24 << 20;
/// Numbers that a thread takes at once.
const TOGETHER: usize = 1 << 16;

/// Three arrays, and the threads that go through them.
pub struct Stream {
    team: Team,
    a: Vec<f64>,
    b: Vec<f64>,
    c: Vec<f64>,
}

impl Stream {
    /// With so many threads.
    ///
    /// # Errors
    /// If the system gives no threads.
    pub fn new(threads: usize) -> Result<Self, String> {
        let team = Team::new("bench", threads).map_err(|error| error.to_string())?;
        Ok(Self { team, a: vec![1.0; LENGTH], b: vec![2.0; LENGTH], c: vec![0.5; LENGTH] })
    }

    /// `a = s a`: bytes read and written [GB/s].
    pub fn in_place(&mut self) -> f64 {
        let start = Instant::now();
        self.team.for_pieces(Cut::every(&mut self.a, TOGETHER), |_, a: &mut [f64]| {
            a.iter_mut().for_each(|a| *a *= 0.999_999);
        });
        rate(16, start)
    }

    /// `a = b`: bytes read and written, without the reads of lines before they are written [GB/s].
    pub fn copy(&mut self) -> f64 {
        let start = Instant::now();
        let b = &self.b;
        self.team.for_pieces(Cut::every(&mut self.a, TOGETHER), |k, a: &mut [f64]| {
            a.copy_from_slice(&b[k * TOGETHER..][..a.len()]);
        });
        rate(16, start)
    }

    /// `a = b + s c`, counted likewise [GB/s].
    pub fn triad(&mut self) -> f64 {
        let start = Instant::now();
        let (b, c) = (&self.b, &self.c);
        self.team.for_pieces(Cut::every(&mut self.a, TOGETHER), |k, a: &mut [f64]| {
            // Piece `k` of `a` lies at the same place in `b` and `c`.
            let own = k * TOGETHER..k * TOGETHER + a.len();
            for ((a, b), c) in a.iter_mut().zip(&b[own.clone()]).zip(&c[own]) {
                *a = b + 3.0 * c;
            }
        });
        rate(24, start)
    }
}

fn rate(bytes: usize, start: Instant) -> f64 {
    1e-9 * (bytes * LENGTH) as f64 / start.elapsed().as_secs_f64()
}

/// Bandwidths.
pub fn benchmarks(threads: &[usize]) -> Vec<Benchmark> {
    let case = |&threads: &usize| {
        let make = move || {
            let mut stream = Stream::new(threads)?;
            let measure: Measurement =
                Box::new(move |_| Ok(vec![stream.in_place(), stream.copy(), stream.triad()]));
            Ok(measure)
        };
        let quantities =
            ["in place", "copy", "triad"].map(|name| Quantity::new(name, "GB/s")).to_vec();
        Benchmark { name: "memory".into(), threads, quantities, make: Box::new(make) }
    };
    threads.iter().map(case).collect()
}
