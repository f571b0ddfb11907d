"""The module with Python alone: errors, tables cell by cell, questions, Ctrl-C. Run by tests/python/main.rs."""

import csv
import datetime
import io
import json
import os
import pathlib
import pydoc
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings

import nearmiss

PROGRAM = os.environ["NEARMISS"]

# A shell starts what runs in its background with the signal ignored.
signal.signal(signal.SIGINT, signal.default_int_handler)

CUT_IN = "ZAM_CutIn-1_1_T-1"


def command(*arguments):
    """What a command prints on standard output."""
    return subprocess.run([PROGRAM, *arguments], check=True, capture_output=True, text=True).stdout


def plain(value):
    """A cell as JSON has it."""
    return value.total_seconds() if isinstance(value, datetime.timedelta) else value


def cells(table):
    return [{key: plain(value) for key, value in row.items()} for row in table.rows()]


class Tables(unittest.TestCase):
    def same(self, table, wanted, left_out=()):
        rows = cells(table)
        self.assertEqual(len(rows), len(wanted))
        for row, other in zip(rows, wanted):
            for key in row:
                self.assertEqual(row[key], other[key], f"{key} of {row}")
            self.assertEqual(set(other) - set(row) - set(left_out), set())

    def test_measures_are_those_of_metrics(self):
        lines = [json.loads(line) for line in command("metrics", CUT_IN, "--format", "json").splitlines()]
        self.assertGreater(len(lines), 500)
        self.same(nearmiss.open(CUT_IN).measures(), lines, ("schema_version", "provenance"))
        chosen = cells(nearmiss.open(CUT_IN).measures(["ttc", "risk"], radius=30))
        near = command("metrics", CUT_IN, "--radius", "30", "--format", "json").splitlines()
        self.assertEqual(len(chosen), len(near))
        for row, line in zip(chosen, map(json.loads, near)):
            self.assertEqual((row["ttc"], row["risk"]), (line["ttc"], line["risk"]))

    def test_reasons_say_why_a_value_is_missing(self):
        lines = command("metrics", CUT_IN, "--reasons", "--format", "csv")
        wanted = list(csv.DictReader(io.StringIO(lines)))
        rows = cells(nearmiss.open(CUT_IN).measures(reasons=True))
        self.assertEqual([row["ttc_reason"] or "" for row in rows], [row["ttc_reason"] for row in wanted])
        self.assertTrue(any(row["ttc_reason"] for row in rows))

    def test_tracks_are_those_of_convert(self):
        wanted = list(csv.DictReader(io.StringIO(command("convert", CUT_IN, "--format", "tracks"))))
        rows = cells(nearmiss.open(CUT_IN).tracks())
        self.assertEqual(len(rows), len(wanted))
        for row, other in zip(rows, wanted):
            for key, text in other.items():
                value = row[key]
                if isinstance(value, bool) or isinstance(value, str):
                    self.assertEqual(str(value).lower(), text.lower())
                else:
                    self.assertEqual(value, float(text), key)

    def test_lanes_are_those_of_inspect(self):
        lanelets = json.loads(command("inspect", CUT_IN, "--format", "json"))["lanelets"]
        rows = cells(nearmiss.open(CUT_IN).lanes())
        self.assertEqual([row["lanelet"] for row in rows], [one["id"] for one in lanelets])
        for row, one in zip(rows, lanelets):
            self.assertEqual(row["successors"].split(), [str(id) for id in one["successors"]])
            for side in ("left", "right"):
                points = row[side].removeprefix("LINESTRING (").removesuffix(")").split(", ")
                points = [[float(number) for number in point.split()] for point in points]
                self.assertEqual(points, [list(map(float, point)) for point in one[f"{side}_bound"]])

    def test_the_worst_is_the_row_of_inspect(self):
        wanted = json.loads(command("inspect", CUT_IN, "--format", "json"))["row"]
        self.assertEqual(nearmiss.open(CUT_IN).worst(), wanted)
        lines = command("inspect", *nearmiss.scenarios(), "--format", "json").splitlines()
        self.same(nearmiss.inspect(nearmiss.scenarios()), [flat(json.loads(line)) for line in lines], ("schema_version",))

    def test_many_at_once_are_each_alone(self):
        names = nearmiss.scenarios()
        self.assertEqual(len(names), 8)
        alone = [row for name in names for row in cells(nearmiss.open(name).measures(["ttc"]))]
        self.assertEqual(cells(nearmiss.measures(names, ["ttc"])), alone)
        alone = [row for name in names for row in cells(nearmiss.open(name).windows())]
        self.assertEqual(cells(nearmiss.windows(names)), alone)
        alone = [row for name in names for row in cells(nearmiss.open(name).encounters())]
        self.assertEqual(cells(nearmiss.encounters(names)), alone)

    def test_drivers_and_encounters_are_those_of_the_command(self):
        drivers = nearmiss.drivers()
        wanted = [json.loads(line) for line in command("drivers", "--format", "json").splitlines()]
        self.assertEqual(drivers, [{key: one[key] for key in one if key != "schema_version"} for one in wanted])
        names = nearmiss.scenarios()
        lines = command("drivers", *names, "--format", "json").splitlines()
        self.assertGreater(len(lines), len(names) // 2)
        self.same(nearmiss.encounters(names), [json.loads(line) for line in lines], ("schema_version",))
        [row] = nearmiss.open(CUT_IN).encounters().rows()
        self.assertEqual(row["avoided"], sum(row[driver["driver"]] == "avoided" for driver in drivers))

    def test_columns_say_what_they_mean(self):
        table = nearmiss.open(CUT_IN).measures(["ttc", "distance"])
        self.assertEqual(len(table), len(table.rows()))
        self.assertTrue(table.columns["distance"].endswith("[m]"))
        self.assertTrue(table.columns["time"].endswith("[s]"))
        self.assertIsInstance(table.rows()[0]["time"], datetime.timedelta)
        self.assertIn(f"<p>{len(table)} rows</p>", table._repr_html_())
        self.assertEqual(list(nearmiss.open(CUT_IN).measures(["ttc", "ttc"]).columns).count("ttc"), 1)
        self.assertEqual(nearmiss.open(CUT_IN).measures("ttc").rows(), nearmiss.open(CUT_IN).measures(["ttc"]).rows())

    def test_a_table_becomes_a_file_that_opens(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "tracks.arrow"
            scenario = nearmiss.open(CUT_IN)
            scenario.tracks().write(file)
            again = nearmiss.open(file, ego=1)
            self.assertEqual(again.steps, scenario.steps)
            again = nearmiss.from_tracks(scenario.tracks(), ego=1, name="mine")
            self.assertEqual((again.name, again.worst()["what"]), ("mine", nearmiss.open(file, ego=1).worst()["what"]))


def flat(row):
    return {key: " ".join(value) if isinstance(value, list) else value for key, value in row.items()}


class Questions(unittest.TestCase):
    def test_a_window_is_asked_as_by_the_commands(self):
        window = nearmiss.open(CUT_IN).window("safety", at="worst", techniques="cp,cot", radius=40)
        wanted = json.loads(
            command(*"prompt show --task safety --at worst --techniques cp,cot --set radius=40 --format json".split(), CUT_IN)
        )
        self.assertEqual(nearmiss.prompt(window), wanted["messages"])
        self.assertEqual(list(window.steps), wanted["window"])
        self.assertEqual(window.tokens, wanted["tokens"])

    def test_the_judge_and_an_answer_agree(self):
        window = nearmiss.open(CUT_IN).window("safety", at=datetime.timedelta(seconds=4.4))
        self.assertEqual(window.steps[1], 44)
        verdict = nearmiss.judge(window)
        answer = nearmiss.ask(window, "reference/geometry", store=False)
        self.assertEqual(answer["verdict"] | {"dangerous": answer["dangerous"]}, verdict)
        self.assertEqual(nearmiss.read_verdict(window, answer["answer"]), verdict)
        wanted = json.loads(
            command(*"ask --no-store --model reference/geometry --task safety --at 44 --format json".split(), CUT_IN)
        )
        for key in answer:
            self.assertEqual(answer[key], wanted[key], key)

    def test_a_moment_has_several_names(self):
        scenario = nearmiss.open(CUT_IN)
        named = [44, 4.4, datetime.timedelta(seconds=4.4), "4.4s", "worst", scenario.worst()["moment"]]
        self.assertEqual({scenario.window(at=at).steps[1] for at in named}, {44})
        self.assertEqual({scenario.figure(at).svg for at in named}, {scenario.figure().svg})

    def test_words_are_those_of_describe(self):
        scenario = nearmiss.open(CUT_IN)
        self.assertEqual(scenario.describe("cartesian", at="worst"), command("describe", CUT_IN, "--frame", "cartesian", "--at", "worst"))
        self.assertEqual(scenario.story().split(), command("describe", CUT_IN, "--story").split())

    def test_claims_are_checked(self):
        scenario = nearmiss.open(CUT_IN)
        truth = next(row for row in cells(scenario.measures(["distance"])) if row["step"] == 44 and row["obstacle"] == 301)
        said = f"Obstacle 301 is {truth['distance']:.2f} m away at step 44. Obstacle 301 is 99.0 m away at step 44."
        found = nearmiss.check(said, scenario)
        self.assertEqual([one["outcome"] for one in found], ["right", "wrong"])
        self.assertEqual({claim["obstacle"] for one in found for claim in one["claims"]}, {301})

    def test_a_figure_is_shown_and_written(self):
        scenario = nearmiss.open(CUT_IN)
        figure = scenario.figure(44)
        self.assertEqual(figure._repr_svg_(), command("render", CUT_IN, "--at", "44"))
        with tempfile.TemporaryDirectory() as folder:
            figure.write(pathlib.Path(folder) / "a.png")
            self.assertEqual((pathlib.Path(folder) / "a.png").read_bytes()[:4], b"\x89PNG")
        self.assertEqual(scenario.page(), command("render", CUT_IN, "--format", "html"))


class Errors(unittest.TestCase):
    def test_errors_say_file_and_line(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.xml"
            file.write_text('<commonRoad commonRoadVersion="2020a"\n timeStepSize="x">\n</commonRoad>\n')
            with self.assertRaises(nearmiss.Error) as raised:
                nearmiss.open(file)
            self.assertEqual((raised.exception.file, raised.exception.line), (str(file), 1))
            with self.assertRaises(nearmiss.Error) as raised:
                nearmiss.open(folder)
            self.assertIn("nearmiss.scenarios", str(raised.exception))

    def test_what_is_mistyped_is_suggested(self):
        scenario = nearmiss.open(CUT_IN)
        wrong = [
            (lambda: nearmiss.open("nothing.xml"), "no such file"),
            (lambda: scenario.measures(["tcc"]), "unknown measure"),
            (lambda: scenario.window("safty"), "did you mean `safety`"),
            (lambda: scenario.window(radus=3), "did you mean `radius`"),
            (lambda: scenario.window(at=9999), "steps 0 to 90"),
            (lambda: scenario.figure(-1), "steps 0 to 90"),
            (lambda: scenario.figure("best"), "worst"),
            (lambda: scenario.measures().write("measures.csv"), ".arrow"),
            (lambda: scenario.windows(length=0), "positive"),
            (lambda: scenario.measures(radius=float("nan")), "positive"),
            (lambda: scenario.window(at=float("nan")), "no time"),
            (lambda: scenario.window(at=datetime.timedelta(days=-1)), "steps 0 to 90"),
            (lambda: nearmiss.open(CUT_IN, ego=999), "999"),
            (lambda: nearmiss.ask(scenario.window(), "nobody/x", store=False), "nobody"),
        ]
        for call, words in wrong:
            with self.assertRaises(nearmiss.Error) as raised:
                call()
            self.assertIn(words, str(raised.exception))
        types = [
            (lambda: nearmiss.from_tracks(3), "no table"),
            (lambda: scenario.window(at=[1]), "a time step (int), seconds (float), a timedelta"),
            (lambda: scenario.measures(3), "a name or a list of names"),
            (lambda: nearmiss.measures(3), "a path or a list of paths"),
        ]
        for call, words in types:
            with self.assertRaises(TypeError) as raised:
                call()
            self.assertIn(words, str(raised.exception))

    def test_a_bad_file_among_many_is_a_warning(self):
        with tempfile.TemporaryDirectory() as folder:
            bad = pathlib.Path(folder) / "bad.xml"
            bad.write_text("<commonRoad>")
            with warnings.catch_warnings(record=True) as said:
                warnings.simplefilter("always")
                table = nearmiss.measures([CUT_IN, str(bad)], ["ttc"])
            self.assertEqual(len(table), len(nearmiss.open(CUT_IN).measures(["ttc"])))
            self.assertTrue(any("bad.xml" in str(one.message) for one in said))
            with self.assertRaises(nearmiss.Error):
                nearmiss.measures(bad)

    def test_errors_without_a_place_say_so(self):
        self.assertEqual((nearmiss.Error("x").file, nearmiss.Error("x").line), (None, None))
        with tempfile.TemporaryDirectory() as folder:
            files = [pathlib.Path(folder) / f"{name}.xml" for name in "ab"]
            for file in files:
                file.write_text("<commonRoad>")
            with self.assertRaises(nearmiss.Error) as raised:
                nearmiss.measures(files)
            self.assertEqual(raised.exception.file, str(files[0]))
            self.assertIn("(and 1 more)", str(raised.exception))

    def test_a_forked_process_works_on(self):
        wanted = len(nearmiss.measures(nearmiss.scenarios(), "ttc"))
        scenario = nearmiss.from_tracks(nearmiss.open(CUT_IN).tracks())
        child = os.fork()
        if child == 0:
            found = len(nearmiss.measures(nearmiss.scenarios(), "ttc"))
            del scenario
            os._exit(0 if found == wanted else 1)
        self.assertEqual(os.waitpid(child, 0)[1], 0)
        self.assertTrue(os.path.exists(scenario.file))

    def test_a_table_is_written_to_a_file_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            pipe = os.path.join(folder, "pipe.arrow")
            os.mkfifo(pipe)
            with self.assertRaises(nearmiss.Error):
                nearmiss.open(CUT_IN).tracks().write(pipe)

    def test_ctrl_c_stops(self):
        with tempfile.TemporaryDirectory() as folder:
            nearmiss.open(CUT_IN).write(pathlib.Path(folder) / "0.xml")
            # A name said again is measured once, so these are files of their own.
            for place in range(1, 500):
                shutil.copy(pathlib.Path(folder) / "0.xml", pathlib.Path(folder) / f"{place}.xml")
            begun = time.monotonic()
            timer = threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGINT))
            timer.start()
            try:
                with self.assertRaises(KeyboardInterrupt):
                    nearmiss.windows(folder)
            finally:
                # It must not meet another test.
                timer.cancel()
            self.assertLess(time.monotonic() - begun, 10)

    def test_others_run_meanwhile(self):
        ticks = []
        done = threading.Event()

        def tick():
            while not done.is_set():
                ticks.append(time.monotonic())
                time.sleep(0.005)

        thread = threading.Thread(target=tick)
        thread.start()
        try:
            nearmiss.windows(nearmiss.scenarios())
        finally:
            done.set()
            thread.join()
        self.assertGreater(len(ticks), 20)


class Words(unittest.TestCase):
    def test_everything_has_a_docstring(self):
        for name in nearmiss.__all__:
            thing = getattr(nearmiss, name)
            self.assertTrue(thing.__doc__, name)
            if isinstance(thing, type):
                for method, found in vars(thing).items():
                    # The class has None where an error has its place.
                    if not method.startswith("_") and found is not None:
                        self.assertTrue(found.__doc__, f"{name}.{method}")
        self.assertIn("Measure, judge and endanger", pydoc.render_doc(nearmiss))


class Written(unittest.TestCase):
    def test_files_are_those_of_convert(self):
        for ending in ("xml", "xosc", "csv", "parquet", "arrow"):
            with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings(record=True) as warned:
                warnings.simplefilter("always")
                here, there = pathlib.Path(folder) / "here", pathlib.Path(folder) / "there"
                here.mkdir()
                there.mkdir()
                nearmiss.open(CUT_IN).write(here / f"a.{ending}")
                command("convert", CUT_IN, "-o", there / f"a.{ending}")
                files = [{file.name: file.read_bytes() for file in where.iterdir()} for where in (here, there)]
                self.assertEqual(files[0], files[1], ending)
                self.assertEqual(bool(warned), ending != "xml")

    def test_nothing_is_overwritten_unasked(self):
        scenario = nearmiss.from_tracks(nearmiss.open(CUT_IN).tracks())
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.csv"
            scenario.write(file)
            with self.assertRaisesRegex(nearmiss.Error, "overwrite=True"):
                scenario.write(file)
            scenario.write(file, overwrite=True)
            with self.assertRaisesRegex(nearmiss.Error, "input"):
                nearmiss.open(file).write(file, overwrite=True)
            with self.assertRaisesRegex(nearmiss.Error, ".xosc"):
                scenario.write(file.with_suffix(".txt"))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
