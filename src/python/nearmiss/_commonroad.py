"""Scenarios as objects of commonroad-io, in and out; that package is imported only here, where it is used."""

import pathlib
import tempfile

from ._nearmiss import Scenario, of_bytes


def from_commonroad(scenario, planning_problems=None, *, ego=None):
    """The scenario of commonroad-io objects.

    scenario: a commonroad.scenario.scenario.Scenario. planning_problems: its PlanningProblemSet; without one there is no
    planning problem. ego: as of nearmiss.open.
    """
    from commonroad.common.file_writer import CommonRoadFileWriter, OverwriteExistingFile  # type: ignore[import-not-found, import-untyped, unused-ignore]
    from commonroad.common.util import FileFormat  # type: ignore[import-not-found, import-untyped, unused-ignore]
    from commonroad.planning.planning_problem import PlanningProblemSet  # type: ignore[import-not-found, import-untyped, unused-ignore]

    problems = planning_problems or PlanningProblemSet()
    writer = CommonRoadFileWriter(scenario, problems, decimal_precision=9, file_format=FileFormat.XML)
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "scenario.xml"
        writer.write_to_file(str(file), OverwriteExistingFile.ALWAYS)
        return of_bytes(file.read_bytes(), f"{scenario.scenario_id}.xml", ego=ego)


def to_commonroad(scenario):
    """A scenario as objects of commonroad-io: its Scenario and its PlanningProblemSet.

    What CommonRoad has no place for is a warning, as of Scenario.write. The ego is not among the obstacles.
    """
    from commonroad.common.file_reader import CommonRoadFileReader  # type: ignore[import-not-found, import-untyped, unused-ignore]

    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / f"{scenario.name}.xml"
        Scenario.write(scenario, file)
        return CommonRoadFileReader(str(file)).open()
