"""The viewer's page, served: to this computer alone, until Ctrl-C."""

from __future__ import annotations

import threading
import urllib.error
import urllib.request

import pytest

from hexathermal.cli import main
from hexathermal.errors import ArgumentError
from hexathermal.show.viewer import PageServer


def test_the_page_is_served_to_this_computer_alone() -> None:
    """The address gives the page, other paths nothing; a port that is taken is refused."""
    server = PageServer("<p>here</p>")
    thread = threading.Thread(target=server.serve, args=(False,))
    thread.start()
    try:
        assert server.address.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(server.address) as answer:
            assert answer.read() == b"<p>here</p>"
        with pytest.raises(urllib.error.HTTPError, match="404") as refused:
            urllib.request.urlopen(server.address + "etc/passwd")
        refused.value.close()
        with pytest.raises(ArgumentError, match="cannot be used"):
            PageServer("", int(server.address.rsplit(":", 1)[1].strip("/")))
    finally:
        server.stop()
        thread.join()


def test_ctrl_c_ends_the_page_and_says_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:  # fmt: skip
    """It is the way to end a served page: exit code 0, and one line that says what is left; silent with --quiet."""

    def stop(_server: object, poll_interval: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("http.server.ThreadingHTTPServer.serve_forever", stop)
    words = ["view", "--machine", "rubin-m2", "--no-browser"]
    assert main(words) == 0
    assert "the page is no longer served; nothing was written" in capsys.readouterr().err
    assert main([*words, "--quiet"]) == 0
    assert capsys.readouterr().err == ""
