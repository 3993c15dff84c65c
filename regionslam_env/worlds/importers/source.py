"""A file to import: read once, parsed as what its readers ask for, within limits that no building reaches."""

from __future__ import annotations

import gzip
import io
import xml.etree.ElementTree as ElementTree
import zlib
from functools import cached_property
from pathlib import Path

import yaml

from regionslam_env.errors import WorldError
from regionslam_env.worlds.format import MAX_BYTES, parse_json
from regionslam_env.worlds.importers.node import Node

MAX_DEPTH = 60
"""Deepest nesting of a YAML file."""

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


class Source:
    """One file; what cannot be read or parsed raises a `WorldError` that names it."""

    def __init__(self, path: Path) -> None:
        self.path = path

    @property
    def ending(self) -> str:
        """Ending in lower case, of what is packed where it is ``.gz``."""
        name = self.path.name.lower().removesuffix(".gz")
        return Path(name).suffix

    @cached_property
    def data(self) -> bytes:
        """Content, unpacked."""
        try:
            if self.path.stat().st_size > MAX_BYTES:
                raise WorldError(f"{self.path}: {self.path.stat().st_size} bytes, expected at most {MAX_BYTES}")
            content = self.path.read_bytes()
            if self.path.suffix.lower() == ".gz":
                content = gzip.GzipFile(fileobj=io.BytesIO(content)).read(MAX_BYTES + 1)
        except (OSError, EOFError, zlib.error) as error:
            reason = getattr(error, "strerror", None) or error
            raise WorldError(f"{self.path}: cannot be read: {reason}") from None
        if len(content) > MAX_BYTES:
            raise WorldError(f"{self.path}: more than {MAX_BYTES} bytes unpacked, expected at most that")
        return content

    @cached_property
    def text(self) -> str:
        """Content as text."""
        try:
            return self.data.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            raise WorldError(f"{self.path}: byte {error.start} is not UTF-8, expected text in UTF-8") from None

    @cached_property
    def json(self) -> Node:
        """Content as JSON."""
        return Node(self.path, parse_json(self.path, self.text))

    @cached_property
    def yaml(self) -> Node:
        """Content as YAML."""
        depth = 0
        try:
            for event in yaml.parse(self.text, Loader=_LOADER):
                depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
                if depth > MAX_DEPTH:
                    raise WorldError(f"{self.path}: nested more than {MAX_DEPTH} deep, expected a plain description")
            value = yaml.load(self.text, Loader=_LOADER)
        except WorldError:
            raise
        except (yaml.YAMLError, ValueError, TypeError, KeyError, AttributeError, OverflowError) as error:
            raise WorldError(f"{self.path}: {' '.join(str(error).split())[:200]}, expected YAML") from None
        return Node(self.path, value)

    @cached_property
    def xml(self) -> ElementTree.Element:
        """Content as XML: its root."""
        if b"<!DOCTYPE" in self.data or b"<!ENTITY" in self.data:
            raise WorldError(f"{self.path}: has a document type declaration, expected plain XML")
        try:
            return ElementTree.fromstring(self.data)
        except (ElementTree.ParseError, ValueError, LookupError) as error:
            raise WorldError(f"{self.path}: {error}, expected XML") from None
