"""A plugin as a package declares it: its name in YAML files, and its class."""

from dataclasses import dataclass
from typing import Type

from flatland_server.plugins.plugin import Plugin


@dataclass(frozen=True)
class PluginDeclaration:
    """A class that a package declares.

    Args:
        name: in YAML files.
        package: that declares it.
        class_path: the module and the class, such as `flatland_plugins.laser.Laser`.
        is_cpp: whether it is a C++ class, as plugins of the original Flatland are.
    """

    name: str
    package: str
    class_path: str
    is_cpp: bool = False

    @classmethod
    def of(cls, plugin: Type[Plugin]) -> "PluginDeclaration":
        """The declaration of a class that no package exports, under its own name.

        Args:
            plugin: the class.
        """
        module = plugin.__module__
        return cls(plugin.__name__, module.partition(".")[0], f"{module}.{plugin.__name__}")

    def answers_to(self, type: str) -> bool:
        """Whether a type in a YAML file means this class.

        Args:
            type: with or without a package, such as `Laser` or `flatland_plugins::Laser`.
        """
        package, _, name = type.rpartition("::")
        return name == self.name and package in ("", self.package, self._namespace)

    @property
    def _namespace(self) -> str:
        """Where the class is: not always in one named as the package that declares it.

        Packages of C++ plugins mostly use the namespace flatland_plugins.
        """
        if self.is_cpp:
            return self.class_path.rpartition("::")[0]
        return self.class_path.partition(".")[0]
