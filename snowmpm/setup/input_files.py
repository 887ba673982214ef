"""What was in the files that a scene names."""

from pathlib import Path

from snowmpm.reading.named_files import digest_of, files_named


def named(scene):
    """{dotted key: path} of the files that a scene names."""
    tables = scene.model_dump(exclude_none=True, by_alias=True, warnings=False)
    return {key: Path(scene.base_dir, Path(name).expanduser()) for key, name in files_named(tables)}


def digests(scene, read):
    """{dotted key: digest} of the files that a scene names. read: digests by path of those that were read already
    (`snowmpm.reading.named_files.noting`); the others are read here, where there are any."""
    return {key: read.get(path.resolve()) or digest_of(path) for key, path in named(scene).items() if path.is_file()}
