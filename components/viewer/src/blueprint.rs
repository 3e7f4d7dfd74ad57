//! A layout of views as Rerun stores it.
//!
//! The crate's own builder (0.36) has no way to set the eye of a 3-D view, the bounds of a 2-D view
//! or the legend of a plot; so the few records of a blueprint are written here.

use rerun::blueprint::components::{
    ActiveTab, ColumnShare, ContainerKind, IncludedContent, PanelState, PlayState, QueryExpression,
    RootContainer, RowShare, TimelineName, ViewClass,
};
use rerun::external::re_log_types::{BlueprintActivationCommand, LogMsg};
use rerun::external::re_sdk_types::blueprint::archetypes::{
    ContainerBlueprint, PanelBlueprint, TimePanelBlueprint, ViewBlueprint, ViewContents,
    ViewportBlueprint,
};
use rerun::{AsComponents, RecordingStream, RecordingStreamBuilder, RecordingStreamResult};
use std::hash::{DefaultHasher, Hash, Hasher};

/// A part of the layout.
pub enum Part {
    /// A view.
    View(View),
    /// Parts side by side, above each other or behind each other.
    Container(Container),
}

/// A view of some entities.
pub struct View {
    class: &'static str,
    name: String,
    origin: String,
    pub(crate) contents: Vec<String>,
    properties: Vec<(&'static str, Box<dyn AsComponents>)>,
}

/// Parts side by side, above each other or behind each other.
pub struct Container {
    kind: ContainerKind,
    name: String,
    parts: Vec<(Part, f32)>,
    /// Place of the tab that is open.
    open: usize,
}

impl View {
    /// A view of class `class` (Rerun's name of it) on `origin` and everything below.
    pub fn new(class: &'static str, name: impl Into<String>, origin: &str) -> Self {
        Self {
            class,
            name: name.into(),
            origin: origin.into(),
            contents: vec!["$origin/**".into()],
            properties: Vec::new(),
        }
    }

    /// Number of the view, by what it is: a layout that is sent again keeps the state of views that
    /// are in both, and never gives one's state to another (a viewer whose page is open trips over
    /// that).
    fn id(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        (self.class, &self.name, &self.origin, &self.contents).hash(&mut hasher);
        hasher.finish() & ID
    }

    /// Shows these entities instead.
    pub fn contents(mut self, contents: impl IntoIterator<Item = String>) -> Self {
        self.contents = contents.into_iter().collect();
        self
    }

    /// Sets a property, by the name of its archetype.
    pub fn property(mut self, name: &'static str, value: impl AsComponents + 'static) -> Self {
        self.properties.push((name, Box::new(value)));
        self
    }
}

impl Container {
    /// An empty container.
    pub fn new(kind: ContainerKind, name: &str) -> Self {
        Self { kind, name: name.into(), parts: Vec::new(), open: 0 }
    }

    /// Adds a part that takes `share` of the room, relative to the others.
    pub fn with(mut self, part: impl Into<Part>, share: f32) -> Self {
        self.parts.push((part.into(), share));
        self
    }

    /// Opens the tab at a place, counted from 0.
    pub fn open_at(self, open: usize) -> Self {
        Self { open, ..self }
    }
}

impl From<View> for Part {
    fn from(view: View) -> Self {
        Part::View(view)
    }
}

impl From<Container> for Part {
    fn from(container: Container) -> Self {
        Part::Container(container)
    }
}

/// Sends the layout and makes it the one that is shown.
pub fn send(
    recording: &RecordingStream,
    root: &Container,
    timeline: &str,
) -> RecordingStreamResult<()> {
    let application = recording
        .store_info()
        .map_or_else(|| "tremie".into(), |info| info.application_id().clone());
    let (stream, storage) = RecordingStreamBuilder::new(application).blueprint().memory()?;
    stream.set_time_sequence("blueprint", 0);
    let mut writer = Writer { stream: &stream, next: 0 };
    let id = writer.container(root)?;
    stream.log(
        "viewport",
        &ViewportBlueprint::new()
            .with_root_container(RootContainer(bytes(id).into()))
            .with_auto_layout(false)
            .with_auto_views(false),
    )?;
    panels(&stream, timeline)?;
    let messages = storage.take();
    let Some(store) = messages.iter().find_map(|message| match message {
        LogMsg::SetStoreInfo(info) => Some(info.info.store_id.clone()),
        _ => None,
    }) else {
        return Ok(());
    };
    recording.send_blueprint(
        messages,
        BlueprintActivationCommand { blueprint_id: store, make_active: true, make_default: true },
    );
    Ok(())
}

fn panels(stream: &RecordingStream, timeline: &str) -> RecordingStreamResult<()> {
    let state = |state| PanelBlueprint::new().with_state(state);
    stream.log("blueprint_panel", &state(PanelState::Hidden))?;
    stream.log("selection_panel", &state(PanelState::Hidden))?;
    stream.log(
        "time_panel",
        &TimePanelBlueprint::new()
            .with_state(PanelState::Collapsed)
            .with_timeline(TimelineName(timeline.into()))
            .with_play_state(PlayState::Following),
    )
}

/// Writes parts, numbering containers as they come.
struct Writer<'a> {
    stream: &'a RecordingStream,
    next: u64,
}

impl Writer<'_> {
    fn part(&mut self, part: &Part) -> RecordingStreamResult<String> {
        match part {
            Part::View(view) => self.view(view),
            Part::Container(container) => Ok(path("container", self.container(container)?)),
        }
    }

    fn number(&mut self) -> u64 {
        self.next += 1;
        self.next
    }

    fn container(&mut self, container: &Container) -> RecordingStreamResult<u64> {
        let mut paths = Vec::new();
        for (part, _) in &container.parts {
            paths.push(self.part(part)?);
        }
        let id = self.number();
        let shares = container.parts.iter().map(|(_, share)| rerun::Float32(*share));
        let mut record = ContainerBlueprint::new(container.kind)
            .with_display_name(container.name.as_str())
            .with_contents(paths.iter().map(|path| IncludedContent(path.as_str().into())));
        record = match container.kind {
            ContainerKind::Vertical => record.with_row_shares(shares.map(RowShare)),
            ContainerKind::Horizontal => record.with_col_shares(shares.map(ColumnShare)),
            ContainerKind::Tabs => record.with_active_tab(ActiveTab(
                paths.get(container.open).map(String::as_str).unwrap_or_default().into(),
            )),
            ContainerKind::Grid => record,
        };
        self.stream.log(path("container", id), &record)?;
        Ok(id)
    }

    fn view(&mut self, view: &View) -> RecordingStreamResult<String> {
        let path = path("view", view.id());
        self.stream.log(
            format!("{path}/ViewContents"),
            &ViewContents::new(
                view.contents.iter().map(|text| QueryExpression(text.as_str().into())),
            ),
        )?;
        self.stream.log(
            path.as_str(),
            &ViewBlueprint::new(ViewClass(view.class.into()))
                .with_display_name(view.name.as_str())
                .with_space_origin(view.origin.as_str()),
        )?;
        for (name, value) in &view.properties {
            let property = format!("{path}/{name}");
            self.stream.log_serialized_batches(property, false, value.as_serialized_batches())?;
        }
        Ok(path)
    }
}

/// Bits of a number that its UUID has room for.
const ID: u64 = (1 << 48) - 1;

/// Rerun names parts by UUIDs; ours hold a number. The version and variant bits say "made by hand"
/// (8).
fn bytes(id: u64) -> [u8; 16] {
    let mut bytes = [0; 16];
    bytes[6] = 0x80;
    bytes[8] = 0x80;
    bytes[10..].copy_from_slice(&id.to_be_bytes()[2..]);
    bytes
}

fn path(kind: &str, id: u64) -> String {
    format!("{kind}/00000000-0000-8000-8000-{id:012x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_keep_their_numbers_and_differ() {
        let cut = || View::new("3D", "cut", "scene");
        assert_eq!(cut().id(), cut().id());
        let others = [
            View::new("2D", "cut", "scene"),
            View::new("3D", "scene", "scene"),
            cut().contents(["/a".to_string()]),
        ];
        assert!(others.iter().all(|other| other.id() != cut().id()));
    }
}
