//! Numbers whose arrays are kept as they lie in memory.

use bytemuck::Pod;

/// A number, or a short row of them, with its name in NumPy.
pub trait StateNumber: Pod {
    /// NumPy's name of the single number, as `<f8`.
    const NAME: &'static str;
    /// Lengths of a row; none of a single number.
    const ROW: &'static [usize];
}

macro_rules! number {
    ($($number:ty => $name:literal),*) => {$(
        impl StateNumber for $number {
            const NAME: &'static str = $name;
            const ROW: &'static [usize] = &[];
        }

        impl<const N: usize> StateNumber for [$number; N] {
            const NAME: &'static str = $name;
            const ROW: &'static [usize] = &[N];
        }
    )*};
}

number!(
    f64 => "<f8", f32 => "<f4", u64 => "<u8", u32 => "<u4", u16 => "<u2", u8 => "|u1",
    i64 => "<i8", i32 => "<i4", i16 => "<i2", i8 => "|i1"
);

// Arrays are kept as they lie in memory, and their names say in which order of bytes that is.
#[cfg(not(target_endian = "little"))]
compile_error!("states are kept by machines whose bytes are in little-endian order");

/// Type and lengths of an array of rows, as messages have them: `<f8, 12 x 3`.
pub(crate) fn describe(name: &str, shape: &[usize]) -> String {
    let lengths: Vec<String> = shape.iter().map(usize::to_string).collect();
    format!("{name}, {}", lengths.join(" x "))
}

/// Lengths of an array of so many rows.
pub(crate) fn shape_of<T: StateNumber>(rows: usize) -> Vec<usize> {
    std::iter::once(rows).chain(T::ROW.iter().copied()).collect()
}
