# SPDX-License-Identifier: GPL-3.0-or-later
"""File names from object names: valid on every system, and different for different objects."""

import hashlib
import unicodedata

LONGEST_STEM_BYTES = 120  # systems allow 255; numbers of chunks and parts of temporary names are added
_PLAIN = frozenset(" .-_()[]+=,;@&!~#$")
_RESERVED = frozenset({"CON", "PRN", "AUX", "NUL", *(f"{port}{n}" for port in ("COM", "LPT") for n in range(1, 10))})


def stem_of(name: str) -> str:
    """A file name without suffix, made from an object's name.

    Letters and digits of all scripts stay. Characters that are special on some system become %XX, the bytes of their
    UTF-8. A name that would be too long is cut and gets a checksum.
    """
    composed = unicodedata.normalize("NFC", name)  # macOS treats composed and decomposed letters as equal
    escaped = "".join(character if _is_plain(character) else _escaped(character) for character in composed)
    if escaped.startswith(".") or escaped.split(".")[0].upper() in _RESERVED:  # hidden, or a device name in Windows
        escaped = _escaped(escaped[0]) + escaped[1:]
    if len(escaped.encode()) <= LONGEST_STEM_BYTES:
        return escaped
    checksum = hashlib.sha256(name.encode()).hexdigest()[:16]
    return escaped.encode()[: LONGEST_STEM_BYTES - 20].decode(errors="ignore") + "..." + checksum


def _is_plain(character: str) -> bool:
    return character.isalnum() or unicodedata.category(character).startswith("M") or character in _PLAIN


def _escaped(character: str) -> str:
    return "".join(f"%{byte:02X}" for byte in character.encode())
