# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of files after objects: any object's name becomes a name that every system takes, and no two become the same."""

import hashlib
import unicodedata

LONGEST_STEM_BYTES = 120  # systems take 255; the number of a chunk and the marks of an unfinished file come on top
_PLAIN = frozenset(" .-_()[]+=,;@&!~#$")
_RESERVED = frozenset({"CON", "PRN", "AUX", "NUL", *(f"{port}{n}" for port in ("COM", "LPT") for n in range(1, 10))})


def stem_of(name: str) -> str:
    """A file's name without suffix, after an object's name: letters and digits of all scripts stay, what a system gives a
    meaning to becomes %XX (the bytes of its UTF-8), and a name that would be too long ends in its checksum."""
    composed = unicodedata.normalize("NFC", name)  # macOS takes composed and decomposed letters for the same
    escaped = "".join(character if _is_plain(character) else _escaped(character) for character in composed)
    if escaped.startswith(".") or escaped.split(".")[0].upper() in _RESERVED:  # hidden, or a device of Windows
        escaped = _escaped(escaped[0]) + escaped[1:]
    if len(escaped.encode()) <= LONGEST_STEM_BYTES:
        return escaped
    checksum = hashlib.sha256(name.encode()).hexdigest()[:16]
    return escaped.encode()[: LONGEST_STEM_BYTES - 20].decode(errors="ignore") + "..." + checksum


def _is_plain(character: str) -> bool:
    return character.isalnum() or unicodedata.category(character).startswith("M") or character in _PLAIN


def _escaped(character: str) -> str:
    return "".join(f"%{byte:02X}" for byte in character.encode())
