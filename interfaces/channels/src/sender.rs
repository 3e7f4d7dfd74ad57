//! The sending end of a channel.

use crate::attachment::{ChannelMedium, ChannelSpec, publish_subscribe};
use crate::error::ChannelError;
use crate::wire::{Wire, plain_slots};
use iceoryx2::node::Node;
use iceoryx2::port::BackpressureAction;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::sample_mut_uninit::SampleMutUninit;
use std::cell::Cell;
use std::mem::MaybeUninit;
use std::rc::Rc;
use std::time::Duration;
use tremie_messages::Message;

/// The sending end of a channel of `T` with a header `H` on each message.
#[derive(Debug)]
pub struct Sender<S: ChannelMedium, H: Message + Default, T: Message> {
    publisher: Publisher<S, [Wire<T>], Wire<H>>,
    name: Rc<str>,
    capacity: usize,
    /// Somebody reads the last message still.
    is_read: Cell<bool>,
}

impl<S: ChannelMedium, H: Message + Default, T: Message> Sender<S, H, T> {
    pub(crate) fn open(
        node: &Node<S>,
        spec: ChannelSpec<'_>,
        patience: Duration,
    ) -> Result<Self, ChannelError> {
        let service = publish_subscribe!(node, spec, H, T);
        let publisher = service
            .publisher_builder()
            .initial_max_slice_len(spec.capacity.max(1))
            // `of_channel` counts one message that is being written, so no second one may be
            // loaned.
            .max_loaned_samples(1)
            // A bounded wait: without a handler iceoryx2 loses the message, or waits for ever.
            .set_backpressure_handler(move |info| {
                if info.elapsed_time < patience {
                    BackpressureAction::Retry
                } else {
                    BackpressureAction::DiscardDataAndFail
                }
            })
            .create()
            .map_err(|e| ChannelError::open(spec.service, e))?;
        let (name, capacity) = (spec.service.into(), spec.capacity.max(1));
        Ok(Self { publisher, name, capacity, is_read: Cell::new(false) })
    }

    /// Connects to a receiver that has opened its end by now, so that the first send need not.
    ///
    /// # Errors
    /// [`ChannelError::Failed`].
    pub fn connect(&self) -> Result<(), ChannelError> {
        self.publisher.update_connections().map_err(|e| ChannelError::failed(&self.name, e))
    }

    /// Loans a message of `count` values from shared memory, to be filled in place.
    ///
    /// The values start as zeros, or as values of an earlier message.
    ///
    /// # Errors
    /// [`ChannelError::Capacity`] if the channel was made for less.
    ///
    /// # Panics
    /// Inside the function that [`Sender::send_then`] calls.
    pub fn loan(&self, count: usize) -> Result<Loan<S, H, T>, ChannelError> {
        assert!(!self.is_read.get(), "a message that was sent is still being read");
        if count > self.capacity {
            return Err(ChannelError::Capacity {
                channel: self.name.to_string(),
                found: count,
                capacity: self.capacity,
            });
        }
        let mut sample = self
            .publisher
            .loan_slice_uninit(count)
            .map_err(|e| ChannelError::failed(&self.name, e))?;
        // The memory of threads is not zeroed, and values that were never written must not be read.
        if !S::ZEROED {
            for slot in sample.payload_mut() {
                *slot = MaybeUninit::zeroed();
            }
        }
        Ok(Loan { sample, name: self.name.clone() })
    }

    /// Sends `loan`, one of this sender's, and then does with its values what need not be done before the
    /// receiver has them.
    ///
    /// # Errors
    /// As [`Loan::send`]; then nothing more is done.
    ///
    /// # Panics
    /// If the loan is another sender's.
    pub fn send_then<R>(
        &self,
        mut loan: Loan<S, H, T>,
        header: H,
        then: impl FnOnce(&[T]) -> R,
    ) -> Result<R, ChannelError> {
        assert!(Rc::ptr_eq(&loan.name, &self.name), "a loan is sent by the sender that gave it");
        let values: *const [T] = loan.values();
        loan.send(header)?;
        self.is_read.set(true);
        // SAFETY: the memory is this sender's, which lives as long as `self`. Receivers only read it, and
        // the sender, which belongs to one thread, writes to it at the next loan at the earliest: there
        // is none while `is_read`.
        let done = then(unsafe { &*values });
        self.is_read.set(false);
        Ok(done)
    }

    /// Sends a message whose values are copied from `values`.
    ///
    /// # Errors
    /// As [`Sender::loan`] and [`Loan::send`].
    pub fn send_copy(&self, header: H, values: &[T]) -> Result<(), ChannelError> {
        let mut loan = self.loan(values.len())?;
        loan.values().copy_from_slice(values);
        loan.send(header)
    }
}

/// A message under construction, in shared memory.
pub struct Loan<S: ChannelMedium, H: Message + Default, T: Message> {
    sample: SampleMutUninit<S, [MaybeUninit<Wire<T>>], Wire<H>>,
    name: Rc<str>,
}

impl<S: ChannelMedium, H: Message + Default, T: Message> Loan<S, H, T> {
    /// The values, to be written.
    pub fn values(&mut self) -> &mut [T] {
        let slots = plain_slots(self.sample.payload_mut());
        // SAFETY: the memory is initialised, by the operating system or in `loan` (see
        // `ChannelMedium::ZEROED`), and every bit pattern is a valid `T` (contract of `Message`).
        unsafe { std::slice::from_raw_parts_mut(slots.as_mut_ptr().cast(), slots.len()) }
    }

    /// Sends the message.
    ///
    /// # Errors
    /// [`ChannelError::Full`] if the receiver made no room in time.
    pub fn send(mut self, header: H) -> Result<(), ChannelError> {
        *self.sample.user_header_mut() = Wire(header);
        // SAFETY: initialised, see `values`.
        let sample = unsafe { self.sample.assume_init() };
        match sample.send() {
            Ok(_) => Ok(()),
            Err(iceoryx2::port::SendError::UnableToDeliver) => {
                Err(ChannelError::Full { channel: self.name.to_string() })
            }
            Err(why) => Err(ChannelError::failed(&self.name, why)),
        }
    }
}
