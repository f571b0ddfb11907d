"""Drives and attacks beside those of the commands; a function as a planner. Run by tests/python/main.rs."""

import json
import math
import os
import pathlib
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import nearmiss

PROGRAM = os.environ["NEARMISS"]

# A shell starts what runs in its background with the signal ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)
MERGE, CUT_IN = "ZAM_Merge-1_1_T-1", "ZAM_CutIn-1_1_T-1"

# Times that are measured, and what the command says of itself and of its files.
MEASURED = ["median_cycle_ms", "longest_cycle_ms", "seconds", "start_seconds", "median_overhead_ms"]
LEFT_OUT = [*MEASURED, "schema_version", "id", "variant", "ego"]


def line(*arguments):
    """What a command prints of its one scenario."""
    ended = subprocess.run([PROGRAM, *arguments, "--format", "json"], capture_output=True, text=True)
    return json.loads(ended.stdout)


def plain(record):
    """A record without what differs from run to run."""
    if not isinstance(record, dict):
        return record
    return {key: plain(value) for key, value in record.items() if key not in LEFT_OUT}


def straight(message):
    """Goes on as it is."""
    ego, dt = message["ego"], message["hello"]["dt"]
    ways = [k * dt * ego["velocity"] for k in range(30)]
    x, y = math.cos(ego["heading"]), math.sin(ego["heading"])
    states = [{**ego, "x": ego["x"] + way * x, "y": ego["y"] + way * y} for way in ways]
    return {"type": "trajectory", "step": message["step"], "states": states}


PROCESS = """
import json, math, sys
hello = None
while (message := json.loads(sys.stdin.readline() or '{"type": "bye"}'))["type"] != "bye":
    if message["type"] == "hello":
        hello, answer = message, {"type": "ready", "protocol": 1, "name": "straight"}
    else:
        ego = message["ego"]
        ways = [k * hello["dt"] * ego["velocity"] for k in range(30)]
        x, y = math.cos(ego["heading"]), math.sin(ego["heading"])
        states = [{**ego, "x": ego["x"] + way * x, "y": ego["y"] + way * y} for way in ways]
        answer = {"type": "trajectory", "step": message["step"], "states": states}
    print(json.dumps(answer), flush=True)
"""


class Drives(unittest.TestCase):
    def test_drives_are_those_of_plan(self):
        for name in [MERGE, CUT_IN]:
            scenario = nearmiss.open(name)
            drive = nearmiss.plan(scenario)
            self.assertEqual(plain(drive.record), plain(line("plan", name)))
            self.assertIn(drive.record["outcome"], repr(drive))
            self.assertEqual(drive.scenario.ego, drive.record["planning_problem"])
            steps = drive.scenario.steps
            self.assertEqual((steps[0], steps[-1]), (drive.record["first_step"], drive.record["last_step"]))
            self.assertGreater(len(drive.scenario.measures(["ttc"])), 0)
            set_so = nearmiss.plan(scenario, "nearmiss", traffic="reactive", horizon=3, rules="off")
            told = ["traffic=reactive", "horizon=3", "rules=off"]
            told = [word for setting in told for word in ("--set", setting)]
            self.assertEqual(plain(set_so.record), plain(line("plan", name, "--planner", "nearmiss", *told)))

    def test_a_function_drives_as_the_same_process(self):
        pathlib.Path("straight.py").write_text(PROCESS)
        for name in [MERGE, CUT_IN]:
            scenario = nearmiss.open(name)
            own = nearmiss.plan(scenario, straight)
            record = plain(line("plan", name, "--planner", "python3 straight.py"))
            self.assertGreater(record["steps"], 3)
            self.assertEqual(plain(own.record), {**record, "planner": "straight"})
            again = nearmiss.plan(scenario, straight)
            self.assertEqual(own.scenario.tracks().rows(), again.scenario.tracks().rows())

    def test_a_function_says_what_it_wants(self):
        seen = []

        def sees(message):
            seen.append(message)
            return straight(message)

        sees.ready = {"predictions": True, "history": 2}
        external = nearmiss.plan(nearmiss.open(CUT_IN), sees).record["external_planner"]
        self.assertEqual((external["predictions"], external["history"]), ("lane", 2))
        self.assertTrue(all(one["predictions"] for one in seen[4]["obstacles"]))

    def test_exceptions_come_out_and_wrong_answers_are_errors_of_the_planner(self):
        class Lost(Exception):
            pass

        def loses_its_way(message):
            if message["step"] > 2:
                raise Lost("no lane")
            return straight(message)

        scenario = nearmiss.open(CUT_IN)
        with self.assertRaisesRegex(Lost, "no lane"):
            nearmiss.plan(scenario, loses_its_way)
        with self.assertRaisesRegex(TypeError, "returned None, not a dict"):
            nearmiss.plan(scenario, lambda message: None)
        for planner, error in [
            (lambda message: {"type": "hello"}, "nonsense"),
            (lambda message: {**straight(message), "states": []}, "empty"),
            (lambda message: time.sleep(1), "cycle_timeout"),
        ]:
            drive = nearmiss.plan(scenario, planner, timeout=0.3)
            self.assertEqual(drive.record["external_planner"]["error"], error)
        wrong = [{"planner": 3}, {"planner": "no-such"}, {"horizon": -1}, {"timeout": 3}, {"problem": 9}, {"horizn": 3}]
        for keywords in wrong:
            with self.assertRaisesRegex(nearmiss.Error, next(iter(keywords)).replace("problem", "planning problem")):
                nearmiss.plan(scenario, **keywords)

    def test_ctrl_c_stops(self):
        scenario = nearmiss.open(CUT_IN)

        def never_answers(message):
            while True:
                time.sleep(0.01)

        for work in [lambda: nearmiss.plan(scenario, never_answers), lambda: nearmiss.attack(scenario, attackers=3)]:
            threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
            began = time.monotonic()
            with self.assertRaises(KeyboardInterrupt):
                work()
            self.assertLess(time.monotonic() - began, 2)


class Attacks(unittest.TestCase):
    def test_variants_are_those_of_generate(self):
        for name, keywords, options in [
            (CUT_IN, {"seed": 3}, ["--seed", "3"]),
            (MERGE, {"style": "limit", "rules": "off"}, ["--style", "limit", "--set", "rules=off"]),
        ]:
            with tempfile.TemporaryDirectory() as folder:
                command, own = pathlib.Path(folder, "command"), pathlib.Path(folder, "own")
                options = [*options, "--candidates", "60"]
                wanted = line("generate", name, *options, "-o", str(command))
                [variant] = nearmiss.attack(nearmiss.open(name), candidates=60, **keywords)
                self.assertEqual(plain(variant.record), plain(wanted))
                saved = variant.write(own)
                self.assertEqual(saved.name, f"{wanted['id']}.xml")
                for file in sorted(command.iterdir()):
                    one, two = file.read_text(), (own / file.name).read_text()
                    if file.suffix == ".json":
                        one, two = json.loads(one), json.loads(two)
                        one["made"]["line"]["seconds"] = two["made"]["line"]["seconds"] = 0
                        avoided = {delay: it["avoided"] for delay, it in one["avoidable"].items()}
                        told = {delay: it["avoided"] for delay, it in variant.certificate.items()}
                        self.assertEqual(avoided, told)
                    self.assertEqual(one, two, file.name)
                opened = nearmiss.open(saved)
                self.assertEqual((opened.name, opened.hash), (variant.scenario.name, variant.scenario.hash))
                self.assertEqual(opened.worst()["what"], variant.scenario.worst()["what"])

    def test_a_function_is_attacked(self):
        scenario = nearmiss.open(CUT_IN)
        [variant] = nearmiss.attack(scenario, planner=straight, candidates=30)
        self.assertEqual(variant.record["planner"], "straight")

        def fails(message):
            raise ValueError("at once")

        with self.assertRaisesRegex(ValueError, "at once"):
            nearmiss.attack(scenario, planner=fails)

    def test_wrong_keywords_are_named(self):
        scenario = nearmiss.open(CUT_IN)
        for keyword, value in [
            ("attackers", 4),
            ("candidates", 0),
            ("survive", 0.7),
            ("style", "rude"),
            ("wish", "nobody"),
            ("traffic", "reactive"),
            ("sed", 1),
        ]:
            with self.assertRaisesRegex(nearmiss.Error, keyword):
                nearmiss.attack(scenario, **{keyword: value})
        with self.assertRaisesRegex(nearmiss.Error, "no obstacle 9"):
            nearmiss.attack(scenario, attacker=9)


if __name__ == "__main__":
    unittest.main()
