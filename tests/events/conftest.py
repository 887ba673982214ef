"""A made-up event: the library's valley, its files served from this machine, which may serve them badly."""

import contextlib
import hashlib
import http.server
import json
import shutil
import threading

import pytest

pytest.importorskip("pooch")
pytest.importorskip("rasterio")

from snowmpm.events import store
from snowmpm.scenes.library import FOLDER as LIBRARY
from tests.support.made_up_event import EVENT, NAME, SCENE, SEEN, Server


@pytest.fixture
def server(tmp_path):
    found = Server(tmp_path / "served")
    found.folder.mkdir()
    for name in ("valley.asc", "valley_release.geojson"):
        shutil.copy(LIBRARY / name, found.folder / name)
    (found.folder / "seen.geojson").write_text(json.dumps(SEEN), encoding="utf-8")

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            status, body, length = found.answer(self.path.strip("/"))
            self.send_response(status)
            for header in found.headers.get(self.path.strip("/"), {}).items():
                self.send_header(*header)
            self.send_header("Content-Length", str(len(body) if length is None else length))
            self.end_headers()
            with contextlib.suppress(ConnectionError):  # a client that has seen enough
                self.wfile.write(body)

        def log_message(self, *_):
            pass

    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler) as http_server:
        found.address = f"http://127.0.0.1:{http_server.server_port}"
        thread = threading.Thread(target=http_server.serve_forever, daemon=True)
        thread.start()
        yield found
        http_server.shutdown()
        thread.join()


@pytest.fixture
def own(tmp_path, monkeypatch):
    """The folder that SNOWMPM_EVENTS names, and a cache that is empty."""
    folder = tmp_path / "events"
    folder.mkdir()
    monkeypatch.setenv(store.VARIABLE, str(folder))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return folder


@pytest.fixture
def made_up(server, own):
    """write(...) describes the event in `own`; -> its name. accept: whether its licence must be accepted; files: TOML
    in place of those of the server; observed: more of it."""

    def write(accept=False, files=None, observed="", event=EVENT):
        rows = files if files is not None else "".join(
            f'[[files]]\nname = "{path.name}"\nurl = "{server.address}/{path.name}"\nbytes = {path.stat().st_size}\n'
            f'sha256 = "{hashlib.sha256(path.read_bytes()).hexdigest()}"\n' for path in sorted(server.folder.iterdir()))
        (own / NAME).mkdir(exist_ok=True)
        (own / NAME / "scene.toml").write_text(SCENE, encoding="utf-8")
        text = event.format(accept=str(accept).lower(), files=rows, observed=observed)
        (own / NAME / "event.toml").write_text(text, encoding="utf-8")
        return NAME

    return write
