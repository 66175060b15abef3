"""Names of collision layers, as the bits of Box2D's filters."""

from typing import Dict, Iterable, List

from flatland_server.exceptions import suggestion

MAX_LAYERS = 16
ALL_LAYERS = 0xFFFF
ALL = "all"


class CollisionFilterRegistry:
    """Gives each layer name one of Box2D's 16 bits."""

    def __init__(self) -> None:
        self._bits: Dict[str, int] = {}

    @property
    def names(self) -> List[str]:
        """The names, in the order of their bits."""
        return list(self._bits)

    def register(self, name: str) -> int:
        """The bit of a new name.

        Raises:
            ValueError: the name is taken or reserved, or all 16 bits are.
        """
        if name == ALL:
            raise ValueError(f'the name "{ALL}" stands for all layers')
        if name in self._bits:
            raise ValueError(f'the layer name "{name}" is given twice')
        if len(self._bits) == MAX_LAYERS:
            raise ValueError(f"expected at most {MAX_LAYERS} layer names in all, found more")
        self._bits[name] = 1 << len(self._bits)
        return self._bits[name]

    def bits(self, names: Iterable[str]) -> int:
        """The bits of some names together; `all` is every bit, no names are none.

        Raises:
            ValueError: a name is unknown.
        """
        mask = 0
        for name in names:
            if name == ALL:
                return ALL_LAYERS
            if name not in self._bits:
                known = ", ".join(self._bits) or "none"
                hint = suggestion(name, self._bits)
                raise ValueError(f'no layer is named "{name}"{hint}; there are: {known}')
            mask |= self._bits[name]
        return mask


class AnyLayer(CollisionFilterRegistry):
    """For a model alone: whatever layer it names may exist in the world that it is made for."""

    def bits(self, names: Iterable[str]) -> int:
        """A bit for each name."""
        return ALL_LAYERS if list(names) else 0
