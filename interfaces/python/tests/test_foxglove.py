"""The layout for Foxglove, held against a recording that the reader of MCAP's makers opens."""

import json

import pytest
import tremie

from conftest import ROOT

mcap_reader = pytest.importorskip("mcap.reader")
mcap_protobuf = pytest.importorskip("mcap_protobuf.decoder")


def recorded(path):
    """Of each topic: the name of its schema, and its first message."""
    found = {}
    with path.open("rb") as file:
        reader = mcap_reader.make_reader(file, decoder_factories=[mcap_protobuf.DecoderFactory()])
        for schema, channel, _, message in reader.iter_decoded_messages():
            found.setdefault(channel.topic, (schema.name, message))
    return found


def fields(message):
    return {field.name for field in message.DESCRIPTOR.fields}


def test_the_layout_shows_what_a_recording_has(tmp_path):
    scene = ROOT / "examples" / "suspension" / "short.toml"
    out = tmp_path / "out"
    tremie.run(scene, until="20 ms", out=out)
    topics = recorded(out / "run.mcap")
    layout = json.loads((ROOT / "components/recorder/foxglove-layout.json").read_text())
    panels = layout["configById"]
    for topic, shown in panels["3D!scene"]["topics"].items():
        schema, cloud = topics[topic]
        assert schema == "foxglove.PointCloud"
        assert cloud.frame_id == panels["3D!scene"]["followTf"]
        assert {"x", "y", "z", shown["colorField"]} <= {field.name for field in cloud.fields}
    for name in [name for name in panels if name.startswith("Plot!")]:
        for path in panels[name]["paths"]:
            topic, field = path["value"].rsplit(".", 1)
            assert field in fields(topics[topic][1]), path["value"]
    assert topics[panels["Log!log"]["topicToRender"]][0] == "foxglove.Log"


def test_every_panel_has_a_place():
    layout = json.loads((ROOT / "components/recorder/foxglove-layout.json").read_text())

    def places(node):
        return [node] if isinstance(node, str) else places(node["first"]) + places(node["second"])

    assert sorted(places(layout["layout"])) == sorted(layout["configById"])
