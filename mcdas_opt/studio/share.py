"""A scene in a link: its document as JSON, deflated, in letters that an address may hold."""

from __future__ import annotations

import base64
import binascii
import json
import zlib
from typing import Any

from mcdas_opt.domain.parsing import parsed_json
from mcdas_opt.errors import InputError
from mcdas_opt.studio.edits import LARGEST_SCENE

NAME = "shared link"
_LARGEST = LARGEST_SCENE + 1000  # bytes of the document, with the closed form's numbers


def link_of(document: dict[str, Any]) -> str:
    """The document as text of letters, digits, - and _."""
    text = json.dumps(document, allow_nan=False, separators=(",", ":"))
    return base64.urlsafe_b64encode(zlib.compress(text.encode(), 9)).decode().rstrip("=")


def document_in(link: str) -> Any:
    """The document of a link. Raises `InputError` for what is none, or unpacks to more than a scene may be."""
    try:
        packed = base64.b64decode(link + "=" * (-len(link) % 4), altchars=b"-_", validate=True)
        unpacking = zlib.decompressobj()
        text = unpacking.decompress(packed, _LARGEST)
        if unpacking.unconsumed_tail:
            raise InputError(NAME, "", None, f"holds more than {_LARGEST} bytes")
        return parsed_json(text.decode("utf-8"), NAME)
    except (binascii.Error, zlib.error, UnicodeError):
        raise InputError(NAME, "", None, "is damaged: copy it whole") from None
