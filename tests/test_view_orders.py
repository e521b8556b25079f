"""What pages may say to the viewer, and how it answers."""

import contextlib
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from taut.view import wire
from taut.view.board import Mailbox
from viewing import unpack


@pytest.mark.parametrize(
    "text",
    [
        "",
        "grab",
        "[]",
        "7",
        "null",
        "{}",
        "[" * 100_000,
        '{"type": "fly"}',
        '{"type": ["grab"]}',
        '{"type": "play"}',
        '{"type": "play", "on": 1}',
        '{"type": "play", "on": true, "more": 1}',
        '{"type": "step", "n": 2}',
        '{"type": "speed", "value": 0}',
        '{"type": "speed", "value": 1e300}',
        '{"type": "speed", "value": NaN}',
        '{"type": "seek", "frame": -1}',
        '{"type": "seek", "frame": 1.5}',
        '{"type": "seek", "frame": true}',
        '{"type": "grab", "vertex": 1, "target": [0, 0]}',
        '{"type": "grab", "vertex": 1, "target": [0, 0, Infinity]}',
        '{"type": "grab", "vertex": 1, "target": [0, 0, 1e30]}',
        '{"type": "grab", "vertex": 99999999999, "target": [0, 0, 0]}',
        '{"type": "grab", "vertex": "1", "target": [0, 0, 0]}',
        '{"type": "drag", "body": 0}',
        '{"type": "drag", "body": -1, "target": [0, 0, 0]}',
        '{"type": "drag", "body": "ball", "target": [0, 0, 0]}',
        '{"type": "drag", "body": 1.0, "target": [0, 0, 0]}',
        '{"type": "drag", "body": 0, "target": [0, 0, 1e5]}',
        '{"type": "drag", "body": 0, "target": {"x": 1}}',
        '{"type": "throw"}',
        '{"type": "throw", "start": [0, 0, 0]}',
        '{"type": "throw", "start": [0, 0, 0], "target": [0, 0, NaN]}',
        '{"type": "throw", "start": [0, 0, -1e9], "target": [0, 0, 0]}',
        '{"type": "throw", "start": [0, 0, 0], "target": [0, 0, 1], "speed": 9}',
        '{"type": "contacts"}',
        '{"type": "contacts", "on": "yes"}',
        '{"type": "set", "control": "wind", "value": null}',
        '{"type": "set", "control": "' + "w" * 1000 + '", "value": 1}',
    ],
)
def test_a_message_without_sense_is_refused_in_a_short_sentence(text: str) -> None:
    with pytest.raises(wire.OrderError) as caught:
        wire.parse(text)
    assert 10 < len(str(caught.value)) < 200


def test_orders_are_read() -> None:
    assert wire.parse('{"type": "play", "on": false}') == wire.Play(False)
    assert wire.parse('{"type": "grab", "vertex": 3, "target": [1, 2.5, -3]}') == wire.Grab(
        3, (1.0, 2.5, -3.0)
    )
    assert wire.parse('{"type": "set", "control": "filter", "value": "none"}') == wire.Set("filter", "none")
    assert wire.parse('{"type": "step"}') == wire.Step()
    assert wire.parse('{"type": "drag", "body": 2, "target": [0, 1, 2]}') == wire.Drag(2, (0.0, 1.0, 2.0))
    throw = wire.parse('{"type": "throw", "start": [0, 0, 0], "target": [1, 0, 0]}')
    assert throw == wire.Throw((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    assert wire.parse('{"type": "contacts", "on": true}') == wire.Contacts(True)


JSON = st.recursive(
    st.none() | st.booleans() | st.floats() | st.integers() | st.text(), st.lists, max_leaves=5
)


FIELDS = ["type", "on", "value", "vertex", "body", "start", "target"]


@given(st.text() | st.dictionaries(st.sampled_from(FIELDS), JSON).map(json.dumps))
def test_any_text_is_an_order_or_refused(text: str) -> None:
    with contextlib.suppress(wire.OrderError):
        wire.parse(text)


def test_ten_thousand_orders_take_no_more_room_than_a_few() -> None:
    mail = Mailbox()
    for number in range(10_000):
        mail.put(number % 3, wire.Grab(number, (0, 0, number / 1e3)))
        mail.put(0, wire.Set(f"c{number}" * 6, 1.0))
        mail.put(0, wire.Set("gravity", number))
        mail.put(0, wire.Seek(number))
        mail.put(number % 3, wire.Drag(number, (0, 0, 0)))
        mail.put(number % 3, wire.Contacts(bool(number % 2)))
        mail.put(number % 3, wire.Throw((0, 0, 0), (0, 0, number / 1e3)))
    left = mail.take()
    assert len(left) == 10
    assert (0, wire.Set("gravity", 9999)) in left and (0, wire.Seek(9999)) in left
    assert mail.take() == []


def test_messages_to_the_page_hold_what_was_packed() -> None:
    places = np.arange(6, dtype=np.float32).reshape(2, 3)
    faces = np.array([[0, 1, 1]], np.int32)
    header, arrays = unpack(wire.pack({"type": "é", "worst": wire.finite(np.inf)}, {"p": places, "f": faces}))
    assert (header["type"], header["worst"]) == ("é", None)
    assert np.array_equal(arrays["p"], places) and np.array_equal(arrays["f"], faces)
