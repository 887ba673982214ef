"""What water in the snow does not go with, whatever its scheme."""

from snowmpm.errors import InputError

DOUBLE = "beside water, whose compression is smaller than the round-off of single precision"
"""Why it needs double precision."""


def refuse_hand_over(scene):
    """Raise InputError for what would have to keep the water and does not."""
    if scene.switch:
        raise InputError.at("switch.0.to", scene.switch[0].to, "does not go with water, which no hand-over keeps",
                            scene.source)
    if scene.initial.from_run is not None:
        raise InputError.at("initial.from", scene.initial.from_run, "does not go with water, which is not taken over",
                            scene.source)
    if scene.saw_test:
        raise InputError.at("saw_test.slope_angle", scene.saw_test.slope_angle, "does not go with water", scene.source)


def refuse_of_pores(scene):
    """The same of water whose pressure the skeleton bears with, and for states of stress that do not know it."""
    refuse_hand_over(scene)
    if scene.initial.stress == "geostatic":
        raise InputError.at("initial.stress", scene.initial.stress, 'does not go with water: "settle" finds the'
                            " effective stress", scene.source)
    if scene.initial.relaxation == "static":
        raise InputError.at("initial.relaxation", "static", 'must be "damped" beside water, whose weight and pressure'
                            " the balance does not know", scene.source)
