"""The contents of a world's files: its properties, layers, models and plugins."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Callable, Dict, Mapping, Optional, Sequence, Set, Tuple, Union

import numpy as np

from flatland_server.arrays import Segments
from flatland_server.config.file_names import find_file, is_bare, nor_in
from flatland_server.config.input_files import is_file
from flatland_server.config.plain_nodes import plain_copy, to_node
from flatland_server.config.ros_names import namespace_problem
from flatland_server.config.yaml_map import check_topic_name
from flatland_server.config.yaml_preprocessor import YamlPreprocessor
from flatland_server.config.yaml_reader import YamlReader
from flatland_server.exceptions import FlatlandError, ModelError, YamlError
from flatland_server.geometry import Pose
from flatland_server.maps.map_reader import MapConfig
from flatland_server.models.collision_filter_registry import CollisionFilterRegistry
from flatland_server.models.layer import LayerConfig, MapSource
from flatland_server.models.model import ModelConfig, ModelText
from flatland_server.models.plugin_config import PluginConfig

_MAX_ITERATIONS = 10_000
"""The maximum number of solver iterations in a step; more would stall the simulation."""

ModelSource = Union[str, Path, Mapping[str, Any], ModelText]
"""A model's file, its content, or a client's text."""


@dataclass(frozen=True)
class ModelEntry:
    """An entry of a world's `models`, with the model's file.

    Attributes:
        name: unique in the world.
        namespace: of the model's topics and frames; may be empty.
        pose: of the model's origin in the world.
        model: the contents of its file.
        is_inline: whether these are in the world's file itself.
        reader: of the entry, for warnings; None if it is in no file.
    """

    name: str
    namespace: str
    pose: Pose
    model: ModelConfig
    is_inline: bool = False
    reader: Optional[YamlReader] = field(default=None, compare=False, repr=False)


@dataclass(frozen=True)
class WorldConfig:
    """A world file, with all the files that it refers to.

    Attributes:
        velocity_iterations: of Box2D's solver in each step.
        position_iterations: of Box2D's solver in each step.
        registry: the collision layers.
        layers: the entries of `layers`.
        models: the entries of `models`.
        plugins: the entries of `plugins`.
        walls: of each map, in the world [m].
        model_folders: where the names of model files are looked up: the world's folder, and those
            of models.
        path: the world file, if it was read from one.
        simplify_map: how much the outlines of map images were simplified; see `MapConfig.walls`.
        read_at: when reading it again began [s of time.monotonic]; 0 for a server's first world.
        seed: of the world, if its files have random numbers (math.random).
        with_seed: reads those files with another seed, as they were; None without random numbers.
    """

    velocity_iterations: int
    position_iterations: int
    registry: CollisionFilterRegistry
    layers: Tuple[LayerConfig, ...]
    models: Tuple[ModelEntry, ...]
    plugins: Tuple[PluginConfig, ...]
    walls: Mapping[MapSource, Segments] = field(default_factory=dict, repr=False, compare=False)
    model_folders: Tuple[Path, ...] = ()
    path: Optional[Path] = field(default=None, compare=False)
    simplify_map: int = 0
    read_at: float = field(default=0.0, compare=False)
    seed: int = field(default=0, compare=False)
    with_seed: Optional[Callable[[int], "WorldConfig"]] = field(
        default=None, compare=False, repr=False
    )

    @classmethod
    def from_file(
        cls,
        path: Path,
        preprocessor: Optional[YamlPreprocessor] = None,
        *,
        simplify_map: int = 0,
        model_folders: Sequence[Path] = (),
    ) -> "WorldConfig":
        """Reads a world file and the files that it refers to.

        Args:
            path: path of the world file.
            preprocessor: evaluates expressions in the files.
            simplify_map: how much the outlines of map images are simplified; see `MapConfig.walls`.
            model_folders: where model files are looked up that are not beside the world file.

        Raises:
            YamlError: something in the files is wrong; lists everything that was found.
        """

        def open(preprocessor: YamlPreprocessor) -> YamlReader:
            return YamlReader.from_file(path, preprocessor)

        return cls._open(open, path, preprocessor, simplify_map, model_folders)

    @classmethod
    def from_content(
        cls,
        content: Mapping[str, Any],
        preprocessor: Optional[YamlPreprocessor] = None,
        *,
        simplify_map: int = 0,
        model_folders: Sequence[Path] = (),
    ) -> "WorldConfig":
        """Reads the content of a world file from plain data; see `from_file`.

        Args:
            content: plain data; see `plain_nodes.plain_copy`. Relative paths in it are relative to
                the working directory.
            preprocessor: as for `from_file`.
            simplify_map: as for `from_file`.
            model_folders: as for `from_file`.
        """
        node = to_node(content, "world")

        def open(preprocessor: YamlPreprocessor) -> YamlReader:
            return YamlReader(preprocessor.resolve(node))

        return cls._open(open, None, preprocessor, simplify_map, model_folders)

    @classmethod
    def _open(
        cls,
        open: Callable[[YamlPreprocessor], YamlReader],
        path: Optional[Path],
        preprocessor: Optional[YamlPreprocessor],
        simplify_map: int,
        model_folders: Sequence[Path],
        former: Optional["WorldConfig"] = None,
    ) -> "WorldConfig":
        """Reads a world file or its content, and again for other seeds if it has random numbers."""
        preprocessor = preprocessor or YamlPreprocessor()
        config = cls.read(
            open(preprocessor),
            preprocessor,
            simplify_map=simplify_map,
            model_folders=model_folders,
            former=former,
        )
        config = replace(config, path=path)
        if preprocessor.random_count == 0:
            return config

        files = preprocessor.again(preprocessor.seed)  # without a process

        def with_seed(seed: int) -> "WorldConfig":
            return cls._open(open, path, files.again(seed), simplify_map, model_folders, config)

        return replace(config, seed=preprocessor.seed, with_seed=with_seed)

    @classmethod
    def read(
        cls,
        reader: YamlReader,
        preprocessor: Optional[YamlPreprocessor] = None,
        *,
        simplify_map: int = 0,
        model_folders: Sequence[Path] = (),
        former: Optional["WorldConfig"] = None,
    ) -> "WorldConfig":
        """Like `from_file`, for a file that has been parsed already.

        Args:
            reader: the reader of the file.
            preprocessor: as for `from_file`.
            simplify_map: as for `from_file`.
            model_folders: as for `from_file`.
            former: of the same files with another seed, to keep its walls.
        """
        properties = reader.get_section("properties", required=True)
        velocity_iterations = properties.get_int(
            "velocity_iterations", 10, minimum=1, maximum=_MAX_ITERATIONS
        )
        position_iterations = properties.get_int(
            "position_iterations", 10, minimum=1, maximum=_MAX_ITERATIONS
        )
        properties.finish()
        registry = CollisionFilterRegistry()
        layers = reader.get_sections(
            "layers", lambda section: LayerConfig.read(section, registry), required=True
        )
        walls, images = _read_walls(reader, preprocessor, simplify_map, former)
        layers = [replace(layer, encloses=layer.map in images) for layer in layers]
        files: Dict[Path, ModelConfig] = {}  # so that each file is read only once

        def read_model(path: Path) -> ModelConfig:
            if path not in files:
                files[path] = ModelConfig.from_file(path, registry, preprocessor)
            return files[path]

        def read_content(section: YamlReader) -> ModelConfig:
            return ModelConfig.read(section, registry)

        models = reader.get_enabled_sections(
            "models",
            lambda section: _read_model_entry(section, read_model, read_content, model_folders),
        )
        plugins = reader.get_enabled_sections("plugins", PluginConfig.read)
        reader.finish()
        return cls(
            velocity_iterations,
            position_iterations,
            registry,
            tuple(layers),
            tuple(models),
            tuple(plugins),
            walls,
            (reader.file.parent, *model_folders),
            reader.file,
            simplify_map,
        )

    def for_seed(self, seed: int) -> "WorldConfig":
        """The same world with the random numbers of a seed; itself if its files have none.

        Args:
            seed: the world's seed.

        Raises:
            FlatlandError: with this seed, something in the files is wrong.
        """
        return self if self.with_seed is None or seed == self.seed else self.with_seed(seed)

    def read_again(
        self, path: Optional[Path] = None, preprocessor: Optional[YamlPreprocessor] = None
    ) -> "WorldConfig":
        """Reads the world's files again, as they are now, or those of another world.

        Args:
            path: of the world file; None is this world's own.
            preprocessor: evaluates expressions in the files.

        Raises:
            FlatlandError: something in them is wrong, or this world was read from no file.
        """
        path = path or self.path
        if path is None:
            raise FlatlandError("the world was made without a file")
        folders = self.model_folders[1:]  # the first is the world's own
        return self.from_file(
            path, preprocessor, simplify_map=self.simplify_map, model_folders=folders
        )

    def read_model(
        self, source: ModelSource, preprocessor: Optional[YamlPreprocessor] = None
    ) -> ModelConfig:
        """Reads a model for this world.

        Args:
            source: the path of its file, also beside the world file or in a folder of models; or
                the content of one. Relative paths in a `ModelText` begin in the world's folder.
            preprocessor: evaluates expressions in it.

        Raises:
            FlatlandError: there is no such file, or something in it is wrong.
        """
        if isinstance(source, ModelText):
            reader = YamlReader.from_text(*source, self.model_folders[0], preprocessor)
            content: Any = source.text
        elif isinstance(source, (str, Path)):
            return ModelConfig.from_file(self.find_model(source), self.registry, preprocessor)
        else:
            reader = YamlReader.from_content(source, "model", preprocessor)
            content = plain_copy(source, "model")  # the caller's may change
        return replace(ModelConfig.read(reader, self.registry), content=content)

    def find_model(self, source: Union[str, Path], base: Path = Path()) -> Path:
        """The path of a model file: as named, beside the world file, or in a folder of models.

        Args:
            source: its name, which may be a `package://name/path`.
            base: the folder in which a relative name begins; by default the working directory.

        Raises:
            ModelError: there is no such file.
        """
        if not str(source):
            raise ModelError("expected the path of a model file, found an empty string")
        folders = self.model_folders if is_bare(source) else ()
        try:
            path = find_file(source, [base, *folders])
        except FlatlandError as error:
            raise ModelError(str(error)) from None
        if not is_file(path):
            raise ModelError(f"there is no file {path.absolute()}{nor_in(folders)}")
        return path

    def with_walls(self, segments: Segments) -> "WorldConfig":
        """The same world with other walls in its first layer.

        Args:
            segments: the walls: shape (n, 4), x1, y1, x2, y2 [m].
        """
        first, *rest = self.layers
        map = "walls of an environment"
        own = replace(first, map=map)
        return replace(self, layers=(own, *rest), walls={**self.walls, map: segments})

    def walls_of(self, layer: LayerConfig) -> Segments:
        """The walls of a layer in the world [m]: shape (n, 4), x1, y1, x2, y2.

        Args:
            layer: a layer of this world.
        """
        return self.walls[layer.map] if layer.map is not None else np.empty((0, 4))


def _read_walls(
    reader: YamlReader,
    preprocessor: Optional[YamlPreprocessor],
    simplify_map: int,
    former: Optional[WorldConfig],
) -> Tuple[Dict[MapSource, Segments], Set[MapSource]]:
    """The walls of each map, and the maps that are images or grids.

    Includes layers with problems in their entries, so that the problems of all files are reported
    together.
    """
    walls: Dict[MapSource, Segments] = {}
    images: Set[MapSource] = set()
    kept = {} if former is None else former.walls
    kept_images = {each.map for each in former.layers if each.encloses} if former else set()

    def read(section: YamlReader) -> None:
        source = LayerConfig.read_map_source(section)
        if isinstance(source, str):
            config = MapConfig.read(section.get_section("map"))
        elif preprocessor and source and source in kept and preprocessor.is_plain(source):
            walls[source] = kept[source]
            if source in kept_images:
                images.add(source)
            return
        elif source is not None and source not in walls and is_file(source):
            config = MapConfig.from_file(source, preprocessor)
        else:
            return
        walls[source] = config.walls(simplify_map)
        if config.is_image:
            images.add(source)

    reader.get_sections("layers", read)
    return walls, images


def _read_model_entry(
    reader: YamlReader,
    read_model: Callable[[Path], ModelConfig],
    read_content: Callable[[YamlReader], ModelConfig],
    folders: Sequence[Path],
) -> ModelEntry:
    name = reader.get_string("name")
    check_topic_name(reader, "name", name)
    namespace = reader.get_string("namespace", "")
    problem = namespace_problem(namespace)
    if problem:
        reader.problem(problem, "namespace")
    pose = reader.get_pose("pose", Pose())
    model = None
    try:
        if reader.is_map("model"):
            model = read_content(reader.get_section("model"))
        else:
            path = reader.get_path("model", folders)
            model = read_model(path) if is_file(path) else None
    except YamlError as error:
        reader.note(error)
    reader.finish()
    assert model is not None  # otherwise `finish` has raised
    return ModelEntry(name, namespace, pose, model, reader.is_map("model"), reader)
