//! The receiving end of a channel.

use crate::attachment::{ChannelMedium, ChannelSpec, publish_subscribe};
use crate::error::ChannelError;
use crate::wire::{Wire, plain};
use iceoryx2::node::Node;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::sample::Sample;
use tremie_messages::Message;

/// The receiving end of a channel of `T` with a header `H` on each message.
#[derive(Debug)]
pub struct Receiver<S: ChannelMedium, H: Message + Default, T: Message> {
    subscriber: Subscriber<S, [Wire<T>], Wire<H>>,
    name: String,
}

impl<S: ChannelMedium, H: Message + Default, T: Message> Receiver<S, H, T> {
    pub(crate) fn open(node: &Node<S>, spec: ChannelSpec<'_>) -> Result<Self, ChannelError> {
        let service = publish_subscribe!(node, spec, H, T);
        let subscriber = service
            .subscriber_builder()
            .buffer_size(spec.depth)
            .create()
            .map_err(|e| ChannelError::open(spec.service, e))?;
        Ok(Self { subscriber, name: spec.service.to_string() })
    }

    /// The oldest message that has arrived, if any. Never blocks.
    ///
    /// # Errors
    /// [`ChannelError::Failed`].
    pub fn take(&self) -> Result<Option<Received<S, H, T>>, ChannelError> {
        let sample = self.subscriber.receive().map_err(|e| ChannelError::failed(&self.name, e))?;
        Ok(sample.map(Received))
    }
}

/// A message, read where the sender wrote it. Dropping it gives the memory back.
#[derive(Debug)]
pub struct Received<S: ChannelMedium, H: Message + Default, T: Message>(
    Sample<S, [Wire<T>], Wire<H>>,
);

impl<S: ChannelMedium, H: Message + Default, T: Message> Received<S, H, T> {
    /// The header.
    pub fn header(&self) -> &H {
        &self.0.user_header().0
    }

    /// The values.
    pub fn values(&self) -> &[T] {
        plain(self.0.payload())
    }
}
