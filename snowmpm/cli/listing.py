"""`snowmpm list`: what comes with the program."""


def list_library():
    """List library scenes and kinds of material."""
    from snowmpm.materials import LAWS
    from snowmpm.scenes import library

    laws = {kind: _first_sentence(law) for kind, law in sorted(LAWS.items())}
    _print_table("Scenes (snowmpm run NAME)", library())
    print()
    _print_table("Materials (kind = NAME in a scene)", laws)


def _first_sentence(law):
    return (law.__doc__ or "").strip().split("\n")[0]


def _print_table(title, entries):
    width = max((len(name) for name in entries), default=0)
    print(title)
    for name, text in entries.items():
        print(f"  {name:<{width}}  {text}".rstrip())
