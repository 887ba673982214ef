"""Makes snowmpm_run.zip, an extension of Blender, with the wheels of h5py for its Python.

    python build.py [--python 3.11] [--platform manylinux2014_x86_64 win_amd64 macosx_11_0_arm64] [-o DIR]
"""

import argparse
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ADDON = HERE / "snowmpm_run"
PLATFORMS = ("manylinux2014_x86_64", "win_amd64", "macosx_11_0_arm64")


def wheel(python, platform, folder):
    """Path of the wheel of h5py for a Python and a platform, fetched by pip."""
    target = Path(folder) / platform
    subprocess.run([sys.executable, "-m", "pip", "download", "-q", "--no-deps", "--only-binary=:all:",
                    "--python-version", python, "--platform", platform, "-d", str(target), "h5py"], check=True)
    return next(target.glob("h5py-*.whl"))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--python", default="3.11", help="of Blender: 4.2 to 4.5 have 3.11")
    parser.add_argument("--platform", nargs="+", default=PLATFORMS)
    parser.add_argument("-o", "--output", type=Path, default=Path())
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        wheels = [wheel(chosen.python, platform, folder) for platform in chosen.platform]
        manifest = (ADDON / "blender_manifest.toml").read_text()
        head, table, rest = manifest.partition("[permissions]")
        listed = "".join(f'  "./wheels/{one.name}",\n' for one in wheels)
        manifest = f"{head}wheels = [\n{listed}]\n\n{table}{rest}"
        path = chosen.output / "snowmpm_run.zip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("blender_manifest.toml", manifest)
            for source in sorted(ADDON.glob("*.py")):
                archive.write(source, source.name)
            for one in wheels:
                archive.write(one, f"wheels/{one.name}")
    print(path)


if __name__ == "__main__":
    main()
