"""Scenarios of commonroad-io, in and out: nothing of them is lost that both have."""

import sys
import unittest

import nearmiss


class CommonRoad(unittest.TestCase):
    def test_out_and_in_again(self):
        for name in nearmiss.scenarios():
            scenario = nearmiss.open(name)
            theirs, problems = nearmiss.to_commonroad(scenario)
            self.assertEqual(len(theirs.lanelet_network.lanelets), len(scenario.lanes()))
            self.assertEqual(theirs.dt, scenario.time_step)
            again = nearmiss.from_commonroad(theirs, problems)
            self.assertEqual([row["lanelet"] for row in again.lanes().rows()], [row["lanelet"] for row in scenario.lanes().rows()])
            mine = {(row["id"], row["time"]): row for row in scenario.tracks().rows() if not row["ego"]}
            back = {(row["id"], row["time"]): row for row in again.tracks().rows() if not row["ego"]}
            self.assertEqual(mine.keys(), back.keys())
            for key, row in mine.items():
                for axis in ("x", "y", "heading", "speed"):
                    self.assertAlmostEqual(row[axis], back[key][axis], places=3)

    def test_an_ego_is_chosen(self):
        theirs, _ = nearmiss.to_commonroad(nearmiss.open("ZAM_CutIn-1_1_T-1"))
        again = nearmiss.from_commonroad(theirs, ego=301)
        self.assertEqual(again.ego, 301)
        self.assertEqual(again.name, "ZAM_CutIn-1_1_T-1")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
