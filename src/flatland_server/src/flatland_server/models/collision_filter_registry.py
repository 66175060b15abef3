"""Names of collision layers, as bits of Box2D's collision filters."""

from typing import Dict, Iterable, List

from flatland_server.exceptions import listed, shortened, suggestion

MAX_LAYERS = 16
"""The number of bits of Box2D's filters."""
ALL_LAYERS = 0xFFFF
ALL = "all"
"""The name that stands for all layers."""


class CollisionFilterRegistry:
    """The collision layers of a world: assigns one of 16 bits to each name."""

    def __init__(self) -> None:
        self._bits: Dict[str, int] = {}

    @property
    def names(self) -> List[str]:
        """The names, in the order of their bits."""
        return list(self._bits)

    def register(self, name: str) -> int:
        """Assigns a bit to a new name.

        Args:
            name: a collision layer's name.

        Raises:
            ValueError: the name is taken or reserved, or all 16 bits are.
        """
        if name == ALL:
            raise ValueError(f'the name "{ALL}" stands for all layers')
        if name in self._bits:
            raise ValueError(f'the layer name "{shortened(name)}" is given twice')
        if len(self._bits) == MAX_LAYERS:
            raise ValueError(f"expected at most {MAX_LAYERS} layer names in all, found more")
        self._bits[name] = 1 << len(self._bits)
        return self._bits[name]

    def bits(self, names: Iterable[str]) -> int:
        """The bits of some names together; none without a name.

        Args:
            names: of collision layers; `all` has all bits.

        Raises:
            ValueError: a name is unknown.
        """
        mask = 0
        for name in names:
            if name == ALL:
                return ALL_LAYERS
            if name not in self._bits:
                known = listed(self._bits)
                hint = suggestion(name, self._bits)
                raise ValueError(f'no layer is named "{shortened(name)}"{hint}; there are: {known}')
            mask |= self._bits[name]
        return mask


class AnyLayer(CollisionFilterRegistry):
    """For a model that is checked without a world: every name is a collision layer."""

    def bits(self, names: Iterable[str]) -> int:
        """All bits, or none without a name."""
        return ALL_LAYERS if list(names) else 0
