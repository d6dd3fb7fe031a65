# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the morph targets of a .glb file smaller: the same numbers, with 16-bit indices that positions and normals share.

Blender writes a sparse accessor (glTF 2.0, 3.6.2.3) for the positions of each key and another for its normals, each with
32-bit indices. Most vertices that a key moves also change their normal, so that one list of indices serves both.
"""

import json
import struct
from pathlib import Path

import numpy as np

from ..files.atomic_write import atomic_write

_HEADER, _CHUNK = struct.Struct("<4sII"), struct.Struct("<I4s")
_TYPES: dict[int, np.dtype] = {5121: np.dtype(np.uint8), 5123: np.dtype("<u2"), 5125: np.dtype("<u4"), 5126: np.dtype("<f4")}
_UNSIGNED_SHORT, _UNSIGNED_INT, _FLOAT = 5123, 5125, 5126
_ALIGNMENT = 4
# Blender can write these, but then buffer views are used in other places, too
_PACKED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression"}


def compact(path: Path):
    """Rewrites the morph targets of a .glb file. A file of another form stays as it is."""
    file = _Glb(path.read_bytes())
    primitives = [primitive for mesh in file.json.get("meshes", ()) for primitive in mesh["primitives"]]
    targets = [target for primitive in primitives for target in primitive.get("targets", ())]
    if not targets or _PACKED & set(file.json.get("extensionsUsed", ())):
        return
    accessors = {index for target in targets for index in target.values()}
    if any(file.json["accessors"][index]["componentType"] != _FLOAT for index in accessors):
        return
    arrays = {index: file.array(index) for index in accessors}
    file.forget_views_of(accessors)
    done: set[int] = set()
    for target in targets:
        group = [index for index in target.values() if index not in done]
        file.write_sparse({index: arrays[index] for index in group})
        done.update(group)
    with atomic_write(path) as out:
        out.write(file.bytes())


class _Glb:
    """The JSON of a .glb file, and the bytes of its buffer views."""

    def __init__(self, data: bytes):
        length, _kind = _CHUNK.unpack_from(data, _HEADER.size)
        start = _HEADER.size + _CHUNK.size
        self.json = json.loads(data[start : start + length])
        binary = data[start + length + _CHUNK.size :]
        self._views = [
            bytes(binary[view.get("byteOffset", 0) :][: view["byteLength"]]) for view in self.json.get("bufferViews", ())
        ]

    def array(self, index: int) -> np.ndarray:
        """(count, 3) float32: the numbers of an accessor."""
        accessor = self.json["accessors"][index]
        values = np.zeros((accessor["count"], 3), np.float32)
        if "bufferView" in accessor:
            values[:] = self._read(accessor, _FLOAT, values.size).reshape(-1, 3)
        sparse = accessor.get("sparse")
        if sparse:
            count = sparse["count"]
            rows = self._read(sparse["indices"], sparse["indices"]["componentType"], count)
            values[rows.astype(int)] = self._read(sparse["values"], _FLOAT, 3 * count).reshape(-1, 3)
        return values

    def _read(self, place: dict, component: int, count: int) -> np.ndarray:
        return np.frombuffer(self._views[place["bufferView"]], _TYPES[component], count, place.get("byteOffset", 0))

    def forget_views_of(self, accessors: set[int]):
        """Removes the data of accessors, and the buffer views that nothing else uses."""
        for index in accessors:
            self.json["accessors"][index].pop("bufferView", None)
            self.json["accessors"][index].pop("byteOffset", None)
            self.json["accessors"][index].pop("sparse", None)
        users = self._users_of_views()
        used = sorted({user["bufferView"] for user in users})
        place = {view: position for position, view in enumerate(used)}
        for user in users:
            user["bufferView"] = place[user["bufferView"]]
        self._views = [self._views[view] for view in used]
        self.json["bufferViews"] = [self.json["bufferViews"][view] for view in used]

    def _users_of_views(self) -> list[dict]:
        accessors = self.json.get("accessors", [])
        sparse = [accessor["sparse"] for accessor in accessors if "sparse" in accessor]
        users = [
            *accessors,
            *(part[name] for part in sparse for name in ("indices", "values")),
            *self.json.get("images", ()),
        ]
        return [user for user in users if "bufferView" in user]

    def write_sparse(self, arrays: dict[int, np.ndarray]):
        """Writes accessors of one length. Each has the rows that are not 0 in itself, or those that are not 0 in any."""
        if not arrays:
            return
        rows = {index: np.flatnonzero(values.any(axis=1)) for index, values in arrays.items()}
        shared = np.unique(np.concatenate(list(rows.values())))
        count = len(next(iter(arrays.values())))
        component = _UNSIGNED_SHORT if count <= 2**16 - 1 else _UNSIGNED_INT
        row_bytes, value_bytes = _TYPES[component].itemsize, 3 * _TYPES[_FLOAT].itemsize
        apart = sum(len(own) for own in rows.values()) * (row_bytes + value_bytes)
        is_shared = len(shared) * (row_bytes + value_bytes * len(arrays)) < apart
        view_of_rows = self._add_view(shared.astype(_TYPES[component])) if is_shared and len(shared) else None
        for index, values in arrays.items():
            own = shared if is_shared else rows[index]
            if len(own) == 0:
                continue  # an accessor without data is 0
            if len(own) * (row_bytes + value_bytes) >= len(values) * value_bytes:
                self.json["accessors"][index]["bufferView"] = self._add_view(values.astype(_TYPES[_FLOAT]))
                continue
            at = view_of_rows if view_of_rows is not None else self._add_view(own.astype(_TYPES[component]))
            self.json["accessors"][index]["sparse"] = {
                "count": len(own),
                "indices": {"bufferView": at, "componentType": component},
                "values": {"bufferView": self._add_view(values[own].astype(_TYPES[_FLOAT]))},
            }

    def _add_view(self, values: np.ndarray) -> int:
        self._views.append(values.tobytes())
        self.json["bufferViews"].append({"buffer": 0, "byteLength": values.nbytes})
        return len(self._views) - 1

    def bytes(self) -> bytes:
        """The file."""
        parts, offset = [], 0
        for view, data in zip(self.json["bufferViews"], self._views, strict=True):
            view["byteOffset"] = offset
            parts.append(data + bytes(-len(data) % _ALIGNMENT))
            offset += len(parts[-1])
        self.json["buffers"] = [{"byteLength": offset}]
        binary, text = b"".join(parts), json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % _ALIGNMENT)
        chunks = _CHUNK.pack(len(text), b"JSON") + text + _CHUNK.pack(len(binary), b"BIN\0") + binary
        return _HEADER.pack(b"glTF", 2, _HEADER.size + len(chunks)) + chunks
