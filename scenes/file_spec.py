"""A file of tables other than a scene: of a campaign, of a region. Its paths are relative to its folder."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import PrivateAttr, ValidationError

from snowmpm.annotations import PathLike
from snowmpm.errors import InputError
from snowmpm.scenes.messages import describe
from snowmpm.scenes.spec import Name, Spec
from snowmpm.scenes.toml import parse, table_text

OwnFile = TypeVar("OwnFile", bound="FileSpec")


class FileSpec(Spec):
    """Tables of a file with a name."""

    name: Name

    _base_dir: Path = PrivateAttr(default_factory=Path.cwd)
    _source: str = PrivateAttr(default="")

    @classmethod
    def read(cls: type[OwnFile], path: PathLike, kind: str) -> OwnFile:
        """From a TOML file; kind: what it is a file of. Raises InputError, which names file, key, value and what is
        allowed."""
        path = Path(path)
        if not path.is_file():
            what = f"a folder, not the file of a {kind}" if path.is_dir() else "no such file"
            raise InputError(f"{path}: {what}")
        return cls.checked(parse(path), str(path), path.resolve().parent)

    @classmethod
    def checked(cls: type[OwnFile], data: Mapping[str, Any], source: str, base_dir: PathLike) -> OwnFile:
        """From tables; source: name for messages. Raises InputError."""
        try:
            found = cls.model_validate(data)
        except ValidationError as error:
            raise InputError(describe(error, data, cls, source)) from None
        found._base_dir, found._source = Path(base_dir), source
        return found

    @property
    def base_dir(self) -> Path:
        """Folder of relative paths."""
        return self._base_dir

    @property
    def source(self) -> str:
        """The file, for messages."""
        return self._source

    def to_toml(self) -> str:
        """As TOML text."""
        return table_text(self.model_dump(exclude_none=True, exclude_defaults=True) | {"name": self.name})
