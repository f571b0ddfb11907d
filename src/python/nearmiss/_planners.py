"""A function as a planner: the thread that answers what a drive asks of it."""

import json
import threading


def begin(function, name, requests):
    """Answers the requests of one drive.

    The thread is Python's own: it may still run when the program ends, and a thread of Rust must not.
    """
    threading.Thread(target=_answer, args=(function, name, requests), name=name, daemon=True).start()


def _answer(function, name, requests):
    hello = None
    for line in requests:
        try:
            message = json.loads(line)
            if message["type"] == "hello":
                hello = message
                wants = getattr(function, "ready", None)
                answer = {"type": "ready", "protocol": 1, "name": name, **(wants if isinstance(wants, dict) else {})}
            else:
                answer = function({**message, "hello": hello})
                if not isinstance(answer, dict):
                    raise TypeError(f"the planner returned {answer!r}, not a dict: {{'type': 'trajectory', …}}")
            requests.answer(json.dumps(answer))
        except BaseException as error:
            requests.fail(error)
