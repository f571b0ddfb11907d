"""Runs the shipped notebook from its first cell to its last, beside a model that answers at once.

notebook.py NOTEBOOK
"""

import http.server
import json
import os
import sys
import threading

import nbclient
import nbformat

ANSWER = {
    "justification": "The ego keeps its lane and the others stay away.",
    "obstacles": [],
    "safety_critical": False,
}


class Model(http.server.BaseHTTPRequestHandler):
    """A server of chat completions whose model always says no."""

    def do_POST(self):
        self.rfile.read(int(self.headers["Content-Length"]))
        chunk = {"choices": [{"index": 0, "delta": {"content": json.dumps(ANSWER)}, "finish_reason": "stop"}], "model": "m"}
        body = f"data: {json.dumps(chunk)}\n\ndata: [DONE]\n\n".encode()
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *arguments):
        pass


def main():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Model)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    os.environ["NEARMISS_MODEL_URL"] = f"http://127.0.0.1:{server.server_port}/v1"
    notebook = nbformat.read(sys.argv[1], as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    shown = [cell.outputs for cell in notebook.cells if cell.cell_type == "code"]
    assert all(shown), "a cell shows nothing"
    kinds = {kind for outputs in shown for one in outputs for kind in one.get("data", {})}
    assert "image/svg+xml" in kinds and "text/html" in kinds, kinds
    printed = "".join(one.text for outputs in shown for one in outputs if one.output_type == "stream")
    assert "model: False" in printed, printed
    print(f"{len(shown)} cells ran")


if __name__ == "__main__":
    main()
