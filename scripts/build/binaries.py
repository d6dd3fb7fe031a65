"""Reads what a compiled module requires of the machine: versions of glibc (ELF) and libraries (PE), without other tools."""

import re
import struct
from pathlib import PurePath

from build.console import Failure

# Libraries that every Windows from 10 has, and those that Blender's Python brings.
WINDOWS_LIBRARIES = re.compile(
    r"(api-ms-win-[\w-]+|advapi32|bcrypt|bcryptprimitives|kernel32|msvcrt|ntdll|python3|ucrtbase|userenv|vcruntime140(_1)?|ws2_32)"
    r"\.dll"
)
_PE_IMPORTS, _PE_DELAYED_IMPORTS = 1, 13  # entries of the data directory


def glibc_of(elf: bytes) -> tuple[int, int]:
    """The newest glibc whose symbols an ELF file uses, such as (2, 28). Raises Failure if the file is not ELF."""
    if elf[:4] != b"\x7fELF":
        raise Failure("not an ELF file")
    found = {(int(major), int(minor)) for major, minor in re.findall(rb"GLIBC_(\d+)\.(\d+)", elf)}
    return max(found, default=(0, 0))


def libraries_of(pe: bytes) -> list[str]:
    """The libraries in the import table of a 64-bit PE file, in lower case and sorted. Raises Failure if it is not one.

    Source: Microsoft, PE Format, sections "Optional Header Data Directories" and "The .idata Section".
    """
    if pe[:2] != b"MZ":
        raise Failure("not a PE file")
    header = _uint32(pe, 0x3C)
    if pe[header : header + 4] != b"PE\0\0" or _uint16(pe, header + 24) != 0x20B:
        raise Failure("not a 64-bit PE file")
    sections = _sections(pe, header)
    directory = header + 24 + 112
    names = set()
    for entry, size_of_row, at_name in ((_PE_IMPORTS, 20, 12), (_PE_DELAYED_IMPORTS, 32, 4)):
        address = _uint32(pe, directory + 8 * entry)
        row = _offset(address, sections) if address else None
        while row is not None and _uint32(pe, row + at_name):
            name = _offset(_uint32(pe, row + at_name), sections)
            names.add(pe[name : pe.index(b"\0", name)].decode("ascii").lower())
            row += size_of_row
    return sorted(names)


def check(name: str, content: bytes, glibc: tuple[int, int]) -> str:
    """Says what a compiled module requires. Raises Failure if it is more than a released wheel may require.

    name: its path in the wheel; the suffix tells the kind of file. glibc: the newest version that is allowed.
    """
    if PurePath(name).suffix == ".pyd":
        libraries = libraries_of(content)
        unknown = [library for library in libraries if not WINDOWS_LIBRARIES.fullmatch(library)]
        if unknown:
            raise Failure(f"{name} imports {', '.join(unknown)}, which not every Windows has")
        return f"imports {', '.join(libraries)}"
    if content[:4] != b"\x7fELF":
        return "a module for macOS"
    newest = glibc_of(content)
    if newest > glibc:
        raise Failure(f"{name} needs glibc {newest[0]}.{newest[1]}, and the oldest supported is {glibc[0]}.{glibc[1]}")
    return f"needs glibc {newest[0]}.{newest[1]}"


def _uint16(content: bytes, at: int) -> int:
    return struct.unpack_from("<H", content, at)[0]


def _uint32(content: bytes, at: int) -> int:
    return struct.unpack_from("<I", content, at)[0]


def _sections(pe: bytes, header: int) -> list[tuple[int, int, int]]:
    """(address in memory, size, offset in the file) of each section."""
    first = header + 24 + _uint16(pe, header + 20)
    rows = range(first, first + 40 * _uint16(pe, header + 6), 40)
    return [(_uint32(pe, row + 12), _uint32(pe, row + 16), _uint32(pe, row + 20)) for row in rows]


def _offset(address: int, sections: list[tuple[int, int, int]]) -> int:
    for start, size, offset in sections:
        if start <= address < start + size:
            return address - start + offset
    raise Failure(f"the address {address:#x} is in no section of the PE file")
