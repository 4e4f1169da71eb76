"""Reads messages as CDR and writes them again, with rosbags; says how many come out as the same bytes."""

import pathlib
import struct
import sys

from rosbags.typesys import Stores, get_types_from_msg, get_typestore

folder = pathlib.Path(sys.argv[1])
types = {}
for file in folder.rglob("*.msg"):
    name = file.relative_to(folder).with_suffix("").as_posix()
    types.update(get_types_from_msg(file.read_text(), name))
store = get_typestore(Stores.EMPTY)
store.register(types)


def known(name):
    """Of services rosbags has names of its own."""
    return name if name in store.types else name.replace("/srv/", "/srv/msg/")


same = 0
for file in sorted(folder.rglob("*.cdr")):
    name = known(file.relative_to(folder).with_suffix("").as_posix())
    bytes_left = file.read_bytes()
    while bytes_left:
        (length,) = struct.unpack_from("<I", bytes_left)
        message, bytes_left = bytes_left[4 : 4 + length], bytes_left[4 + length :]
        again = bytes(store.serialize_cdr(store.deserialize_cdr(message, name), name))
        assert again == message, f"{name}: {message.hex()} comes out as {again.hex()}"
        same += 1
print(same)
