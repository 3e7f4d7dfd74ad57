//! Lets the plain messages of `tremie-messages` travel through iceoryx2, under names of their own.

use iceoryx2::prelude::ZeroCopySend;
use std::mem::MaybeUninit;
use tremie_messages::Message;

/// A message as iceoryx2 sees it: same memory, and the type name that the message gives itself.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Wire<T>(pub T);

// SAFETY: `Message` demands all that `ZeroCopySend` does: `repr(C)`, no pointers, no handles.
unsafe impl<T: Message> ZeroCopySend for Wire<T> {
    unsafe fn type_name() -> &'static str {
        T::TYPE_NAME
    }
}

/// The plain messages in a received payload.
pub fn plain<T: Message>(wired: &[Wire<T>]) -> &[T] {
    // SAFETY: `Wire<T>` is a transparent wrapper of `T`: same size, alignment and validity.
    unsafe { std::slice::from_raw_parts(wired.as_ptr().cast(), wired.len()) }
}

/// The plain slots of a loaned payload.
pub fn plain_slots<T: Message>(wired: &mut [MaybeUninit<Wire<T>>]) -> &mut [MaybeUninit<T>] {
    // SAFETY: as above; `MaybeUninit` keeps size and alignment.
    unsafe { std::slice::from_raw_parts_mut(wired.as_mut_ptr().cast(), wired.len()) }
}
