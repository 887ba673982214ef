"""Scatter of densities by hardness and form, from profiles that have a measured density as well.

    python tests/benchmarks/snow_pits.py FOLDER [--every N]

FOLDER: profiles that `snowmpm profile` reads, in any depth; the figures of docs/snow_pits.md are of 31 170 profiles of
SnowPilot, as the package snowpylot keeps them (demos/snowpits/by_season). For each way to a density: layers, median of
measured over computed, standard deviation of its logarithm by the median deviation; then by form.
The comparison with saw tests in that guide is `snowmpm profile --all FOLDER`.
"""

import argparse
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from snowmpm.errors import InputError
from snowmpm.pit import mechanics
from snowmpm.pit.reader import READERS, read_profile


def logarithms(profiles):
    """{"hardness" or "form": {form: [log(measured over computed)]}} of all layers with a measured density."""
    found = {"hardness": {}, "form": {}}
    for profile in profiles:
        for layer in profile.layers:
            form = mechanics.density_form(layer.form)
            if layer.density is None or not form:
                continue
            for way, hardness in (("hardness", layer.hardness), ("form", None)):
                value, source = mechanics.density(replace(layer, density=None, hardness=hardness))
                if source == way:
                    found[way].setdefault(form, []).append(math.log(layer.density / value))
    return found


def told(values):
    """Number, median ratio, scatter."""
    values = np.asarray(values)
    middle = np.median(values)
    return f"{len(values):6} {math.exp(middle):8.2f} {1.4826 * np.median(np.abs(values - middle)):8.2f}"


def read(folder, every):
    for path in sorted(path for path in folder.rglob("*") if path.suffix.lower() in READERS)[::every]:
        try:
            yield read_profile(path)
        except InputError:
            continue


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--every", type=int, default=1, metavar="N")
    choice = parser.parse_args()
    for way, forms in logarithms(read(choice.folder, choice.every)).items():
        print(f"{way:10} layers   median  scatter")
        if forms:
            print(f"{'all':10} {told(np.concatenate([np.array(values) for values in forms.values()]))}")
        for form, values in sorted(forms.items()):
            print(f"{form:10} {told(values)}")


if __name__ == "__main__":
    main()
