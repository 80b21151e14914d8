"""Counts the messages of every channel, and finds a joint by the layout."""

import json
import struct
import sys
from collections import Counter

from mcap.reader import make_reader

counts, last = Counter(), None
with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, validate_crcs=True)
    print("channels", len(reader.get_summary().channels))
    for schema, channel, message in reader.iter_messages():
        counts[channel.topic] += 1
        if channel.message_encoding == "json":
            json.loads(message.data)
        if channel.topic == "world":
            last = (json.loads(schema.data), message.data)


def unpack(packed):
    """The struct, out of the words of it that are not zero."""
    (length,) = struct.unpack_from("<I", packed)
    words = [b"\0" * 8] * -(-length // 8)
    masks = struct.unpack_from(f"<{-(-length // 512)}Q", packed, 4)
    at = 4 + 8 * len(masks)
    for i in range(len(words)):
        if masks[i // 64] >> i % 64 & 1:
            words[i] = packed[at : at + 8]
            at += 8
    assert at == len(packed)
    return b"".join(words)[:length]


layout, data = last[0], unpack(last[1])


def field(struct_name, name):
    fields = layout["structs"][struct_name]["fields"]
    return next(f["offset"] for f in fields if f["name"] == name)


at = field("WorldPiece", "arms") + field("ArmState", "joint_positions")
print("joint", struct.unpack_from("<d", data, at)[0])
for topic, count in counts.items():
    print(topic, count)
