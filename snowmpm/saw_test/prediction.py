"""The theories of `snowmpm.saw_test.theory` for one scene."""

from snowmpm.saw_test import theory


def column_of(scene):
    """(`theory.Slab`, law of the weak layer, its thickness [m]) of a scene with a saw test."""
    test, laws = scene.saw_test, scene.materials
    slab = theory.Slab.of([(layer.thickness, laws[layer.material]) for layer in test.slab])
    return slab, laws[test.weak_layer.material], test.weak_layer.thickness


def uncounted_by_theories(scene):
    """Loads of a scene that act on its saw test and that the theories neglect."""
    return [name for name in ("forces", "damping", "events", "obstacles") if scene.get(name)]


def elastic_predictions(scene):
    """Predictions that need no strength, by name: load on the weak layer [Pa], with the magnitude of its shear, and
    wave speeds of the slab [m/s]."""
    slab = column_of(scene)[0]
    normal, shear = slab.stresses(scene.saw_test.slope_angle, scene.gravity)
    return {"normal_stress": float(normal), "shear_stress": float(abs(shear)), "shear_wave_speed": slab.shear_speed,
            "plate_wave_speed": slab.plate_speed}


def predictions(scene):
    """Predictions that need nothing measured, by name; None if a theory does not apply.

    maxwell_load [Pa] and fracture_energy [J/m2] of the weak layer, from its oedometric curve; critical_length_energy,
    critical_length_strength [m].
    """
    slab, law, thickness = column_of(scene)
    found = elastic_predictions(scene)
    normal, shear = slab.stresses(scene.saw_test.slope_angle, scene.gravity)
    e, P, _, _ = theory.collapse_curve(law)
    energy = theory.fracture_energy(law, law.collapse_thickness or thickness)
    strength = theory.shear_strength(law, normal)
    found["maxwell_load"] = _known(theory.maxwell_load(e, P)[0])
    found["fracture_energy"] = _known(energy)
    found["critical_length_energy"] = theory.critical_length_by_energy(
        slab, normal, shear, energy, scene.saw_test.ends) if found["fracture_energy"] else None
    found["critical_length_strength"] = _known(theory.critical_length_by_strength(
        slab, normal, abs(shear), strength, thickness, law.shear_modulus))
    return found


def collapse_wave_speed(scene, collapse_height):
    """[m/s], with a measured collapse height [m]; None without one."""
    if not collapse_height or collapse_height <= 0.0:
        return None
    return theory.collapse_speed(column_of(scene)[0], collapse_height, scene.gravity)


def _known(value):
    return float(value) if value == value else None
