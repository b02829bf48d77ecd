"""The methods by name: those of this package, and those that other installed packages bring.

Another package brings a method by an entry point of the group `anamorph.methods`: its name is the method's, and what
it points to is a `Method`. Each method is loaded when it is first asked for.
"""

from __future__ import annotations

from collections.abc import Iterator, MutableMapping
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points

from anamorph.base.errors import AnamorphError
from anamorph.methods.protocol import Method

OWN = ("auto", "raytrace", "environment", "pervertex", "trilinear", "threeray", "virtual")
"""The methods of this package: each is the room of that name."""

GROUP = "anamorph.methods"


class Registry(MutableMapping[str, Method]):
    """Methods by name.

    Going through them leaves out those that do not load. Asking for such a one raises an `AnamorphError` that says why
    in one line: its package is broken, or several packages bring a method of that name.
    """

    @cached_property
    def _claims(self) -> dict[str, list[EntryPoint]]:
        """What brings each method."""
        own = [EntryPoint(name, f"anamorph.methods.{name}:METHOD", GROUP) for name in OWN]
        claims: dict[str, list[EntryPoint]] = {}
        for claim in (*own, *sorted(entry_points(group=GROUP), key=lambda claim: claim.name)):
            claims.setdefault(claim.name, []).append(claim)
        return claims

    @cached_property
    def _loaded(self) -> dict[str, Method]:
        return {}

    def __getitem__(self, name: str) -> Method:
        if name not in self._loaded:
            self._loaded[name] = _load(name, self._claims[name])
        return self._loaded[name]

    def __setitem__(self, name: str, method: Method) -> None:
        self._loaded[name] = method

    def __delitem__(self, name: str) -> None:
        del self._loaded[name]

    def __iter__(self) -> Iterator[str]:
        for name in dict.fromkeys((*self._claims, *self._loaded)):
            try:
                self[name]
            except AnamorphError:
                continue
            yield name

    def __len__(self) -> int:
        return sum(1 for _ in self)


METHODS = Registry()


def _load(name: str, claims: list[EntryPoint]) -> Method:
    packages = [claim.dist.name if claim.dist else "anamorph" for claim in claims]
    if len(claims) > 1:
        raise AnamorphError(f"method {name}: {' and '.join(packages)} both bring it; uninstall one of these packages")
    try:
        method = claims[0].load()
    # A package of others may fail in any way.
    except Exception as error:
        said = " ".join(f"{type(error).__name__}: {error}".split())
        raise AnamorphError(f"method {name}: its package {packages[0]} does not load ({said}); mend it") from error
    if not isinstance(method, Method) or method.name != name:
        raise AnamorphError(f"method {name}: {claims[0].value} of {packages[0]} is not a Method of that name; mend it")
    return method
