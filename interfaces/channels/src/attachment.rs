//! A component's access to the shared memory of its run.

use crate::error::ChannelError;
use crate::receiver::Receiver;
use crate::sender::Sender;
use iceoryx2::config::Config;
use iceoryx2::node::{Node, NodeBuilder, node_name::NodeName};
use iceoryx2::prelude::{
    FileName, LogLevel, Path, SemanticString, SignalHandlingMode, set_log_level,
};
use iceoryx2::service::{Service, service_name::ServiceName};
use std::time::Duration;
use tremie_messages::Message;

/// Medium of a run's channels: memory shared between processes, or between threads of one process.
pub trait ChannelMedium: Service + 'static {
    /// The memory of channels comes zeroed from the operating system.
    const ZEROED: bool;
}

/// Longest wait for another member of the run that is making the same channel. A busy disk or a
/// machine that stands still may hold that member up for seconds; whoever dies or hangs over it is
/// found by the orchestrator, which then ends the run.
const CREATION: Duration = Duration::from_secs(60);

/// Components are processes.
pub type SharedMemory = iceoryx2::service::ipc::Service;
/// Components are threads of one process.
pub type InProcess = iceoryx2::service::local::Service;

impl ChannelMedium for SharedMemory {
    const ZEROED: bool = true;
}

impl ChannelMedium for InProcess {
    const ZEROED: bool = false;
}

/// A component's access to the shared memory of its run.
#[derive(Debug)]
pub struct Attachment<S: ChannelMedium> {
    node: Node<S>,
    /// Longest time that a send waits for room.
    patience: Duration,
}

/// Size and depth of a channel. Sender and receiver must give the same.
#[derive(Clone, Copy, Debug)]
pub struct ChannelSpec<'a> {
    /// Name, unique in the run.
    pub service: &'a str,
    /// Most values in one message.
    pub capacity: usize,
    /// Most messages under way.
    pub depth: usize,
    /// Most messages that the receiver keeps at once.
    pub borrowed: usize,
    /// `true`: a full channel makes the sender wait, boundedly. `false`: the oldest message gives
    /// way.
    pub lossless: bool,
}

impl<S: ChannelMedium> Attachment<S> {
    /// Attaches to the run that keeps its bookkeeping in `root` and names its memory with `prefix`.
    /// `patience` bounds every wait of a sender for room.
    ///
    /// # Errors
    /// [`ChannelError::Open`] if the folder cannot be used.
    pub fn open(
        root: &str,
        prefix: &str,
        component: &str,
        patience: Duration,
    ) -> Result<Self, ChannelError> {
        // What iceoryx2 logs on its own, users cannot act on; its errors come back as values.
        set_log_level(LogLevel::Fatal);
        let open = |why: &dyn std::fmt::Debug| ChannelError::open(root, why);
        let mut config = Config::default();
        config.global.prefix = FileName::new(prefix.as_bytes()).map_err(|e| open(&e))?;
        config.global.set_root_path(&Path::new(root.as_bytes()).map_err(|e| open(&e))?);
        config.global.creation_timeout = CREATION;
        // The orchestrator sweeps after everyone has ended; sweeping while others start races with
        // them.
        config.global.node.cleanup_dead_nodes_on_creation = false;
        config.global.node.cleanup_dead_nodes_on_destruction = false;
        config.global.service.cleanup_dead_nodes_on_open = false;
        let node = NodeBuilder::new()
            .name(&NodeName::new(component).map_err(|e| open(&e))?)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .config(&config)
            .create::<S>()
            .map_err(|e| open(&e))?;
        Ok(Self { node, patience })
    }

    /// Opens the sending end of a channel.
    ///
    /// # Errors
    /// [`ChannelError::Open`], for example if the other end has other types or sizes.
    pub fn sender<H: Message + Default, T: Message>(
        &self,
        spec: ChannelSpec<'_>,
    ) -> Result<Sender<S, H, T>, ChannelError> {
        Sender::open(&self.node, spec, self.patience)
    }

    /// As [`Attachment::sender`], with another bound for its waits for room.
    ///
    /// # Errors
    /// As [`Attachment::sender`].
    pub fn sender_with_patience<H: Message + Default, T: Message>(
        &self,
        spec: ChannelSpec<'_>,
        patience: Duration,
    ) -> Result<Sender<S, H, T>, ChannelError> {
        Sender::open(&self.node, spec, patience)
    }

    /// Opens the receiving end of a channel.
    ///
    /// # Errors
    /// [`ChannelError::Open`], for example if the other end has other types or sizes.
    pub fn receiver<H: Message + Default, T: Message>(
        &self,
        spec: ChannelSpec<'_>,
    ) -> Result<Receiver<S, H, T>, ChannelError> {
        Receiver::open(&self.node, spec)
    }

    /// Frees the shared memory of members of the run that died. A sender whose receiver was killed
    /// stays blocked until then.
    pub fn clean_after_dead(&self) {
        self.node.try_cleanup_dead_nodes();
    }

    pub(crate) fn node(&self) -> &Node<S> {
        &self.node
    }
}

pub(crate) fn service_name(name: &str) -> Result<ServiceName, ChannelError> {
    ServiceName::new(name).map_err(|e| ChannelError::open(name, e))
}

/// Opens or creates the service behind a channel; both ends come through here and so agree.
macro_rules! publish_subscribe {
    ($node:expr, $spec:expr, $header:ty, $item:ty) => {
        $node
            .service_builder(&crate::attachment::service_name($spec.service)?)
            .publish_subscribe::<[crate::wire::Wire<$item>]>()
            .user_header::<crate::wire::Wire<$header>>()
            // Without overflow iceoryx2 makes the sender wait, for which `Sender::open` sets a
            // bound.
            .enable_safe_overflow(!$spec.lossless)
            .subscriber_max_buffer_size($spec.depth)
            .subscriber_max_borrowed_samples($spec.borrowed)
            .history_size(0)
            .max_publishers(1)
            .max_subscribers(1)
            .max_nodes(4)
            .open_or_create()
            .map_err(|e| crate::error::ChannelError::open($spec.service, e))?
    };
}
pub(crate) use publish_subscribe;
