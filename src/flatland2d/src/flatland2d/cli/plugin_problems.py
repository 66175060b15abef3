"""Problems with the keys of plugins, in files that have other problems, too.

Plugins read their own keys when they start, for which their model must exist. Here each model is
put into a world of its own, with the bodies that can be read and empty ones instead of the others.
Plugins that name a joint that cannot be read are left out.
"""

from contextlib import suppress
from pathlib import Path
from typing import Dict, List, Sequence

from flatland_server.config import YamlPreprocessor, YamlReader
from flatland_server.exceptions import FlatlandError, Problem, YamlError
from flatland_server.geometry import Pose
from flatland_server.models import AnyLayer, BodyConfig, JointConfig, ModelConfig, PluginConfig
from flatland_server.simulation import ModelEntry, World, WorldConfig
from flatland_server.transport import Transport


def plugin_problems(
    path: Path, preprocessor: YamlPreprocessor, model_folders: Sequence[Path], transport: Transport
) -> List[Problem]:
    """The problems of the plugins of a model, or of all models of a world.

    Args:
        path: of the world or model file.
        preprocessor: evaluates the expressions in the file.
        model_folders: where models are looked up that are not beside the world file.
        transport: carries the topics and parameters of the plugins.
    """
    problems: List[Problem] = []
    with suppress(FlatlandError):
        reader = YamlReader.from_file(path, preprocessor)
        if reader.has("bodies"):
            return _problems_of_model(reader, transport)
        files: Dict[Path, None] = {}

        def read_entry(entry: YamlReader) -> None:
            if entry.is_map("model"):
                problems.extend(_problems_of_model(entry.get_section("model"), transport))
            else:
                files[entry.get_path("model", model_folders)] = None

        reader.get_sections("models", read_entry)
        for file in files:
            with suppress(FlatlandError):
                problems += _problems_of_model(YamlReader.from_file(file, preprocessor), transport)
    return problems


def _problems_of_model(reader: YamlReader, transport: Transport) -> List[Problem]:
    registry = AnyLayer()
    faulty_joints: List[str] = []

    def read_body(section: YamlReader) -> BodyConfig:
        name = section.get_string("name")
        try:
            return BodyConfig.read(section, registry)
        except YamlError:
            return BodyConfig(name, Pose(), "dynamic", (1.0, 1.0, 1.0, 1.0), 0.0, 0.0, ())

    bodies = reader.get_enabled_sections("bodies", read_body)
    names = [body.name for body in bodies]
    if not bodies or not all(names):
        return []  # plugins name bodies that are missing

    def read_joint(section: YamlReader) -> JointConfig:
        try:
            return JointConfig.read(section, names)
        except YamlError:
            faulty_joints.append(section.get_string("name"))
            raise

    joints = reader.get_enabled_sections("joints", read_joint)
    plugins = [
        each
        for each in reader.get_enabled_sections("plugins", PluginConfig.read)
        if not any(map(each.reader.key_of, faulty_joints))  # it needs one of them
    ]
    model = ModelConfig(reader.file, tuple(bodies), tuple(joints), tuple(plugins), is_read=True)
    entry = ModelEntry(reader.file.name.split(".")[0], "", Pose(), model)
    try:
        World(WorldConfig(10, 10, registry, (), (entry,), ()), transport).close()
    except YamlError as error:
        return list(error.problems)
    except FlatlandError:  # the bodies do not make a model
        return []
    return []
