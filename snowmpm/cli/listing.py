"""`snowmpm list`: what comes with the program."""


def list_library():
    """List library scenes, material cards, kinds of material and tests of a material."""
    from snowmpm.materials import EXPERIMENTS, LAWS
    from snowmpm.scenes import library, material_cards

    laws = {kind: _first_sentence(law) for kind, law in sorted(LAWS.items())}
    _print_table("Scenes (snowmpm run NAME)", library())
    print()
    cards = {name: card.description for name, card in material_cards().items()}
    _print_table("Material cards (material = NAME in a scene)", cards)
    print()
    _print_table("Materials (kind = NAME in a scene)", laws)
    print()
    tests = {name: experiment.summary for name, experiment in EXPERIMENTS.items()}
    _print_table("Tests of a material at one point (snowmpm element NAME)", tests)


def _first_sentence(law):
    return (law.__doc__ or "").strip().split("\n")[0]


def _print_table(title, entries):
    width = max((len(name) for name in entries), default=0)
    print(title)
    for name, text in entries.items():
        print(f"  {name:<{width}}  {text}".rstrip())
