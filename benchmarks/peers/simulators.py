"""The simulators that are compared, and how each is used."""

from typing import NamedTuple, Tuple

from scenario import TEAMS


class Simulator(NamedTuple):
    """A simulator, as it is measured."""

    name: str
    rooms: str
    """The module that opens its rooms."""
    requirement: str
    """The requirement for pip; empty for Flatland, which comes from this workspace."""
    flags: str
    """Compiler flags for a build by pip."""
    variant: str
    """The variant for the module's `open_room`."""
    most_robots: int
    """The largest number of robots in one room that is measured."""
    has_batches: bool
    about: str
    has_teams: bool = False
    """Whether it has batches of rooms with several robots."""
    has_crowds: bool = False
    """Whether it has agents that avoid each other by ORCA."""


FLATLAND = Simulator(
    "Flatland",
    "flatland_rooms",
    "",
    "",
    "",
    1000,
    True,
    "Box2D's rigid bodies and contacts, in one physics step of 0.1 s",
    has_teams=True,
    has_crowds=True,
)
FLATLAND_SUBSTEPS = FLATLAND._replace(
    name="Flatland, 20 x 5 ms",
    variant="20 x 5 ms",
    about="the same in 20 physics steps of 5 ms, the server's default",
)
IRSIM = Simulator(
    "ir-sim",
    "irsim_rooms",
    "ir-sim[all]==2.12.0",
    "",
    "",
    100,
    False,
    'kinematics; a robot that touches something stays there (collision_mode "stop", its default)',
    has_crowds=True,
)
IRSIM_CONTACT = IRSIM._replace(
    name="ir-sim, contact",
    variant="contact",
    has_crowds=False,
    about='bodies that overlap are pushed apart (collision_mode "contact")',
)
IRSIM_X = Simulator(
    "irsim-x",
    "irsim_rooms",
    "irsim-x==1.1.4",
    "-mno-avx512f",  # with AVX-512, its batch leaves every other eight ranges undefined
    "",
    1000,
    True,
    "kinematics; robots do not see each other, those of a batch drive through discs and walls",
)
VMAS = Simulator(
    "VMAS",
    "vmas_rooms",
    "vmas==1.5.2",
    "",
    "",
    0,
    False,
    "forces by overlaps, in one physics step of 0.1 s",
    has_teams=True,
)
VMAS_OPEN = VMAS._replace(
    name="VMAS, open",
    variant="open",
    about="the same without discs and walls: robots see and hit each other alone",
)
SIMULATORS = (FLATLAND, FLATLAND_SUBSTEPS, IRSIM, IRSIM_CONTACT, IRSIM_X, VMAS, VMAS_OPEN)


class Case(NamedTuple):
    """Robots that are measured together."""

    kind: str
    """"room", "batch", "team" or "crowd"; see `open_room`."""
    robots: int

    @property
    def name(self) -> str:
        """The name, such as "robots_10" or "batch_1024"."""
        return f"{'robots' if self.kind == 'room' else self.kind}_{self.robots}"

    @property
    def title(self) -> str:
        """The heading of its table column."""
        if self.kind == "batch":
            return f"batch of {self.robots:,}"
        if self.kind == "team":
            return f"{TEAMS:,} teams of {self.robots:,}"
        if self.kind == "crowd":
            return f"crowd of {self.robots:,}"
        return "1 robot" if self.robots == 1 else f"{self.robots:,} robots"

    def suits(self, simulator: Simulator) -> bool:
        """True if a simulator can run this case."""
        if self.kind == "batch":
            return simulator.has_batches
        if self.kind == "team":
            return simulator.has_teams
        if self.kind == "crowd":
            return simulator.has_crowds
        return self.robots <= simulator.most_robots


class Target(NamedTuple):
    """A target for the ratio of Flatland's rate to a peer's."""

    peer: str
    kinds: Tuple[str, ...]
    times: float


TARGETS = (Target("ir-sim", ("room",), 200.0), Target("irsim-x", ("batch",), 3.0))
