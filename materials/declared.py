"""What a class of laws declares, and a law of it with parts of its own may extend."""

from collections.abc import Callable
from typing import Any


class Declared:
    """Class attribute that is `of_class` when read from the class, and `of_law(law)` when read from a law.

    For `Law.STATE` and its like, where they depend on the numbers of a law: whoever asks a law gets what that one has.
    """

    def __init__(self, of_class: Any, of_law: Callable[[Any], Any]) -> None:
        self._of_class, self._of_law = of_class, of_law

    def __get__(self, law: Any, owner: type) -> Any:
        return self._of_class if law is None else self._of_law(law)
