"""Skeletons to other programs while tracking runs."""

from __future__ import annotations

import json
import socket
import threading
import urllib.error
import urllib.request
from contextlib import closing

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from made_frames import ABOUT, frames_with
from moving_bodies import pose
from patience import HANGS_S
from topview import JOINT_NAMES
from topview.body.hierarchy import NODES
from topview.body.parts import LEFT_UPPER_ARM, RIGHT_UPPER_ARM
from topview.io.writers.levelled import BodyMotion
from topview.records import InputError
from topview.skeletons import SkeletonSequence, TrackedFrame
from topview.stream import open_stream
from topview.stream.outlets import MOST_QUEUED, Background
from topview.stream.vmc import UNITY_BONES, UNITY_FROM_ANIMATION, vmc_messages

pythonosc = pytest.importorskip("pythonosc.osc_packet", reason="needs python-osc")
client = pytest.importorskip("websockets.sync.client", reason="needs websockets")


def free_port() -> int:
    with closing(socket.socket()) as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


def body(angles_rad: np.ndarray) -> TrackedFrame:
    people = np.zeros(1, ABOUT.person_type)
    joints, Ts = pose(angles_rad)
    people["id"], people["height_m"], people["joints_camera"], people["Ts_camera_part"] = (
        2, 1.8, joints, Ts,
    )  # fmt: skip
    return TrackedFrame(5, 0.5, "5", people)


def test_every_joint_is_an_osc_message():
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(HANGS_S)
        outlet = open_stream(f"osc:127.0.0.1:{listener.getsockname()[1]}")
        frame = body(np.zeros((11, 3)))
        outlet.send(frame)
        told = {}
        while len(told) < 1 + len(JOINT_NAMES):
            for timed in pythonosc.OscPacket(listener.recv(2**16)).messages:
                if timed.message.address.startswith("/topview"):
                    told[timed.message.address] = timed.message.params
        outlet.close()
    assert told["/topview/frame"] == [5, 0.5, 1]
    (person,) = frame.people
    for j, name in enumerate(JOINT_NAMES):
        *xyz_m, confidence, state = told[f"/topview/person/2/{name}"]
        np.testing.assert_allclose(xyz_m, person["joints_camera"][j], atol=1e-6)
        assert confidence == pytest.approx(float(person["joint_confidence"][j]))
        assert state == person["joint_state"][j]


def test_a_vmc_avatar_s_bones_make_the_body_again():
    """Rotations and offsets, each in the frame of the bone above, give all joints."""
    frame = body(np.random.default_rng(3).uniform(-0.5, 0.5, (11, 3)))
    bones = {m[1][0]: m[1][1:] for m in vmc_messages(frame) if m[0] == "/VMC/Ext/Bone/Pos"}
    motion = BodyMotion.of(SkeletonSequence.from_frames([frame], ABOUT), "test")
    Rs, places, expected_R, expected = {}, {}, {}, {}
    for n, node in enumerate(NODES):
        if node.name not in UNITY_BONES:  # a palm, from which nothing hangs
            continue
        *place, x, y, z, w = bones[UNITY_BONES[node.name]]
        R, at = Rotation.from_quat([x, y, z, w]).as_matrix(), np.array(place)
        R0, at0 = motion.Rs_parent_node[0, n], motion.offsets_m[n]
        if node.parent < 0:
            at0 = motion.root_m[0]
        else:
            R, at = Rs[node.parent] @ R, places[node.parent] + Rs[node.parent] @ at
            at0 = expected[node.parent] + expected_R[node.parent] @ at0
            R0 = expected_R[node.parent] @ R0
        for kept, value in ((Rs, R), (places, at), (expected_R, R0), (expected, at0)):
            kept[n] = value
    told, true = (np.stack(list(kept.values())) for kept in (places, expected))
    np.testing.assert_allclose(told, true @ UNITY_FROM_ANIMATION, atol=1e-9)


def test_the_t_pose_turns_no_bone():
    angles = np.zeros((11, 3))
    angles[LEFT_UPPER_ARM, 2], angles[RIGHT_UPPER_ARM, 2] = np.pi / 2, -np.pi / 2
    bones = [m[1] for m in vmc_messages(body(angles)) if m[0] == "/VMC/Ext/Bone/Pos"]
    assert len(bones) == len(UNITY_BONES) == len(NODES) - 2  # without the palms
    for name, *_, x, y, z, w in bones:
        assert abs(w) == pytest.approx(1.0), name
        np.testing.assert_allclose([x, y, z], 0.0, atol=1e-9)


def test_nobody_is_no_avatar():
    assert vmc_messages(frames_with([[]])[0]) == []


def test_a_listener_gets_the_newest_frame_and_one_that_never_reads_holds_up_nobody():
    port = free_port()
    outlet = open_stream(f"websocket:{port}")
    frames = frames_with([[1, 2, 3, 4, 5, 6]] * 60)
    with (
        client.connect(f"ws://127.0.0.1:{port}/", max_queue=1) as listener,
        closing(socket.create_connection(("127.0.0.1", port))) as idle,
    ):
        idle.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
        idle.sendall(
            f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nUpgrade: websocket\r\n"
            "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
            "Sec-WebSocket-Version: 13\r\n\r\n".encode()
        )
        for frame in frames:
            outlet.send(frame)
        last, told = -1, {}
        while last < frames[-1].index:
            told = json.loads(listener.recv(HANGS_S))
            assert told["frame_index"] > last
            last = told["frame_index"]
        assert len(told["people"]) == 6
        assert told["people"][0]["joints"]["head"]["camera_m"] == pytest.approx(
            frames[-1].people[0]["joints_camera"][0].tolist()
        )
        outlet.close()
    assert outlet.problem == ""


def test_the_page_is_served_to_browsers_and_its_socket_to_no_other_page():
    port = free_port()
    outlet = open_stream(f"websocket:{port}")
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/") as answer:
        page, policy = answer.read().decode(), answer.headers["Content-Security-Policy"]
    assert '"left_hand"' in page
    assert "__ABOUT__" not in page
    assert "script-src 'sha256-" in policy
    for place, headers, status in (
        ("no", {}, 404),
        ("", {"Host": "elsewhere.example"}, 403),
        ("", {"Origin": "http://elsewhere.example"}, 403),
    ):
        request = urllib.request.Request(f"http://127.0.0.1:{port}/{place}", headers=headers)
        with pytest.raises(urllib.error.HTTPError) as refused:
            urllib.request.urlopen(request)
        assert refused.value.code == status
    outlet.close()


def test_the_oldest_frames_are_left_out_where_a_listener_is_slow():
    taken = []
    may_go_on, is_at_it, ended = threading.Event(), threading.Event(), threading.Event()

    def slow(frame):
        is_at_it.set()
        may_go_on.wait()
        taken.append(frame.index)

    outlet = Background(slow, ended.set)
    frames = frames_with([[1]] * 50)
    outlet.send(frames[0])
    is_at_it.wait()
    for frame in frames[1:]:
        outlet.send(frame)
    may_go_on.set()
    outlet.close()
    assert ended.is_set()
    assert taken == [0, *range(50 - MOST_QUEUED, 50)]


def test_what_fails_ends_the_stream_and_not_the_run():
    def fails(frame):
        raise ZeroDivisionError("odd")

    outlet = Background(fails, lambda: None)
    outlet.send(frames_with([[1]])[0])
    outlet.close()
    assert outlet.problem == "ZeroDivisionError: odd"


@pytest.mark.parametrize(
    "words", ["osc:9000", "osc:host", "websocket:", "websocket:70000", "udp:host:1", ""]
)
def test_other_words_are_refused(words):
    with pytest.raises(InputError, match="it must be osc:HOST:PORT"):
        open_stream(words)


def test_a_port_that_is_taken_is_told():
    with closing(socket.socket()) as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        with pytest.raises(InputError, match="cannot be had"):
            open_stream(f"websocket:{taken.getsockname()[1]}")


def test_track_streams_and_says_what_it_cannot(topview, make_recording, tmp_path):
    source = make_recording()
    ended = topview("track", source, "--out", tmp_path / "out", "--stream", "osc:9000")
    assert ended.status == 2
    assert "it must be osc:HOST:PORT" in ended.complaints[-1]
    streams = ("--stream", f"websocket:{free_port()}", "--stream", f"osc:127.0.0.1:{free_port()}")
    ended = topview("track", source, "--out", tmp_path / "out", *streams)
    assert "no person was found in 3 frames" in ended.complaints[-1]
