"""Frames: what is packed is what the page unpacks."""

import json
import struct
import warnings

import numpy as np

from gelcone.studio.frames import pack


def unpack(frame):
    """Head and arrays of a frame; what the page does in JavaScript."""
    (length,) = struct.unpack_from("<I", frame)
    head = json.loads(frame[4 : 4 + length])
    arrays = {
        name: np.frombuffer(frame, dtype=f"<{kind}", count=count, offset=4 + length + at)
        for name, kind, at, count in head["arrays"]
    }
    return head, arrays


def test_a_frame_holds_its_head_and_arrays_at_multiples_of_eight_bytes():
    arrays = {"x": np.array([1.5, np.nan, -2.0]), "code": np.array([1, 255], dtype=np.uint8), "none": np.zeros(0)}
    frame = pack({"kind": "response", "share": np.float64(0.25), "bad": np.inf}, arrays)
    head, found = unpack(frame)
    assert (head["kind"], head["share"], head["bad"]) == ("response", 0.25, None)
    assert found["x"].dtype == np.float32
    np.testing.assert_array_equal(found["x"], np.array([1.5, np.nan, -2.0], dtype=np.float32))
    assert found["code"].tolist() == [1, 255]
    assert found["none"].size == 0
    assert len(frame) % 8 == 0
    assert all(at % 8 == 0 for _, _, at, _ in head["arrays"])


def test_what_single_precision_cannot_hold_is_infinite_and_nobody_is_warned():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        _, found = unpack(pack({"kind": "response"}, {"x": np.array([1e300, 1.0])}))
    assert found["x"].tolist() == [np.inf, 1.0]


def test_every_array_travels_in_its_own_type_and_place():
    arrays = {
        "flags": np.array([True, False, True]), "whole": np.arange(-3, 6), "big": np.array([1.5, 2.5], dtype=">f8"),
        "bytes": np.arange(8, dtype=np.uint8), "table": np.arange(6.0).reshape(2, 3).T, "last": np.array([7.0]),
    }  # fmt: skip
    frame = pack({"kind": "map"}, arrays)
    head, found = unpack(frame)
    kinds = {"flags": "u1", "whole": "f4", "big": "f4", "bytes": "u1", "table": "f4", "last": "f4"}
    places = [0, 8, 48, 56, 64, 88]
    assert head["arrays"] == [
        [name, kinds[name], at, arrays[name].size] for name, at in zip(arrays, places, strict=True)
    ]
    for name, values in arrays.items():
        assert found[name].tolist() == values.ravel().tolist()
    text = int.from_bytes(frame[:4], "little")
    assert len(frame) == 4 + text + 96
    assert (4 + text) % 8 == 0
    assert unpack(pack({"a": {"b": [np.float32(0.5), np.nan, (np.int64(3), True)]}}))[0] == {
        "a": {"b": [0.5, None, [3, True]]}, "arrays": [],
    }  # fmt: skip
