"""What an installation weighs: the table of docs/install.md.

    python .ci/weight.py [--least MB]

Megabytes (10^6 bytes) of the files of each distribution of this environment, with the total; pip and setuptools, which
an environment has anyway, are left out.
"""

import argparse
from importlib.metadata import distributions
from pathlib import Path

LEFT_OUT = {"pip", "setuptools"}


def weights():
    """{distribution: bytes}."""
    found = {}
    for one in distributions():
        files = {Path(one.locate_file(file)).resolve() for file in one.files or ()}
        found[one.metadata["Name"].lower()] = sum(path.stat().st_size for path in files if path.is_file())
    return {name: size for name, size in found.items() if name not in LEFT_OUT}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--least", type=float, default=5.0, metavar="MB", help="smaller ones are summed up")
    least = parser.parse_args().least * 1e6
    found = weights()
    small = sum(size for size in found.values() if size < least)
    for name, size in sorted(found.items(), key=lambda one: -one[1]):
        if size >= least:
            print(f"{name:<20} {size / 1e6:6.0f}")
    print(f"{'others':<20} {small / 1e6:6.0f}")
    print(f"{'all':<20} {sum(found.values()) / 1e6:6.0f}")


if __name__ == "__main__":
    main()
