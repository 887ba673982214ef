"""Everything that can be added to the program, by name: laws, events, shapes, methods, commands.

    snowmpm.register(MyLaw)

A registry holds the entries of the package, in the module that is its home, and those of plugins
(`snowmpm.plugins`). The tables of a scene are built from the registries: an entry that is added is known to all of
them at once.
"""

import importlib
import pkgutil
import sys
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Annotated, Any, TypeVar, Union, get_args

from snowmpm.errors import InputError

T = TypeVar("T")

OWN = "snowmpm"
"""Who added the entries of the package."""


class Registry(Mapping[str, Any]):
    """Entries by name. what: an entry in messages; home: module that registers those of the package; key: field of a
    table, or attribute, that holds the name."""

    what: str
    home: str
    key: str
    needs: str
    """attribute that each entry has, besides"""
    by: dict[str, str]
    """the module that added an entry, by name"""

    def __init__(self, what: str, home: str, key: str = "kind", needs: str = "") -> None:
        self.what, self.home, self.key, self.needs = what, home, key, needs
        self._entries: dict[str, Any] = {}
        self.by = {}

    def add(self, entry: T, by: str = OWN) -> T:
        """Add an entry of the module `by`, and return it; usable as a decorator. Raises InputError where the name is
        taken, unless by the same class, which a notebook defines anew."""
        name = self.name_of(entry)
        if self.needs and not any(self.needs in vars(base) for base in entry.__mro__):
            raise InputError(f"{entry!r}: {self.needs} is missing, which names what it does in a run")
        known = self._entries.get(name)
        if known is not None and (self.by[name], _class_of(known)) != (by, _class_of(entry)):
            raise InputError(f"{self.what} {name!r}: there is one already, of {self.by[name]}")
        self._entries[name], self.by[name] = entry, by
        return entry

    def name_of(self, entry: Any) -> str:
        """Name of an entry: an attribute, or the only value of the field of a table."""
        field = getattr(entry, "model_fields", {}).get(self.key)
        name = get_args(field.annotation)[:1] if field else (getattr(entry, self.key, None),)
        if not name or not isinstance(name[0], str):
            raise InputError(f"{entry!r}: a {self.what} needs {self.key}: Literal[\"its name\"]")
        return name[0]

    def member(self, *others: type, usual: Callable[[], str | None] | None = None) -> "Member":
        """Mark of a table that is one of the entries, or one of the `others`:

            Material = Annotated[Law, LAWS.member()]

        usual: names the entry of a table without a name.
        """
        return Member(self, others, usual)

    def _loaded(self) -> dict[str, Any]:
        if self.home not in sys.modules:
            importlib.import_module(self.home)
        return self._entries

    __eq__, __hash__ = object.__eq__, object.__hash__

    def __getitem__(self, name: str) -> Any:
        return self._loaded()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._loaded())

    def __len__(self) -> int:
        return len(self._loaded())


def _class_of(entry: Any) -> str:
    return (entry if isinstance(entry, type) else type(entry)).__qualname__


class Member:
    """Pydantic's schema of a table that is one of the entries of a registry, told apart by its key."""

    registry: Registry

    def __init__(self, registry: Registry, others: tuple[type, ...], usual: Callable[[], str | None] | None) -> None:
        self.registry, self._others, self._usual = registry, others, usual

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        from pydantic import Discriminator, Field, Tag

        if self._usual is None:
            members = Union[(*self.registry._entries.values(), *self._others)]
            return handler.generate_schema(Annotated[members, Field(discriminator=self.registry.key)])
        # Marks of members that no key of a scene can be equal to (`scenes.space.tag`), as the table may not name one
        marked = tuple(Annotated[entry, Tag(f"<{name}>")] for name, entry in self.registry._entries.items())
        return handler.generate_schema(Annotated[Union[(*marked,)], Discriminator(self._mark)])

    def _mark(self, given: Any) -> str:
        key, usual = self.registry.key, self._usual and self._usual()
        return f"<{given.get(key, usual) if isinstance(given, dict) else getattr(given, key, usual)}>"


LAWS = Registry("law", "snowmpm.materials")
GROUND_LAWS = Registry("law of ground friction", "snowmpm.ground", "law")
EVENTS = Registry("event", "snowmpm.scenes.events", needs="ACTS")
FORCES = Registry("force", "snowmpm.scenes.forces")
SHAPES = Registry("shape of a body", "snowmpm.scenes.shapes")
WATER = Registry("scheme of water", "snowmpm.components", "scheme")
OBSTACLES = Registry("shape of an obstacle", "snowmpm.scenes.shapes")
FIELDS = Registry("field of particles", "snowmpm.particles.fields", "name")
COMPONENTS = Registry("component", "snowmpm.components", "name")
METHODS = Registry("method", "snowmpm.methods", "name")
COMMANDS = Registry("command", "snowmpm.cli.app", "name")

generation = 0
"""How many entries were added to the package's own: caches of what is made of the registries are of one generation."""


def register(entry: T, by: str) -> T:
    """Add an entry of the module `by` to the program, and return it.

    Its class says where it belongs: REGISTRIES, of the base that it derives from. Scenes that are loaded afterwards may
    name it. Raises InputError for what belongs nowhere, or has a name that is taken.
    """
    global generation
    registries = getattr(entry, "REGISTRIES", ())
    if not registries:
        raise InputError(f"{entry!r}: no law, event, force, shape, field, component, method or command, so it cannot be"
                         " registered")
    for registry in registries:
        registry._loaded()
    for registry in registries:
        registry.add(entry, by)
    generation += 1
    _rebuild(set(registries), entry.registered() if COMPONENTS in registries else ())
    return entry


def _rebuild(registries: set[Registry], changed: Collection[type] = ()) -> None:
    """Build the tables anew that name entries of these registries or hold `changed` ones, those within others first."""
    from pydantic import BaseModel

    done: dict[type, bool] = {}

    def depends(model: type[BaseModel]) -> bool:
        if model not in done:
            done[model] = False  # a table within itself
            found = [part in changed or depends(part) if isinstance(part, type) else part.registry in registries
                     for field in model.model_fields.values()
                     for part in _parts((field.annotation, *field.metadata))]
            done[model] = any(found)
            if done[model] and model.__pydantic_complete__:
                model.model_rebuild(force=True)
        return done[model]

    for model in list(_below(BaseModel)):
        depends(model)


def _parts(found: Any) -> Iterator[Any]:
    """Models and marks of members that an annotation is made of."""
    from pydantic import BaseModel

    if isinstance(found, Member) or (isinstance(found, type) and issubclass(found, BaseModel)):
        yield found
    for part in found if isinstance(found, tuple) else get_args(found):
        yield from _parts(part)


def _below(model: type) -> Iterator[type]:
    for one in model.__subclasses__():
        yield one
        yield from _below(one)


def resolved(named: Any) -> Any:
    """What "module:name" names, or the object itself: what takes long to import is named."""
    return pkgutil.resolve_name(named) if isinstance(named, str) else named
